"""The settled bed: where the charge lies when the mill starts, filled and settled once and kept by content.

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
from nutamill.base.frames import MOTION_SIZE, quaternion_product
from nutamill.base.source_code import code_digest, definition_of, reached
from nutamill.case import Case
from nutamill.charge.face import Charge
from nutamill.charge.filling.fill import fill_cylinder, random_attitudes, settle
from nutamill.charge.filling.fill_walls import fill_between
from nutamill.charge.particles.particles import Particles
from nutamill.simulation.setup.charge import chamber_charge, chamber_surfaces, rib_inside
from nutamill.simulation.setup.clock import run_clock
from nutamill.simulation.setup.mill import chamber_quaternion, chamber_rotation
from nutamill.simulation.setup.particles import charge_particles, particle_count
from nutamill.simulation.setup.rigid_parts import whole_chamber
from nutamill.simulation.setup.threads import team_size
from nutamill.simulation.setup.walls import charge_room, room_box

STILL = 1e-6
"""Kinetic energy per mass at which a bed is settled [J/kg]: a mean speed of 1.4 mm/s."""

LONGEST = 1.0
"""Time after which a bed that still creeps is taken as settled [s]."""


def bed_key(case: Case) -> str:
    """Identity of the settled bed of a case: SHA-256 of all that decides it."""
    content = {
        "chamber": case.chamber.model_dump(),
        "walls": [wall.model_dump() for wall in case.walls],
        "charge": case.charge.model_dump(),
        "materials": {name: material.model_dump() for name, material in case.materials.items()},
        "contact": case.contact.model_dump(),
        "seed": case.run.seed,
        "substep": run_clock(case).substep,
        "tilt": chamber_quaternion(case),
        "gravity": case.mechanism.gravity,
        "code": _settling_code(),
        "version": __version__,
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


@functools.cache
def _settling_code() -> str:
    """Digest of the code that fills and settles: the kernels and the plain functions about them."""
    return code_digest(reached([definition_of(_settle)]))


def bed_file(case: Case) -> Path:
    """Where the bed of a case is kept, in the user's cache folder."""
    return beds_folder() / f"{bed_key(case)[:32]}.bed"


def bed_is_kept(case: Case) -> bool:
    """Whether there is nothing left to settle: the bed is in the cache and whole, or the chamber is empty."""
    return not case.charge.parts or _kept_bed(case) is not None


def settled_bed(case: Case, progress: Callable[[float], None] | None = None) -> np.ndarray | None:
    """Places of the particles [m] (n, 3) at rest in the tilted chamber at crank angle 0, in chamber axes from
    the nutation point.

    With clumps, places and attitudes (n, 7).

    Taken from the user's cache if the same bed was settled before and its file is whole; None for an empty
    chamber.

    Parameters
    ----------
    progress : called while settling with the share of the time it may take at most [1]

    Raises
    ------
    CaseError : more charge than the chamber holds
    StepError : an overlap beyond its limit while settling
    """
    if not case.charge.parts:
        return None
    bed = _kept_bed(case)
    if bed is None:
        bed = _settle(case, progress)
        _keep(bed_file(case), bed)
    return bed


def settle_apart(case: Case) -> subprocess.Popen:
    """Start a process that settles the bed of a case into the cache; a fault shows when `settled_bed` is
    asked again.
    """
    task = "from nutamill.simulation.setup.bed import settle_for_parent; settle_for_parent()"
    return start_child(task, case.with_("run.threads", 1).to_toml())


def settle_for_parent() -> None:
    """Settle the bed of the case that the parent gives, in a process of its own."""
    settled_bed(Case.from_toml(task_of_parent()))


def _settle(case: Case, progress: Callable[[float], None] | None) -> np.ndarray:
    """Fill the chamber at random and let it lie down under gravity, at rest and tilted as at crank angle
    0.
    """
    mass_centre = whole_chamber(case.chamber).mass_centre
    placed = _filled(case)
    rotation, quaternion = chamber_rotation(case), np.array(chamber_quaternion(case))
    position = rotation @ mass_centre
    substep = run_clock(case).substep
    built = chamber_charge(case, placed.poses, position, quaternion, substep)
    at_rest = np.zeros((1, MOTION_SIZE))
    at_rest[0, :3], at_rest[0, 3:7] = position, quaternion
    charge = Charge.from_parts(*built, substep, at_rest, team_size(case))
    settle(charge, LONGEST, STILL, progress)
    places = (charge.positions - position) @ rotation + mass_centre
    turned = charge.attitudes
    if turned is None:
        return places
    back = quaternion * [1.0, -1.0, -1.0, -1.0]
    return np.column_stack([places, [quaternion_product(back, own) for own in turned]])


def _filled(case: Case) -> Particles:
    """The particles at random places, in chamber axes from the nutation point."""
    chamber, particles, seed = case.chamber, charge_particles(case), case.run.seed
    if chamber.mesh is None and not case.walls:
        boxes = [rib_inside(case, number) for number in range(chamber.ribs)]
        return fill_cylinder(
            particles, chamber.inner_diameter / 2, -chamber.floor_depth, -chamber.ceiling_depth, boxes, seed
        )
    mass_centre = whole_chamber(chamber).mass_centre
    low, high = room_box(case) - mass_centre
    places = (
        fill_between(particles.bounding_radius, chamber_surfaces(case), low, high, charge_room(case), seed)
        + mass_centre
    )
    return particles.placed(
        places, None if particles.spheres_only else random_attitudes(particles.number, seed)
    )


def _keep(file: Path, bed: np.ndarray) -> None:
    """Put the bed in the cache behind its own digest, whole or not at all; a cache that cannot be written is
    no fault.
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


def _kept_bed(case: Case) -> np.ndarray | None:
    """The bed of a case from the cache; None if there is none, or if its file is damaged."""
    try:
        digest, content = (whole := bed_file(case).read_bytes())[:32], whole[32:]
        if hashlib.sha256(content).digest() != digest:
            return None
        bed = np.load(io.BytesIO(content), allow_pickle=False)
    except (OSError, ValueError):
        return None
    sound = (
        bed.ndim == 2
        and bed.shape[0] == particle_count(case)
        and bed.shape[1] in (3, 7)
        and np.isfinite(bed).all()
    )
    return bed if sound else None
