"""A piston on a spring that nothing drives but the balls on it.

Two hundred balls have settled on the piston, held where its spring has no force; then it is let go.
Checked: it comes to rest where the spring carries the weight of piston and balls, and the balls push on it
with their weight, as near as the swing has died down by then.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

import nutamill as nm

G, PISTON, STIFFNESS, DAMPING = 9.81, 0.2, 2000.0, 15.0

case = nm.load_case("piston")
with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "piston.h5") as result:
    series = result.series
    place, push = series["piston_position_z"].values, -series["piston_charge_force_z"].values
    nm.draw_histories(result, ["piston_position_z", "piston_charge_force_z"]).savefig("piston.png")
    late = series["time"].values >= 0.4

balls = 200 * 7800.0 * math.pi / 6 * 0.006**3
sag = (PISTON + balls) * G / STIFFNESS
# what is left of a swing of the size of the sag, and twice as much again for the speed in the damper
left = 3.0 * math.exp(-0.4 * DAMPING / (2.0 * (PISTON + balls)))
print(f"lowest {1e3 * place.min():.2f} mm, {place.min() / -sag:.2f} times the sag at rest")
print(f"at rest {1e3 * np.mean(place[late]):.3f} mm, weight over stiffness {-1e3 * sag:.3f} mm")
print(f"push of the balls {np.mean(push[late]):.3f} N, their weight {balls * G:.3f} N")
assert abs(np.mean(place[late]) / -sag - 1.0) < left
assert abs(np.mean(push[late]) / (balls * G) - 1.0) < left
