"""A force law of your own in a script: a spring that hardens with the cube of its length.

A law of contacts is a file in a clone of the package: docs/guides/contact-law.md writes one. A force on a
body can follow any Python function, which is called before each step.
Checked: the period against the closed form of the cubic spring, T = 4 K(1/2) / sqrt(c a^2 / m), with the
parameter m = 1/2 of the elliptic integral K.
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from scipy.special import ellipk

import nutamill as nm

MASS, CUBIC, START, STEP = 1.0, 4e6, 0.05, 1e-4  # kg, N/m^3, m, s


def force(x):
    """Return the force of the spring [N] at a displacement [m]."""
    return -CUBIC * x**3


bob = nm.Body("bob", MASS, 1e-3 * np.eye(3), (START, 0.0, 0.0))
guide = nm.Joint(
    "guide", nm.JointKind.PRISMATIC, nm.GROUND, "bob", point=(0.0, 0.0, 0.0), axis=(1.0, 0.0, 0.0)
)
system = nm.System([bob], [guide], gravity=(0.0, 0.0, 0.0))

times, places = [0.0], [START]
while times[-1] < 0.2:
    # the force at the middle of the step, from the velocity: second order, as the step of the mechanism
    middle = system.position("bob")[0] + 0.5 * STEP * system.velocity("bob")[0]
    system.apply("bob", (force(middle), 0.0, 0.0))
    system.step(STEP)
    times.append(system.time)
    places.append(system.position("bob")[0])

places = np.array(places)
up = np.flatnonzero((places[:-1] < 0.0) & (places[1:] >= 0.0))
crossings = [np.interp(0.0, places[k : k + 2], times[k : k + 2]) for k in up]
period = float(np.mean(np.diff(crossings)))
exact = 4.0 * ellipk(0.5) / math.sqrt(CUBIC * START**2 / MASS)
print(f"period {period:.5f} s, closed form {exact:.5f} s")
# a step of second order errs by (step x frequency)^2 / 24 at a frequency of sqrt(3 c a^2 / m) at most: 1.3e-5
assert abs(period / exact - 1.0) < 1e-4
plt.plot(times, 1e3 * places)
plt.gca().set(xlabel="time (s)", ylabel="displacement (mm)")
plt.savefig("custom_law.png")
