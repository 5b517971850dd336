"""A box on a leaf spring that is bent and let go: how fast it rings down, empty and with sixty balls in it.

Checked: the empty box follows the closed form of a damped oscillator, and both ledgers of energy close to a
thousandth of the energy of the bent leaf.
"""

import math
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import nutamill as nm

MASS, STIFFNESS, DAMPING, BENT = 0.5, 1600.0, 0.2828, 0.004
ENERGY = 0.5 * STIFFNESS * BENT**2

case = nm.load_case("particle-damper")
left, lost = {}, {}
figure, axes = plt.subplots()
for name, one in (("empty", case.with_("charge.kind", "none")), ("with balls", case)):
    with tempfile.TemporaryDirectory() as folder, nm.run(one, to=Path(folder) / "damper.h5") as result:
        series = result.series
        time, place = series["time"].values, series["box_position_x"].values
        swing = [np.abs(place[(time >= t) & (time < t + 0.06)]).max() for t in (0.0, 0.9)]
        left[name], lost[name] = swing[1] / swing[0], float(series["spring_leaf_loss"].values[-1])
        axes.plot(time, 1e3 * place, label=name)
        assert abs(series["ledger_residual"].values).max() < 1e-3 * ENERGY
        if name == "empty":
            rate, speed = DAMPING / (2.0 * MASS), math.sqrt(STIFFNESS / MASS)
            damped = math.sqrt(speed**2 - rate**2)
            swung = np.cos(damped * time) + rate / damped * np.sin(damped * time)
            # a second-order step of 50 us is late by (speed x step)^2 of the angle at most
            late = (speed * 50e-6) ** 2 * speed * time[-1]
            assert np.abs(place - BENT * np.exp(-rate * time) * swung).max() < late * BENT

for name in left:
    print(f"{name}: {100 * left[name]:.1f} % of the swing after 0.9 s, {1e3 * lost[name]:.2f} mJ in the leaf")
print(f"of {1e3 * ENERGY:.2f} mJ")
assert left["with balls"] < 0.5 * left["empty"]
axes.set(xlabel="time (s)", ylabel="box (mm)", ylim=(-4.5, 5.5))
axes.legend(loc="upper right", ncols=2)
figure.savefig("particle_damper.png")
