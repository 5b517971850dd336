"""Another program's motor on our shaft: an FMU with a speed as input and a torque as output.

The FMU is made here too, of a rotor whose torque falls with its speed, c (Omega - w), but any other takes its
place. Needs the extra fmu and a C compiler. Checked: a flywheel J comes up as Omega (1 - exp(-c t / J)).
"""

import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import nutamill as nm

SPEED, SLOPE, INERTIA = 100.0, 0.05, 0.01  # rad/s, N m s/rad, kg m^2

ROTOR = """run = {{ until = "0.6 s" }}
[[bodies]]
name     = "rotor"
mass     = "1 kg"
inertia  = ["1 kg m^2", "1 kg m^2", "{inertia} kg m^2"]
position = ["0 m", "0 m", "0 m"]
[[joints]]
name     = "bearing"
kind     = "revolute"
between  = ["ground", "rotor"]
point    = ["0 m", "0 m", "0 m"]
axis     = [0, 0, 1]
{more}
[[drives]]
name     = "shaft"
joint    = "bearing"
speed    = "100 rad/s"
ramp     = "1000 rad/s^2"
"""
MOTOR = 'friction = {{ viscous = "{} N m s/rad" }}\n[[torques]]\nname = "field"\nbody = "rotor"\n'
MOTOR += 'moment = ["0 N m", "0 N m", "{} N m"]'
FMU = '[[fmus]]\nname = "motor"\nfile = "motor.fmu"\n[[fmus.drives]]\ndrive = "shaft"\n'
FMU += 'torque = "-drive_shaft_torque"\nspeed = "drives.shaft.speed"'

more = MOTOR.format(SLOPE, SLOPE * SPEED)
Path("motor.toml").write_text(ROTOR.format(inertia=1e-9, more=more))
export = ["nutamill", "export", "fmu", "motor.toml", "--drives", "speed", "-o", "motor.fmu"]
subprocess.run([sys.executable, "-m", *export], check=True)
Path("flywheel.toml").write_text(ROTOR.format(inertia=INERTIA, more=FMU))

with nm.run("flywheel.toml", to="flywheel.h5", trust_fmu=True) as result:
    time, speed = (result.series[name].values for name in ("time", "drive_shaft_speed"))
exact = SPEED * (1.0 - np.exp(-SLOPE * time / INERTIA))

figure, panel = plt.subplots(layout="constrained")
panel.plot(time, speed, label="flywheel, motor as FMU")
panel.plot(time, exact, "--", label="closed form")
panel.set(xlabel="time (s)", ylabel="speed (rad/s)")
panel.legend()
figure.savefig("fmu_motor.png")
print(f"largest difference {np.abs(speed - exact).max() / SPEED:.1e} of the speed of the motor")
assert np.abs(speed - exact).max() < 1e-3 * SPEED
