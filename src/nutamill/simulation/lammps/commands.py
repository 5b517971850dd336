"""The input of the LAMMPS that holds the particles of a charge: pairs by its laws, no walls, no gravity."""

import dataclasses
import itertools
import math

import numpy as np

from nutamill.case.machine import Machine
from nutamill.charge.model import ChargeModel
from nutamill.simulation.setup.kinds import Kind, particle_kinds
from nutamill.simulation.setup.regions import region_of
from nutamill.simulation.setup.touches import granular_words, touches
from nutamill.simulation.setup.walls import region_corners

WALLS, KICKS, FRAME = "d2_wall", "d2_kick", "walls"
"""Names of the arrays with the memory of the walls and the last accelerations, and of the fix that adds the
forces of the walls.
"""
COLUMNS = 8
"""Numbers in the memory of a contact [1]."""
BALANCE_EVERY, UNBALANCE = 2000, 1.05
"""Steps between two shares of the particles among the processes [1], and the excess of the busiest at which
they are shared anew [1].
"""


def box_commands(machine: Machine, places: np.ndarray) -> list[str]:
    """Return the commands that make an empty box around the regions of a charge and around `places` [m] (n,
    3), world, and its types.
    """
    regions = [region_of(machine, part) for part in machine.charge.parts]
    corners = np.concatenate([places, *(region_corners(machine, region) for region in regions)])
    margin = 2.0 * max(part.size_range[1] for part in machine.charge.parts)
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + margin
    extents = " ".join(f"{a:.15g} {b:.15g}" for a, b in zip(low, high, strict=True))
    return [f"region box block {extents} units box", f"create_box {len(_types(machine))} box"]


def _types(machine: Machine) -> list[Kind]:
    """Return the kind of each type of particle: those of the charge in the order of their numbers."""
    return [kind for kind in particle_kinds(machine).kinds if not math.isnan(kind.diameter)]


def pair_words(machine: Machine) -> dict[tuple[int, int], str]:
    """Return the laws of all pairs of types, from 0 and the lower one first, in the words of LAMMPS.

    A stiffness that grows with the diameters is that of the kinds, each of one diameter.
    """
    known, kinds, words = touches(machine), _types(machine), {}
    pairs = {frozenset((pair.first, pair.second)): pair for pair in machine.touching if not pair.wall}
    for (i, one), (j, other) in itertools.combinations_with_replacement(enumerate(kinds), 2):
        pair = pairs[frozenset((one.material, other.material))]
        # each spring in series has the diameter of its own particle
        two = (one, other) if one.material == pair.first else (other, one)
        contact = known[pair.name]
        touch = dataclasses.replace(contact.touch, diameters=(two[0].diameter, two[1].diameter))
        words[i, j] = granular_words(dataclasses.replace(contact, touch=touch))
    return words


def start_commands() -> list[str]:
    """Return the commands before there are particles."""
    return [
        "units si",
        "atom_style sphere",
        "atom_modify map array",
        "boundary m m m",
        "newton off",
        "comm_modify vel yes",
    ]


def memory_commands(surfaces: int) -> list[str]:
    """Return the commands that give each particle memory of its walls and of its last accelerations."""
    return [
        f"fix wall_memory all property/atom {WALLS} {COLUMNS * max(surfaces, 1)} ghost no",
        f"fix kicks all property/atom {KICKS} 6 ghost no",
    ]


def law_commands(machine: Machine, model: ChargeModel, dt: float) -> list[str]:
    """Return the commands that make the particles move and touch: laws and lists."""
    pairs = [f"pair_coeff {i + 1} {j + 1} {words}" for (i, j), words in pair_words(machine).items()]
    return [
        "pair_style granular",
        *pairs,
        f"neighbor {model.skin:.15g} bin",
        "neigh_modify delay 0 every 1 check yes",
        f"timestep {dt:.17g}",
        f"fix {FRAME} all external pf/callback 1 1",
        "fix move all nve/sphere",
        "compute touching all contact/atom",
        # its sums over all particles at both ends of every window, as by default, would cost a step
        "thermo_style custom step",
        "thermo 1000000000",
        "thermo_modify lost error",
    ]


def share_commands(ranks: int) -> list[str]:
    """Return the commands that share the particles among the processes, none for one process."""
    if ranks == 1:
        return []
    return [
        f"balance {UNBALANCE} shift xyz 20 1.01",
        f"fix share all balance {BALANCE_EVERY} {UNBALANCE} shift xyz 10 1.02",
    ]
