"""Make the stand-in for the coarse sand of SAIMM 2025: ten clumps of three spheres, and their sizes.

The paper's ten scanned grains and its measured size distribution are not public.  What is: three spheres to a
clump, ten shapes, 39534 clumps that weigh 1.34 kg at 2480 kg/m^3, grains of 3 to 5 mm with a mean diameter of
3.38 mm, bulk density 1403 kg/m^3. The rest is chosen here: random triangles of spheres with aspect ratios
(longest over shortest side) from 1.2 to 1.6, mean 1.4.

    python tools/coarse_sand.py         writes the two files beside the machines
"""

import math
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from nutamill.charge.particles.shapes import clump_shape
from nutamill.charge.particles.sizes import normal_sizes, sphere_volume

SEED = 20250
SHAPES, SPHERES = 10, 3
ASPECTS = np.linspace(1.2, 1.6, SHAPES)
CLUMPS, MASS, DENSITY, BULK = 39534, 1.34, 2480.0, 1403.0
MEAN_DIAMETER, SIEVES = 3.38e-3, (3e-3, 5e-3)
DEVIATION = 0.3e-3
MACHINES = Path(__file__).parents[1] / "src" / "nutamill" / "data" / "machines"

SHAPES_HEAD = """\
# STAND-IN, not measured: ten clumps of three spheres in place of the scanned grains of coarse sand of van Tonder, Bredell, Coetzee
# and Branehog, J. S. Afr. Inst. Min. Metall. 125, 99-106 (2025), whose shapes are not public.
# Each clump is a list of spheres: x, y, z, radius; the diameter of the sphere of its volume is 1. Aspect ratios 1.2 to 1.6, mean 1.4.
# Made by tools/coarse_sand.py with seed {seed}; do not edit.
assumed = "the scanned grains of SAIMM 2025 are not public; ten random three-sphere clumps with a mean aspect ratio of 1.4 take their place"
clumps = [
"""

CHARGE = """\
# Coarse sand of van Tonder, Bredell, Coetzee and Branehog, J. S. Afr. Inst. Min. Metall. 125, 99-106 (2025) = SAIMM.
# Marks: P published, F fitted to a published number, A assumed. Made by tools/coarse_sand.py; do not edit.
kind     = "clumps"                       # P SAIMM Table 3: three spheres each, ten shapes
material = "sand"
shapes   = "coarse-sand"                  # A the shapes are not public
count    = {count}                          # P SAIMM Table 3
packing  = {packing:.4f}                         # P SAIMM Table 3: bulk density 1403 kg/m^3 over 2480 kg/m^3

[distribution]                            # A the measured distribution is not public
law       = "normal"
by        = "number"
mean      = "{mean:.6f} mm"                 # F so that the clumps together weigh the published 1.34 kg, 33.9 mg each
deviation = "{deviation:g} mm"                      # A a tenth of the mean
smallest  = "{smallest:.3f} mm"                    # A the published grains of 3 to 5 mm, times {factor:.4f}: a clump of the mean
largest   = "{largest:.3f} mm"                    # A mass has the volume of a {sphere:.3f} mm sphere, the published mean is 3.38 mm
"""


def random_clump(rng: np.random.Generator, aspect: float) -> np.ndarray:
    """Three spheres (3, 4) of which each overlaps the next, drawn apart until the clump has the aspect ratio
    asked for.
    """
    while True:
        radii = rng.uniform(0.75, 1.0, SPHERES)
        centres = rng.normal(size=(SPHERES, 3)) * (1.0, 0.6, 0.3)
        centres -= centres.mean(axis=0)
        apart = np.linalg.norm(centres - np.roll(centres, 1, axis=0), axis=1)
        # between spheres that just do not hide each other and spheres that overlap by a fifth of the sum of
        # their radii
        least = 1.05 * float((np.abs(radii - np.roll(radii, 1)) / apart).max())
        most = 0.8 * float(((radii + np.roll(radii, 1)) / apart).min())
        if (
            least < most
            and clump_shape(least * centres, radii).aspect_ratio
            < aspect
            < clump_shape(most * centres, radii).aspect_ratio
        ):
            return _drawn_apart(centres, radii, aspect, least, most)


def _drawn_apart(centres, radii, aspect, least, most) -> np.ndarray:
    spread = brentq(lambda s: clump_shape(s * centres, radii).aspect_ratio - aspect, least, most, xtol=1e-9)
    shape = clump_shape(spread * centres, radii).scaled(1.0)
    return np.column_stack([shape.offsets, shape.radii])


def shapes_text() -> str:
    """The file of shapes."""
    rng = np.random.default_rng(SEED)
    text = SHAPES_HEAD.format(seed=SEED)
    for aspect in ASPECTS:
        rows = ", ".join(
            f"[{', '.join(f'{number:.5f}' for number in sphere.round(5) + 0.0)}]"
            for sphere in random_clump(rng, aspect)
        )
        text += f"  [{rows}],\n"
    return text + "]\n"


def charge_text() -> str:
    """The file of the charge: its mean diameter is such that the mean clump weighs what the published one
    does.
    """
    volume = MASS / DENSITY / CLUMPS
    sphere = (6.0 * volume / math.pi) ** (1.0 / 3.0)
    factor = sphere / MEAN_DIAMETER
    smallest, largest = (round(factor * sieve, 6) for sieve in SIEVES)

    def excess(mean: float) -> float:
        sizes = normal_sizes(mean, DEVIATION, smallest, largest, "number").of_number(CLUMPS)
        return float(sphere_volume(sizes).mean()) / volume - 1.0

    mean = brentq(excess, 2e-3, 4e-3, xtol=1e-12)
    lengths = {
        "mean": mean,
        "deviation": DEVIATION,
        "smallest": smallest,
        "largest": largest,
        "sphere": sphere,
    }
    return CHARGE.format(
        count=CLUMPS,
        packing=BULK / DENSITY,
        factor=factor,
        **{name: 1e3 * value for name, value in lengths.items()},
    )


if __name__ == "__main__":
    (MACHINES / "shapes" / "coarse-sand.toml").write_text(shapes_text(), encoding="utf-8")
    (MACHINES / "charges" / "coarse-sand.toml").write_text(charge_text(), encoding="utf-8")
