"""Walls and regions that no charge can be put between are refused before a step, in one sentence; walls that
meet later stop the run.
"""

import math

import numpy as np
import pytest
from steel import STEEL

from nutamill.base.errors import CaseError
from nutamill.case import case_of_text, load_case
from nutamill.simulation.setup.carriers import carriers_of
from nutamill.simulation.setup.solid_walls import penetration, solid_pairs, solids_met
from nutamill.simulation.setup.wall_checks import refuse_walls

HEAD = (
    """
schema = 1
[[bodies]]
name     = "rotor"
mass     = "1 kg"
inertia  = ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"]
position = ["0 mm", "0 mm", "0 mm"]
[[joints]]
name    = "shaft"
kind    = "revolute"
between = ["ground", "rotor"]
point   = ["0 mm", "0 mm", "0 mm"]
axis    = [0, 0, 1]
[charge]
kind     = "spheres"
diameter = "5 mm"
count    = 1
material = "steel"
"""
    + STEEL
    + """
[run]
until = "1 s"
[[regions]]
name  = "tub"
shape = "box"
size  = ["300 mm", "300 mm", "100 mm"]
point = ["0 mm", "0 mm", "POINT"]
"""
)
REGION = HEAD.replace("POINT", "200 mm")
FLOOR = '[[walls]]\nname = "floor"\nshape = "plane"\nmaterial = "steel"\npoint = ["0 mm", "0 mm", "-50 mm"]\n'
PADDLE = """
[[walls]]
name     = "paddle"
body     = "rotor"
shape    = "box"
size     = ["100 mm", "10 mm", "20 mm"]
point    = ["50 mm", "0 mm", "0 mm"]
material = "steel"
"""
POST = """
[[walls]]
name     = "post"
shape    = "box"
size     = ["20 mm", "20 mm", "40 mm"]
point    = [X, Y, "0 mm"]
material = "steel"
"""
DRIVE = '[[drives]]\nname = "motor"\njoint = "shaft"\nspeed = "60 rpm"\nramp = "600 rpm/s"\n'


def post(x: int, y: int) -> str:
    """A post on the ground at a point [mm]."""
    return POST.replace("X", f'"{x} mm"').replace("Y", f'"{y} mm"')


def refusal(text: str) -> str:
    """Return the message that refuses a machine before a step is run."""
    with pytest.raises(CaseError) as caught:
        refuse_walls(case_of_text(text))
    return str(caught.value)


def test_boxes_of_two_bodies_that_overlap_at_the_start_are_refused():
    # the paddle ends at x = 100 mm, the post begins at 95 mm
    assert refusal(REGION + FLOOR + PADDLE + post(105, 0)) == (
        'walls.post: reaches 5 mm into wall "paddle" of rotor as assembled. Move one of the two'
    )
    refuse_walls(case_of_text(REGION + FLOOR + PADDLE + post(110, 0)))  # they only touch


def test_a_box_that_a_drive_turns_into_another_is_refused_with_the_angle():
    # the corner (100, 5) mm of the paddle meets the side y = 90 mm of the post: 100 sin a + 5 cos a = 90
    angle = math.degrees(math.asin(90 / math.hypot(100, 5)) - math.atan2(5, 100))
    message = refusal(REGION + FLOOR + PADDLE + post(40, 100) + DRIVE)
    first = next(a for a in range(1, 360) if a > angle)
    assert message == (
        f'walls.post: moves into wall "paddle" of rotor when drive "motor" has turned {first} deg.'
        " Move one of the two, or end the run earlier"
    )
    # 60 rpm after a ramp of 0.1 s: in 0.1 s it turns 18 deg
    refuse_walls(case_of_text((REGION + FLOOR + PADDLE + post(40, 100) + DRIVE).replace('"1 s"', '"0.1 s"')))


ARM = """
[[bodies]]
name     = "arm"
mass     = "1 kg"
inertia  = ["1 kg m^2", "1 kg m^2", "1 kg m^2"]
position = ["50 mm", "0 mm", "0 mm"]
[[joints]]
name    = "wrist"
kind    = "KIND"
between = ["rotor", "arm"]
point   = ["0 mm", "0 mm", "0 mm"]
"""
ON_ARM = PADDLE.replace('"rotor"', '"arm"')
GEARED = (
    ARM.replace("KIND", "revolute")
    + 'axis = [0, 0, 1]\n[[gears]]\nname = "belt"\ninput = "shaft"\noutput = "wrist"\nratio = -0.5\n'
)


def test_a_box_that_a_drive_moves_through_another_body_is_refused_with_the_time():
    # the paddle of the test above on an arm that is fixed to the rotor: it meets the post at the same angle
    angle = math.asin(90 / math.hypot(100, 5)) - math.atan2(5, 100)
    text = REGION + FLOOR + ON_ARM + post(40, 100) + DRIVE
    # 60 rpm after a ramp of 0.1 s, in which it makes half a turn less of 0.05 s
    for arm, share in ((ARM.replace("KIND", "fixed"), 1.0), (GEARED, 0.5)):
        message = refusal(text + arm)
        time = float(message.partition("t = ")[2].partition(" s,")[0])
        begin = angle / share / math.tau + 0.05
        assert begin - 0.001 <= time <= begin + 0.005
        assert message == (
            f'walls.post: moves into wall "paddle" of arm at t = {time:.3g} s, moved by the drives. Move one '
            "of the two, or end the run earlier"
        )
        refuse_walls(case_of_text((text + arm).replace('"1 s"', '"0.1 s"')))


def test_a_box_on_an_arm_that_swings_freely_is_looked_at_during_the_run_alone():
    arm = ARM.replace("KIND", "revolute") + "axis = [0, 0, 1]\n"
    refuse_walls(case_of_text(REGION + FLOOR + ON_ARM + post(40, 100) + DRIVE + arm))


def test_boxes_that_meet_during_the_run_stop_it_and_are_named():
    case = case_of_text(REGION + FLOOR + PADDLE + post(0, 100))
    apart = np.zeros((2, 3)), np.array([[1.0, 0, 0, 0], [1.0, 0, 0, 0]])
    assert solids_met(case, *apart, 0.5) is None
    quarter = math.sqrt(0.5)
    turned = apart[0], np.array([[quarter, 0, 0, quarter], [1.0, 0, 0, 0]])
    assert str(solids_met(case, *turned, 0.5)) == (
        'wall "paddle" of rotor and wall "post" of ground reach 10 mm into each other at t = 0.5 s. Walls do '
        "not stop each other: give the bodies a stop, or move the walls."
    )


def test_depth_of_boxes_across_each_other_is_that_of_their_nearest_edges():
    text = REGION + FLOOR + PADDLE + post(0, 0)
    # an edge of a cube turned by 45 deg about x, over an edge along x of one turned about y: both are
    # 10 sqrt(2) mm high
    text = text.replace(
        'size     = ["100 mm", "10 mm", "20 mm"]\npoint    = ["50 mm", "0 mm", "0 mm"]',
        'size = ["20 mm", "20 mm", "20 mm"]\npoint = ["0 mm", "0 mm", "27 mm"]\naxis = [0, 1, 1]',
    )
    text = text.replace(
        'size     = ["20 mm", "20 mm", "40 mm"]',
        'size = ["20 mm", "20 mm", "20 mm"]\naxis = [1, 0, 1]\nacross = [0, 1, 0]',
    )
    case = case_of_text(text)
    poses = {carrier.name: (carrier.position, carrier.rotation) for carrier in carriers_of(case)}
    ((one, two),) = solid_pairs(case)
    assert penetration(one, two, poses) == pytest.approx(0.02 * math.sqrt(2) - 0.027, abs=1e-12)


def test_bodies_that_a_fixed_joint_connects_may_overlap():
    weld = '[[joints]]\nname = "weld"\nkind = "fixed"\nbetween = ["ground", "rotor"]\n'
    weld += 'point = ["0 m", "0 m", "0 m"]\n'
    refuse_walls(case_of_text(REGION + FLOOR + PADDLE + post(105, 0) + weld))


def test_a_region_without_a_floor_is_refused():
    side = FLOOR.replace('material = "steel"', 'material = "steel"\naxis = [1, 0, 0]').replace(
        '"0 mm", "0', '"-1 m", "0'
    )
    assert refusal(REGION + side) == (
        "regions.tub: has no floor: no wall is below it, and the charge would fall out. Add a wall below it, "
        "or turn the one there around"
    )
    refuse_walls(case_of_text(REGION + side + FLOOR.replace("floor", "second")))
    refuse_walls(case_of_text(REGION + side).with_("gravity", (0.0, 0.0, 0.0)))


def test_a_region_behind_a_wall_is_refused():
    roof = FLOOR.replace('material = "steel"', 'material = "steel"\naxis = [0, 0, -1]').replace(
        "floor", "roof"
    )
    assert refusal(REGION + FLOOR + roof) == (
        'regions.tub: is outside of the walls: all of it is behind wall "roof". Move it to the charge\'s '
        "side of that wall"
    )


SHAPES = {
    "box": 'shape = "box"\nsize = ["400 mm", "400 mm", "10 mm"]',
    "cone": 'shape = "cone"\nradius = "10 mm"\nend_radius = "300 mm"\nheight = "100 mm"',
    "cap": 'shape = "cap"\nradius = "300 mm"\nangle = "80 deg"\naxis = [0, 0, 1]',
    "disc": 'shape = "disc"\nradius = "100 mm"',
    "lying tube": 'shape = "tube"\nradius = "300 mm"\nheight = "100 mm"\naxis = [1, 0, 0]',
    "rod": 'shape = "rod"\nradius = "100 mm"\nheight = "50 mm"',
    "lying rod": 'shape = "rod"\nradius = "50 mm"\nheight = "50 mm"\naxis = [1, 0, 0]',
    "ball": 'shape = "ball"\nradius = "50 mm"',
    "lying cylinder": 'shape = "cylinder"\nradius = "400 mm"\naxis = [1, 0, 0]',
}


@pytest.mark.parametrize("shape", SHAPES)
def test_a_wall_of_any_shape_below_a_region_is_a_floor_and_above_it_is_none(shape):
    wall = (
        f'[[walls]]\nname = "bowl"\nmaterial = "steel"\npoint = ["0 mm", "0 mm", "0 mm"]\n{SHAPES[shape]}\n'
    )
    refuse_walls(case_of_text(REGION + wall))
    if shape != "lying cylinder":
        assert "has no floor" in refusal(HEAD.replace("POINT", "-600 mm") + wall)


@pytest.mark.parametrize("shape", ['"cylinder"', '"tube"\nheight = "1 m"'])
def test_an_upright_cylinder_is_no_floor(shape):
    wall = f'[[walls]]\nname = "liner"\nmaterial = "steel"\nshape = {shape}\nradius = "400 mm"\n'
    assert "has no floor" in refusal(REGION + wall)


def test_a_published_mill_passes():
    refuse_walls(load_case("numill").machine)
