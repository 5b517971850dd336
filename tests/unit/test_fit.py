"""Fits: a linear model must give the textbook answer, a fit file its runs, and what cannot be fitted is
refused.
"""

from pathlib import Path

import numpy as np
import pytest

from nutamill.analysis.values import Reading
from nutamill.base.errors import CaseError, StepError
from nutamill.base.steady import Estimate
from nutamill.studies import fit as fitting
from nutamill.studies import measurand
from nutamill.studies.least_squares import Free, fitted
from nutamill.studies.table import Outcome

MATRIX = np.array([[1.0, 2.0], [3.0, -1.0], [0.5, 0.5], [2.0, 2.0]])
TRUTH, SIGMA = np.array([0.4, -1.2]), np.array([0.1, 0.2, 0.1, 0.4])
FREE = [Free("a", 0.0, -2.0, 2.0), Free("b", 0.1, -3.0, 3.0)]


def linear(points):
    return points @ MATRIX.T


def test_linear_model_gives_the_weighted_least_squares_answer():
    measured = MATRIX @ TRUTH + np.array([0.05, -0.1, 0.02, 0.1])
    solution = fitted(FREE, measured, SIGMA, linear)
    weighted = MATRIX / SIGMA[:, None]
    covariance = np.linalg.inv(weighted.T @ weighted)
    expected = covariance @ weighted.T @ (measured / SIGMA)
    # the search ends when a step is below 1e-3 of its size, and on a linear problem each step is the whole
    # way
    assert solution.values == pytest.approx(expected, abs=1e-3)
    assert solution.uncertainty == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-6)
    assert solution.correlation[0, 1] == pytest.approx(
        covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1]), rel=1e-6
    )
    assert (solution.freedom, solution.converged) == (2, True)
    assert solution.chi_squared == pytest.approx(
        np.sum(((MATRIX @ expected - measured) / SIGMA) ** 2), rel=1e-3
    )


def test_residuals_beyond_the_stated_uncertainties_widen_those_of_the_values():
    measured = MATRIX @ TRUTH + np.array([1.0, -1.0, 1.0, -1.0])
    solution = fitted(FREE, measured, SIGMA, linear)
    weighted = MATRIX / SIGMA[:, None]
    plain = np.sqrt(np.diag(np.linalg.inv(weighted.T @ weighted)))
    assert solution.uncertainty == pytest.approx(plain * np.sqrt(solution.chi_squared / 2), rel=1e-6)
    assert solution.chi_squared > 2


def test_point_and_its_differences_are_computed_in_one_call():
    calls = []

    def count(points):
        calls.append(len(points))
        return linear(points)

    solution = fitted(FREE, MATRIX @ TRUTH, SIGMA, count)
    assert set(calls) == {3}
    assert len(calls) == solution.evaluations


def test_no_point_beyond_the_bounds_is_ever_computed():
    free = [
        Free("a", 1.999, -2.0, 2.0),
        Free("b", -2.999, -3.0, 3.0),
    ]  # within one difference of an upper and a lower bound

    def guarded(points):
        assert np.all(points >= [-2.0, -3.0]) and np.all(points <= [2.0, 3.0])
        return linear(points)

    assert fitted(free, MATRIX @ TRUTH, SIGMA, guarded).values == pytest.approx(TRUTH, abs=1e-2)


def test_value_on_its_bound_is_marked():
    solution = fitted([FREE[0], Free("b", 0.1, -1.0, 3.0)], MATRIX @ TRUTH, SIGMA, linear)
    assert solution.values[1] == pytest.approx(-1.0, abs=1e-3)
    assert not solution.at_bound[0]


def test_keys_that_no_target_depends_on_or_that_act_alike_are_named():
    with pytest.raises(CaseError, match="free b: no target depends on it"):
        fitted(FREE, np.ones(4), SIGMA, lambda points: points[:, :1] * np.ones(4))
    with pytest.raises(CaseError, match="the targets cannot separate: a, b"):
        fitted(
            FREE,
            np.ones(4),
            SIGMA,
            lambda points: (points[:, :1] + 2.0 * points[:, 1:]) * np.arange(1.0, 5.0),
        )


def test_too_few_targets_and_guesses_out_of_bounds_are_refused_together():
    with pytest.raises(CaseError) as raised:
        fitted([FREE[0], Free("b", 4.0, -3.0, 3.0)], np.ones(1), np.zeros(1), linear)
    assert [str(fault) for fault in raised.value.faults] == [
        "free b: must have low < start < high, got -3, 4, 3 (SI)",
        "target: there must be as many targets as free keys or more, got 1 for 2. Fix some keys",
        "target 1: must have an uncertainty above zero, got 0",
    ]


FILE = """
case = "numill"
[set]
"charge.kind" = "none"
"mechanism.mounting" = "rigid"
[free]
"mechanism.joint_friction" = { start = 0.02, low = 0.0, high = 0.2 }
"mechanism.joint_friction_constant" = { start = "0.1 N m", low = "0 N m", high = "500 N mm" }
[[target]]
quantity = "driveshaft_torque"
value = "0.35 N m"
uncertainty = "20 N mm"
set = { "drive.speed" = "400 rpm" }
[[target]]
quantity = "driveshaft_torque"
value = "0.67 N m"
uncertainty = "20 N mm"
[[target]]
quantity = "natural_frequency 1"
value = "7.88 Hz"
uncertainty = "0.1 Hz"
set = { "mechanism.mounting" = "flexible" }
"""


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """A fit file, and runs replaced by a torque of constant + friction x 10 x (speed/100)^2 and a frequency
    of 8 Hz - friction.
    """
    (tmp_path / "fit.toml").write_text(FILE)

    def run_all(runs, folder, workers, readings, report, log):
        def torque(case):
            return (
                case.mechanism.joint_friction_constant
                + 10.0 * case.mechanism.joint_friction * (case.drive.speed / 100.0) ** 2
            )

        return [
            Outcome(
                one,
                folder,
                "complete",
                {Reading("driveshaft_torque"): Estimate(torque(one.case), 0.0, 0.0, 9, True)},
            )
            for one in runs
        ]

    monkeypatch.setattr(fitting, "run_all", run_all)
    monkeypatch.setattr(measurand, "oscillations", lambda case: [(8.0 - case.mechanism.joint_friction, 0.1)])
    return tmp_path / "fit.toml"


def test_fit_file_finds_two_keys_from_runs_and_a_mode(bench, tmp_path):
    result = fitting.fit(bench, tmp_path)
    speed = np.array([400.0, 700.0]) * np.pi / 30.0 / 100.0
    # two torques, two keys: solved exactly but for the frequency, which is one part in a thousand of the
    # weight
    friction = (0.67 - 0.35) / (10.0 * (speed[1] ** 2 - speed[0] ** 2))
    assert result.best.values == pytest.approx([friction, 0.35 - 10.0 * friction * speed[0] ** 2], rel=0.02)
    text = "\n".join(result.lines())
    assert "mechanism.joint_friction_constant" in text and " N m" in text
    assert "driveshaft torque, drive.speed = 400 rpm" in text and "natural frequency 1" in text
    assert "correlation" in text


def test_run_that_does_not_end_stops_the_fit_and_is_named(bench, tmp_path, monkeypatch):
    monkeypatch.setattr(
        fitting,
        "run_all",
        lambda runs, *_: [Outcome(one, tmp_path, "its process was killed (SIGKILL)", {}) for one in runs],
    )
    with pytest.raises(
        StepError,
        match=r"did not finish \(.*joint_friction=0\.02 .*was killed .*Repeat the command",
    ):
        fitting.fit(bench, tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("joint_friction_constant", "joint_frction_constant", "unknown key"),
        ('"0.1 N m", low', "0.1, low", 'needs a unit, got 0.1. Write e.g. "5 N m"'),
        ('"0.35 N m"', '"0.35 N"', '"0.35 N" is a force, this needs a torque'),
        (
            '"driveshaft_torque"\nvalue = "0.35',
            '"driveshaft_torqe"\nvalue = "0.35',
            'Did you mean "driveshaft_torque"?',
        ),
        ("natural_frequency 1", "natural_frequency first", "must number the mode from 1"),
        ("uncertainty = ", "uncertanty = ", "unknown key. Did you mean"),
        ('set = { "drive.speed"', 'set = { "drive.sped"', 'Did you mean "speed"?'),
    ],
)
def test_wrong_fit_file_is_refused_before_anything_runs(bench, tmp_path, old, new, message):
    bench.write_text(FILE.replace(old, new, 1))
    with pytest.raises(CaseError) as raised:
        fitting.fit(bench, tmp_path)
    assert message in str(raised.value)


@pytest.mark.parametrize("name", ["joint-friction", "friction-law"])
def test_examples_are_sound(name):
    free, targets = fitting.read_fit(Path(__file__).parents[2] / "examples" / f"{name}.toml")
    assert "mechanism.joint_friction_viscous" in [one.key for one in free]
    assert all(target.case.run.until == "steady" and not target.case.charge.parts for target in targets)
