"""What a run will take, and warnings where that is more than can be meant or than the machine has."""

from typing import NamedTuple

from nutamill.base.durations import rough_duration
from nutamill.base.errors import Fault
from nutamill.base.units import si_value
from nutamill.case.run import RunPlan
from nutamill.simulation.setup.threads import usable_cores

RUN_MEMORY = 425e6
"""Largest memory of a run from its start to its pictures, without particles [bytes]: peak of a process of its
own.
"""
LONG = si_value(24.0, "h")
"""Wall time from which a forecast is a warning [s]."""
SHARE = 0.5
"""Share of the memory, and of the free disk, from which a forecast is a warning [1]."""


class Forecast(NamedTuple):
    """What a run will take; in each case with the key that brings it down."""

    wall_time: float
    """Wall time [s], settling and compilation left out."""
    memory: float
    """Largest memory, pictures included [bytes]."""
    file_size: float
    """Size of the result file [bytes]."""
    time_key: str
    """Key that brings the wall time down."""
    memory_key: str
    """Key that brings the memory down."""
    file_key: str
    """Key that brings the size of the file down."""
    by_trial: bool = False
    """Whether the wall time is that of a trial of the case, and not of a table for machines like this one."""

    @property
    def text(self) -> str:
        """``2 min (by a trial), 441 MB memory, 65 MB file``."""
        source = "trial" if self.by_trial else "table"
        sizes = f"{_size(self.memory)} memory, {_size(self.file_size)} file"
        return f"{rough_duration(self.wall_time)} (by a {source}), {sizes}"

    def warnings(self, memory: float | None, disk: float | None) -> list[Fault]:
        """Return what is too much for a machine with this total memory and this free disk [bytes], if they
        are known.
        """
        warnings = []
        if self.wall_time > LONG:
            what = f"the run takes about {rough_duration(self.wall_time)}, more than a day"
            warnings.append(Fault("forecast", what, f"{self.time_key} brings it down"))
        for what, needed, there, place, key in (
            ("memory", self.memory, memory, "of memory", self.memory_key),
            ("file", self.file_size, disk, "free on the disk", self.file_key),
        ):
            if there is not None and needed > SHARE * there:
                text = f"the {what} takes about {_size(needed)}, more than half of the {_size(there)} {place}"
                warnings.append(Fault("forecast", text, f"{key} brings it down"))
        return warnings


def _size(size: float) -> str:
    """Return a number of bytes with the unit that suits it."""
    return f"{size / 1e6:.0f} MB" if size < 1e10 else f"{size / 1e9:.0f} GB"


def idle_threads(run: RunPlan) -> list[Fault]:
    """Return a warning where a case asks for more threads than there are cores."""
    cores = usable_cores()
    if isinstance(run.threads, str) or run.threads <= cores:
        return []
    what = f"asks for {run.threads} threads on a machine with {cores} core{'s' * (cores > 1)}"
    return [Fault("run.threads", what, 'More threads than cores slow a run down: write threads = "auto"')]
