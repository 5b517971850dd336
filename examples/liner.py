"""A chamber from an STL file: a liner with sixteen flat sides, which the case as drawn does not have.

Checked: the mesh holds the volume of that prism, and no pellet leaves it.
"""

import itertools
import math
from pathlib import Path

import numpy as np

import nutamill as nm

SIDES, RADIUS, FLOOR, CEILING = 16, 0.070, -0.350, -0.122  # m, from the nutation point along the axis


def prism(sides, radius, low, high):
    """Return the triangles of a closed prism (n, 3, 3)."""
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    rim = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle])
    down, up = np.array([0.0, 0.0, low]), np.array([0.0, 0.0, high])
    triangles = []
    for a, b in itertools.pairwise(rim):
        triangles += [(down, b + down, a + down), (up, a + up, b + up)]
        triangles += [(a + down, b + down, b + up), (a + down, b + up, a + up)]
    return np.array(triangles)


liner = prism(SIDES, RADIUS, FLOOR, CEILING)
corners = ["".join(f"vertex {x:.6g} {y:.6g} {z:.6g}\n" for x, y, z in one) for one in 1e3 * liner]
facets = "\n".join(f"facet normal 0 0 0\nouter loop\n{text}endloop\nendfacet" for text in corners)
Path("liner.stl").write_text(f"solid liner\n{facets}\nendsolid liner\n", encoding="utf-8")  # in mm

case = nm.load_case(
    "numill",
    [
        'chamber.mesh={file="liner.stl", unit="mm"}',
        "mechanism.mounting=rigid",
        "charge.diameter=10 mm",
        "charge.count=30",
        "drive.ramp=40000 rpm/s",
        "run.until=40 ms",
        'run.snapshots={rate="500 Hz", last="40 ms"}',
        "run.threads=1",
    ],
)
sheet = nm.check(case)
print("\n".join(line for line in sheet.lines() if line.startswith("mesh")))
area = 0.5 * SIDES * RADIUS**2 * math.sin(2 * math.pi / SIDES)
assert abs(sheet.meshes[0].volume - area * (CEILING - FLOOR)) < 1e-6 * sheet.meshes[0].volume
with nm.run(case, to="results/liner.h5") as result:
    last = result.snapshots[-1]
    print(nm.write_view(result, result.path.with_suffix(".html")))
    farthest = np.linalg.norm(last["positions"], axis=1).max()
print(f"farthest pellet {1e3 * farthest:.0f} mm from the nutation point")
assert farthest < math.hypot(RADIUS, FLOOR)
