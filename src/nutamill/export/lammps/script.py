"""Data file and input scripts of a charge in the axes of its chamber."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.charge.walls.surface import Surface
from nutamill.export.lammps.motion import Stretches
from nutamill.export.lammps.regions import region_lines

DATA, SCRIPT, MOTION, DUMP = "charge.data", "charge.in", "motion.in", "charge.dump"
"""Names of the files: particles, the script to run, the motion that it includes, and what it writes."""

AXES = ("x", "y", "z")
FRAME = ("gx", "gy", "gz", "wx", "wy", "wz", "ex", "ey", "ez")
"""Variables of the moving frame, in the order of `Stretches.at_start`."""


class Atoms(NamedTuple):
    """Particles at the start, in the axes of the chamber from its mass centre."""

    type: np.ndarray
    """Type, from 1 [1] (n,)."""
    diameter: np.ndarray
    """[m] (n,)."""
    density: np.ndarray
    """[kg/m^3] (n,)."""
    position: np.ndarray
    """[m] (n, 3)."""
    velocity: np.ndarray
    """Relative to the chamber [m/s] (n, 3)."""
    spin: np.ndarray
    """Relative to the chamber [rad/s] (n, 3)."""


class Laws(NamedTuple):
    """Contact laws in the words of ``pair_style granular``, by type of particle."""

    pairs: dict[tuple[int, int], str]
    """Of two types."""
    walls: dict[tuple[int, int], str]
    """Of a type and the material of a surface."""


def data_text(title: str, atoms: Atoms, n_types: int, corners: np.ndarray) -> str:
    """Return the data file of the particles, in a box around them and the `corners` of their regions [m]
    (n, 3), in the axes of the chamber from its mass centre.
    """
    margin, points = 2.0 * atoms.diameter.max(), np.concatenate([atoms.position, corners])
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    box = [f"{low[k]:.15g} {high[k]:.15g} {c}lo {c}hi" for k, c in enumerate("xyz")]
    places = [
        f"{i} {atoms.type[i - 1]} {atoms.diameter[i - 1]:.15g} {atoms.density[i - 1]:.15g} "
        + " ".join(f"{x:.15g}" for x in place)
        for i, place in enumerate(atoms.position, 1)
    ]
    motions = np.hstack([atoms.velocity, atoms.spin])
    moving = [f"{i} " + " ".join(f"{x:.15g}" for x in motion) for i, motion in enumerate(motions, 1)]
    head = [title, "", f"{len(places)} atoms", f"{n_types} atom types", "", *box]
    return "\n".join([*head, "", "Atoms # sphere", "", *places, "", "Velocities", "", *moving, ""])


def motion_text(motion: Stretches) -> str:
    """Return the script that gives the frame its motion, stretch after stretch, and runs through each."""
    lines, begun = [], 0
    for steps, start, slope in zip(*motion, strict=True):
        lines += [
            f"variable {name} equal {at:.12g}{rate:+.12g}*(step-{begun})"
            for name, at, rate in zip(FRAME, start, slope, strict=True)
        ]
        # the first run prepares lists and forces, the others go on with them
        lines += [f"variable h equal {steps}*dt", f"run {steps} {'' if begun == 0 else 'pre no '}post no"]
        lines.append("set group all omega v_ox v_oy v_oz")
        begun += int(steps)
    return "\n".join([*lines, ""])


def script_text(
    title: str, atoms: Atoms, surfaces: Sequence[Surface], laws: Laws, dt: float, every: int, first: Stretches
) -> str:
    """Return the script to run.

    Parameters
    ----------
    title : of the case
    atoms : particles at the start
    surfaces : walls, in the axes of the chamber from its mass centre
    laws : contact laws
    dt : step [s]
    every : steps between two moments of the dump [1]
    first : motion of the frame, whose start the variables hold until `motion_text` changes them
    """
    types = sorted({int(one) for one in atoms.type})
    coefficients = [f"pair_coeff {i} {j} {words}" for (i, j), words in laws.pairs.items()]
    walls = [line for number, surface in enumerate(surfaces) for line in region_lines(number, surface)]
    touching = [
        (f"touch{number}_{kind}", f"wall{number}", kind, laws.walls[kind, surface.material])
        for number, surface in enumerate(surfaces)
        for kind in types
    ]
    fixes = [
        f"fix {name} type{kind} wall/gran/region granular {words} region {region} contacts"
        for name, region, kind, words in touching
    ]
    forces = [
        f"compute force_{name} all reduce sum f_{name}[2] f_{name}[3] f_{name}[4]" for name, *_ in touching
    ]
    sums = [
        f"variable force_{c} equal -({'+'.join(f'c_force_{name}[{k}]' for name, *_ in touching)})"
        for k, c in enumerate("xyz", 1)
    ]
    frame = [f"variable {name} equal {at:.12g}" for name, at in zip(FRAME, first.at_start[0], strict=True)]
    return "\n".join([
        f"# {title}: the charge in the axes of its chamber, from the mass centre of the chamber",
        "# Walls rest; gravity and the forces of the frame that moves with the chamber act on the particles.",
        "units si",
        "atom_style sphere",
        "boundary m m m",
        "newton off",
        "comm_modify vel yes",
        f"read_data {DATA}",
        f"neighbor {0.25 * atoms.diameter.max():.6g} bin",
        "neigh_modify delay 0 every 1 check yes",
        "pair_style granular",
        *coefficients,
        f"timestep {dt:.15g}",
        "",
        *[f"group type{kind} type {kind}" for kind in types],
        *walls,
        *fixes,
        "",
        *frame,
        "variable h equal dt",
        *_frame_forces(),
        "fix frame all addforce v_fx v_fy v_fz",
        "compute spin all property/atom omegax omegay omegaz",
        "fix spin all ave/atom 1 1 1 c_spin[1] c_spin[2] c_spin[3]",
        *_frame_spins(),
        "fix move all nve/sphere",
        "",
        "# Force of the charge on the chamber [N], chamber axes, and kinetic energy in them [J]",
        *forces,
        *sums,
        "thermo_style custom step time atoms v_force_x v_force_y v_force_z ke",
        "thermo_modify lost error",
        f"thermo {every}",
        f"dump charge all custom {every} {DUMP} id type x y z vx vy vz omegax omegay omegaz",
        "dump_modify charge sort id format float %.9g",
        f"include {MOTION}",
        "",
    ])  # fmt: skip


def _frame_forces() -> list[str]:
    """Return the variables with the force of the frame: ``m (g - W' x r - W x (W x r) - 2 W x v)``."""
    out = ["variable dot atom v_wx*x+v_wy*y+v_wz*z", "variable square equal v_wx^2+v_wy^2+v_wz^2"]
    for n in range(3):
        a, b, c = (AXES[(n + k) % 3] for k in range(3))
        across = f"(v_e{b}*{c}-v_e{c}*{b})"
        centre = f"(v_w{a}*v_dot-v_square*{a})"
        turning = f"2*(v_w{b}*v{c}-v_w{c}*v{b})"
        out.append(f"variable f{a} atom mass*(v_g{a}-{across}-{centre}-{turning})")
    return out


def _frame_spins() -> list[str]:
    """Return the variables with the spins after a stretch of length h, which the frame turns and changes at
    the rate ``-W' - W x w``: the terms of first and second order in h.
    """
    rates, ends = [], []
    for n in range(3):
        a, b, c = (AXES[(n + k) % 3] for k in range(3))
        second, third = (n + 1) % 3 + 1, (n + 2) % 3 + 1
        rates.append(f"variable r{a} atom v_e{a}+v_w{b}*f_spin[{third}]-v_w{c}*f_spin[{second}]")
        ends.append(f"variable o{a} atom f_spin[{n + 1}]-v_h*v_r{a}+0.5*v_h^2*(v_w{b}*v_r{c}-v_w{c}*v_r{b})")
    return rates + ends
