"""Another program's machine around our charge: a piston on a spring, as an FMU, moves under our balls.

The FMU is made here too, of the mechanism of our own piston. Needs the extra fmu and a C compiler. Checked:
piston and balls move as they do where both are ours, to the last bit.
"""

import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import nutamill as nm

RUN = ["charge.count=150", "run.until=60 ms", "run.threads=1"]
NAMES = ["piston_position_z", "piston_charge_force_z"]
PARTS = {"position": "xyz", "attitude": "wxyz", "velocity": "xyz", "angular_velocity": "xyz"}
PARTS |= {"acceleration": "xyz", "angular_acceleration": "xyz"}

# one step of the FMU in each window of ours
step = ["-s", "run.step=125 us"]
export = ["nutamill", "export", "fmu", "piston", *step, "-o", "machine.fmu"]
subprocess.run([sys.executable, "-m", *export], check=True)

lines = ['schema = 1\nbase = "piston"\njoints = []\nsprings = []']
lines += ['[[fmus]]\nname = "machine"\nfile = "machine.fmu"\n[[fmus.bodies]]\nbody = "piston"']
for part, axes in PARTS.items():
    name = "quaternion" if part == "attitude" else part
    lines.append(f"{part} = {[f'bodies.piston.{name}.{axis}' for axis in axes]}")
lines += [f"{load} = {[f'wrench.piston.{load}.{axis}' for axis in 'xyz']}" for load in ("force", "moment")]
Path("foreign.toml").write_text("\n".join(lines) + "\n")

own, foreign = (
    nm.run(nm.load_case(case, RUN), to=file, trust_fmu=True).series[["time", *NAMES]].load()
    for case, file in (("piston", "own.h5"), ("foreign.toml", "foreign.h5"))
)
figure, panels = plt.subplots(2, sharex=True, layout="constrained")
for panel, name, label in zip(panels, NAMES, ("piston (mm)", "push of the balls (N)"), strict=True):
    factor = 1e3 if name == NAMES[0] else 1.0
    panel.plot(1e3 * foreign["time"], factor * foreign[name], label="machine as FMU")
    panel.plot(1e3 * own["time"], factor * own[name], "--", label="all ours")
    panel.set_ylabel(label)
panels[0].legend()
panels[1].set_xlabel("time (ms)")
figure.savefig("fmu_machine.png")
equal = all(np.array_equal(own[name], foreign[name]) for name in NAMES)
print(f"{own.sizes['time']} rows, {'all bits' if equal else 'not all bits'} as with our own machine")
assert equal
