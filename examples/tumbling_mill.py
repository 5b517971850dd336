"""A tumbling ball mill from rest, with a motor that has a limit of torque.

Checked: the motor never exceeds its limit, the ledger of energy closes, and the drum turns as the torques on
it say: of the motor, of the bearings and of the balls.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

import nutamill as nm

LIMIT, INERTIA, DRAG = 20.0, 1.2, 0.05

case = nm.load_case("tumbling-mill")
with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "mill.h5") as result:
    series = result.series
    time, speed = series["time"].values, series["drive_motor_speed"].values
    torque, balls = series["drive_motor_torque"].values, series["drum_charge_moment_x"].values
    names = ["drive_motor_speed", "drive_motor_torque", "drum_charge_moment_x"]
    nm.draw_histories(result, names).savefig("tumbling_mill.png")
    work, left = float(series["drive_motor_work"].values[-1]), abs(series["ledger_residual"].values).max()

# moments of momentum: what the three torques gave the drum until the end
gained = np.trapezoid(torque - DRAG * speed + balls, time)
late = time >= 1.5
print(
    f"speed {speed[-1] * 30 / math.pi:.1f} rpm, motor {torque[late].mean():.2f} N m, largest"
    f" {torque.max():.2f} N m"
)
print(
    f"balls {-balls[late].mean():.2f} N m, power {np.mean((torque * speed)[late]):.1f} W, work {work:.1f} J"
)
print(f"drum {INERTIA * speed[-1]:.3f} N m s, torques gave {gained:.3f} N m s")
assert torque.max() <= LIMIT * (1.0 + 1e-9)
assert left < 1e-3 * work
# samples of 1 ms miss one row's torque at most where the motor comes off its limit, and one at the start
assert abs(gained - INERTIA * speed[-1]) < 2 * 1e-3 * LIMIT
