"""The progress of a run while it runs, for a screen."""

import math
import time as wall
from collections import deque
from collections.abc import Callable

import numpy as np

from nutamill.base.units import in_unit
from nutamill.case import Case, Machine
from nutamill.result import Recorder
from nutamill.simulation.progress_report import Progress
from nutamill.simulation.running_mean import RunningMean
from nutamill.simulation.setup.model import Model

PAUSE = 0.5
"""Wall time between two reports [s]."""
LATELY = 10.0
"""Wall time over which the present speed of a run is taken [s]: a charge in motion costs more than one at
rest, so that the mean since the start would be behind.
"""
READINGS = ("crank_pin_force_resultant", "driveshaft_torque")
"""Series whose mean at constant speed is shown while a run goes on."""
UNKNOWN = (math.nan,) * 12
"""Readings of a `Progress` before the first step."""


class Watch:
    """Turns what a march records into `Progress` reports, about twice a second of wall time."""

    def __init__(
        self,
        case: Case | Machine,
        progress: Callable[[Progress], None] | None,
        log: Callable[[str], None] | None = None,
    ):
        self._case = case
        self._progress = progress
        self._log = log
        self._next = 0.0
        self._lately: deque[tuple[float, float]] = deque()
        """Wall time and simulated time [s] of the last `LATELY` seconds."""
        self._settling_since: tuple[float, float] | None = None
        self._means = RunningMean(len(READINGS))

    def settling(self, fraction: float) -> None:
        """Report that this share of the settling is done [1]."""
        if self._progress is not None and (self._due() or fraction >= 1.0):
            left = self._settling_left(fraction)
            readings = (*UNKNOWN[:2], left, *UNKNOWN[3:])
            self._progress(Progress("settle", 0.0, self._case.run.end, fraction, *readings, 0, math.nan, 0))

    def _settling_left(self, fraction: float) -> float:
        """Return the wall time [s] that settling still takes. Placing the particles comes before its first
        share.
        """
        now = wall.monotonic()
        if self._settling_since is None:
            if fraction > 0.0:
                self._settling_since = (now, fraction)
            return math.nan
        begun, first = self._settling_since
        return (now - begun) * (1.0 - fraction) / (fraction - first) if fraction > first else math.nan

    def marched(
        self, model: Model, names: tuple[str, ...], series: np.ndarray, until: float, recorder: Recorder
    ) -> None:
        """Report where the run stands after `series` (n, n_names) has been recorded."""
        time = series[-1, 0]
        steady = series[series[:, 0] >= self._case.drive.ramp_end]
        if (
            self._progress is not None and len(steady) and set(READINGS) <= set(names)
        ):  # a mechanism of any kind has no crank pin
            self._means.add(
                steady[:, 0],
                steady[:, names.index("crank_angle")],
                steady[:, [names.index(name) for name in READINGS]],
            )
        now = wall.monotonic()
        self._lately.append((now, time))
        while len(self._lately) > 2 and now - self._lately[1][0] > LATELY:
            self._lately.popleft()
        if len(self._lately) == 1:
            return
        if self._progress is None or not (self._due() or time >= until * (1 - 1e-12)):
            return
        at = dict(zip(names, series[-1], strict=True))
        spent, marched = now - self._lately[0][0], time - self._lately[0][1]
        ramp = self._case.drive.ramp_end
        phase, first, last = ("ramp", 0.0, min(ramp, until)) if time < ramp else ("steady", ramp, until)
        steps = marched / model.clock.substep * (model.charge.n_particles if model.charge is not None else 1)
        (force, torque), (force_width, torque_width) = self._means.mean(), self._means.half_width()
        largest = {
            name: series[:, names.index(name)].max() if name in names else math.nan
            for name in ("largest_pair_overlap", "largest_wall_overlap")
        }
        self._progress(
            Progress(
                phase=phase,
                time=time,
                end_time=until,
                fraction=(time - first) / max(last - first, 1e-12),
                rate=marched / spent,
                nanoseconds=in_unit(spent / steps, "ns"),
                time_left=(until - time) * spent / marched,
                crank_pin_force=at.get("crank_pin_force_resultant", math.nan),
                shaft_torque=at.get("driveshaft_torque", math.nan),
                mean_force=force,
                mean_force_half_width=force_width,
                mean_torque=torque,
                mean_torque_half_width=torque_width,
                largest_pair_overlap=largest["largest_pair_overlap"],
                largest_wall_overlap=largest["largest_wall_overlap"],
                ledger_residual=at["ledger_residual"] / at["motor_work"]
                if at.get("motor_work", 0.0) > 0
                else math.nan,
                contacts=int(at.get("pair_contacts", 0) + at.get("wall_contacts", 0)),
                dt=model.clock.substep,
                file_size=recorder.size,
            )
        )

    def checkpoint_saved(self, time: float) -> None:
        """Report that the checkpoint that was asked for is in the file, of the state at `time` [s]."""
        if self._log is not None:
            self._log(f"checkpoint saved at t = {time:.6g} s")

    def _due(self) -> bool:
        now = wall.monotonic()
        if now < self._next:
            return False
        self._next = now + PAUSE
        return True
