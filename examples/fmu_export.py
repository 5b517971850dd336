"""Our machine in another program: the piston with the balls on it as an FMU, run by FMPy.

Needs the extra fmu and a C compiler. Checked: the FMU, which holds no Python, gives the numbers of a run of
ours to the last bit.
"""

import subprocess
import sys

import fmpy
import matplotlib.pyplot as plt
import numpy as np

import nutamill as nm

CHANGES = ["charge.count=150", "run.until=60 ms", "run.threads=1"]
PLACE, PUSH = "piston_position_z", "piston_charge_force_z"

settings = [word for change in CHANGES for word in ("-s", change)]
command = [sys.executable, "-m", "nutamill", "export", "fmu", "piston", *settings, "--what", "whole"]
subprocess.run([*command, "-o", "piston.fmu"], check=True)

with nm.run(nm.load_case("piston", CHANGES), to="piston.h5") as result:
    rate, series = result.rate, result.series.load()
answer = fmpy.simulate_fmu(
    "piston.fmu", stop_time=0.06, step_size=1 / rate, output_interval=1 / rate, output=[PLACE, PUSH]
)

figure, panels = plt.subplots(2, sharex=True, layout="constrained")
for panel, name, factor, label in zip(
    panels, (PLACE, PUSH), (1e3, 1.0), ("piston (mm)", "push of the balls (N)"), strict=True
):
    panel.plot(1e3 * answer["time"], factor * answer[name], label="FMU in FMPy")
    panel.plot(1e3 * series["time"], factor * series[name], "--", label="nutamill run")
    panel.set_ylabel(label)
panels[0].legend()
panels[1].set_xlabel("time (ms)")
figure.savefig("fmu_export.png")

equal = all(np.array_equal(answer[name], series[name].values) for name in (PLACE, PUSH))
print(f"{len(answer)} rows, {'all bits' if equal else 'not all bits'} as in our own run")
assert equal
