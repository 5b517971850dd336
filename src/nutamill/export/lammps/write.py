"""The charge of a result as input of LAMMPS, from its first snapshot to its last."""

from pathlib import Path

import numpy as np

from nutamill.analysis.source import any_case_of
from nutamill.base.atomic_file import write_whole
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.units import shown
from nutamill.case.machine import Machine
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.export.lammps.motion import FEWEST, ChamberMotion, stretches
from nutamill.export.lammps.regions import SHAPES
from nutamill.export.lammps.script import (
    DATA,
    MOTION,
    SCRIPT,
    Atoms,
    Laws,
    data_text,
    motion_text,
    script_text,
)
from nutamill.result import Result
from nutamill.simulation.lammps.faults import charge_faults, diameters, grows_with_diameter
from nutamill.simulation.setup.carriers import Carrier, carriers_of
from nutamill.simulation.setup.clock import run_clock
from nutamill.simulation.setup.touches import granular_words, touches
from nutamill.simulation.setup.walls import material_order, region_corners, wall_surfaces

LARGEST_ERROR = 0.01
"""Largest error of the position of a wall between two snapshots, share of the smallest radius [1]."""

OTHER_WALLS = "It has planes, cylinders, boxes, rods and balls"
"""Hint of a wall that is not exported."""


def export_charge(result: Result, folder: Path) -> list[Path]:
    """Write data file, input script and motion of the charge of a result to `folder`, and return their paths.

    Raises
    ------
    CaseError : what LAMMPS has no counterpart of, all at once
    ResultError : no snapshots of particles, or too few for the motion of the chamber
    OutputError : a file cannot be written
    """
    machine = any_case_of(result).machine
    refuse_without_counterpart(machine)
    snapshots = result.snapshots
    if not len(snapshots) or "positions" not in snapshots[0]:
        raise ResultError(f"{result.path}: holds no snapshots of particles. Run it with run.snapshots.")
    carrier, first = carriers_of(machine)[0], snapshots[0]
    corners = np.concatenate([region_corners(machine, region) for region in machine.regions])
    arms = (corners - carrier.position) @ carrier.rotation
    motion = recorded_motion(result, machine, carrier, float(np.linalg.norm(arms, axis=1).max()))
    dt = run_clock(machine).substep
    seen = stretches(motion, np.array(machine.gravity), dt)
    atoms, surfaces = chamber_atoms(machine, motion, first), wall_surfaces(machine)
    title = machine.title or machine.name
    every = max(1, round((motion.time[1] - motion.time[0]) / dt))
    texts = {
        DATA: data_text(title, atoms, len(machine.charge.materials), arms),
        MOTION: motion_text(seen),
        SCRIPT: script_text(title, atoms, surfaces, granular_laws(machine), dt, every, seen),
    }
    return [write_whole(folder / name, text) for name, text in texts.items()]


def refuse_without_counterpart(machine: Machine) -> None:
    """Raise CaseError with every part of a machine and of its charge that the script cannot hold."""
    if not machine.charge.parts:
        what = "the chamber is empty"
        raise CaseError(Fault("charge", what, "Export the run of a machine with a charge"))
    faults = list(charge_faults(machine))
    if not faults and grows_with_diameter(machine) and len(np.unique(diameters(machine))) > 1:
        # the script has one type of particle for each material
        what = "a stiffness that grows with the diameter is not handed to LAMMPS for several sizes"
        faults.append(Fault("contact.stiffness", what, 'Write "direct", or one diameter'))
    names = [carrier.name for carrier in carriers_of(machine)]
    if len(names) > 1:
        what = f"walls on several bodies are not exported to LAMMPS, got {', '.join(names)}"
        faults.append(Fault("walls", what, "Its particles move in the axes of one chamber"))
    else:
        faults += [
            Fault(f"walls.{surface.name}", f"LAMMPS has no region like a {_shape(surface)}", OTHER_WALLS)
            for surface in wall_surfaces(machine)
            if surface.kind not in SHAPES
        ]
    if faults:
        raise CaseError(*faults)


def recorded_motion(result: Result, machine: Machine, carrier: Carrier, reach: float) -> ChamberMotion:
    """Return the motion of the body that carries the walls, which are at most `reach` [m] from its mass
    centre, from the snapshots of a result.

    Raises
    ------
    ResultError : too few snapshots, or too far apart
    """
    snapshots = result.snapshots
    if len(snapshots) < FEWEST:
        raise ResultError(
            f"{result.path}: its {len(snapshots)} snapshots are too few for the motion of the chamber, which "
            f"needs {FEWEST}. Run it with a higher rate of run.snapshots."
        )
    time, n = np.asarray(snapshots.time, float), carrier.body
    poses = np.zeros((len(time), 7))
    poses[:, 3] = 1.0
    if n < len(machine.bodies):
        for row, snapshot in zip(poses, snapshots, strict=True):
            row[:3], row[3:] = snapshot["body_positions"][n], snapshot["body_attitudes"][n]
    motion = ChamberMotion(time, poses[:, :3], poses[:, 3:])
    radius = 0.5 * min(part.size_range[0] for part in machine.charge.parts)
    error = motion.error(reach)
    if error > LARGEST_ERROR * radius:
        raise ResultError(
            f"{result.path}: its snapshots are too far apart for the motion of the chamber, a wall between "
            f"two of them is off by {shown(error, 'mm')}, at most {shown(LARGEST_ERROR * radius, 'mm')} is "
            "accepted. Run it with a higher rate of run.snapshots."
        )
    return motion


def chamber_atoms(machine: Machine, motion: ChamberMotion, snapshot: dict) -> Atoms:
    """Return the particles of the first snapshot of a motion, in the axes of the chamber."""
    start = motion.time[:1]
    (place, rotation), (velocity, spin) = motion.pose(start), motion.twist(start)
    arms = np.asarray(snapshot["positions"], float) - place[0]
    turning = rotation[0] @ spin[0]
    slip = np.asarray(snapshot["velocities"], float) - velocity[0] - np.cross(turning, arms)
    material = np.asarray(snapshot["materials"], int)
    density = np.array([machine.materials[name].density for name in machine.charge.materials])
    return Atoms(
        material + 1,
        2.0 * np.asarray(snapshot["radii"], float),
        density[material],
        arms @ rotation[0],
        slip @ rotation[0],
        (np.asarray(snapshot["spins"], float) - turning) @ rotation[0],
    )


def granular_laws(machine: Machine) -> Laws:
    """Return the contact laws of a machine in the words of LAMMPS."""
    names, words = material_order(machine), {}
    known = {name: granular_words(contact) for name, contact in touches(machine).items()}
    for touching in machine.touching:
        first, second = names.index(touching.first), names.index(touching.second)
        words[touching.wall, first, second] = known[touching.name]
    pairs = {(i + 1, j + 1): text for (wall, i, j), text in words.items() if not wall}
    return Laws(pairs, {(i + 1, j): text for (wall, i, j), text in words.items() if wall})


def _shape(surface: Surface) -> str:
    return SurfaceKind(surface.kind).name.lower().replace("_", " ")
