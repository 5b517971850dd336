"""A motor of 370 W that is asked for 700 rpm, and a power cut.

The empty mill has no charge to slow it; viscous friction stands in for the pellets, chosen so that it takes
6.31 N m at 560 rpm, which is where 0.37 kW ended the tests of SAIMM 2025.
Checked: the mill ends at 560 rpm, and coasts down after the cut.
"""

import math
import tempfile
from pathlib import Path

import nutamill as nm

RPM = math.pi / 30.0

case = nm.load_case(
    "numill-2025", ["charge.kind=none", "drive.speed=700 rpm", "drive.ramp=350 rpm/s", "run.until=6 s"]
).with_(
    mechanism__joint_friction=0.0,
    mechanism__joint_friction_viscous=0.5 * 6.31 / (560.0 * RPM),  # each of two bearings
    drive__motor={"power": 370.0, "cut": 5.0},
)
with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "motor.h5") as result:
    series = result.series
    print(f"{'t (s)':>6} {'asked rpm':>10} {'rpm':>7} {'N m':>7} {'W':>7}")
    for time in (0.5, 1.0, 1.5, 2.0, 3.0, 4.9, 5.1, 5.5, 6.0):
        now = series.sel(time=time, method="nearest")
        asked = min(350.0 * time, 700.0)
        speed, torque = float(now["driveshaft_speed"]), float(now["driveshaft_torque"])
        print(f"{time:6.1f} {asked:10.0f} {speed / RPM:7.1f} {torque:7.2f} {speed * torque:7.1f}")
    drawn = nm.draw_histories(result, ["driveshaft_speed", "driveshaft_torque", "driveshaft_power"])
    drawn.savefig("motor.png")
    steady = float(series["driveshaft_speed"].sel(time=4.9, method="nearest"))
    assert abs(steady / RPM - 560.0) < 5.0
    assert float(series["driveshaft_speed"][-1]) < 0.2 * steady
    assert float(abs(series["ledger_residual"]).max()) < 1e-3 * float(series["motor_work"][-1])
