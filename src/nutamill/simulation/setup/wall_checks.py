"""Refusal of walls and regions that no charge can be put between, before a step is run."""

from nutamill.base.errors import CaseError
from nutamill.case.machine import Machine
from nutamill.simulation.setup.floors import region_faults
from nutamill.simulation.setup.solid_walls import solid_faults


def refuse_walls(machine: Machine) -> None:
    """Raise CaseError for walls that reach or move into each other, and for regions outside of the walls or
    without a floor. A machine without a charge has nothing to refuse.
    """
    if machine.charge.parts and (faults := [*solid_faults(machine), *region_faults(machine)]):
        raise CaseError(*faults)
