"""What a charge in LAMMPS cannot be: laws without a counterpart, and all that needs the pairs of this
engine.
"""

import math
from collections.abc import Iterator

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.case.machine import Machine
from nutamill.simulation.lammps.ranks import launched
from nutamill.simulation.setup.kinds import MOST_CLASSES, particle_kinds
from nutamill.simulation.setup.particles import charge_parts, particle_count
from nutamill.simulation.setup.touches import missing_laws, touches
from nutamill.simulation.setup.walls import wall_surfaces

MOST_SURFACES = 64
"""Surfaces of walls, patches of meshes counted each [1]: every particle has 64 bytes of memory for each."""

FEWEST = 50
"""Particles of a process, at least [1]: with fewer, it does nothing but wait for the others."""


def charge_faults(machine: Machine) -> Iterator[Fault]:
    """Yield the parts of a charge that LAMMPS cannot hold with these numbers."""
    for number, part in enumerate(machine.charge.parts):
        key = f"charge.part[{number}]" if machine.charge.part else "charge"
        if part.kind == "clumps":
            yield Fault(f"{key}.kind", "clumps are not handed to LAMMPS", 'Write kind = "spheres"')
            return
    if grows_with_diameter(machine) and _mixed(machine):
        what = "a stiffness that grows with the diameter is handed to LAMMPS for classes of one diameter each"
        yield Fault("contact.stiffness", what, f'Write "direct", or at most {MOST_CLASSES} diameters')
    for name, contact in touches(machine).items():
        for law in missing_laws(contact.terms("LAMMPS")):
            yield Fault(f"contact.{name}", f"LAMMPS lacks {law}", "nutamill check --dialects has its words")


def grows_with_diameter(machine: Machine) -> bool:
    """Return whether the stiffness of a contact grows with the diameters. In LAMMPS it is one number."""
    return machine.contact.stiffness == "young" and machine.contact.normal != "hertz"


def diameters(machine: Machine) -> np.ndarray:
    """Return the diameter of each particle of a charge of spheres [m] (n,)."""
    return np.concatenate([part.diameter for part in charge_parts(machine)])


def _mixed(machine: Machine) -> bool:
    """Return whether a kind of particles has several diameters: LAMMPS has one stiffness for two of its
    types.
    """
    kinds = particle_kinds(machine)
    diameter = diameters(machine)
    return any(
        np.ptp(diameter[kinds.of_particles == number]) > 1e-9 * kind.diameter
        for number, kind in enumerate(kinds.kinds)
        if not math.isnan(kind.diameter)
    )


def lammps_faults(machine: Machine) -> list[Fault]:
    """Return why a machine cannot run with its charge in LAMMPS, all at once, or nothing where this
    program moves the charge.
    """
    run, faults = machine.run, []
    if machine.charge.engine is None or not machine.charge.parts:
        return []
    with_lammps = 'with charge.engine = "lammps"'
    if run.coupling == "iterated":
        what = f'must be "staggered" or "prescribed" {with_lammps}, got "iterated"'
        faults.append(Fault("run.coupling", what, "LAMMPS cannot go back to the start of a window"))
    if run.threads != "auto":
        what = f"has no use {with_lammps}, got {run.threads}"
        faults.append(Fault("run.threads", what, "Start as many processes: mpiexec -n 2 nutamill run ..."))
    if machine.fmus:
        faults.append(Fault("fmus", f"are not run {with_lammps}", "Leave one of the two out"))
    faults += charge_faults(machine)
    if (surfaces := len(wall_surfaces(machine))) > MOST_SURFACES:
        what = f"at most {MOST_SURFACES} surfaces {with_lammps}, patches of meshes counted each"
        faults.append(Fault("walls", f"{what}, got {surfaces}"))
    if (count := particle_count(machine)) < FEWEST * (ranks := launched()) and ranks > 1:
        what = f"{ranks} processes share {count} particles, fewer than {FEWEST} each"
        faults.append(Fault("mpiexec", what, f"Start at most {max(1, count // FEWEST)}"))
    return faults


def refuse_for_lammps(machine: Machine) -> None:
    """Raise CaseError for a machine whose charge LAMMPS is to move and cannot."""
    if faults := lammps_faults(machine):
        raise CaseError(*faults)
