"""Bad input of each machine of the package: what walls, regions and carriers contradict is refused in words
before a step is run, and walls that only the motion brings together stop the run.
"""

import math

import numpy as np
import pytest

from nutamill.base.errors import CaseError
from nutamill.case import load_case
from nutamill.case.placement import quaternion_of
from nutamill.case.walls import WallEntry
from nutamill.simulation.setup.solid_walls import solids_met
from nutamill.simulation.setup.wall_checks import refuse_walls

MACHINES = {
    "piston": ("piston", "bore", (0.0, 0.0, -1.0)),
    "particle-damper": ("box", "enclosure", (1.0, 0.0, 0.0)),
    "tumbling-mill": ("drum", "drum", (1.0, 0.0, 0.0)),
    "planetary-mill": ("sun", "jar_1", (0.0, 0.0, 1.0)),
    "vibratory-mill": ("tube", "tube", (0.0, 1.0, 0.0)),
}
"""A body and a region of each machine, and a way [m] out of its walls."""


@pytest.fixture(scope="module", params=MACHINES)
def machine(request):
    """A machine of the package."""
    return load_case(request.param)


def parts(machine) -> tuple[str, str, tuple[float, float, float]]:
    return MACHINES[machine.name]


def refusal(machine) -> str:
    with pytest.raises(CaseError) as caught:
        refuse_walls(machine)
    return str(caught.value)


def block(name, body, point, size=0.01) -> WallEntry:
    """A cube on a body."""
    return WallEntry(
        name=name, body=body, shape="box", size=(size, size, size), point=tuple(point), material="steel"
    )


def with_walls(machine, *walls):
    return machine.with_("walls", (*machine.walls, *walls))


def test_walls_that_reach_into_each_other_at_the_start_are_refused(machine):
    body = parts(machine)[0]
    lug, post = block("lug", body, (0.5, 0.5, 0.5)), block("post", "ground", (0.506, 0.5, 0.5))
    expected = f'walls.post: reaches 4 mm into wall "lug" of {body} as assembled. Move one of the two'
    assert refusal(with_walls(machine, lug, post)) == expected


def test_a_carrier_that_is_not_there_is_refused_with_those_that_are(machine):
    with pytest.raises(CaseError, match=r'walls\[\d\]\.body: no body is called "nobody". Known: ground, '):
        with_walls(machine, block("lug", "nobody", (0.5, 0.5, 0.5)))
    regions = (machine.regions[0].model_copy(update={"body": "nobody"}), *machine.regions[1:])
    with pytest.raises(CaseError, match=r'regions\[0\]\.body: no body is called "nobody". Known: ground, '):
        machine.with_("regions", regions)


def test_a_region_without_a_floor_is_refused(machine):
    pipe = WallEntry(
        name="pipe",
        body=parts(machine)[0],
        shape="cylinder",
        radius=5.0,
        point=(0.0, 0.0, 0.0),
        material="steel",
    )
    message = refusal(machine.with_("walls", (pipe,)))
    assert f"regions.{parts(machine)[1]}: has no floor: no wall is below it" in message


def test_a_charge_outside_of_its_walls_is_refused(machine):
    _, name, way = parts(machine)
    moved = [
        region.model_copy(update={"point": tuple(np.add(region.point, way))})
        if region.name == name
        else region
        for region in machine.regions
    ]
    message = refusal(machine.with_("regions", tuple(moved)))
    assert f"regions.{name}: is outside of the walls" in message
    assert "Move it to the charge's side of that wall" in message


@pytest.mark.parametrize(("name", "drive"), [("tumbling-mill", "motor"), ("planetary-mill", "motor")])
def test_a_wall_that_a_drive_sweeps_through_another_carrier_is_refused(name, drive):
    machine = load_case(name)
    body = parts(machine)[0]
    centre, axis = (0.0, 0.0, 0.0), 0 if name == "tumbling-mill" else 2
    across = [k for k in range(3) if k != axis]
    places = np.zeros((2, 3))
    places[0, across[0]] = places[1, across[1]] = 0.5  # a quarter of a turn apart
    lug, post = (
        block(*one, np.add(centre, at))
        for one, at in zip((("lug", body), ("post", "ground")), places, strict=True)
    )
    message = refusal(with_walls(machine, lug, post))
    assert message.startswith(f'walls.post: moves into wall "lug" of {body} when drive "{drive}" has turned ')
    turned = float(message.partition("turned ")[2].partition(" deg")[0])
    # a quarter of a turn, less the width of both cubes at half a metre
    assert 90.0 - math.degrees(0.01 * math.sqrt(2.0) / 0.49) < turned % 180.0 <= 90.0


def test_walls_that_the_motion_brings_together_stop_the_run(machine):
    body = parts(machine)[0]
    lug, post = block("lug", body, (0.5, 0.5, 0.5)), block("post", "ground", (0.512, 0.5, 0.5))
    case = with_walls(machine, lug, post)
    place = np.array([*(one.position for one in case.bodies), (0.0, 0.0, 0.0)])
    turn = np.array([*(quaternion_of(one.turn) for one in case.bodies), (1.0, 0.0, 0.0, 0.0)])
    if case.unbalance_motors:  # the rotor comes after the bodies
        place, turn = np.insert(place, -1, 0.0, axis=0), np.insert(turn, -1, (1.0, 0.0, 0.0, 0.0), axis=0)
    assert solids_met(case, place, turn, 0.1) is None
    number = [one.name for one in case.bodies].index(body)
    place[number, 0] += 0.005
    assert str(solids_met(case, place, turn, 0.1)).startswith(
        f'wall "lug" of {body} and wall "post" of ground reach 3 mm into each other at t = 0.1 s. Walls do '
    )
