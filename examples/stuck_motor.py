"""A start against a charge that has set: friction that grips at rest, and a motor that may not turn it.

Friction of the crank pin stands in for the set charge. A motor that gives less torque than it stays where it
is, one that gives more starts, and the speed controller asks for all it has until then.
Checked: the weak motor creeps at less than a tenth of the speed, for the model lets friction slip a little
where a real joint sticks; the strong one reaches the speed. Neither gives more than its largest torque.
"""

import math

import nutamill as nm

GRIP, RPM = 4.0, math.pi / 30.0  # N m

case = nm.load_case(
    "numill-2025", ["charge.kind=none", "drive.speed=300 rpm", "drive.ramp=600 rpm/s", "run.until=1.5 s"]
)
case = case.with_(mechanism__joint_friction=0.0, mechanism__joint_friction_constant=0.5 * GRIP)
print(f"{'motor':>10} {'largest torque':>15} {'speed at the end':>17}")
ends = {}
for torque in (3.0, 8.0):
    with nm.run(case.with_("drive.motor", {"torque": torque}), to=f"results/stuck-{torque:g}.h5") as result:
        series = result.series
        ends[torque] = float(series["driveshaft_speed"][-1]) / RPM
        most = float(series["driveshaft_torque"].max())
        nm.draw_histories(result, ["driveshaft_speed", "driveshaft_torque"]).savefig(f"stuck-{torque:g}.png")
    print(f"{torque:6.1f} N m {most:11.2f} N m {ends[torque]:13.1f} rpm")
    assert most <= torque * (1 + 1e-9)
assert abs(ends[3.0]) < 30.0 and abs(ends[8.0] - 300.0) < 1.0
