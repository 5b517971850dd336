"""One-sided stops against closed forms: restitution, rebound, rest, contact time, ledger, levers."""

import itertools
import math

import numpy as np
import pytest

from nutamill import CaseError, System
from nutamill.mechanism.parts import GROUND, Body, Drive, Joint, JointKind, Stop
from nutamill.mechanism.stop_tables import damping_number, longest_step

O, X, Y, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
MASS, RADIUS, STIFFNESS = 2.0, 0.1, 2e5


def ball(height, speed=0.0, name="ball", mass=MASS):
    return Body(
        name, mass, 0.4 * mass * RADIUS**2 * np.eye(3), (0.0, 0.0, height), velocity=(0.0, 0.0, speed)
    )


def floor(restitution, name="floor", body="ball", at=O, stiffness=STIFFNESS):
    """The ground's plane z = 0 under a sphere of `body`."""
    return Stop(name, GROUND, body, O, at, stiffness, restitution, normal=Z, radius_b=RADIUS)


def thrown(restitution, speed, clearance=1e-4):
    """A ball above the floor, thrown down at `speed`, without weight."""
    start = (0.0, 0.0, RADIUS + clearance)
    return System([ball(start[2], -speed)], loads=[floor(restitution, at=start)], gravity=O)


def ledger(system):
    return system.energy().total + system.state.loss.sum()


@pytest.mark.parametrize("restitution", [1.0, 0.8, 0.4, 0.1])
def test_a_ball_rebounds_with_its_restitution_at_any_speed(restitution):
    frequency = math.sqrt(STIFFNESS / MASS)
    for speed in (0.05, 5.0):
        errors = []
        for dt in (1e-4, 5e-5):
            system = thrown(restitution, speed)
            system.march(2e-4 / speed + 6.0 * math.pi / frequency, dt)
            assert system.contact("floor").force == 0.0
            errors.append(system.velocity("ball")[2] / speed - restitution)
        # the law's rebound is exact; a step that cuts touch or rebound errs by a share (w dt)^2
        assert np.abs(errors).max() < (frequency * 1e-4) ** 2 * (1.0 + damping_number(restitution))


def test_rebound_and_ledger_converge_with_second_order():
    # where touch and rebound fall in a step is chance; the mean over many phases falls by four
    means = []
    for dt in (2e-4, 1e-4, 5e-5):
        misses, gaps = [], []
        for phase in np.linspace(0.0, 1.0, 8, endpoint=False):
            system = thrown(0.6, 1.0, (1.0 + phase) * dt)
            begin = ledger(system)
            system.march(0.02, dt)
            misses.append(abs(system.velocity("ball")[2] - 0.6))
            gaps.append(abs(ledger(system) - begin) / begin)
        means.append((np.mean(misses), np.mean(gaps)))
    for one, two in itertools.pairwise(means):
        assert 3.5 < one[0] / two[0] < 4.6
        assert 3.5 < one[1] / two[1] < 4.6


def test_heights_of_a_dropped_ball_fall_by_the_restitution_squared():
    drop, e = 0.5, 0.7
    centre = (0.0, 0.0, RADIUS + drop)
    system = System([ball(centre[2])], loads=[floor(e, at=centre)])
    fall, heights = math.sqrt(2.0 * drop / 9.81), []
    contact = math.pi * math.sqrt(MASS / STIFFNESS)
    highest, before = 0.0, -1.0
    for _ in range(round((fall * (1 + 2 * e + 2 * e**2) + 2.5 * contact) / 5e-4)):
        system.march(5e-4, 5e-5)
        speed, height = system.velocity("ball")[2], system.position("ball")[2] - RADIUS
        highest = max(highest, height) if speed > 0.0 or before > 0.0 else 0.0
        if before > 0.0 >= speed:
            heights.append(highest)
        before = speed
    # the weight works through the overlap too: of the order of g sqrt(m/k) over the speed of impact
    share = 9.81 * math.sqrt(MASS / STIFFNESS) / math.sqrt(2.0 * 9.81 * drop * e**2)
    assert heights[0] == pytest.approx(drop * e**2, rel=2.0 * share)
    assert heights[1] == pytest.approx(drop * e**4, rel=4.0 * share)


def test_a_ball_comes_to_rest_on_its_static_overlap():
    system = System([ball(RADIUS + 2e-3)], loads=[floor(0.3, at=(0.0, 0.0, RADIUS + 2e-3))])
    begin = ledger(system)
    system.march(0.6, 1e-4)
    weight = MASS * 9.81
    assert system.contact("floor") == pytest.approx((weight, -weight / STIFFNESS), rel=1e-6)
    assert system.velocity("ball")[2] == pytest.approx(0.0, abs=1e-7)
    # of second order: (w dt)^2 of the energy of the fall
    assert ledger(system) == pytest.approx(begin, abs=STIFFNESS / MASS * 1e-4**2 * weight * 2e-3)


def test_a_body_rests_on_its_stops_and_stays_there():
    centre, feet = (0.0, 0.0, 0.5), [(x, y, RADIUS) for x in (-0.3, 0.3) for y in (-0.2, 0.2)]
    vessel = Body("ball", 40.0, 2.0 * np.eye(3), centre)
    stops = [floor(0.5, f"foot_{k}", at=foot) for k, foot in enumerate(feet)]
    system = System([vessel], loads=stops)
    system.rest()
    sink = 40.0 * 9.81 / (4.0 * STIFFNESS)
    assert system.position("ball")[2] == pytest.approx(0.5 - sink, abs=1e-9)
    system.march(0.1, 1e-4)
    assert system.position("ball")[2] == pytest.approx(0.5 - sink, abs=1e-9)
    assert system.contact("foot_2").force == pytest.approx(40.0 * 9.81 / 4.0, rel=1e-6)


def test_two_spheres_exchange_momentum_as_an_impact():
    # in line: v1' = (m1 - e m2) v / (m1 + m2), v2' = (1 + e) m1 v / (m1 + m2)
    bodies = [ball(0.0, 1.0, "one", 3.0), ball(0.25, 0.0, "two", 1.0)]
    stop = Stop("touch", "one", "two", O, (0.0, 0.0, 0.25), STIFFNESS, 0.5, radius_a=RADIUS, radius_b=RADIUS)
    system = System(bodies, loads=[stop], gravity=O)
    system.march(0.1, 5e-5)
    exact = 0.01 * math.sqrt(STIFFNESS / 0.75) * 5e-5
    assert system.velocity("one")[2] == pytest.approx((3.0 - 0.5) / 4.0, abs=exact)
    assert system.velocity("two")[2] == pytest.approx(1.5 * 3.0 / 4.0, abs=3.0 * exact)
    momentum = 3.0 * system.velocity("one") + system.velocity("two")
    assert momentum == pytest.approx((0.0, 0.0, 3.0), abs=1e-12)


def test_a_lever_rebounds_from_its_stop_by_the_mass_it_has_there():
    # the mass behind the stop is I / r^2 about the pin, not that of a free rod: half of it would be wrong
    # damping at rest, and a rebound that is not e
    length, spin, e = 1.0, 2.0, 0.5
    rod = Body("rod", MASS, np.diag([1e-3, MASS / 12.0, MASS / 12.0]), (0.5, 0.0, 0.0),
               velocity=(0.0, 0.0, -0.5 * spin), angular_velocity=(0.0, spin, 0.0))  # fmt: skip
    pin = Joint("pin", JointKind.REVOLUTE, GROUND, "rod", O, Y)
    stop = Stop("bump", GROUND, "rod", (1.0, 0.0, -1e-3), (1.0, 0.0, 0.0), STIFFNESS, e, normal=Z)
    system = System([rod], [pin], [stop], gravity=O)
    mass = MASS / 3.0 * length**2
    assert system.mechanism.stops[0].frequency == pytest.approx(math.sqrt(STIFFNESS / mass), rel=1e-9)
    system.march(0.03, 2e-5)
    assert system.angular_velocity("rod")[1] == pytest.approx(-e * spin, rel=1e-3)


def test_time_of_an_elastic_contact_is_half_a_period():
    frequency = math.sqrt(STIFFNESS / MASS)
    dt, steps, closed = 1e-5, 0, 0
    system = thrown(1.0, 1.0)
    while steps < 2500:
        system.step(dt)
        closed += system.contact("floor").force > 0.0
        steps += 1
    assert closed * dt == pytest.approx(math.pi / frequency, abs=2.0 * dt)


def test_a_prescribed_piston_is_pushed_back_by_its_stop():
    # pushed into the stop at constant speed: k d at rest, and the drive does the work
    piston = Body("piston", MASS, np.eye(3), O)
    guide = Joint("guide", JointKind.PRISMATIC, GROUND, "piston", O, X)
    stop = Stop("end", GROUND, "piston", (0.01, 0.0, 0.0), O, 1e4, 1.0, normal=(-1.0, 0.0, 0.0))
    drive = Drive("ram", "guide", (0.0, 0.1, 0.2, 0.3), (0.0, 0.1, 0.1, 0.0))
    system = System([piston], [guide], [stop], [drive], gravity=O)
    system.march(0.4, 1e-3)
    assert system.contact("end") == pytest.approx((1e4 * 0.01, -0.01), rel=1e-9)
    assert system.torque("ram") == pytest.approx(100.0, rel=1e-9)
    assert system.state.drive_work[0] == pytest.approx(system.energy().elastic, rel=1e-4)


def test_a_step_that_does_not_resolve_the_contact_is_refused():
    system = thrown(0.2, 1.0)
    longest = longest_step(system.mechanism.stops[0])
    with pytest.raises(CaseError, match="dt: too long for the contact of stop 'floor'"):
        system.march(0.1, 1.01 * longest)
    system.march(10.0 * longest, longest)


def test_bad_stops_are_refused_all_at_once():
    def bad(name, **other):
        numbers = {"stiffness": 1e5, "restitution": 0.5, "normal": Z, "radius_b": 0.1} | other
        return Stop(name, GROUND, "ball", O, (0.0, 0.0, 1.0), **numbers)

    stops = [
        bad("a", normal=None),
        bad("b", radius_a=0.1),
        bad("c", normal=O),
        bad("d", stiffness=0.0),
        bad("e", restitution=0.0),
        bad("f", radius_b=-0.1),
        Stop("g", GROUND, "ball", O, O, 1e5, 0.5, radius_a=0.1),
        Stop("h", "ball", "ball", O, X, 1e5, 0.5, normal=Z),
    ]
    with pytest.raises(CaseError) as error:
        System([ball(1.0)], loads=stops)
    assert {fault.where for fault in error.value.faults} == {f"stop '{name}'" for name in "abcdefgh"}
