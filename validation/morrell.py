"""Net power of a dry ball mill by Morrell's C-model, for the worked example of Erdem and others (2004).

    python -m validation.morrell

S. Morrell, Trans. Inst. Min. Metall. C 105, C43-C62, 1996 (power draw of wet tumbling mills).  A. S. Erdem,
S. L. Ergun, A. H. Benzer, Physicochem. Probl. Miner. Process. 38, 221-230, 2004.
"""

import math
from typing import NamedTuple

DIAMETER, LENGTH, SHARE, FILLING, DENSITY = 3.27, 3.60, 0.7267, 0.2748, 3.96
"""D [m], L [m], speed over the critical one [1], share of the volume [1], bulk density [t/m^3]."""
NET, NO_LOAD, TOE = 341.97, 41.94, 235.6
"""Printed net power [kW], no-load power [kW], toe [deg]."""
CALIBRATION = 1.26
"""Factor with which Morrell's model meets measured gross power [1]."""
GRAVITY = 9.81


class Draw(NamedTuple):
    """What the model gives."""

    toe: float
    """Angle of the toe [deg]."""
    shoulder: float
    """Angle of the shoulder [deg]."""
    inner: float
    """Inner radius of the active charge over that of the mill [1]."""
    power: float
    """Power that the charge takes [kW]."""


def draw(share: float = SHARE) -> Draw:
    """Compute the power of the chamber."""
    radius, critical = DIAMETER / 2.0, 42.305 / math.sqrt(DIAMETER) / 60.0
    rate = share * critical
    limit = share if share > (least := 0.35 * (3.364 - FILLING)) else least
    toe = 2.5307 * (1.2796 - FILLING) * (1.0 - math.exp(-19.42 * (limit - share))) + math.pi / 2.0
    lean = 0.3386 + 0.1041 * share + (1.54 - 2.5673 * share) * FILLING
    shoulder = math.pi / 2.0 - (toe - math.pi / 2.0) * lean
    open_angle = 2.0 * math.pi + shoulder - toe
    middle = 0.5 * radius * (1.0 + math.sqrt(1.0 - 2.0 * math.pi * FILLING / open_angle))
    on = open_angle / (2.0 * math.pi * 0.5 * rate)
    off = math.sqrt(2.0 * middle * (math.sin(shoulder) - math.sin(toe)) / GRAVITY)
    active = on / (on + off)
    inner = radius * math.sqrt(1.0 - 2.0 * math.pi * active * FILLING / open_angle)
    z = (1.0 - FILLING) ** 0.4532
    across = radius - z * inner
    lifted = (
        math.pi * GRAVITY * LENGTH * rate * radius / (3.0 * across)
        * (2.0 * radius**3 - 3.0 * z * radius**2 * inner + inner**3 * (3.0 * z - 2.0))
        * DENSITY * (math.sin(shoulder) - math.sin(toe))
    )  # fmt: skip
    spun = (rate * radius * math.pi / across) ** 3
    thrown = LENGTH * DENSITY * spun * (across**4 - inner**4 * (z - 1.0) ** 4)
    return Draw(math.degrees(toe), math.degrees(shoulder), inner / radius, lifted + thrown)


def lines() -> list[str]:
    """Return what is recomputed beside what is printed."""
    own = draw()
    no_load = 1.68 * DIAMETER**2.05 * (SHARE * LENGTH) ** 0.82
    return [
        f"no-load power {no_load:.2f} kW, printed {NO_LOAD:.2f} kW",
        f"toe {own.toe:.1f} deg, printed {TOE:.1f} deg; shoulder {own.shoulder:.1f} deg",
        f"inner radius of the active charge {own.inner:.3f} of that of the mill",
        f"power of the charge {own.power:.1f} kW, times {CALIBRATION} {CALIBRATION * own.power:.1f} kW, "
        f"printed net power {NET:.2f} kW",
        f"printed over recomputed: {NET / own.power:.3f} without the factor, "
        f"{NET / own.power / CALIBRATION:.3f} with it",
    ]


if __name__ == "__main__":
    print("\n".join(lines()))
