"""How long a run is, how finely it is computed, and what is recorded of it."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from nutamill.base.required import required
from nutamill.base.schema import (
    AutoTime,
    Count,
    EndTime,
    Frequency,
    Length,
    Seed,
    Share,
    Table,
    Time,
    refusal,
    spelled,
)
from nutamill.case.case_file import SnapshotPlan

MOST_THREADS = 1000
"""Threads that a case may ask for [1]; no computer of today has more cores for one process."""

STEADY_DEFAULTS = {"max": "30 s", "precision": 0.01}
"""Keys of a run that ends when steady, unless given."""


def _threads(given: Any) -> Any:
    whole = isinstance(given, int) and not isinstance(given, bool)
    if given != "auto" and not (whole and 1 <= given <= MOST_THREADS):
        raise refusal(f'must be "auto" or a whole number from 1 to {MOST_THREADS}, got {spelled(given)}')
    return given


class RunPlan(Table):
    """How long, how finely, and what is recorded."""

    until: EndTime
    """Simulated time at the end [s]; ``"steady"``: when crank-pin force and torque are steady, looked at
    after each `run.checkpoint`.
    """
    max: Time | None = None
    """With until = "steady": simulated time at the end at the latest [s]."""
    precision: Share | None = None
    """With until = "steady": 95 % half width, and drift, of both means at which they count as known and
    steady, share of their size [1].
    """
    dt: AutoTime = "auto"
    """Charge substep [s]; ``"auto"``: contact time of the stiffest, lightest pair over 20."""
    window: Annotated[Count, Field(ge=1, le=1000)] = 10
    """Charge substeps in one mechanism step [1]."""
    coupling: Literal["prescribed", "staggered", "iterated"] = "staggered"
    """Whether the charge moves the mechanism, and how often a window is repeated."""
    threads: Annotated[int | str, BeforeValidator(_threads)] = "auto"
    """Threads of the charge; ``"auto"``: the physical cores."""
    seed: Seed = 1
    """Seed of the placement of the charge."""
    series_rate: Frequency = 4800.0
    """Rate of the recorded series [Hz]."""
    snapshots: SnapshotPlan = SnapshotPlan(rate=200.0, last=0.5)
    """Snapshots of the charge."""
    checkpoint: Time = 1.0
    """Simulated time between checkpoints [s]; where that takes longer than ten minutes, more are saved
    between.
    """
    statistics: bool = True
    """Whether spectra, wall work and fields of the charge are summed, and recorded after every
    `run.checkpoint`.
    """

    @model_validator(mode="before")
    @classmethod
    def _bounded(cls, given: Any) -> Any:
        """Give a run that ends when steady its default longest time and precision."""
        return (
            STEADY_DEFAULTS | given if isinstance(given, dict) and given.get("until") == "steady" else given
        )

    @property
    def end(self) -> float:
        """Simulated time at the end at the latest [s]."""
        return required(self.max) if isinstance(self.until, str) else self.until


class WatchEntry(Table):
    """A series that must be steady for a run that ends when it is."""

    series: str
    """Its name."""
    force: str | None = None
    """Another watched series, a force: a torque that is small beside it times `lever` counts as none."""
    lever: Length | None = None
    """Lever of that force [m]."""


class MachineRun(RunPlan):
    """How long, how finely, and what is recorded of a machine given part by part."""

    step: Time = 50e-6
    """Longest step of a machine without a charge [s]; the step divides the period of the series."""
    start: Literal["assembled", "rest"] = "assembled"
    """As assembled, with the velocities given; or from static equilibrium, with the weight of the charge."""
    period: str | None = None
    """Drive over whose whole turns means are taken; `fields.drive` if not given, and where that is none,
    means are over time.
    """
    watch: tuple[WatchEntry, ...] = ()
    """With until = "steady": the series whose means over whole turns of `period` must be steady."""
    series: tuple[str, ...] | None = None
    """Names of the series that are recorded; all if not given."""
    series_rate: Frequency = 1000.0
    """Rate of the recorded series [Hz]."""
    snapshots: SnapshotPlan = SnapshotPlan(rate=50.0, last=10.0)
    """Snapshots of all bodies and of the charge."""
