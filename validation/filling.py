"""Fill cylinders as densely as the rule of `charge/filling/room.py` allows, and settle a crowded bed.

    python -m validation.filling             all of it, and write the table
    python -m validation.filling 12 49       cylinders of these diameters, printed only
    python -m validation.filling settle      settle a crowded bed of the mill, printed only

A row gives the solids fraction of the whole cylinder, as high as wide: that which the rule allows and that of
the particles which were placed.  *Core* is the fraction farther than three diameters from all walls, by a
million random points.  The chamber of the mill is filled with 0.99 of a bed of 0.62.
"""

import math
import os
import sys
import time
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import nutamill as nm
from nutamill import __version__
from nutamill.base.provenance import processor
from nutamill.charge.filling.fill import random_fill
from nutamill.charge.filling.room import cylinder_room, largest_fill
from nutamill.simulation.setup.bed import bed_file, settled_bed
from nutamill.simulation.setup.particles import charge_particles

TABLE = Path(__file__).parent / "results" / "filling.txt"
ACROSS = (12, 16, 20, 30)
"""Diameters of a particle in that of the cylinder [1]."""
POINTS = 1_000_000
SETTLED = {"charge.diameter": "10 mm", "charge.fill": 0.98, "charge.packing": 0.6}
"""A bed of the published mill that is settled."""
FULL = {"charge.diameter": "5 mm", "charge.fill": 0.99, "charge.packing": 0.62}
"""A bed of the published mill that is placed."""
HEAD = f"{'bed':34} {'particles':>9} {'asked':>7} {'placed':>7} {'core':>7} {'processor':>10}"


def cylinder(radius: float, height: float, r: float, number: int) -> tuple[str, bool]:
    """Fill a cylinder with `number` spheres of radius `r` [m].

    Return the numbers of a row, and whether all spheres are in the cylinder and none overlap.
    """
    volume, one = cylinder_room(radius, 0.0, height).volume, 4.0 / 3.0 * math.pi * r**3
    began = time.process_time()
    try:
        x = random_fill(np.full(number, r), radius, 0.0, height)
    except nm.CaseError as error:
        return f"{number:9d} {number * one / volume:7.4f} not placed: {error}", False
    spent = time.process_time() - began
    tree = cKDTree(x)
    inside = np.hypot(x[:, 0], x[:, 1]).max() <= radius - r and r <= x[:, 2].min()
    good = inside and x[:, 2].max() <= height - r and not len(tree.query_pairs(2.0 * r))
    free = len(x) * one / volume
    row = f"{number:9d} {number * one / volume:7.4f} {free:7.4f} {core(tree, radius, height, r):7.4f}"
    return f"{row} {spent:8.1f} s", good


def core(tree: cKDTree, radius: float, height: float, r: float) -> float:
    """Return the solids fraction farther than three diameters from all walls."""
    draw, away = np.random.default_rng(1), 6.0 * r
    angle = draw.uniform(0.0, math.tau, POINTS)
    out = (radius - away) * np.sqrt(draw.random(POINTS))
    z = draw.uniform(away, height - away, POINTS)
    near, _ = tree.query(np.column_stack([out * np.cos(angle), out * np.sin(angle), z]))
    return float((near <= r).mean())


def main(words: list[str]) -> int:
    """Run the rows and return 1 if a sphere overlaps or is outside."""
    if words == ["settle"]:
        print(settled())
        return 0
    lines, good = [HEAD], True
    for across in [int(word) for word in words] or ACROSS:
        room = cylinder_room(across / 2, 0.0, across)
        number = int(largest_fill(np.array([0.5]), room) / (math.pi / 6.0))
        row, fine = cylinder(across / 2, across, 0.5, number)
        good &= fine
        _say(lines, f"{f'cylinder of {across} diameters':34} {row}")
    if not words:
        full = _mill(FULL)
        radius, particles = full.chamber.inner_diameter / 2, charge_particles(full.machine)
        row, fine = cylinder(
            radius, full.chamber.height, float(particles.bounding_radius[0]), particles.number
        )
        good &= fine
        _say(lines, f"{'mill, 5 mm, 0.99 of a bed of 0.62':34} {row}")
        _say(lines, f"\n{settled()}")
        head = [
            "python -m validation.filling",
            f"nutamill {__version__}, {time.strftime('%Y-%m-%d', time.gmtime())}, {processor()}, "
            f"{os.cpu_count()} cores",
            "",
        ]
        TABLE.write_text("\n".join([*head, *lines]) + "\n", encoding="utf-8")
    return 0 if good else 1


def settled() -> str:
    """Return a line on a crowded bed of the mill that is placed, settled, and started."""
    case = _mill(SETTLED)
    bed_file(case.machine).unlink(missing_ok=True)
    began = time.process_time()
    places = settled_bed(case.machine)
    spent = time.process_time() - began
    high = np.ptp(places[:, 2]) + case.charge.parts[0].diameter
    return (
        f"mill, {len(places)} spheres of 10 mm at 0.588: settled to a bed {1e3 * high:.1f} mm high in "
        f"{1e3 * case.chamber.height:.1f} mm, {spent:.1f} s of processor time"
    )


def _mill(keys: dict) -> nm.Case:
    """Return the published mill with some keys of its charge changed."""
    return nm.load_case("numill", [f"{key}={value}" for key, value in keys.items()])


def _say(lines: list[str], line: str) -> None:
    """Print a line and add it to the others."""
    lines.append(line)
    print(line, flush=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
