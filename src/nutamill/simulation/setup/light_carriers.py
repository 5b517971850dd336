"""The carriers of a machine as the push of its charge moves them, for the warnings of the pre-flight."""

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.light_carriers import PushedCarrier, carrier_faults, carrier_warnings
from nutamill.case.machine import Machine
from nutamill.mechanism.dynamics import start
from nutamill.mechanism.effective_mass import effective_mass
from nutamill.simulation.setup.carriers import carriers_of
from nutamill.simulation.setup.clock import contact_facts, run_clock
from nutamill.simulation.setup.mechanism import assemble_machine
from nutamill.simulation.setup.particles import particle_masses


def machine_carriers(machine: Machine) -> list[PushedCarrier]:
    """Return the bodies that carry walls of the charge and give way, with the least mass at any of the points
    that their walls are given by, one contact with the heaviest particle each.
    """
    if not machine.charge.parts or machine.run.coupling == "prescribed":
        return []
    mechanism, state, scratch = assemble_machine(machine)
    start(mechanism, state, scratch)
    stiffness = {facts.pair: facts.stiffness for facts in contact_facts(machine)}
    heaviest, carriers = float(particle_masses(machine).max()), []
    for carrier in carriers_of(machine):
        walls = [wall for wall in machine.walls if wall.body == carrier.name]
        if carrier.body >= len(machine.bodies) or not walls:
            continue
        masses = [effective_mass(mechanism, state, scratch, carrier.body, wall.point) for wall in walls]
        if not np.isfinite(least := min(masses)):
            continue
        materials = {wall.material for wall in walls}
        touched = [
            stiffness[pair.name] for pair in machine.touching if pair.wall and pair.second in materials
        ]
        carriers.append(PushedCarrier(f"bodies.{carrier.name}", least, heaviest, max(touched)))
    return carriers


def light_carrier_warnings(machine: Machine) -> list[Fault]:
    """Return what is doubtful about carriers that are light, or about a window that is long for them.

    Raises
    ------
    CaseError : a carrier that cannot be coupled in the window of the run
    """
    refuse_light_carriers(machine)
    window, iterated = run_clock(machine).window, machine.run.coupling == "iterated"
    carriers = machine_carriers(machine)
    return [fault for carrier in carriers for fault in carrier_warnings(carrier, window, iterated)]


def refuse_light_carriers(machine: Machine) -> None:
    """Raise CaseError for carriers that cannot be coupled in the window of the run."""
    carriers = machine_carriers(machine)
    if not carriers:
        return
    window, iterated = run_clock(machine).window, machine.run.coupling == "iterated"
    if faults := [fault for carrier in carriers for fault in carrier_faults(carrier, window, iterated)]:
        raise CaseError(*faults)
