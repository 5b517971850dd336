"""The number of threads of the charge."""

import os
from pathlib import Path

from nutamill.base.kernel import JIT
from nutamill.case.machine import Machine
from nutamill.charge.kernels.team import MOST_THREADS


def team_size(machine: Machine) -> int:
    """Return the threads of the charge: those of the case, or the cores that this process may use, up to the
    number of work spaces.
    """
    if not JIT:
        return 1
    return min(MOST_THREADS, usable_cores() if machine.run.threads == "auto" else int(machine.run.threads))


def usable_cores() -> int:
    """Return the physical cores that this process may use. Hardware threads of one core count once."""
    allowed = os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(os.cpu_count() or 1)
    siblings = set()
    for cpu in allowed:
        try:
            siblings.add(Path(f"/sys/devices/system/cpu/cpu{cpu}/topology/thread_siblings_list").read_text())
        except OSError:
            siblings.add(str(cpu))
    return max(1, len(siblings))
