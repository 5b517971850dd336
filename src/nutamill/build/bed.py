"""The settled bed: where the charge lies when the mill starts, filled and settled once and kept by content.

The bed depends on the chamber, the charge, the contact laws and the seed, and on the kernels that settled it, but not on speed
or mounts, so that a sweep settles once.
"""

import hashlib
import json
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from nutamill.build.chamber_charge import chamber_surfaces, pair_laws, particle_radii
from nutamill.build.clock import run_clock
from nutamill.build.mill_mechanism import chamber_quaternion
from nutamill.case import Case
from nutamill.kernel import cache_folder, kernel_digest


def bed_key(case: Case) -> str:
    """Identity of the settled bed of a case: SHA-256 of all that decides it."""
    content = {
        "chamber": case.chamber.model_dump(),
        "charge": case.charge.model_dump(),
        "materials": {name: material.model_dump() for name, material in case.materials.items()},
        "contact": case.contact.model_dump(),
        "seed": case.run.seed,
        "substep": run_clock(case).substep,
        "tilt": chamber_quaternion(case),
        "gravity": case.mechanism.gravity,
        "kernels": kernel_digest(),
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def bed_file(case: Case) -> Path:
    """Where the bed of a case is kept, in the user's cache folder."""
    return cache_folder().parent / "beds" / f"{bed_key(case)[:32]}.npy"


def settled_bed(case: Case, progress: Callable[[float], None] | None = None) -> np.ndarray | None:
    """Places of the particles [m] (n, 3) at rest in the tilted chamber at crank angle 0, in chamber axes from the nutation point.

    Taken from the user's cache if the same bed was settled before; None for an empty chamber.

    Parameters
    ----------
    case : what is asked
    progress : called now and then with the share of the settling that is done [1]

    Raises
    ------
    CaseError : more charge than the chamber holds
    StepError : a bed that does not come to rest
    """
    if not case.charge.size_classes:
        return None
    file = bed_file(case)
    if file.is_file():
        return np.load(file, allow_pickle=False)
    bed = _settle(case, progress)
    _keep(file, bed)
    return bed
