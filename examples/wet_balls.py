"""Steel balls dropped on a floor wet with oil, dry ones beside them: how much a film takes of a rebound.

Checked: each wet ball rebounds as the closed form says, a line over the inverse Stokes number, and the
slowest stays in the oil.
"""

import dataclasses
import math

import matplotlib.pyplot as plt
import numpy as np

import nutamill as nm

DIAMETER, DENSITY, RESTITUTION = 0.005, 7850.0, 0.9
mass, radius = DENSITY * math.pi / 6 * DIAMETER**3, DIAMETER / 2
dry = nm.linear_pair(stiffness=1e5, restitution=RESTITUTION)
wet = dataclasses.replace(dry, liquid_viscosity=0.2, film_thickness=1e-4, film_roughness=1e-6)

speeds = np.array([0.3, 0.5, 0.7, 1.0, 1.5, 3.0])
places = np.stack([0.02 * np.arange(len(speeds)), 0 * speeds, np.full(len(speeds), radius + 1.2e-4)], axis=1)
falls = np.stack([0 * speeds, 0 * speeds, -speeds], axis=1)


def rebound(pair, film):
    """Speed of parting over speed of approach [1] of each ball."""
    charge = nm.Charge(
        nm.spheres([DIAMETER] * len(speeds)).placed(places), [DENSITY], pair, [nm.plane("floor")],
        dt=2e-6, law=nm.contact_law(film=film), velocities=falls, gravity=(0.0, 0.0, 0.0),
    )  # fmt: skip
    charge.march(3e-3)
    return charge.velocities[:, 2] / speeds


plain, soaked = rebound(dry, "none"), rebound(wet, "viscous")
stokes = mass * speeds / (6 * math.pi * wet.liquid_viscosity * radius**2)
closed = np.maximum(RESTITUTION - (1 + RESTITUTION) * math.log(100.0) / stokes, 0.0)
for v, st, e, wanted in zip(speeds, stokes, soaked, closed, strict=True):
    print(f"{v:.1f} m/s, St {st:5.1f}: restitution {e:.3f}, closed form {wanted:.3f}")
print(f"dry: {plain.mean():.3f}")
assert np.abs(soaked - closed).max() < 0.01
assert soaked[0] < 1e-3 < soaked[1]
plt.plot(1 / stokes, soaked, "o", label="charge")
plt.plot(1 / stokes, closed, label="closed form")
plt.gca().set(xlabel="1/St (1)", ylabel="restitution (1)")
plt.legend()
plt.savefig("wet_balls.png")
