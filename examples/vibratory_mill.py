"""A tube on springs, shaken by an unbalanced rotor, empty and with balls.

Checked: the empty tube runs on the circle of the closed form, and with balls the ledger of energy closes.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

import nutamill as nm

UNBALANCE, MASS, STIFFNESS, SPEED = 2.0 * 0.03, 20.0, 4 * 1776.0, 1500 * math.pi / 30

case = nm.load_case("vibratory-mill")
radius = {}
for name, one in (("empty", case.with_({"charge.kind": "none", "run.until": "8 s"})), ("with balls", case)):
    with tempfile.TemporaryDirectory() as folder, nm.run(one, to=Path(folder) / "tube.h5") as result:
        series = result.series
        late = slice(-200, None)  # 0.2 s: five turns
        angle = series["drive_motor_angle"].values[late]
        across, up = (series[f"tube_position_{axis}"].values[late] for axis in "xz")
        # the part of the motion that turns with the rotor
        radius[name] = abs(np.mean((across + 1j * up) * np.exp(1j * angle)))
        power = np.polyfit(series["time"].values[late], series["drive_motor_work"].values[late], 1)[0]
        print(f"{name}: circle of {1e3 * radius[name]:.3f} mm, motor {power:.1f} W")
        work = float(series["drive_motor_work"].values[-1])
        assert abs(series["ledger_residual"].values).max() < 1e-3 * work
        if name == "with balls":
            names = ["tube_position_x", "tube_position_z", "drive_motor_torque"]
            nm.draw_histories(result, names).savefig("vibratory_mill.png")

closed = UNBALANCE * SPEED**2 / abs(STIFFNESS - MASS * SPEED**2)
print(f"closed form, empty: {1e3 * closed:.3f} mm")
# the first swing has died down to exp(-7.2) of its size, and damping changes the closed form by 7e-5
assert abs(radius["empty"] / closed - 1.0) < math.exp(-7.2)
