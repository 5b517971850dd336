"""The viscous film of one contact: its impulse, its restitution and its order, without an engine."""

import itertools
import math

import numpy as np
import pytest
from contact_bench import UP, ZERO, M, R, pair

from nutamill.charge.laws import viscous_film
from nutamill.charge.laws.composition import (
    COHESION,
    NORMAL,
    ROLLING,
    TANGENTIAL,
    contact,
    contact_law,
    film_numbers,
    law_faults,
    law_numbers,
)
from nutamill.charge.laws.impact import impact
from nutamill.charge.laws.meeting import meeting

WATER = {"liquid_viscosity": 0.05, "film_thickness": 60e-6, "film_roughness": 1e-6}
DRAG = 6.0 * math.pi * 0.05 * R * R
LOG = math.log(60.0)


def film_pair(**changes):
    return pair(**(WATER | changes))


class Fall:
    """A ball of mass M and radius R against a wall, by the leapfrog of the engine."""

    def __init__(self, numbers, dt, gap, speed, law=None, weight=0.0):
        self.law = law or contact_law(rolling="none", film="viscous")
        self.numbers, self.liquid = tuple(law_numbers(self.law, numbers)), film_numbers(self.law, numbers)
        self.dt, self.gap, self.speed, self.kick, self.weight = dt, gap, speed, 0.0, weight
        self.alive, self.history, self.film_work, self.begun = 0.0, 0.0, 0.0, 0
        self.gap -= 0.5 * dt * speed  # positions are half a substep ahead

    def step(self):
        acceleration = self.weight
        if self.gap < viscous_film.numbers(film_pair())[1]:
            seen = self.speed + 0.5 * self.dt * self.kick
            force, _, _, _, _, _, self.history, _, power, lasts = meeting(
                self.law.film, self.law, UP, -self.gap, (0.0, 0.0, seen), ZERO, ZERO, ZERO, 0.0, self.history,
                self.alive, M, R, (2 * R, 2 * R), self.numbers, tuple(self.liquid), self.dt,
            )  # fmt: skip
            self.alive, self.begun = 1.0, self.begun + int(1.0 - lasts)
            self.film_work += power * self.dt
            acceleration += force[2] / M
        else:
            self.alive, self.history = 0.0, 0.0
        self.kick = acceleration
        self.speed += self.dt * acceleration
        self.gap -= self.dt * self.speed

    def present_gap(self):
        """Gap at the time of the speed."""
        return self.gap + 0.5 * self.dt * self.speed


def rebound(numbers, v, dt, **options):
    """Speed of parting over speed of approach [1], 0 where the ball stays in the film."""
    fall = Fall(numbers, dt, 61e-6 + 0.3 * v * dt, v, **options)
    for _ in range(10_000):
        fall.step()
        if fall.speed < 0.0 and fall.gap > 61e-6:
            return -fall.speed / v
    return 0.0


@pytest.mark.parametrize("v", [0.3, 1.0, 4.0])
def test_film_acts_both_ways_restitution_falls_with_one_over_stokes(v):
    # the impulse of a passage depends on its ends alone: what is left is the error of the elastic spring met
    # at another phase, (w dt)^2/8 of the speed
    dt = math.pi * math.sqrt(M / 1e5) / 200
    stokes = M * v / DRAG
    wanted = 1.0 - 2.0 * LOG / stokes
    assert rebound(film_pair(), v, dt) == pytest.approx(wanted, abs=(math.pi / 200) ** 2 / 4)


def test_a_fast_ball_that_crosses_the_film_in_two_substeps_loses_the_same_impulse():
    # 30 micrometres in a substep, thirty roughnesses; two phases of the first substep
    v, dt = 30.0, 1e-6
    wanted = 1.0 - 2.0 * LOG * DRAG / (M * v)
    assert rebound(film_pair(), v, dt) == pytest.approx(wanted, abs=1e5 / M * dt * dt / 4)


def test_dashpot_and_film_give_the_closed_form_together():
    # the dashpot meets the speed behind the film; first and last substep are shared with it
    v, e = 1.0, 0.6
    numbers = film_pair(damping_ratio=-math.log(e) / math.hypot(math.pi, math.log(e)))
    stokes = M * v / DRAG
    dt = math.pi * math.sqrt(M / 1e5) / 400
    assert rebound(numbers, v, dt) == pytest.approx(e - (1.0 + e) * LOG / stokes, abs=2e-4)


def test_below_the_critical_stokes_number_the_ball_stays():
    critical = 2.0 * LOG * DRAG / M
    assert rebound(film_pair(), 0.95 * critical, 2e-6) == 0.0
    assert rebound(film_pair(), 1.05 * critical, 2e-6) > 0.0


def test_closed_form_of_the_impact_is_the_march():
    law, numbers = contact_law(rolling="none", film="viscous"), film_pair()
    met = impact(law, numbers, M, R, 2 * R, 2 * R, 2.0)
    assert met.restitution == pytest.approx(1.0 - 2.0 * LOG * DRAG / (2.0 * M), rel=1e-12)
    stuck = impact(law, numbers, M, R, 2 * R, 2 * R, 0.9 * LOG * DRAG / M)
    assert (stuck.restitution, stuck.overlap) == (0.0, 0.0)
    # a thick liquid is resolved near the roughness: its braking time m s/(6 pi mu R^2)
    thick = film_pair(liquid_viscosity=50.0)
    assert impact(law, thick, M, R, 2 * R, 2 * R, 1.0).resolve == pytest.approx(M * 1e-6 / (1000.0 * DRAG))


def test_motion_in_the_film_is_of_second_order_in_the_substep():
    # in at 0.04 m/s, down to a third of it after 2 ms: v = v0 - (c/M) ln(h/s) of the gap reached, and both
    # against a quarter of the error at half the substep
    def motion(dt):
        fall = Fall(film_pair(), dt, 64.3e-6, 0.04)
        for _ in range(round(2e-3 / dt)):
            fall.step()
        return np.array([fall.present_gap(), fall.speed])

    exact = motion(2.5e-7)
    assert exact[1] == pytest.approx(0.04 - DRAG / M * math.log(60e-6 / (exact[0] + 1e-6)), rel=1e-6)
    coarse, fine = (np.abs(motion(dt) - exact) for dt in (2e-5, 1e-5))
    assert coarse / fine == pytest.approx([4.0, 4.0], rel=0.1)


def test_work_of_the_film_is_the_loss_of_kinetic_energy():
    # predicted for mean velocities: second order in the substep
    fall = Fall(film_pair(), 1e-6, 61e-6, 0.04)
    while fall.speed > 1e-3:
        fall.step()
    lost = 0.5 * M * (0.04**2 - fall.speed**2)
    assert -fall.film_work == pytest.approx(lost, rel=1e-4)
    assert fall.begun == 0


def test_a_ball_that_slides_onto_a_surface_at_its_present_gap_meets_no_film():
    law, liquid = (
        contact_law(rolling="none", film="viscous"),
        film_numbers(contact_law(film="viscous"), film_pair()),
    )
    numbers = tuple(law_numbers(law, film_pair()))
    out = meeting(
        law.film, law, UP, 2e-6, ZERO, ZERO, ZERO, ZERO, 0.0, 0.0, 0.0, M, R, (2 * R, 2 * R), numbers,
        tuple(liquid), 1e-6,
    )  # fmt: skip
    assert out[0][2] == pytest.approx(-1e5 * 2e-6, rel=1e-12)


EVERY = list(itertools.product(NORMAL, TANGENTIAL, ROLLING, COHESION))


@pytest.mark.parametrize("names", EVERY, ids=" ".join)
def test_every_law_has_a_film_beside_it_and_none_while_the_solids_touch(names):
    numbers = film_pair(
        damping_ratio=0.2, unloading_ratio=2.0, static_friction=0.5, dynamic_friction=0.4,
        rolling_friction=0.1, tangential_damping=0.2, rolling_stiffness=0.1,
        cohesive_pressure=1e5 if names[3] == "area" else 0.0,
    )  # fmt: skip
    law = contact_law(*names, "viscous")
    p, liquid, dt = tuple(law_numbers(law, numbers)), tuple(film_numbers(law, numbers)), 1e-6
    u, w, spring, rolled = (0.3, 0.1, 0.5), (20.0, 5.0, 1.0), (1e-6, 0.0, 0.0), (1e-5, 0.0, 0.0)
    rest = M, R, (2 * R, 2 * R), p
    plain = getattr(contact, "py_func", contact)
    touching = meeting(law.film, law, UP, 3e-5, u, w, spring, rolled, 0.0, 1e-6, 1.0, *rest, liquid, dt)
    alone = plain(law, UP, 3e-5, u, w, spring, rolled, 0.0, 1e-6, *rest, dt)
    assert touching[0] == pytest.approx(alone[0], rel=1e-12)
    assert touching[1:8] == alone[1:8]
    assert touching[8:] == (0.0, 1.0)
    # 20 micrometres apart, 21 at the end of the last substep
    apart = meeting(law.film, law, UP, -2e-5, u, w, ZERO, ZERO, 0.0, -22e-6, 1.0, *rest, liquid, dt)
    push = DRAG * math.log(22e-6 / (21e-6 - 0.25e-6)) / dt
    assert apart[0] == pytest.approx((0.0, 0.0, -push), rel=1e-9)
    assert apart[1:6] == (ZERO, ZERO, ZERO, ZERO, 0.0)
    assert apart[6] == pytest.approx(-20.75e-6)
    assert apart[8:] == pytest.approx((-push * 0.5, 1.0))


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"liquid_viscosity": -1.0}, "liquid_viscosity must be 0 or more, got -1 Pa s"),
        ({"film_thickness": 0.0}, "film_thickness must exceed film_roughness 1e-06 m, got 0 m"),
        ({"film_roughness": 1e-10}, "film_roughness must be 1e-08 m or more, got 1e-10 m"),
    ],
)
def test_films_that_cannot_be_are_refused(changes, fault):
    assert [what for what, _ in law_faults(contact_law(film="viscous"), film_pair(**changes))] == [fault]


def test_liquid_without_a_film_is_refused():
    wanted = [("liquid_viscosity 0.05 Pa s has no film", "Choose a viscous film, or write 0")]
    assert law_faults(contact_law(), film_pair()) == wanted


def test_numbers_of_the_film_are_what_it_reads():
    assert np.array(film_numbers(contact_law(film="viscous"), film_pair())) == pytest.approx(
        [6 * math.pi * 0.05, 60e-6, 1e-6]
    )
    assert film_numbers(contact_law(), pair()) == []
