"""The test of steadiness, on records whose mean, correlation and drift are known."""

import math

import numpy as np
import pytest

from nutamill.base.steady import (
    correlation_length,
    drift,
    estimate_of_turns,
    interval,
    truncation,
    turn_means,
    turn_swings,
    whole_turns,
)


def autoregressive(phi: float, turns: int, records: int, seed: int = 1) -> np.ndarray:
    """Records (records, turns) of y[k] = phi y[k-1] + e[k], e standard normal, from its stationary law."""
    noise = np.random.default_rng(seed).standard_normal((records, turns))
    y = np.empty_like(noise)
    y[:, 0] = noise[:, 0] / math.sqrt(1.0 - phi**2)
    for k in range(1, turns):
        y[:, k] = phi * y[:, k - 1] + noise[:, k]
    return y


def variance_of_mean(phi: float, n: int) -> float:
    """Variance of the mean of n successive values of that law, exactly."""
    return ((1 + phi) / (1 - phi) - 2 * phi * (1 - phi**n) / (n * (1 - phi) ** 2)) / (n * (1 - phi**2))


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.8])
def test_correlation_length_is_that_of_an_autoregressive_record(phi):
    # (1 + phi)/(1 - phi); 20 records of 4000 turns. The estimate scatters by about sqrt(4 tau/n) ~ 10 % each
    # at phi = 0.8
    # (Sokal 1997, eq. 3.19 with a window of some tau), 2.2 % together, and the monotone sequence errs upwards
    # by a few per cent.
    length = np.mean([correlation_length(y) for y in autoregressive(phi, 4000, 20)])
    assert length == pytest.approx((1 + phi) / (1 - phi), rel=0.1)


@pytest.mark.parametrize(("phi", "turns"), [(0.0, 40), (0.5, 200)])
def test_interval_is_as_wide_as_the_mean_scatters(phi, turns):
    # half width over 1.96 standard deviations of the mean: Student's law and the estimated correlation widen
    # or narrow it by less than 15 %
    records = autoregressive(phi, turns, 400)
    widths = [interval(y, correlation_length(y)) for y in records]
    assert np.median(widths) == pytest.approx(1.96 * math.sqrt(variance_of_mean(phi, turns)), rel=0.15)


def test_interval_holds_the_true_mean_as_often_as_it_says():
    # 400 records: 95 % of them, within three standard deviations of a binomial law, 3 x 1.1 %, and 4 % for
    # the estimated correlation
    records = 7.0 + autoregressive(0.5, 200, 400)
    held = np.mean(
        [abs((estimate := estimate_of_turns(y)).mean - 7.0) < estimate.half_width for y in records]
    )
    assert 0.95 - 0.033 - 0.04 < held <= 0.95 + 0.033


def test_correlated_turns_give_a_wider_interval_than_independent_ones():
    y = autoregressive(0.8, 500, 1)[0]
    shuffled = np.random.default_rng(2).permutation(y)
    ratio = interval(y, correlation_length(y)) / interval(shuffled, correlation_length(shuffled))
    assert ratio == pytest.approx(
        3.0, rel=0.35
    )  # sqrt((1 + 0.8)/(1 - 0.8)) = 3; each correlation is known to about 30 %


def test_transient_is_cut_off_and_the_rest_is_steady():
    # 5 exp(-k/5) is below the scatter of 0.3 after 14 turns; the scatter of a mean of some 80 turns is 0.033
    y = 10.0 + 5.0 * np.exp(-np.arange(100) / 5.0) + 0.3 * autoregressive(0.0, 100, 1, seed=4)[0]
    estimate = estimate_of_turns(y)
    assert 8 <= estimate.first <= 30
    assert estimate.steady
    assert abs(estimate.mean - 10.0) < 0.1
    assert abs(y.mean() - 10.0) > 0.15  # what the transient does to the plain mean: 5 x 5/100


def test_rule_cuts_where_the_marginal_standard_error_is_least():
    y = 3.0 + 2.0 * np.exp(-np.arange(60) / 4.0) + 0.1 * autoregressive(0.3, 60, 1, seed=6)[0]
    errors = [np.sum((y[d:] - y[d:].mean()) ** 2) / (len(y) - d) ** 2 for d in range(31)]
    assert truncation(y) == int(np.argmin(errors))


def test_record_that_drifts_is_not_steady_and_has_its_drift():
    y = 9.0 + 0.02 * np.arange(60) + 0.05 * autoregressive(0.0, 60, 1, seed=3)[0]
    estimate = estimate_of_turns(y)
    assert not estimate.steady
    assert estimate.drift == pytest.approx(0.02 * (estimate.turns - 1), rel=0.1)


def test_slope_of_a_line_without_scatter_is_exact():
    change, doubt = drift(5.0 - 0.3 * np.arange(40))
    assert change == pytest.approx(-0.3 * 39, rel=1e-12)
    assert doubt == pytest.approx(0.0, abs=1e-9)


def test_drift_too_small_to_matter_is_steady():
    # no scatter at all, so that any drift is sure: 0.5 % over the record is within 1 %, not within 0.1 %
    y = np.linspace(100.0, 100.5, 50)
    assert estimate_of_turns(y).steady
    assert not estimate_of_turns(y, precision=0.001).steady


def test_constant_record_is_steady_and_certain():
    estimate = estimate_of_turns(np.full(20, 719.0))
    assert (estimate.steady, estimate.first, estimate.turns, estimate.half_width, estimate.mean) == (
        True,
        0,
        20,
        0.0,
        719.0,
    )


def test_few_turns_and_numbers_that_are_none_are_refused():
    with pytest.raises(ValueError, match="needs at least 5 whole turns, got 4"):
        estimate_of_turns([1.0, 2.0, 1.0, 2.0])
    with pytest.raises(ValueError, match="must be finite numbers"):
        estimate_of_turns([1.0, 2.0, math.nan, 2.0, 1.0])


def test_turns_are_counted_back_from_the_end_and_ripple_leaves_no_trace():
    time = np.linspace(0.0, 1.0, 1001)
    angle = 2.0 * math.pi * 3.5 * time
    turns = whole_turns(time, angle)
    assert turns == pytest.approx([0.5 / 3.5, 1.5 / 3.5, 2.5 / 3.5, 1.0])
    value = 4.0 + np.sin(angle)
    # trapezoids of a sine: (phase step)^2/12 of its size, and broken samples at the ends of a turn, (phase
    # step)^2/2 per turn
    assert turn_means(time, value, turns) == pytest.approx([4.0] * 3, abs=(0.0035 * 2 * math.pi) ** 2)
    assert turn_swings(time, value, turns) == pytest.approx([1.0] * 3, abs=(0.0035 * 2 * math.pi) ** 2)
