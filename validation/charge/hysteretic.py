"""Hysteretic linear spring: O. R. Walton and R. L. Braun, Journal of Rheology 30 (1986) 949-980; the default
of Ansys Rocky.
"""

import math

from nutamill.charge.laws.hysteretic import LEAST_FORCE
from validation.charge.harness import SAMPLES, pair, sphere_mass, strike_floor
from validation.charge.rows import Row

SOURCE = "closed form (Walton and Braun 1986)"


def walton_braun() -> list[Row]:
    """Restitution, force, time and remaining dent do not depend on speed but as the closed form says."""
    rows = []
    radius, density, k, e = 0.0025, 2700.0, 1e5, 0.6
    mass = sphere_mass(radius, density)
    for v in (0.1, 3.0):
        overlap = v * math.sqrt(mass / k)
        time = 0.5 * math.pi * math.sqrt(mass / k) * (1 + e)
        got = strike_floor(
            radius, density, pair(k, unloading=1 / e**2), time, v, law=("hysteretic", "displacement", "none")
        )
        second = (math.pi / SAMPLES / e) ** 2
        # a thousandth of the loading force stays on the dent, (1 - e^2) of the largest overlap, and gives its
        # energy back
        least = LEAST_FORCE * (1 - e**2) ** 2 / (2 * e)
        why_least = (
            "second order in the substep, and the least force, a thousandth of that of loading, over the dent"
        )
        why = "second order in the substep on unloading"
        pressed = time / SAMPLES * (got.curve[:, 0] > 2e-3 * got.force).sum()
        dent = max(d for f, d in got.curve[len(got.curve) // 2 :] if f <= 2e-3 * got.force)
        rows += [
            Row(f"{v} m/s: restitution [1]", e, SOURCE, got.v[0, 2] / v, second + least, why_least),
            Row(f"{v} m/s: largest force [N]", k * overlap, SOURCE, got.force, second * k * overlap, why),
            Row(
                f"{v} m/s: contact time [s]",
                time,
                SOURCE,
                pressed,
                2 * time / SAMPLES,
                "counted in substeps, one at each end",
            ),
            Row(
                f"{v} m/s: overlap left [m]",
                overlap * (1 - e**2),
                SOURCE,
                dent,
                2 * e * v * time / SAMPLES,
                "sampled in substeps; the force is cut at a thousandth of that of loading",
            ),
        ]
    return rows


CASES = {"Walton-Braun": walton_braun}
