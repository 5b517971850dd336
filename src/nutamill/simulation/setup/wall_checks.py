"""Refusal of walls and regions that no charge can be put between, before a step is run."""

from nutamill.base.errors import CaseError
from nutamill.case.machine import Machine
from nutamill.simulation.setup.floors import region_faults
from nutamill.simulation.setup.solid_walls import indirect_pairs, solid_faults
from nutamill.simulation.setup.swept_walls import swept_faults


def refuse_walls(machine: Machine) -> None:
    """Raise CaseError for walls that reach or move into each other, and for regions outside of the walls or
    without a floor. A machine without a charge has nothing to refuse.
    """
    if not machine.charge.parts:
        return
    faults = [*solid_faults(machine), *region_faults(machine)]
    reported = {fault.where for fault in faults}
    faults += [
        fault for fault in swept_faults(machine, indirect_pairs(machine)) if fault.where not in reported
    ]
    if faults:
        raise CaseError(*faults)
