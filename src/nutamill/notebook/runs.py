"""`run` and `resume` of the public face: those of the simulation, with live progress in a notebook."""

from collections.abc import Callable
from pathlib import Path

from nutamill.case import Case, Machine
from nutamill.notebook.live import LiveProgress, in_notebook
from nutamill.result import Result
from nutamill.simulation import runs
from nutamill.simulation.progress_report import Progress

Report = Callable[[Progress], None]
Log = Callable[[str], None]


def run(
    case: Case | Machine | str | Path,
    to: str | Path | None = None,
    progress: Report | None = None,
    log: Log | None = None,
    again: bool = False,
    trust_fmu: bool = False,
) -> Result:
    """Run a case from rest to its end and return the opened result. An existing complete result is returned
    unchanged.

    In a notebook the progress is shown below the cell, unless `progress` is given.

    Parameters
    ----------
    case : a case of a mill or of any mechanism, or the name of a machine of the package, or a case file
    to : result file; in the folder `results`, as `Case.file_in` names it, if None
    progress : called about twice a second with the progress of the run
    log : called with a line of text when something takes time before the first step, or when a requested
        checkpoint is saved
    again : run the case even if the file exists; the file there stays until the new run has ended
    trust_fmu : run the native code of the FMUs that the case names

    Raises
    ------
    CaseError : bad input, before a step is run
    ResultError : the file holds another case or an incomplete run, another run writes it now, or it cannot be
        written
    DamagedError : a result in the file is damaged
    StepError : the run cannot go on; what was recorded is in the file
    NotSteadyError : the run should end when steady, and was not within `run.max`; the file has it all
    KeyboardInterrupt : after an interrupt before the first step
    Interrupted : after an interrupt of the march, with everything saved
    """
    case = runs.asked_case(case)
    if progress is not None or not in_notebook():
        return runs.run(case, to, progress, log, again, trust_fmu)
    with LiveProgress(case.title or case.name) as live:
        return runs.run(case, to, live, log or live.message, again, trust_fmu)


def resume(
    path: str | Path,
    until: float | str | None = None,
    progress: Report | None = None,
    log: Log | None = None,
    trust_fmu: bool = False,
) -> Result:
    """Continue a run from its last checkpoint and return the opened result.

    In a notebook the progress is shown below the cell, unless `progress` is given.

    Parameters
    ----------
    path : result of an interrupted or a complete run
    until : new end [s], or a text with a unit; with ``run.until = "steady"`` the new longest time
    progress, log, trust_fmu : as for `run`

    Raises
    ------
    ResultError, DamagedError, StepError, NotSteadyError, KeyboardInterrupt : as for `run`
    """
    if progress is not None or not in_notebook():
        return runs.resume(path, until=until, progress=progress, log=log, trust_fmu=trust_fmu)
    with LiveProgress(Path(path).stem) as live:
        return runs.resume(path, until=until, progress=live, log=log or live.message, trust_fmu=trust_fmu)
