"""The empty mill at three speeds, one process a run: mean force and torque with their 95 % intervals.

Checked: the force is that of a rotating mass, so that force over speed squared is the same at every
speed within its interval.
"""

import nutamill as nm

EMPTY = ["mechanism.mounting=rigid", "charge.kind=none", "drive.ramp=4000 rpm/s", "run.until=1 s"]
SPEEDS = ["400 rpm", "500 rpm", "600 rpm"]

case = nm.load_case("numill", EMPTY)
done = nm.sweep(case, {"drive.speed": SPEEDS}, folder="results/speeds")
print(f"{'speed':>8} {'force (N)':>18} {'torque (N m)':>18}")
shares = []
for speed, outcome in zip(SPEEDS, done.outcomes, strict=True):
    with nm.open_result(outcome.file) as result:
        force, torque = (
            nm.steady_mean(result, name) for name in ("crank_pin_force_resultant_tared", "driveshaft_torque")
        )
        nm.write_figures(result, ["run"], done.folder)
    means = [f"{one.mean:9.4g} ± {one.half_width:<6.1g}" for one in (force, torque)]
    print(f"{speed:>8} {' '.join(means)}")
    shares.append(force.mean / case.with_("drive.speed", speed).drive.speed ** 2)
spread = max(shares) / min(shares) - 1.0
print(f"force over speed squared differs by {100 * spread:.2f} %")
assert spread < 1e-4  # the resolution of the step
