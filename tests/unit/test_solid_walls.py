"""Solid walls of any shape that reach into each other: boxes, rods, balls and meshes of different bodies."""

import math

import numpy as np
import pytest
from test_wall_checks import FLOOR, REGION

from nutamill.base.errors import CaseError
from nutamill.case import load_case
from nutamill.charge.walls.triangles import signed_volumes
from nutamill.simulation.setup.solid_triangles import (
    CIRCLE,
    ball_triangles,
    box_triangles,
    rod_triangles,
    solids_meet,
)
from nutamill.simulation.setup.solid_walls import solids_met
from nutamill.simulation.setup.wall_checks import refuse_walls

TURNING = REGION + FLOOR
SLIDING = TURNING.replace("revolute", "prismatic").replace("[0, 0, 1]", "[1, 0, 0]")
DRIVE = '[[drives]]\nname = "motor"\njoint = "shaft"\nspeed = "60 rpm"\nramp = "600 rpm/s"\n'
RAM = '[[linear_drives]]\nname = "ram"\njoint = "shaft"\nspeeds = [["0 s", "0.1 m/s"], ["1 s", "0.1 m/s"]]\n'


def wall(name, body, shape, point, **keys) -> str:
    """A solid wall; lengths in mm."""
    sizes = {"radius": "'{} mm'", "height": "'{} mm'", "size": "['{} mm', '{} mm', '{} mm']"}
    lines = [f'[[walls]]\nname = "{name}"\nbody = "{body}"\nshape = "{shape}"\nmaterial = "steel"']
    lines.append("point = ['{} mm', '{} mm', '{} mm']".format(*point))
    for key, value in keys.items():
        text = sizes.get(key, "{}").format(*(value if isinstance(value, tuple) else (value,)))
        lines.append(f"{key} = {text}")
    return "\n".join(lines) + "\n"


@pytest.fixture
def blade(tmp_path):
    """A mesh on the rotor: a blade from x = 20 mm to 100 mm, 4 mm thick."""
    middle = box_triangles(np.array([40.0, 2.0, 10.0])) + np.array([60.0, 0.0, 0.0])
    corners, faces = np.unique(middle.reshape(-1, 3), axis=0, return_inverse=True)
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners]
    lines += ["f {} {} {}".format(*(1 + face)) for face in faces.reshape(-1, 3)]
    (tmp_path / "blade.obj").write_text("\n".join(lines) + "\n")
    return wall("blade", "rotor", "mesh", (0, 0, 0), file="'blade.obj'", unit="'mm'")


@pytest.fixture
def machine(tmp_path):
    """Load a machine from its text, with files beside it."""

    def loaded(text):
        (tmp_path / "machine.toml").write_text(text)
        return load_case(tmp_path / "machine.toml")

    return loaded


def refusal(machine) -> str:
    with pytest.raises(CaseError) as caught:
        refuse_walls(machine)
    return str(caught.value).partition("walls.")[2]


def test_solids_of_triangles_are_closed_and_have_the_volume_of_their_shape():
    assert signed_volumes(box_triangles(np.array([1.0, 2.0, 3.0]))).sum() == pytest.approx(48.0)
    polygon = 0.5 * CIRCLE * math.sin(2.0 * math.pi / CIRCLE)  # area of the polygon in the unit circle
    assert signed_volumes(rod_triangles(2.0, 3.0)).sum() == pytest.approx(4.0 * polygon * 6.0)
    # of an inscribed ball the defect is of the order of the square of the angle
    ball = signed_volumes(ball_triangles(1.0)).sum() / (4.0 / 3.0 * math.pi)
    assert 1.0 - (2.0 * math.pi / CIRCLE) ** 2 < ball < 1.0


def test_solids_meet_where_an_edge_crosses_a_face_or_one_is_in_the_other():
    cube, ball = box_triangles(np.ones(3)), ball_triangles(0.5)
    assert solids_meet(ball, cube) and solids_meet(cube, ball)
    assert solids_meet(cube, ball + np.array([1.3, 0.1, 0.0])) and not solids_meet(
        cube, ball + np.array([1.6, 0.1, 0.0])
    )
    # beside the corner: their boxes meet, they do not
    apart = 0.4
    assert not solids_meet(cube, ball + 1.0 + apart) and math.sqrt(3.0) * apart > 0.5
    assert solids_meet(cube, ball + 1.0 + 0.5 * apart)
    # side by side they only touch
    assert not solids_meet(cube, cube + np.array([2.0, 0.0, 0.0])) and solids_meet(
        cube, cube + np.array([1.999, 0.3, 0.1])
    )
    # a plate through a plate, no corner of either in the other
    plate = box_triangles(np.array([1.0, 1.0, 0.01]))
    assert solids_meet(plate, plate[:, :, [2, 0, 1]] + np.array([0.3, 0.2, 0.1]))


def test_a_mesh_in_a_thin_plate_of_another_body_is_refused(machine, blade):
    plate = {"shape": "box", "size": (2, 100, 60)}
    through = machine(TURNING + blade + wall("plate", "ground", point=(70, 20, 0), **plate))
    assert refusal(through) == (
        'plate: reaches some way into wall "blade" of rotor as assembled. Move one of the two'
    )
    refuse_walls(machine(TURNING + blade + wall("plate", "ground", point=(70, 52.1, 0), **plate)))


def test_a_mesh_that_a_drive_turns_into_a_plate_is_refused_with_the_angle(machine, blade):
    plate = wall("plate", "ground", "box", (0, 60, 0), size=(1, 100, 40))
    # the plate x = 0.5 mm from y = 10 mm on; the corner (20, 2) mm of the blade reaches x = 0.5 mm first at
    # y = 20.09 mm: 20 cos a - 2 sin a = 0.5
    angle = math.degrees(math.acos(0.5 / math.hypot(20, 2)) - math.atan2(2, 20))
    message = refusal(machine(TURNING + blade + plate + DRIVE))
    turned = float(message.partition("has turned ")[2].partition(" deg")[0])
    assert message.startswith('plate: moves into wall "blade" of rotor when drive "motor" has turned ')
    assert angle - 0.5 <= turned <= angle + 1.5


def test_a_mesh_that_a_linear_drive_pushes_through_a_plate_is_refused_with_the_travel(machine, blade):
    # the blade ends at 100 mm, the plate begins at 149.5 mm; the run ends at 1 s and 100 mm
    plate = wall("plate", "ground", "box", (150, 0, 0), size=(1, 100, 40))
    message = refusal(machine(SLIDING + blade + plate + RAM))
    travel = float(message.partition("has travelled ")[2].partition(" mm")[0])
    assert message.startswith(
        'plate: moves into wall "blade" of rotor when linear drive "ram" has travelled '
    )
    assert 49.5 < travel <= 50.0  # positions are half the thickness of the plate apart
    refuse_walls(machine((SLIDING + blade + plate + RAM).replace('"1 s"', '"0.49 s"')))


@pytest.mark.parametrize(
    ("shape", "keys", "near", "far"),
    [
        ("rod", {"radius": 10, "height": 40}, (50, 11.5, -20), (50, 12.5, -20)),
        ("ball", {"radius": 10}, (50, 11.5, 0), (50, 12.5, 0)),
    ],
)
def test_rods_and_balls_are_solid_too(machine, blade, shape, keys, near, far):
    assert "post: reaches some way into" in refusal(
        machine(TURNING + blade + wall("post", "ground", shape, near, **keys))
    )
    refuse_walls(machine(TURNING + blade + wall("post", "ground", shape, far, **keys)))


def test_a_mesh_that_meets_a_plate_during_the_run_stops_it(machine, blade):
    case = machine(TURNING + blade + wall("plate", "ground", "box", (0, 60, 0), size=(1, 100, 40)))
    place, quarter = np.zeros((2, 3)), math.sqrt(0.5)
    assert solids_met(case, place, np.array([[1.0, 0, 0, 0], [1.0, 0, 0, 0]]), 0.5) is None
    met = solids_met(case, place, np.array([[quarter, 0, 0, quarter], [1.0, 0, 0, 0]]), 0.5)
    assert str(met) == (
        'wall "blade" of rotor and wall "plate" of ground reach some way into each other at t = 0.5 s. Walls '
        "do not stop each other: give the bodies a stop, or move the walls."
    )
