"""What is known of a case before a step is run: the sheet of a mill as drawn, or of any other machine."""

from collections.abc import Callable

from nutamill.case import Case, Machine
from nutamill.design.machine_sheet import MachineSheet, machine_sheet
from nutamill.design.preflight import Preflight, preflight


def check(
    case: Case | Machine, trial: Callable[[Machine], float | None] | None = None
) -> Preflight | MachineSheet:
    """Return what is known of a case without running it. The first call compiles the mechanism's kernels.

    Parameters
    ----------
    case : the case
    trial : as for `nutamill.design.preflight.preflight`

    Raises
    ------
    CaseError : every fault that shows before a step is run
    StepError : the first accelerations of a machine part by part are not finite
    """
    mill = case.drawing
    return machine_sheet(case.machine, trial) if mill is None else preflight(mill, trial)
