"""The settled bed: the charge at rest when the mill starts, filled and settled once and cached by content.

The bed depends on the chamber, the charge, the contact laws and the seed, and on the code that fills and
settles, but not on speed or mounts, so that a sweep settles once.
"""

import functools
import hashlib
import io
import json
import os
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from nutamill import __version__
from nutamill.base.cache_folder import beds_folder
from nutamill.base.child import start_child, task_of_parent
from nutamill.base.frames import MOTION_SIZE
from nutamill.base.required import required
from nutamill.base.source_code import code_digest, definition_of, reached
from nutamill.case.machine import Machine
from nutamill.charge.face import Charge
from nutamill.charge.filling.fill import settle
from nutamill.charge.particles.particles import Particles, joined
from nutamill.simulation.setup.carriers import carriers_of
from nutamill.simulation.setup.charge import bed_in_carriers, machine_charge
from nutamill.simulation.setup.clock import run_clock
from nutamill.simulation.setup.particles import charge_particles, charge_parts, particle_count
from nutamill.simulation.setup.regions import filled, region_of
from nutamill.simulation.setup.threads import team_size
from nutamill.simulation.setup.walls import wall_surfaces

# Absolute: it decides when settling stops, and with that how quiet the bed is at the start of a run. Scaled
# cases that are to have the same bits begin from a given bed.
STILL = 1e-6
"""Kinetic energy per mass at which a bed is settled [J/kg]: a mean speed of 1.4 mm/s."""

LONGEST = 1.0
"""Time after which a bed that still creeps is taken as settled [s]."""


def bed_key(machine: Machine) -> str:
    """Compute the identity of the settled bed of a case: SHA-256 of all that decides it."""
    walls = [wall.model_dump(exclude={"file"}) for wall in machine.walls]
    content = {
        "walls": walls,
        "regions": [region.model_dump() for region in machine.regions],
        "carriers": [(carrier.name, carrier.pose.tolist()) for carrier in carriers_of(machine)],
        "charge": machine.charge.model_dump(),
        "materials": {name: material.model_dump() for name, material in machine.materials.items()},
        "contact": machine.contact.model_dump(),
        "seed": machine.run.seed,
        "substep": run_clock(machine).substep,
        "gravity": machine.gravity,
        "code": _settling_code(),
        "version": __version__,
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


@functools.cache
def _settling_code() -> str:
    """Compute the digest of the code that fills and settles: kernels and the plain functions about them."""
    return code_digest(reached([definition_of(_settle)]))


def bed_file(machine: Machine) -> Path:
    """Return the file of a case's bed in the user's cache folder."""
    return beds_folder() / f"{bed_key(machine)[:32]}.bed"


def bed_is_cached(machine: Machine) -> bool:
    """Return whether there is nothing left to settle: the bed is in the cache and whole, or the chamber is
    empty.
    """
    return not machine.charge.parts or cached_bed(machine) is not None


def settled_bed(machine: Machine, progress: Callable[[float], None] | None = None) -> np.ndarray | None:
    """Return the positions of the particles [m] (n, 3) at rest in the tilted chamber at crank angle 0, in
    chamber axes from the nutation point.

    With clumps, places and attitudes (n, 7).

    Taken from the user's cache if the same bed was settled before and its file is whole; None for an empty
    chamber.

    Parameters
    ----------
    progress : called while settling, if there is something to settle, with the share of the time it may take
        at most [1], from 0 to 1

    Raises
    ------
    CaseError : more charge than the chamber holds
    StepError : an overlap beyond its limit while settling
    """
    if not machine.charge.parts:
        return None
    bed = cached_bed(machine)
    if bed is None:
        report = progress or (lambda share: None)
        report(0.0)
        bed = _settle(machine, progress)
        report(1.0)
        _keep(bed_file(machine), bed)
    return bed


def settle_apart(machine: Machine) -> subprocess.Popen:
    """Start a process that settles the bed of a case into the cache.

    A fault shows at the next call of `settled_bed`.
    """
    task = "from nutamill.simulation.setup.bed import settle_for_parent; settle_for_parent()"
    return start_child(task, machine.with_("run.threads", 1).to_toml())


def settle_for_parent() -> None:
    """Settle the bed of the case that the parent gives, in a process of its own."""
    settled_bed(Machine.from_toml(task_of_parent()))


def _settle(machine: Machine, progress: Callable[[float], None] | None) -> np.ndarray:
    """Fill the regions at random and let the charge come to rest under gravity, with all carriers at rest as
    assembled.
    """
    poses = np.array([carrier.pose for carrier in carriers_of(machine)])
    substep, bed = run_clock(machine).substep, loose_bed(machine)
    built = machine_charge(machine, bed, poses, substep)
    at_rest = np.zeros((len(poses), MOTION_SIZE))
    at_rest[:, :7] = poses
    names = [surface.name for surface in wall_surfaces(machine)]
    charge = Charge.from_parts(*built, substep, at_rest, team_size(machine), names)
    settle(charge, LONGEST, STILL, progress)
    return bed_in_carriers(machine, charge.positions, charge.attitudes, poses)


def loose_bed(machine: Machine) -> np.ndarray:
    """Return the particles of a machine where they are placed before they settle, as `settled_bed`."""
    poses = np.array([carrier.pose for carrier in carriers_of(machine)])
    placed = joined_fills(machine)
    return bed_in_carriers(machine, required(placed.centre), placed.attitude, poses)


def joined_fills(machine: Machine) -> Particles:
    """Return all particles at random positions in their regions, world axes as assembled.

    Those of one region are placed together.
    """
    parts, regions = charge_parts(machine), [region_of(machine, part) for part in machine.charge.parts]
    placed: dict[int, Particles] = {}
    for region in dict.fromkeys(regions):
        members = [number for number, one in enumerate(regions) if one == region]
        together = filled(machine, region, joined([parts[number] for number in members]), machine.run.seed)
        first = 0
        for number in members:
            own = slice(first, first + parts[number].number)
            attitudes = None if together.attitude is None else together.attitude[own]
            placed[number] = parts[number].placed(required(together.centre)[own], attitudes)
            first = own.stop
    return charge_particles(machine).placed(
        np.concatenate([required(placed[number].centre) for number in range(len(parts))]),
        None
        if charge_particles(machine).spheres_only
        else np.concatenate([_attitudes(placed[number]) for number in range(len(parts))]),
    )


def _attitudes(particles: Particles) -> np.ndarray:
    """Return the attitudes of particles (n, 4). Those of spheres have no meaning."""
    if particles.attitude is not None:
        return particles.attitude
    return np.tile([1.0, 0.0, 0.0, 0.0], (particles.number, 1))


def _keep(file: Path, bed: np.ndarray) -> None:
    """Store the bed in the cache behind its own digest, whole or not at all.

    A cache that cannot be written is no fault.
    """
    buffer = io.BytesIO()
    np.save(buffer, bed, allow_pickle=False)
    content = buffer.getvalue()
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=file.parent, suffix=".part", delete=False) as part:
            try:
                part.write(hashlib.sha256(content).digest() + content)
                part.flush()
                os.fsync(part.fileno())
                part.close()
                os.replace(part.name, file)
            except OSError:
                os.unlink(part.name)
    except OSError:
        pass


def cached_bed(machine: Machine) -> np.ndarray | None:
    """Read the bed of a case from the cache, or return None if there is none or its file is damaged."""
    try:
        digest, content = (whole := bed_file(machine).read_bytes())[:32], whole[32:]
        if hashlib.sha256(content).digest() != digest:
            return None
        bed = np.load(io.BytesIO(content), allow_pickle=False)
    except (OSError, ValueError):
        return None
    sound = (
        bed.ndim == 2
        and bed.shape[0] == particle_count(machine)
        and bed.shape[1] in (3, 7)
        and np.isfinite(bed).all()
    )
    return bed if sound else None
