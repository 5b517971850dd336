"""A pendulum on a pin, without a mill: its period and the force on the pin against their closed forms.

python examples/pendulum.py
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipk

import nutamill as nm

MASS, LENGTH, START, G = 2.0, 0.5, math.radians(60.0), 9.81  # kg, m, rad from straight down, m/s^2

bob = nm.Body("bob", MASS, 1e-9 * np.eye(3), (LENGTH * math.sin(START), 0.0, -LENGTH * math.cos(START)))
pin = nm.Joint("pin", nm.JointKind.REVOLUTE, nm.GROUND, "bob", point=(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
system = nm.System([bob], [pin], gravity=(0.0, 0.0, -G))

# closed form: T = 4 sqrt(L/g) K(sin(start/2)); the pin carries m g cos(angle) + m v^2/L along the rod
period = 4.0 * math.sqrt(LENGTH / G) * ellipk(math.sin(START / 2) ** 2)
angles, forces, steps = [], [], 200
for _ in range(steps + 1):
    x, _, z = system.position("bob")
    angles.append(math.atan2(x, -z))
    forces.append(np.linalg.norm(system.reaction("pin").force))
    system.march(period / steps, dt=period / 20000)
angles, forces = np.array(angles), np.array(forces)
exact = MASS * G * (3.0 * np.cos(angles) - 2.0 * math.cos(START))

print(
    f"after a period of {period:.4f} s: {math.degrees(angles[-1]):.4f} deg of {math.degrees(START):.0f} deg"
)
print(f"largest force on the pin {forces.max():.3f} N, closed form {exact.max():.3f} N")
assert abs(angles[-1] - START) < 1e-6 and np.abs(forces - exact).max() < 1e-5 * exact.max()

plt.plot(np.degrees(angles), forces)
plt.gca().set(xlabel="angle (deg)", ylabel="force on the pin (N)")
plt.savefig("pendulum.png")
