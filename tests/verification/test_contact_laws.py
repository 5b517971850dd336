"""Each contact law against its closed form, or against an integration written down here."""

import itertools
import math

import numpy as np
import pytest
from contact_bench import UP, M, Probe, R, bounce, evaluate, pair, plain
from scipy.integrate import solve_ivp

from nutamill.charge.laws.composition import (
    COHESION,
    NORMAL,
    ROLLING,
    TANGENTIAL,
    contact_law,
    law_faults,
    law_numbers,
    stored_energy,
)
from nutamill.charge.laws.impact import impact
from nutamill.charge.laws.oscillator import damping_ratio_from_restitution

LEAST = 0.001
"""Least force of the hysteretic spring over that of loading."""
E_STAR, G_STAR, K = 1e8, 4e7, 1e5
"""As `pair` has them."""
EVERY = list(itertools.product(NORMAL, TANGENTIAL, ROLLING, COHESION))


def hysteretic_restitution(r):
    """Share of the work of loading that is left below the unloading line (slope r) and the least force, for
    unit depth and slope.
    """
    corner = (1 - 1 / r) / (1 - LEAST / r)
    return math.sqrt((1 + LEAST * corner) * (1 - corner) + LEAST * corner * corner)


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("normal", list(NORMAL))
@pytest.mark.parametrize("wanted", [0.9, 0.5, 0.3])
def test_particle_leaves_with_the_restitution_its_law_promises(normal, wanted, cut):
    # second order in a = w dt with w of the stiffest spring met: the bound of the linear impact test,
    # (a^2/8)(1 + 4 zeta) of the impulse
    # at each end of the contact and a^2/24 pi of the swing
    law = contact_law(normal, rolling="none")
    zeta = damping_ratio_from_restitution(wanted, cut)
    numbers = pair(damping_ratio=zeta, tension_cut=cut, unloading_ratio=wanted**-2)
    met = impact(law, numbers, M, R, 2 * R, 2 * R, 1.0)
    dt = met.resolve / 100
    a2 = met.stiffness * (numbers.unloading_ratio if normal == "hysteretic" else 1.0) / M * dt * dt
    expected = hysteretic_restitution(wanted**-2) if normal == "hysteretic" else wanted
    assert met.restitution == pytest.approx(expected, rel=1e-9)
    for phase in (0.1, 0.35, 0.6, 0.85):
        got, deepest, _ = bounce(law, numbers, 1.0, dt, phase)
        assert got == pytest.approx(expected, abs=a2 * (0.25 * (1 + 4 * zeta) * (1 + wanted) + math.pi / 24))
        # the deepest sample is up to half a substep from the turn: a^2/8, and the start errs by as much with
        # its dashpot
        assert deepest == pytest.approx(met.overlap, rel=a2 * (0.25 + zeta))


@pytest.mark.parametrize(("normal", "least"), [("linear", 1.7), ("hysteretic", 1.7), ("hertz", 1.25)])
def test_restitution_error_falls_with_the_square_of_the_substep(normal, least):
    # Mean of eight phases, from 40 to 160 substeps a contact: order 2 means 16. Hertz's dashpot begins with
    # the fourth root of time, whose midpoint rule is of order 5/4.
    law, zeta = contact_law(normal, rolling="none"), damping_ratio_from_restitution(0.5, True)
    numbers = pair(damping_ratio=zeta, tension_cut=True, unloading_ratio=4.0)
    met = impact(law, numbers, M, R, 2 * R, 2 * R, 1.0)
    mean = [
        sum(
            abs(bounce(law, numbers, 1.0, met.resolve / n, (k + 0.3) / 8)[0] - met.restitution)
            for k in range(8)
        )
        / 8
        for n in (40, 160)
    ]
    assert least < math.log2(mean[0] / mean[1]) / 2 < 2.3


def test_undamped_hertz_contact_lasts_as_long_as_the_closed_form():
    # 2 (15/16)^(2/5) int_0^1 dx/sqrt(1 - x^(5/2)) (m^2/(R E*^2 v))^(1/5) = 2.87 (...)^(1/5); K. L. Johnson,
    # Contact Mechanics, 11.4
    law, v = contact_law("hertz", rolling="none"), 2.0
    integral = math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9)
    time = 2 * (15 / 16) ** 0.4 * integral * (M * M / (R * E_STAR**2 * v)) ** 0.2
    assert time == pytest.approx(2.87 * (M * M / (R * E_STAR**2 * v)) ** 0.2, rel=1e-3)
    assert impact(law, pair(), M, R, 2 * R, 2 * R, v).time == pytest.approx(time, rel=1e-8)
    assert bounce(law, pair(), v, time / 200)[2] == pytest.approx(time, abs=2 * time / 200)


def test_hertz_restitution_does_not_depend_on_speed():
    law, zeta = contact_law("hertz", rolling="none"), damping_ratio_from_restitution(0.5, False)
    numbers = pair(damping_ratio=zeta)
    got = [
        bounce(law, numbers, v, impact(law, numbers, M, R, 2 * R, 2 * R, v).resolve / 100)[0]
        for v in (0.01, 1.0, 10.0)
    ]
    # the same number of substeps and the same phase: the same path but for its scale
    assert got == pytest.approx([got[0]] * 3, rel=1e-9)


def test_hertz_force_and_tangent_are_those_of_two_elastic_spheres():
    depth = 1e-4
    law = contact_law("hertz", rolling="none")
    force = [-Probe(law, pair(), 1e-9).step(d, (0, 0, 0))[0][2] for d in (depth - 1e-9, depth, depth + 1e-9)]
    assert force[1] == pytest.approx(4 / 3 * E_STAR * math.sqrt(R) * depth**1.5, rel=1e-12)
    assert (force[2] - force[0]) / 2e-9 == pytest.approx(2 * E_STAR * math.sqrt(R * depth), rel=1e-6)


def drive(law, numbers, depths, dt=1e-6):
    """Work [J] done on a contact whose overlap is led along `depths`, sampled halfway between; and the last
    force [N].
    """
    probe, work = Probe(law, numbers, dt), 0.0
    for a, b in itertools.pairwise(depths):
        force = -probe.step(0.5 * (a + b), (0.0, 0.0, (b - a) / dt))[0][2]
        work += force * (b - a)
    return work, probe, force


def test_hysteretic_loop_encloses_the_work_that_is_lost():
    # triangle of loading less what is left under the unloading line and the least force
    r, deep, n = 4.0, 2e-4, 2000
    law = contact_law("hysteretic", rolling="none")
    up, down = np.linspace(0.0, deep, n + 1), np.linspace(deep, 0.0, n + 1)
    loop = drive(law, pair(unloading_ratio=r), np.concatenate([up, down[1:]]))[0]
    # the deepest sample is half a step before the turn; each corner errs by at most the slopes' difference
    # times a step squared
    seen = deep * (1 - 0.5 / n)
    assert loop == pytest.approx(
        0.5 * K * seen**2 * (1 - hysteretic_restitution(r) ** 2), abs=2 * r * K * (deep / n) ** 2
    )


def test_hysteretic_spring_goes_down_and_up_again_on_one_line():
    # from the largest load half way down the unloading line and back: no work, and the same force
    r, deep = 4.0, 2e-4
    law = contact_law("hysteretic", rolling="none")
    path = np.concatenate(
        [
            np.linspace(0.0, deep, 401),
            np.linspace(deep, 0.9 * deep, 101)[1:],
            np.linspace(0.9 * deep, deep, 101)[1:],
        ]
    )
    whole, _, force = drive(law, pair(unloading_ratio=r), path)
    assert whole == pytest.approx(0.5 * K * deep**2, rel=1e-3)
    assert force == pytest.approx(K * deep, rel=2e-3)
    middle = drive(law, pair(unloading_ratio=r), path[:501])[2]
    # the deepest and the last sample lie half a step before the turn and before the end
    assert middle == pytest.approx(
        K * deep - r * K * 0.1 * deep, abs=r * K * 0.5 * (deep / 400 + 0.1 * deep / 100)
    )


@pytest.mark.parametrize("tangential", list(TANGENTIAL))
def test_small_slip_meets_mindlins_stiffness(tangential):
    depth, slip, dt = 1e-4, 1e-9, 1e-6
    probe = Probe(
        contact_law("hertz", tangential, "none"), pair(static_friction=1.0, dynamic_friction=1.0), dt
    )
    for _ in range(10):
        force, _ = probe.step(depth, (slip / 10 / dt, 0.0, 0.0))
    # sampled half a substep before the end of ten: 19/20 of the slip
    assert -force[0] / (0.95 * slip) == pytest.approx(8 * G_STAR * math.sqrt(R * depth), rel=1e-9)


def test_stored_length_follows_the_stiffness_and_stored_force_does_not():
    # slipped at depth 1, unloaded to a quarter without slip: Mindlin's stiffness halves, and with it the
    # force of the stored length only
    deep, dt, slip = 2e-4, 1e-6, 1e-9
    force = {}
    for tangential in TANGENTIAL:
        probe = Probe(
            contact_law("hertz", tangential, "none"), pair(static_friction=1.0, dynamic_friction=1.0), dt
        )
        probe.step(deep, (slip / dt, 0.0, 0.0))
        force[tangential] = -probe.step(0.25 * deep, (0.0, 0.0, 0.0))[0][0]
    full = 8 * G_STAR * math.sqrt(R * deep) * slip
    assert force["displacement"] == pytest.approx(0.5 * full, rel=1e-9)
    assert force["incremental"] == pytest.approx(full, rel=1e-9)


def test_stored_length_and_stored_force_agree_at_constant_stiffness():
    rng = np.random.default_rng(4)
    probes = [
        Probe(contact_law("linear", name, "none"), pair(static_friction=0.5, dynamic_friction=0.4), 1e-6)
        for name in ("displacement", "incremental")
    ]
    for slip in rng.normal(size=(200, 3)):
        one, other = (probe.step(1e-4, slip * [1, 1, 0])[0] for probe in probes)
        assert one == pytest.approx(other, rel=1e-9)
    assert probes[0].sliding == probes[1].sliding


def test_mass_on_a_tangential_spring_with_a_dashpot_swings_as_a_damped_oscillator():
    # x'' + 2 zeta w x' + w^2 x = 0 from x = 0 at speed v, held down by friction without limit
    zeta, ratio, v, dt = 0.2, 0.7, 0.01, 1e-6
    numbers = pair(tangential_ratio=ratio, tangential_damping=zeta, static_friction=1e6, dynamic_friction=1e6)
    probe = Probe(contact_law("linear", "incremental_dashpot", "none"), numbers, dt)
    w = math.sqrt(ratio * K / M)
    swing, speed, kick = w * math.sqrt(1.0 - zeta * zeta), v, 0.0
    steps = round(2.5 * math.pi / swing / dt)
    for _ in range(steps):
        force = probe.step(1e-4, (speed + 0.5 * dt * kick, 0.0, 0.0))[0]
        kick = force[0] / M
        speed += dt * kick
    t = steps * dt
    exact = v * math.exp(-zeta * w * t) * (math.cos(swing * t) - zeta * w / swing * math.sin(swing * t))
    # second order in w dt for each radian of the swing, and as much at the start
    assert abs(speed - exact) < v * (w * dt) ** 2 * (1.0 + w * t)


def test_dashpot_of_friction_stays_within_coulombs_limit():
    probe = Probe(
        contact_law("linear", "incremental_dashpot", "none"),
        pair(tangential_damping=0.9, static_friction=0.5, dynamic_friction=0.5),
        1e-6,
    )
    for slip in (3.0, -3.0, 5.0, 0.1):
        force, _ = probe.step(1e-4, (slip, 0.5 * slip, 0.0))
        assert np.hypot(force[0], force[1]) <= 0.5 * K * 1e-4 * (1 + 1e-12)


@pytest.mark.parametrize("share", [0.25, 4.0])
def test_rolling_spring_of_given_stiffness_swings_with_its_own_frequency(share):
    # t'' = -(k_r/I) t from angle 0 with spin w0, whatever the tangential stiffness; limit out of reach
    stiffness, inertia, w0 = share * K * R * R, 0.4 * M * R * R, 1.0
    law = contact_law("linear", rolling="type_c_direct")
    numbers = pair(rolling_stiffness=stiffness, rolling_friction=1e3)
    frequency = math.sqrt(stiffness / inertia)
    dt = 0.02 / frequency
    probe, spin, kick = Probe(law, numbers, dt), w0, 0.0
    steps = round(2.25 * math.pi / frequency / dt)
    for _ in range(steps):
        moment = probe.step(1e-4, (0.0, 0.0, 0.0), (0.0, spin + 0.5 * dt * kick, 0.0))[1]
        kick = moment[1] / inertia
        spin += dt * kick
    t = steps * dt
    assert abs(spin - w0 * math.cos(frequency * t)) < w0 * (frequency * dt) ** 2 * (1.0 + frequency * t)
    # what the spring holds is what the spin has lost
    lost = 0.5 * inertia * (w0**2 - spin**2)
    assert stored(probe, 1e-4)[2] == pytest.approx(lost, abs=inertia * (frequency * dt) ** 2 * frequency * t)


def test_substep_has_to_resolve_a_rolling_spring_that_is_given():
    law = contact_law("linear", rolling="type_c_direct")
    soft, stiff = (pair(rolling_stiffness=share * K * R * R) for share in (1e-3, 100.0))
    plain_law = impact(contact_law("linear"), pair(), M, R, 2 * R, 2 * R, 1.0)
    assert impact(law, soft, M, R, 2 * R, 2 * R, 1.0) == plain_law
    # half a period of a sphere that rolls on a wall: I = 2/5 m R^2
    half = math.pi * math.sqrt(0.4 * M * R * R / stiff.rolling_stiffness)
    assert impact(law, stiff, M, R, 2 * R, 2 * R, 1.0).resolve == pytest.approx(half, rel=1e-12)


def test_cohesion_pulls_in_proportion_to_the_contact_area():
    pressure, depth = 1e5, 1e-4
    law = contact_law(rolling="none", cohesion="area")
    force, _ = Probe(law, pair(cohesive_pressure=pressure), 1e-9).step(depth, (0, 0, 0))
    assert -force[2] == pytest.approx(K * depth - pressure * 2 * math.pi * depth * 2 * R, rel=1e-12)


def test_friction_of_a_cohesive_contact_sees_the_push_alone():
    pressure, depth, mu = 1e6, 1e-4, 0.5
    law = contact_law(rolling="none", cohesion="area")
    probe = Probe(law, pair(cohesive_pressure=pressure, static_friction=mu, dynamic_friction=mu), 1e-6)
    force, _ = probe.step(depth, (1e3, 0.0, 0.0))
    assert -force[0] == pytest.approx(mu * K * depth, rel=1e-12)


@pytest.mark.parametrize(
    ("normal", "pressure", "cut"), [("linear", 1e6, False), ("linear", 1e6, True), ("hertz", 5e5, False)]
)
def test_cohesive_impact_is_that_of_its_equation_of_motion(normal, pressure, cut):
    # m u'' = pull - max(spring + dashpot, floor), integrated here until the two part
    zeta, v = 0.15, 1.0
    numbers = pair(damping_ratio=zeta, cohesive_pressure=pressure, tension_cut=cut)

    def rates(t, y):
        u = max(y[0], 0.0)
        k = K if normal == "linear" else 2 * E_STAR * math.sqrt(R * u)
        push = (1.0 if normal == "linear" else 2 / 3) * k * u
        push += 2 * zeta * (1.0 if normal == "linear" else math.sqrt(5 / 6)) * math.sqrt(M * k) * y[1]
        return y[1], (4 * math.pi * R * pressure * u - (max(push, 0.0) if cut else push)) / M

    def parted(t, y):
        return y[0] if t > 1e-6 else 1.0

    parted.terminal = True
    end = solve_ivp(rates, (0.0, 1e-2), (0.0, v), events=parted, rtol=1e-9, atol=1e-13, max_step=1e-6)
    law = contact_law(normal, rolling="none", cohesion="area")
    met = impact(law, numbers, M, R, 2 * R, 2 * R, v)
    assert met.restitution == pytest.approx(-end.y[1, -1], abs=1e-5)
    assert met.time == pytest.approx(end.t[-1], rel=1e-5)
    assert met.overlap == pytest.approx(end.y[0].max(), rel=1e-4)
    dt = met.resolve / 100
    assert bounce(law, numbers, v, dt)[0] == pytest.approx(met.restitution, abs=met.stiffness / M * dt * dt)


def test_particles_that_meet_too_slowly_for_their_cohesion_stick():
    law = contact_law("hertz", rolling="none", cohesion="area")
    numbers = pair(damping_ratio=0.3, cohesive_pressure=1e6)
    met = impact(law, numbers, M, R, 2 * R, 2 * R, 1e-3)
    assert (met.restitution, met.time) == (0.0, math.inf)
    assert bounce(law, numbers, 1e-3, met.resolve / 100)[2] == math.inf


def stored(probe, depth):
    """Energy a probed contact holds at this overlap [J] (3)."""
    memory = np.array([*probe.s, *probe.t, 1.0, probe.history])
    return np.array(
        stored_energy(probe.law, np.array(probe.numbers), memory, 1.0, depth, probe.r, probe.r, probe.r)
    )


@pytest.mark.parametrize("cohesion", list(COHESION))
@pytest.mark.parametrize("normal", list(NORMAL))
def test_work_of_loading_is_stored_but_for_what_plastic_flow_takes(normal, cohesion):
    # halfway samples: exact for straight lines, (step)^2 of the curvature for Hertz
    deep, r, pressure = 2e-4, 4.0, 1e6 if cohesion == "area" else 0.0
    law = contact_law(normal, rolling="none", cohesion=cohesion)
    numbers = pair(unloading_ratio=r, cohesive_pressure=pressure)
    work, probe, _ = drive(law, numbers, np.linspace(0.0, deep, 1001))
    lost = 0.5 * K * deep**2 * (1 - hysteretic_restitution(r) ** 2) if normal == "hysteretic" else 0.0
    # the memory of a hysteretic contact is that of the last sample, half a step back
    assert stored(probe, deep)[0] == pytest.approx(work - lost, rel=2e-3 if normal == "hysteretic" else 1e-5)


@pytest.mark.parametrize(("tangential", "rolling"), list(itertools.product(TANGENTIAL, ROLLING)))
def test_spring_of_constant_stiffness_never_gives_out_more_than_it_took(tangential, rolling):
    # random slip and spin at one overlap: work taken from the motion less energy held grows, substep by
    # substep
    rng = np.random.default_rng(8)
    depth, dt, taken, before = 1e-4, 1e-6, np.zeros(3), np.zeros(3)
    numbers = pair(
        static_friction=0.5,
        dynamic_friction=0.4,
        rolling_friction=0.1,
        tangential_damping=0.3,
        rolling_stiffness=0.5 * K * R * R,
    )
    probe = Probe(contact_law("linear", tangential, rolling), numbers, dt)
    for slip, spin in zip(rng.normal(size=(400, 3)), 2e3 * rng.normal(size=(400, 3)), strict=True):
        probe.step(depth, slip * 20 * [1, 1, 0], spin)
        taken -= np.array(probe.powers) * dt
        now = taken - stored(probe, depth)
        assert (now - before)[1:].min() >= -1e-12 * taken[1]
        before = now
    assert before[1] > 0.0
    assert (before[2] > 0.0) == (rolling != "none")


GIVEN = pair(
    damping_ratio=0.2,
    static_friction=0.5,
    dynamic_friction=0.4,
    rolling_friction=0.1,
    unloading_ratio=3.0,
    cohesive_pressure=1e5,
    tangential_damping=0.3,
    rolling_stiffness=0.05,
)


def any_contact(law, side, call):
    """A contact under any law, seen from the first (side 1) or the second particle (side -1)."""
    rng = np.random.default_rng(5)
    n = rng.normal(size=3)
    vectors = (
        n / np.linalg.norm(n),
        rng.normal(size=3),
        100 * rng.normal(size=3),
        1e-6 * rng.normal(size=3),
        1e-3 * rng.normal(size=3),
    )
    n, u, w, s, t = (tuple(map(float, side * v)) for v in vectors)
    diameters = (4e-3, 6e-3)[::side]
    numbers = tuple(law_numbers(law, GIVEN))
    return np.hstack(call(law, n, 1e-4, u, w, s, t, 0.0, 1e-5, 2e-4, 1e-3, diameters, numbers, 1e-7))


@pytest.mark.parametrize("names", EVERY, ids="-".join)
def test_every_law_gives_the_partner_the_opposite(names):
    # seen from the second particle the normal, all velocities and all memory turn round; forces and moments
    # must too
    law = contact_law(*names)
    one, other = any_contact(law, 1, plain), any_contact(law, -1, plain)
    assert np.isfinite(one).all()
    assert other[:15] == pytest.approx(-one[:15], rel=1e-14, abs=0)
    assert other[15:] == pytest.approx(one[15:], rel=1e-13)
    assert (one[6:9] == 0.0).all() == (names[2] == "none")
    # the other laws hand it on
    assert (one[16] != 1e-5) == (names[0] == "hysteretic")


# every two choices of two families meet in one of these
NUMBER = {
    name: number for family in (NORMAL, TANGENTIAL, ROLLING, COHESION) for number, name in enumerate(family)
}
COVER = [
    (n, t, r, c)
    for n, t, r, c in EVERY
    if (NUMBER[n] + NUMBER[t] + NUMBER[r]) % 3 == 0 and (NUMBER[t] + NUMBER[r]) % 2 == NUMBER[c]
]


@pytest.mark.parametrize("names", COVER, ids="-".join)
def test_compiled_law_is_the_plain_one(names):
    law = contact_law(*names)
    assert any_contact(law, 1, evaluate) == pytest.approx(any_contact(law, 1, plain), rel=1e-12)


def test_dashpot_takes_energy_and_a_resting_contact_none():
    probe = Probe(contact_law("hertz", rolling="none"), pair(damping_ratio=0.2), 1e-7)
    spring = -probe.step(1e-4, (0, 0, 0))[0] @ UP
    assert -probe.step(1e-4, (0, 0, 1.0))[0] @ UP > spring > -probe.step(1e-4, (0, 0, -1.0))[0] @ UP


@pytest.mark.parametrize(
    ("names", "number", "fault"),
    [
        (
            ("linear", "incremental_dashpot", "none"),
            {"tangential_damping": 1.0},
            "tangential_damping must be from 0 to below 1, got 1",
        ),
        (
            ("linear", "displacement", "type_c_direct"),
            {"rolling_stiffness": 0.0},
            "rolling_stiffness must be above 0, got 0 N m/rad",
        ),
    ],
)
def test_law_names_the_number_that_a_pair_lacks(names, number, fault):
    assert [what for what, _ in law_faults(contact_law(*names), pair(**number))] == [fault]
