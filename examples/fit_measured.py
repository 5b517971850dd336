"""The stiffness of the mounts from a ring-down that was recorded as a table: frequency, then fit.

The record is made here, 7.85 Hz with noise, so that the example needs no other file; yours begins at `READ`.
Checked: the mill with the fitted stiffness has the measured frequency.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import curve_fit

import nutamill as nm

FIT = """case = "numill"
[set]
"charge.kind" = "none"
[free]
"mounts.shear_stiffness" = {{ start = "70 N/mm", low = "50 N/mm", high = "90 N/mm" }}
[[target]]
quantity    = "natural_frequency 1"
value       = "{value:.4f} Hz"
uncertainty = "{doubt:.4f} Hz"
"""


def ring_down(time, size, decay, frequency, phase):
    return size * np.exp(-decay * time) * np.cos(2 * np.pi * frequency * time + phase)


time = np.arange(0.0, 2.0, 2e-3)
noise = np.random.default_rng(1).normal(0.0, 0.02, len(time))
record = np.column_stack([time, ring_down(time, 1.0, 1.8, 7.85, 0.3) + noise])
np.savetxt("ring-down.csv", record, delimiter=",", header="time [s],displacement [mm]", comments="")

time, displacement = np.loadtxt("ring-down.csv", delimiter=",", skiprows=1).T  # READ
best, covariance = curve_fit(ring_down, time, displacement, [1.0, 1.0, 7.9, 0.0])
frequency, doubt = best[2], float(np.sqrt(covariance[2, 2]))
print(f"measured {frequency:.3f} ± {doubt:.3f} Hz")
Path("mounts-fit.toml").write_text(FIT.format(value=frequency, doubt=doubt), encoding="utf-8")
fitted = nm.fit("mounts-fit.toml", folder="results/fit")
print("\n".join(fitted.lines()))

case = nm.load_case("numill", ["charge.kind=none"]).with_(
    "mounts.shear_stiffness", float(fitted.best.values[0])
)
assert abs(nm.machine_modes(case).frequency[0] - frequency) < 3.0 * doubt
plt.plot(time, displacement, ".", time, ring_down(time, *best))
plt.gca().set(xlabel="time (s)", ylabel="displacement (mm)")
plt.savefig("fit_measured.png")
