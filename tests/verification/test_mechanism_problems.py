"""Published mechanisms, as files in `examples/mechanisms` and as `python -m validation.mechanism` runs them.

References, limits and sources stand with the problems, in `validation/mechanism`.
"""

import importlib
import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[2]))
problems, simulation = (
    importlib.import_module(f"validation.mechanism.{name}") for name in ("problems", "simulate")
)

QUICK = [
    problem
    for problem in problems.PROBLEMS
    if problem.file in ("pendulum", "n-four-bar", "bricard", "slider-crank", "universal-joint")
]
"""Those that take less than half a second; the others are solved in test_mechanism_joints and
test_mechanism_rotation, or below.
"""


@pytest.mark.parametrize("problem", QUICK, ids=[problem.file for problem in QUICK])
def test_a_published_mechanism_is_solved_within_its_limits(problem):
    run = simulation.simulate(problem.file)
    if problem.error is not None:
        assert problem.error(run) <= problem.limit
    assert run.energy_drift <= problem.energy_limit
    # projected at every step: round-off of metres and of metres per second
    assert run.gap < 1e-14 and run.gap_rate < 1e-12


def test_the_governor_settles_where_its_equations_say():
    # a tenth of the problem's time, which holds the first swing of the slider
    run = simulation.simulate("flyball-governor", until=1.0)
    height = run.series["slider_position_z"]
    assert np.ptp(height) > 0.05
    assert np.abs(height - problems.exact.governor(run.series["time"])).max() < 1e-3


def test_bricard_moves_although_its_constraints_count_more_than_its_freedoms():
    run = simulation.simulate("bricard")
    # 5 bodies have 30 freedoms and 6 pins hold 30: yet the far corner swings through most of a rod's length
    # of 1 m
    assert np.ptp(run.series["p3_position_y"]) > 0.7
