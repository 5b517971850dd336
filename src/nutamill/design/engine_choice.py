"""From how many processes a charge in LAMMPS is faster than in this program, by a trial of both."""

import math
from collections.abc import Callable

from nutamill.case.machine import Machine
from nutamill.simulation.setup.threads import team_size


def engine_lines(machine: Machine, theirs: float | None, trial: Callable | None) -> list[str]:
    """Return a line on when LAMMPS pays for a case that asks for it, no line for others.

    Parameters
    ----------
    theirs : wall time that a simulated second takes in LAMMPS on one process [1]; None where it was not tried
    trial : measures the same of a machine, as `nutamill.simulation.trial.trial_rate`; None for no trial
    """
    if machine.charge.engine is None or trial is None:
        return []
    own = machine.model_copy(update={"charge": machine.charge.model_copy(update={"engine": None})})
    ours = trial(own) if theirs is not None else None
    if theirs is None or ours is None:
        return ["engine    not tried: after a first run with LAMMPS and one without, check says when it pays"]
    threads, ratio = team_size(own), theirs / ours
    ours_on = f"this program on {threads} thread{'s' * (threads > 1)}"
    took = f"engine    LAMMPS on one process takes {ratio:.2g} times as long as {ours_on}"
    if ratio < 1.0:
        return [f"{took}: it pays"]
    return [f"{took}: it pays from some {math.floor(ratio) + 1} processes on"]
