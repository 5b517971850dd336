"""Work of loading of contacts at their deepest, against closed forms, and what it must leave alone."""

import math
from dataclasses import replace

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law, sphere_mass
from scipy.integrate import solve_ivp

from nutamill.charge.kernels.impacts import FINE, LOADING, LOWEST
from nutamill.charge.laws import viscous_film
from nutamill.charge.laws.composition import contact_law
from nutamill.charge.laws.oscillator import largest_overlap
from nutamill.charge.laws.pair import PairLaw, spring_stiffness

R, K = 0.0025, 1e5
M = sphere_mass(R)
EDGES = 2.0 ** (LOWEST + 0.5 * np.arange(128))
ROUNDED = 2.0**-16
"""Share of an energy to which a spectrum is exact."""
PAIR, WALL = 0, 1


def loading(bench, kind):
    """Number of contacts of a kind whose loading is booked [1], and their work [J]."""
    page = bench.state.impacts.spectra.sum(axis=0)[kind, LOADING]
    assert np.all(page >= 0)
    return page[:, 0].sum(), (page[:, 1] / FINE * EDGES).sum()


def turn(m_eff, v, dt, k=K):
    """Square of the angle by which a contact turns in a substep."""
    return k / m_eff * dt * dt


def hysteretic(restitution=0.5):
    """A hysteretic pair of stiffness K on the line of loading."""
    return PairLaw(K, 0, 0, 1.0, 0.0, False, 0.3, 0.3, 0.05, 0.1, 0.9, unloading_ratio=restitution**-2)


def bounce(pair_law, m_eff, v, dt, phase, pair=True, sizes=(R, R), **options):
    """Two balls, or a ball and a floor, after a head-on impact at `v`, first seen a share of a substep after
    they touch.
    """
    gap = (3.0 + phase) * dt * v
    if pair:
        a, b = sizes
        x, speeds = [[0, 0, 0], [a + b + gap, 0, 0]], [[v, 0, 0], [0, 0, 0]]
        bench = Bench(x, pair_law, dt, radius=[a, b], velocities=speeds, **options)
    else:
        bench = Bench([0, 0, R + gap], pair_law, dt, [FLOOR], velocities=[0, 0, -v], **options)
    bench.step(10 + round(1.5 * math.pi * math.sqrt(m_eff / K) / dt))
    return bench


@pytest.mark.parametrize("phase", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("pair", [False, True])
def test_an_undamped_contact_loads_its_spring_with_the_energy_of_approach(pair, phase):
    # leapfrog: the amplitude is that of v^2 (1 - a^2 p (1 - p))/(1 - a^2/4), a the turn of a substep, p the
    # phase; the deepest overlap is right to the fourth order
    m_eff, v, dt = (M / 2 if pair else M), 0.7, 3e-6
    a2 = turn(m_eff, v, dt)
    bench = bounce(law(K), m_eff, v, dt, phase, pair)
    number, work = loading(bench, PAIR if pair else WALL)
    assert number == 1
    assert work == pytest.approx(0.5 * m_eff * v * v, rel=0.25 * a2 + a2 * a2 + ROUNDED)


@pytest.mark.parametrize("zeta", [0.1, 0.4])
def test_a_damped_contact_loads_its_spring_by_the_deepest_overlap_of_the_oscillator(zeta):
    # the substep in which a dashpot sets in is wrong by (a^2/8)(1 + 4 zeta) of the impulse at most
    v, dt = 0.7, 3e-6
    a2 = turn(M, v, dt)
    number, work = loading(bounce(law(K, zeta), M, v, dt, 0.3, pair=False), WALL)
    deep = largest_overlap(K, M, zeta, v)
    assert number == 1
    assert work == pytest.approx(0.5 * K * deep**2, rel=0.25 * a2 * (1 + 4 * zeta) + a2 * a2 + ROUNDED)


def test_two_spheres_of_different_stiffness_and_size_load_their_springs_in_series():
    a, b, v, dt = 0.0025, 0.004, 0.7, 2e-6
    two = law(0.0, a=4e7, b=1e7)
    ma, mb = sphere_mass(a), sphere_mass(b)
    m_eff = ma * mb / (ma + mb)
    k = spring_stiffness(two, 2 * a, 2 * b)
    laws = {(0, 0): two, (1, 1): two, (0, 1): two}
    bench = bounce(
        laws, m_eff, v, dt, 0.4, sizes=(a, b), materials=np.array([0, 1]), densities=[7863.7, 7863.7]
    )
    a2 = k / m_eff * dt * dt
    spectra = bench.state.impacts.spectra.sum(axis=0)[:, LOADING]
    numbers = spectra[..., 0].sum(axis=-1)
    assert numbers.sum() == numbers[1] + numbers[2] == 1
    work = (spectra[..., 1] / FINE * EDGES).sum()
    assert work == pytest.approx(0.5 * m_eff * v * v, rel=0.25 * a2 + a2 * a2 + ROUNDED)


def test_a_hertzian_contact_loads_its_spring_with_the_energy_of_approach():
    # its stiffness at the deepest is the largest: the angle of a substep is at most that of this stiffness
    v, dt, modulus = 0.7, 2e-6, 2e8
    pair_law = PairLaw(
        0, 0, 0, 1, 0, False, 0, 0, 0, 0.1, 0.9, contact_modulus=modulus, contact_shear_modulus=modulus
    )
    gap = 3.3 * dt * v
    bench = Bench([0, 0, R + gap], pair_law, dt, [FLOOR], velocities=[0, 0, -v], law=contact_law("hertz"))
    bench.step(200)
    deep = (15 / 16 * M * v * v / (modulus * math.sqrt(R))) ** 0.4
    a2 = 2 * modulus * math.sqrt(R * deep) / M * dt * dt
    assert bench.velocities[0, 2] > 0.0
    number, work = loading(bench, WALL)
    assert number == 1
    assert work == pytest.approx(0.5 * M * v * v, rel=a2 + ROUNDED)


def test_a_hysteretic_contact_loads_along_its_line_of_loading_up_to_the_deepest_overlap():
    v, dt = 0.7, 2e-6
    bench = Bench(
        [0, 0, R + 3.3 * dt * v],
        hysteretic(),
        dt,
        [FLOOR],
        velocities=[0, 0, -v],
        law=contact_law("hysteretic"),
    )
    bench.step(200)
    number, work = loading(bench, WALL)
    deep = bench.state.largest_overlap[1] * 2 * R
    a2 = turn(M, v, dt)
    assert number == 1
    assert work == pytest.approx(0.5 * K * deep**2, rel=1e-9 + ROUNDED)
    # the deepest sample is half a substep from rest at most
    assert work == pytest.approx(0.5 * M * v * v, rel=0.5 * a2)


@pytest.mark.parametrize("normal", ["linear", "hysteretic"])
def test_a_contact_that_is_pressed_again_counts_once_with_its_deepest(normal):
    # a ball rests in its dent; its weight grows over some periods and falls back, three times
    dt, least = 2e-6, 200.0
    pair_law = law(K) if normal == "linear" else hysteretic(0.8)
    bench = Bench([0, 0, R - M * least / K], pair_law, dt, [FLOOR], law=contact_law(normal))
    deepest = []
    for most in (400.0, 600.0, 500.0):
        for gravity in (*np.linspace(least, most, 60), *np.linspace(most, least, 60)):
            bench.model.gravity[2] = -gravity
            bench.step(20)
        number, work = loading(bench, WALL)
        deep = bench.state.largest_overlap[1] * 2 * R
        assert number == 1
        # of a linear spring the deepest overlap is between the samples
        assert work == pytest.approx(0.5 * K * deep**2, rel=turn(M, 1, dt) + ROUNDED)
        deepest.append(deep)
    assert deepest[1] > 1.2 * deepest[0] and deepest[2] == deepest[1]


def test_a_contact_between_others_bears_work_that_it_did_not_bring_along():
    # a ball strikes the first of two that touch: the second contact has no energy of approach
    v, dt = 1.0, 1e-6
    gap = 2.3 * dt * v
    x = np.array([[-2 * R - gap, 0, 0], [0, 0, 0], [2 * R - 1e-12, 0, 0]])
    bench = Bench(x, law(K), dt, velocities=[[v, 0, 0], [0, 0, 0], [0, 0, 0]])
    bench.step(400)

    def rates(t, y):
        forces = K * np.maximum(y[:2] - y[1:3], 0.0)
        return [*y[3:], -forces[0] / M, (forces[0] - forces[1]) / M, forces[1] / M]

    steps = np.linspace(0.0, 4e-4, 40001)
    y = solve_ivp(rates, (0, 4e-4), [0, 0, 0, v, 0, 0], "DOP853", steps, rtol=1e-10, atol=1e-16).y
    works = 0.5 * K * np.array([(y[0] - y[1]).max(), (y[1] - y[2]).max()]) ** 2
    page = bench.state.impacts.spectra.sum(axis=0)[PAIR]
    assert (page[:, :, 0].sum(axis=1) == 2).all()
    approach, work = (page[0, :, 1] / FINE * EDGES).sum(), (page[LOADING, :, 1] / FINE * EDGES).sum()
    assert approach == pytest.approx(0.25 * M * v * v, rel=1e-3)
    assert work == pytest.approx(works.sum(), rel=turn(M / 2, v, dt) + ROUNDED)
    assert works.min() > 0.3 * approach


def crowd(law_of=None, names=("linear",), precision="single", on=1):
    """Balls thrown at one another and at a floor, some of them lastingly in touch."""
    rng = np.random.default_rng(4)
    x = np.array([[a, b, c] for c in range(5) for a in range(6) for b in range(6)], float) * 2.05 * R
    bench = Bench(
        x + np.array([0, 0, R]),
        law_of or law(K, 0.2, friction=0.4, rolling=0.05),
        3e-6,
        [FLOOR],
        velocities=rng.normal(size=(len(x), 3)) - 30.0 * (x - x.mean(axis=0)),
        precision=precision,
        gravity=(0, 0, -50.0),
        law=contact_law(*names),
    )
    bench.state.impacts.on[0] = on
    return bench


@pytest.mark.parametrize("normal", ["linear", "hysteretic"])
def test_booking_leaves_every_bit_of_the_motion_as_it_is(normal):
    pair_law = None if normal == "linear" else hysteretic()
    on, off = (crowd(pair_law, (normal,), on=switch).step(600) for switch in (1, 0))
    assert loading(on, PAIR)[0] > 100
    assert not off.state.impacts.spectra.any() and not off.state.impacts.cut.any()
    for name in ("x", "v", "w", "published_rows", "ledger"):
        assert np.array_equal(getattr(on.state, name), getattr(off.state, name))


@pytest.mark.parametrize("normal", ["linear", "hysteretic"])
def test_of_a_wet_contact_the_solids_alone_are_loaded(normal):
    # the film brakes the ball before it touches, and again on its way out
    v, dt = 0.7, 2e-6
    pair_law = replace(
        law(K) if normal == "linear" else hysteretic(),
        liquid_viscosity=0.1,
        film_thickness=2e-5,
        film_roughness=1e-6,
    )
    benches = []
    for on in (1, 0):
        bench = Bench(
            [0, 0, R + 4e-5], pair_law, dt, [FLOOR], velocities=[0, 0, -v],
            law=contact_law(normal, film="viscous"),
        )  # fmt: skip
        bench.state.impacts.on[0] = on
        benches.append(bench.step(300))
    number, work = loading(benches[0], WALL)
    slowed = v - viscous_film.lost_momentum(pair_law, R) / M
    assert number == 1
    # the start of the contact and the deepest sample, each as in the dry test
    assert work == pytest.approx(0.5 * M * slowed**2, rel=turn(M, v, dt) + ROUNDED)
    assert work < 0.9 * 0.5 * M * v * v
    assert np.array_equal(benches[0].state.x, benches[1].state.x)
    assert np.array_equal(benches[0].state.v, benches[1].state.v)


def test_of_a_crowd_every_contact_that_has_ended_is_booked_once():
    # what is still being loaded is not booked yet: as many contacts as there are at most
    bench = crowd().step(1500)
    for kind in (PAIR, WALL):
        begun = bench.state.impacts.spectra.sum(axis=0)[kind, 0, :, 0].sum()
        number, _ = loading(bench, kind)
        assert begun - bench.reading().contacts[kind] <= number <= begun
