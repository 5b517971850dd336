"""The problems: a file of `examples/mechanisms`, what is compared, and how near it must come.

IFToMM: M. Gonzalez, D. Dopico, U. Lugris, J. Cuadrado, A benchmarking system for MBS simulation software,
Multibody System Dynamics 16, 179-190, 2006, and the library of computational benchmark problems at
iftomm-multibody.org.  The library measures A01, A02 and A04 by their energy; the limits on positions are our
own.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from validation.mechanism import references as exact
from validation.mechanism.simulate import Run


class Problem(NamedTuple):
    """One problem and its limits."""

    file: str
    """Name of its file."""
    quantity: str
    """What is compared with the reference."""
    unit: str
    """Its unit."""
    error: Callable[[Run], float] | None
    """Largest error of a run; None where nothing but the energy is compared."""
    limit: float
    """How large it may be."""
    energy_limit: float
    """How far the energy may drift [J]; infinite where it is not a criterion."""
    probe: Callable[[Run], float] = lambda run: 0.0
    """Number whose differences between steps give the order where there is no reference."""


def _places(run: Run, sensor: str, axes: str = "xyz") -> np.ndarray:
    return np.column_stack([run.series[f"{sensor}_position_{axis}"] for axis in axes])


def _largest(difference: np.ndarray) -> float:
    return float(np.abs(difference).max())


def squeezer_error(run: Run) -> float:
    """Largest error of four angles at 0.03 s [rad]; whole turns are not told apart."""
    errors = []
    for body, end in exact.SQUEEZER_END.items():
        angle = exact.SQUEEZER_START[body] + 2 * math.atan2(
            run.series[f"{body}_attitude_z"][-1], run.series[f"{body}_attitude_w"][-1]
        )
        errors.append((angle - end + math.pi) % math.tau - math.pi)
    return _largest(np.array(errors))


def attitude_error(run: Run) -> float:
    """Largest angle between the free body's attitude and that of the reference [rad]: 4 asin of half the
    distance of quaternions.
    """
    ours = np.column_stack([run.series[f"nut_attitude_{part}"] for part in "wxyz"])
    theirs = exact.free_body(run.series["time"])
    nearer = np.sign((ours * theirs).sum(axis=1))[:, None]  # q and -q are the same attitude
    return float(4.0 * np.arcsin(0.5 * np.linalg.norm(ours - nearer * theirs, axis=1)).max())


def piston_error(run: Run) -> float:
    """Largest error of the piston's acceleration over its peak [1]."""
    theirs = exact.slider_crank(run.series["time"])
    return _largest(run.series["piston_acceleration_x"] - theirs) / _largest(theirs)


def driven_speed_error(run: Run) -> float:
    """Largest error of the driven shaft's speed [rad/s], from the speed of a point 0.1 m off its axis."""
    speed = np.hypot(run.series["tip_velocity_x"], run.series["tip_velocity_z"]) / 0.1
    return _largest(speed - exact.universal_joint(run.series["time"]))


PROBLEMS = (
    Problem(
        "pendulum", "place over 10 s", "m",
        lambda run: _largest(_places(run, "bob", "xy") - exact.pendulum(run.series["time"])), 1e-4, 5e-5,
    ),
    Problem(
        "n-four-bar", "place of B0 over 10 s", "m",
        lambda run: _largest(_places(run, "b0", "xy") - exact.four_bars(run.series["time"])), 1e-3, 0.1,
    ),
    Problem("andrews-squeezer", "angles at 0.03 s", "rad", squeezer_error, 1e-4, math.inf),
    Problem("bricard", "energy over 10 s", "J", None, math.inf, 1e-3, lambda run: run.series["p3_position_x"][200]),
    Problem(
        "flyball-governor", "height of the slider over 10 s", "m",
        lambda run: _largest(run.series["slider_position_z"] - exact.governor(run.series["time"])), 1e-3, math.inf,
    ),
    Problem("slider-crank", "acceleration of the piston over peak", "1", piston_error, 1e-5, math.inf),
    Problem(
        "heavy-top", "place of the mass centre over 1 s", "m",
        lambda run: _largest(_places(run, "top") - exact.heavy_top(run.series["time"])), 1e-3, math.inf,
    ),
    Problem("dzhanibekov", "attitude over 10 s", "rad", attitude_error, 1e-2, math.inf),
    Problem("universal-joint", "speed of the driven shaft", "rad/s", driven_speed_error, 1e-6, math.inf),
)  # fmt: skip
"""All problems, in the order of the table."""
