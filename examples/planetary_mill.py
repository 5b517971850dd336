"""A planetary ball mill with two jars, empty and with forty balls in each.

Checked: each bearing of an empty jar carries the centrifugal force and the weight of its jar, with balls the
ledger of energy closes, and the bearings then carry the balls as well.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

import nutamill as nm

JAR, RADIUS, SPEED, G = 2.0, 0.075, 300 * math.pi / 30, 9.81
BALLS = 40 * 7800.0 * math.pi / 6 * 0.010**3

case = nm.load_case("planetary-mill")
radial, power = {}, {}
for name, one in (("empty", case.with_("charge.kind", "none")), ("with balls", case)):
    with tempfile.TemporaryDirectory() as folder, nm.run(one, to=Path(folder) / "mill.h5") as result:
        series = result.series
        late = slice(-400, None)  # 0.4 s: two turns
        force = [series[f"joint_jar_1_bearing_force_{axis}"].values[late] for axis in "xyz"]
        radial[name] = np.hypot(force[0], force[1]).mean()
        work = series["drive_motor_work"].values
        power[name] = (work[-1] - work[-400]) / 0.399
        print(f"{name}: bearing {radial[name]:.2f} N across, {force[2].mean():.2f} N up, {power[name]:.2f} W")
        assert abs(series["ledger_residual"].values).max() < 1e-3 * work[-1]
        if name == "with balls":
            names = ["drive_motor_torque", "joint_jar_1_bearing_force_x", "jar_1_charge_moment_z"]
            nm.draw_histories(result, names).savefig("planetary_mill.png")

closed = JAR * SPEED**2 * RADIUS
most = closed + BALLS * SPEED**2 * (RADIUS + 0.032)
print(f"closed form, empty: {closed:.2f} N across, {JAR * G:.2f} N up; all balls at the rim {most:.2f} N")
# a step of 50 us is of second order
assert abs(radial["empty"] / closed - 1.0) < (SPEED * 50e-6) ** 2
assert radial["empty"] < radial["with balls"] < most and power["with balls"] > power["empty"]
