"""Sizes of particles against the closed forms of their laws."""

import math

import numpy as np
import pytest
from scipy.special import gamma, gammainc, ndtr

from nutamill.charge.particles.sizes import (
    CELLS,
    SizeClasses,
    mass_percentiles,
    normal_sizes,
    rosin_rammler_sizes,
)

MM = 1e-3


def kolmogorov_smirnov(sizes, below):
    """Largest distance of the staircase of a sample, each particle counting alike, from a distribution."""
    exact = below(np.sort(sizes))
    steps = np.arange(len(sizes) + 1) / len(sizes)
    return max(np.abs(exact - steps[1:]).max(), np.abs(exact - steps[:-1]).max())


def between(below, smallest, largest):
    """A distribution, cut."""
    return lambda d: (below(d) - below(smallest)) / (below(largest) - below(smallest))


def table_error(law, below):
    """Half the steepest step of a law over one cell of its table: what linear interpolation may be wrong by
    at most.
    """
    d = np.geomspace(law.diameter[0], law.diameter[-1], CELLS + 1)
    return 0.5 * np.diff(below(d)).max()


def test_a_normal_law_of_numbers_is_met_within_half_a_particle():
    below = between(lambda d: ndtr((d - 3.4 * MM) / (0.5 * MM)), 2.5 * MM, 4.5 * MM)
    law = normal_sizes(3.4 * MM, 0.5 * MM, 2.5 * MM, 4.5 * MM, "number")
    for n in (1, 10, 997):
        sizes = law.of_number(n)
        assert len(sizes) == n
        # sizes are the (i + 1/2)/n quantiles: the staircase is 1/(2 n) off at each
        assert kolmogorov_smirnov(sizes, below) <= 0.5 / n + table_error(law, below)


def test_a_rosin_rammler_law_of_mass_is_met_within_half_a_particle():
    # shares of number are those of mass over d^3: with x = (d/d')^k the density of number is x^(-3/k)
    # exp(-x), an incomplete gamma
    # function of index 1 - 3/k
    size, k, smallest, largest = 3 * MM, 5.0, 1 * MM, 5 * MM
    below = between(lambda d: gammainc(1 - 3 / k, (d / size) ** k), smallest, largest)
    law = rosin_rammler_sizes(size, k, smallest, largest)
    for n in (10, 1000):
        assert kolmogorov_smirnov(law.of_number(n), below) <= 0.5 / n + table_error(law, below)


def by_mass(sizes, below):
    """Largest distance of the staircase of a sample, each particle counting with its mass, from a
    distribution.
    """
    sizes = np.sort(sizes)
    steps = np.concatenate([[0.0], np.cumsum(sizes**3) / (sizes**3).sum()])
    exact = below(sizes)
    return max(np.abs(exact - steps[1:]).max(), np.abs(exact - steps[:-1]).max())


@pytest.mark.parametrize("exponent", [1.5, 3.0, 8.0])
def test_a_sample_of_a_rosin_rammler_law_weighs_as_it_says(exponent):
    size, smallest, largest, n = 3 * MM, 1 * MM, 5 * MM, 4000
    below = between(lambda d: -np.expm1(-((d / size) ** exponent)), smallest, largest)
    law = rosin_rammler_sizes(size, exponent, smallest, largest)
    sizes = law.of_number(n)
    # of the n equal shares of the number each is one particle of a size within the share: their masses are
    # off by no more than the mass
    # at the two ends of the share, summed by no more than that of the largest less that of the smallest;
    # whole and part: twice; and the
    # staircase has a step of the largest
    span = 2 * (largest**3 - smallest**3) + largest**3
    assert by_mass(sizes, below) <= span / (sizes**3).sum() + table_error(law, below)


def test_a_normal_law_may_give_shares_of_the_mass():
    below = between(lambda d: ndtr((d - 3 * MM) / (0.5 * MM)), 2 * MM, 4 * MM)
    law, n = normal_sizes(3 * MM, 0.5 * MM, 2 * MM, 4 * MM, "mass"), 4000
    sizes = law.of_number(n)
    span = 2 * (4**3 - 2**3) + 4**3
    assert by_mass(sizes, below) <= span / ((sizes / MM) ** 3).sum() + table_error(law, below)
    # a law of mass has more small particles than the same law of numbers: half the mass is below 3 mm, more
    # than half the number
    assert (sizes < 3 * MM).mean() > 0.6


def test_the_mean_volume_of_a_law_is_its_third_moment():
    # uncut in effect above: exp(-(8/2)^4) of the mass is coarser
    size, k = 2 * MM, 4.0
    law = rosin_rammler_sizes(size, k, 1e-5 * MM, 8 * MM)
    # mass over number: 1 over the integral of the density of mass over the volume
    exact = math.pi / 6 * size**3 / gamma(1 - 3 / k)
    # below the lower cut is the share 4 (d/d')^(k - 3) / gamma(1/4) of the number: 1.1 x 5e-6
    assert law.mean_volume == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("volume", [1e-9, 3.3e-7, 1e-5])
def test_a_volume_is_met_by_the_fewest_particles(volume):
    for law in (
        rosin_rammler_sizes(3 * MM, 3.0, 1 * MM, 5 * MM),
        normal_sizes(3 * MM, 0.3 * MM, 2 * MM, 4 * MM, "number"),
    ):
        sizes = law.of_volume(volume)
        solid = math.pi / 6 * (sizes**3).sum()
        fewer = math.pi / 6 * (law.of_number(len(sizes) - 1) ** 3).sum()
        assert fewer < volume * (1 + 1e-12) and solid >= volume - 1e-6 * law.mean_volume


def test_each_class_gets_the_fewest_particles_that_weigh_its_share():
    sizes = SizeClasses(((4 * MM, 0.3), (5 * MM, 0.7))).of_volume(1e-5)
    # 0.3e-5 / (pi/6 0.004^3) = 89.5 and 0.7e-5 / (pi/6 0.005^3) = 106.95
    assert [int((sizes == d).sum()) for d in (4 * MM, 5 * MM)] == [90, 107]


def test_classes_of_a_number_of_particles_share_it_by_mass_over_volume():
    # numbers as 0.3/4^3 to 0.7/5^3: 0.0046875 to 0.0056, that is 45.56 % and 54.44 %
    classes = SizeClasses(((4 * MM, 0.3), (5 * MM, 0.7)))
    for number in (1, 2, 7, 100, 12345):
        sizes = classes.of_number(number)
        assert len(sizes) == number
        assert abs((sizes == 4 * MM).sum() - number * 0.0046875 / 0.0102875) < 1
    assert classes.mean_volume == pytest.approx(
        math.pi / 6 / (0.3 / (4 * MM) ** 3 + 0.7 / (5 * MM) ** 3), rel=1e-14
    )


def test_percentiles_are_of_mass():
    # 9 of volume 1 and one of volume 91: the ten per cent lie at the large one's foot
    assert mass_percentiles(np.array([2.0, *[1.0] * 9]), np.array([91.0, *[1.0] * 9])) == [2.0, 2.0, 2.0]
    assert mass_percentiles(np.arange(1.0, 11.0), np.ones(10), (0.1, 0.5, 0.9)) == [1.0, 5.0, 9.0]


def test_cuts_beyond_the_law_are_refused():
    with pytest.raises(ValueError, match="the law has no share between the cuts"):
        normal_sizes(3 * MM, 0.1 * MM, 5 * MM, 6 * MM, "number")
