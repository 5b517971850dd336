"""The same thirty balls of 10 mm in a smooth chamber and in one with twelve ribs.

It prints crank-pin force, torque, and where the power goes.
Checked: the motor's power is what the sinks of the ledger take, and the ribs weigh on the crank: 2.06 kg more
in the chamber add to its force.
"""

import nutamill as nm

CASE = [
    "mechanism.mounting=rigid",
    "charge.diameter=10 mm",
    "charge.count=30",
    "drive.speed=800 rpm",
    "drive.ramp=40000 rpm/s",
    "run.until=0.12 s",
    "run.threads=1",
]
print(f"{'ribs':>4} {'force (N)':>10} {'torque (N m)':>13} {'power (W)':>10}  largest sinks")
forces = []
for ribs in (0, 12):
    case = nm.load_case("numill", CASE).with_("chamber.ribs", ribs)
    with nm.run(case, to=f"results/ribs-{ribs}.h5") as result:
        force = nm.steady_mean(result, "crank_pin_force_resultant").mean
        torque = nm.steady_mean(result, "driveshaft_torque").mean
        power = nm.power_split(result)
        nm.write_figures(result, ["run"], result.path.parent)
    largest = sorted(power.sinks.items(), key=lambda sink: -sink[1])[:2]
    shares = ", ".join(f"{name} {100 * sink / power.motor:.0f} %" for name, sink in largest)
    print(f"{ribs:4} {force:10.1f} {torque:13.3f} {power.motor:10.1f}  {shares}")
    assert abs(power.motor - sum(power.sinks.values())) < 2e-3 * power.motor
    forces.append(force)
assert forces[1] > forces[0]
