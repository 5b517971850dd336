"""Breakage of single particles and the population balance, against closed forms and published numbers."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.stats import poisson

from nutamill.analysis.breakage import laws
from nutamill.analysis.breakage.balance import (
    Balance,
    grind,
    middles,
    passing_of,
    percentile,
    shares_of,
    size_edges,
)
from nutamill.analysis.breakage.conditions import (
    moves_to,
    response,
    unharmed,
)
from nutamill.analysis.breakage.impacts import DENSEST, Impacts, captured_mass
from nutamill.analysis.breakage.ore import Ore, load_ore, steepness_of
from nutamill.analysis.breakage.rates import fragments, rates_of

WEAKENING = {
    "source": "made up for tests",
    "density": 2700.0,
    "feed": 1e-3,
    "feed_exponent": 2.0,
    "product": 1e-4,
    "fineness": 0.8,
    "tavares": {
        "A": 60.0,
        "steepness": 0.03,
        "fracture_energy": 100.0,
        "half_size": 1e-3,
        "size_exponent": 1.2,
        "spread": 0.5,
        "largest": 4.0,
        "damage_exponent": 5.0,
    },
}


@pytest.fixture(scope="module", params=["drop weight", "fracture energies"])
def ore(request):
    """An ore of each law."""
    return load_ore("smc-sample-a") if request.param == "drop weight" else Ore.model_validate(WEAKENING)


def impacts(energies, numbers, radius=0.00125):
    """Impacts of these energies [J], so many per joule."""
    edges = np.append(energies, energies[-1] * 2.0)
    rows = np.array(energies)[None], np.array(numbers, float)[None]
    return Impacts(edges, 100.0 * rows[1], rows[0], rows[1], np.array([[radius]]))


MANY = impacts(np.geomspace(1e-5, 1e-1, 20), np.geomspace(1e3, 1e-2, 20))


def test_drop_weight_law_has_the_slope_a_b_at_no_energy_and_reaches_a():
    small = 1e-9
    assert laws.fineness_of_impact(0.5, small, 0.0, 0.3) / small == pytest.approx(0.5 * 0.3, rel=1e-9)
    assert laws.fineness_of_impact(0.5, 1e6, 0.0, 0.3) == 0.5


def test_no_particle_breaks_below_the_least_energy():
    assert laws.breakage_probability(np.array([0.0, 4.9, 5.0]), 5.0, 0.3).tolist() == [0.0, 0.0, 0.0]
    assert laws.breakage_probability(5.1, 5.0, 0.3) > 0.0


def test_two_loadings_are_survived_as_often_as_one_of_their_sum():
    survived = (1.0 - laws.breakage_probability(7.0, 5.0, 0.3)) * (
        1.0 - laws.breakage_probability(9.0, 5.0, 0.3)
    )
    assert survived == pytest.approx(1.0 - laws.breakage_probability(5.0 + 2.0 + 4.0, 5.0, 0.3), rel=1e-14)


@pytest.mark.parametrize("g", [1.0, 5.0, 20.0])
def test_damage_is_that_of_a_contact_whose_stiffness_fades(g):
    def work(x):
        return quad(lambda u: (1.0 - u**g) * u**1.5, 0.0, x, epsabs=0.0, epsrel=1e-12)[0]

    for lost in (0.01, 0.3, 0.9):
        assert laws.damage(work(lost ** (1.0 / g)) / work(1.0), g) == pytest.approx(lost, rel=1e-9)
    assert laws.damage(np.array([0.0, 1.0, 2.0]), g) == pytest.approx([0.0, 1.0, 1.0], abs=1e-9)


def test_a_weak_loading_breaks_after_some_repetitions_and_never_without_damage():
    left, loadings = 1.0, 0
    while left > 0.6:
        left = float(laws.weakened(left, laws.damage(0.6 / left, 5.0)))
        loadings += 1
    # closed form: the first loading leaves 1 - D with D^(1/2) (15 - 5 D)/10 = 0.6
    first = float(laws.damage(0.6, 5.0))
    assert math.sqrt(first) * (1.5 - 0.5 * first) == pytest.approx(0.6, rel=1e-12)
    assert 1 < loadings < 5 and laws.weakened(1.0, 0.0) == 1.0


def test_cut_lognormal_law_and_its_inverse():
    energy = laws.fracture_energy_at(np.array([0.01, 0.5, 0.99]), 100.0, 0.5, 4.0)
    assert laws.fracture_share(energy, 100.0, 0.5, 4.0) == pytest.approx([0.01, 0.5, 0.99], rel=1e-12)
    assert laws.fracture_share(np.array([399.9, 400.0, 1e9]), 100.0, 0.5, 4.0) == pytest.approx(1.0)
    # uncut, e^s above the median is one standard deviation
    uncut = laws.fracture_share(100.0 * math.exp(0.5), 100.0, 0.5, 1e12)
    assert uncut == pytest.approx(0.5 * (1.0 + math.erf(math.sqrt(0.5))), rel=1e-9)


def test_particles_of_the_half_size_are_twice_as_strong():
    strong = laws.median_fracture_energy(np.array([1e-3, 1e3]), 100.0, 1e-3, 1.2)
    assert strong == pytest.approx([200.0, 100.0], rel=1e-6)


def test_sizes_of_fragments_pass_t10_at_a_tenth_and_all_at_the_particle():
    n = np.array([1e9, 75.0, 10.0, 4.0, 2.0, 1.0, 0.5])
    finer = laws.finer_share(0.2, n, 0.8)
    assert finer[2] == pytest.approx(0.2, rel=1e-14) and finer[0] < 1e-6 and finer[-2:].tolist() == [1.0, 1.0]
    assert np.all(np.diff(finer[:-1]) > 0.0)


SMC = {
    (87.9, 0.31): ((0.10, 0.39), (0.20, 0.82), (0.30, 1.31)),
    (84.3, 0.31): ((0.10, 0.41), (0.20, 0.88), (0.30, 1.40)),
}
"""A [%] and b [t/kWh] of two samples, and the energies [kWh/t] printed for t10 at 28.9 mm: SMC Testing, About
the SMC Test, table 1.
"""


@pytest.mark.parametrize("sample", SMC)
def test_published_energies_of_the_drop_weight_table(sample):
    a, b = sample
    for t10, printed in SMC[sample]:
        computed = -math.log1p(-t10 / (a / 100.0)) / b
        assert laws.fineness_of_impact(a / 100.0, computed, 0.0, b) == pytest.approx(t10, rel=1e-12)
        # b has two digits, the energy two decimals; the table itself is a fit, of 1 %
        assert computed == pytest.approx(printed, rel=0.005 / b + 0.005 / printed + 0.01)


def uniform(edges, power):
    """Rates of particles that break at size^power into uniform fragments, as Ziff and McGrady have them."""
    size, n = middles(edges), len(edges) - 1
    births = np.zeros((n, 1, n + 1))
    for j in range(n):
        births[j, 0] = size[j] ** power * shares_of(np.minimum((edges / size[j]) ** 2, 1.0))
    return Balance(-births.sum(axis=2)[:, :, None], births, np.ones(1))


def test_fragmentation_of_ziff_and_mcgrady_at_a_rate_of_size_squared():
    """n = 2 t l exp(-t x^2) below l, exp(-t l^2) at l: the mass coarser than x is exp(-t x^2)."""
    edges = size_edges(1.0, 1e-3)
    feed = np.append(1.0, np.zeros(len(edges) - 1))
    times = np.geomspace(1e-2, 1e4, 9)
    coarser = 1.0 - passing_of(grind(uniform(edges, 2), feed, times))
    # a class passes what it passes to finer ones at the rate of its lower edge: exact at every edge
    exact = np.exp(-times[:, None] * edges[1:] ** 2)
    assert coarser[:, 1:] == pytest.approx(exact, abs=1e-11)


def test_random_scission_of_ziff_and_mcgrady_is_approached_with_the_classes():
    """n = exp(-t x) (2 t + t^2 (l - x)) below l, exp(-t l) at l, at a rate of the size."""
    time, errors = 5.0, []
    for ratio in (2.0**0.25, 2.0**0.125, 2.0**0.0625):
        edges = ratio ** -np.arange(round(math.log(1e4) / math.log(ratio)) + 1.0)
        feed = np.append(1.0, np.zeros(len(edges) - 1))
        passing = passing_of(grind(uniform(edges, 1), feed, np.array([time])))[0]
        exact = [
            quad(lambda x: x * math.exp(-time * x) * (2 * time + time**2 * (1 - x)), 0.0, edge)[0]
            for edge in edges[1:]
        ]
        errors.append(np.abs(passing[1:] - exact).max())
    assert errors[0] < 0.05 and errors[0] / errors[1] > 1.8 and errors[1] / errors[2] > 1.8


def test_the_inverse_laplace_transform_is_the_exponential_of_the_matrix():
    edges, draw = size_edges(1.0, 0.2), np.random.default_rng(1)
    n, k = len(edges) - 1, 3
    births, moves = np.triu(draw.random((k, n, n + 1))).transpose(1, 0, 2), draw.random((n, k, k))
    losses = births.sum(2) + moves.sum(1)
    within = moves - np.stack([np.diag(loss) for loss in losses])
    fresh, feed = np.array([0.5, 0.3, 0.2]), draw.random(n + 1)
    matrix = np.zeros((n * k + 1, n * k + 1))
    for i in range(n):
        here = slice(i * k, (i + 1) * k)
        matrix[here, here] += within[i]
        for j in range(n):
            matrix[j * k : (j + 1) * k, here] += np.outer(fresh, births[i, :, j])
        matrix[-1, here] = births[i, :, n]
    start = np.append(np.outer(feed[:n], fresh).ravel(), feed[n])
    for energy in (0.01, 3.0):
        whole = expm(energy * matrix) @ start
        exact = np.append(whole[:-1].reshape(n, k).sum(1), whole[-1])
        assert grind(Balance(within, births, fresh), feed, np.array([energy]))[0] == pytest.approx(
            exact, abs=1e-11
        )


def test_mass_is_conserved(ore):
    rates = rates_of(ore, MANY, size_edges(ore.top_size, ore.product / 8.0))
    assert rates.feed.sum() == pytest.approx(1.0, abs=1e-12)
    mass = grind(rates.balance, rates.feed, np.geomspace(1.0, 1e7, 8))
    assert mass.sum(axis=1) == pytest.approx(1.0, abs=1e-12) and mass.min() > -1e-12
    assert mass[-1, 0] < 0.5 * mass[0, 0]


def test_fragments_of_every_fineness_have_the_mass_of_the_particle():
    edges = size_edges(1e-3, 1e-5)
    assert fragments(9e-4, edges, 0.8, np.linspace(0.0, 0.6, 5)).sum(axis=1) == pytest.approx(1.0, abs=1e-12)


def test_selection_is_impacts_times_captured_mass_times_probability():
    ore, energy, often = load_ore("smc-sample-a"), 0.02, 3.0
    edges = size_edges(ore.top_size, ore.product)
    rates = rates_of(ore, impacts([energy], [often]), edges)
    law, size = ore.drop_weight, middles(edges)[2]
    mass = float(captured_mass(size, np.array(0.00125), ore.density))
    weakness = steepness_of(law) * (size / law.size) ** law.size_exponent
    assert rates.selection[2] == pytest.approx(often * mass * (1.0 - math.exp(-weakness * energy / mass)))


def test_a_layer_fills_the_gap_of_two_balls_and_holds_one_particle_at_least():
    radius, density = 0.00125, 3000.0
    size = 1e-5
    disc = math.pi * 2.0 * radius * size  # gap r^2/(2 R) up to the size
    particles = DENSEST * disc / (0.25 * math.pi * size**2)
    assert captured_mass(size, radius, density) == pytest.approx(
        particles * math.pi / 6.0 * size**3 * density
    )
    assert captured_mass(0.1, radius, density) == pytest.approx(math.pi / 6.0 * 1e-3 * density)


def test_every_particle_breaks_moves_or_stays(ore):
    does = response(ore.breakage, 5e-4, np.geomspace(1.0, 1e5, 12))
    gone = does.broken + does.moves.sum(axis=1)
    assert unharmed(ore.breakage).sum() == pytest.approx(1.0, abs=1e-14)
    assert gone.min() >= 0.0 and gone.max() <= 1.0 + 1e-12
    grid = np.array([0.0, 1.0, 1.5, 4.0])
    after = grid[:, None] + np.array([[0.0, 0.3, 1.7]])
    moves = moves_to(grid, after, np.ones_like(after))
    reached = np.einsum("ijk,j->ik", moves, grid) + (1.0 - moves.sum(axis=1)) * grid[:, None]
    assert reached == pytest.approx(np.minimum(after, 4.0), abs=1e-12)


def test_repeated_weak_impacts_break_as_the_recursion_of_single_particles():
    """Impacts of one energy come by chance; after k of them a particle of each strength has broken or not."""
    ore = Ore.model_validate(WEAKENING)
    law, energy = ore.tavares, 0.002
    edges = size_edges(ore.top_size, ore.product)
    size, mean = middles(edges)[0], 4.0
    mass = float(captured_mass(size, np.array(0.00125), ore.density))
    median = float(laws.median_fracture_energy(size, law.fracture_energy, law.half_size, law.size_exponent))
    rates = rates_of(ore, impacts([energy], [1.0]), edges)
    births = np.zeros_like(rates.balance.births)
    births[..., -1] = rates.balance.births.sum(axis=2)  # what breaks leaves
    feed = np.append(1.0, np.zeros(len(rates.feed) - 1))
    left = grind(rates.balance._replace(births=births), feed, np.array([mean / mass]))[0, 0]
    share = (np.arange(4000) + 0.5) / 4000
    strength = laws.fracture_energy_at(share, median, law.spread, law.largest)
    specific, unbroken, whole = energy / mass, np.ones_like(share), 0.0
    for k in range(40):
        whole += poisson.pmf(k, mean) * unbroken.mean()
        unbroken = np.where(strength <= specific, 0.0, unbroken)
        lost = laws.damage(np.minimum(specific / strength, 1.0), law.damage_exponent)
        strength = np.where(strength <= specific, strength, laws.weakened(strength, lost))
    print(left, whole)
    assert 0.1 < whole < 0.9 and left == pytest.approx(whole, abs=0.02)


def test_percentile_is_read_on_logarithmic_lines():
    edges = np.array([1.0, 0.5, 0.25])
    passing = np.array([1.0, 0.5, 0.25])
    assert percentile(edges, passing) == pytest.approx(0.8)
    assert percentile(edges, np.array([1.0, 0.9, 0.85])) == 0.25
