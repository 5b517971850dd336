"""Synthetic twins of an identification: drawn values are inside their intervals as often as stated."""

import numpy as np
import pytest
from scipy import stats

from nutamill.studies.identify.emulator import fit_emulator
from nutamill.studies.identify.inputs import Inputs
from nutamill.studies.identify.posterior import Evidence, sample_posterior
from nutamill.studies.identify.sample import filling_points

SEEDS = 100
NOISE = (0.06, 0.05, 0.04)
NO_GAINS = np.array([], dtype=int), np.zeros((0, 2))


def model(points):
    """Three rows of two unknowns, mass and stiffness: amplitude below resonance, frequency, product."""
    mass, stiffness = 1.0 + points[:, 0], 2.0 + 2.0 * points[:, 1]
    return np.stack(
        [1.0 / (stiffness - 0.5 * mass), np.sqrt(stiffness / mass), mass * stiffness / 4.0], axis=1
    )


@pytest.fixture(scope="module")
def twins():
    """The posterior of each seed: the drawn point, and points of the posterior."""
    points = filling_points(2, 30, 1)
    values = model(points)
    both = Inputs(np.eye(2))
    emulators = [
        fit_emulator(points, values[:, k], both, *NO_GAINS, f"row {k}", NOISE[k]) for k in range(len(NOISE))
    ]
    drawn = []
    for seed in range(SEEDS):
        rng = np.random.default_rng(seed)
        truth = rng.random(2)
        measured = model(truth[None])[0] + rng.standard_normal(len(NOISE)) * NOISE
        rows = [Evidence(*row) for row in zip(emulators, measured, NOISE, strict=True)]
        drawn.append((truth, sample_posterior(rows, 2, seed, most_steps=200).points))
    return drawn


def test_intervals_of_90_percent_hold_the_drawn_value_in_82_to_97_of_100_twins(twins):
    # 82 to 97 is the 99 % band of a binomial of 100 trials with 0.9
    assert stats.binom.interval(0.99, SEEDS, 0.9) == (82, 97)
    for unknown in range(2):
        inside = sum(
            low <= truth[unknown] <= high
            for truth, points in twins
            for low, high in [np.quantile(points[:, unknown], (0.05, 0.95))]
        )
        assert 82 <= inside <= 97


def test_ranks_of_the_drawn_values_are_even(twins):
    # Talts et al. 2018: the rank of the drawn value among points of its posterior is uniform
    for unknown in range(2):
        ranks = [np.mean(points[:, unknown] < truth[unknown]) for truth, points in twins]
        histogram = np.histogram(ranks, bins=10, range=(0.0, 1.0))[0]
        assert stats.chisquare(histogram).pvalue > 0.01, histogram
