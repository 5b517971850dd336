"""A steel ball strikes a bed of grains: M. Dosta and 28 others, "Comparing open-source DEM frameworks for
simulations of common bulk processes", Computer Physics Communications 296 (2024) 109066; 25 000 grains of
material M1.  Hertz and Mindlin, no rolling resistance.
"""

import numpy as np

from nutamill.charge.laws.oscillator import damping_ratio_from_restitution
from validation.charge.bulk import THREADS, plane
from validation.charge.closed_forms import modulus, shear_modulus
from validation.charge.data import dosta_packing
from validation.charge.harness import DOWN, Bench, G, pair
from validation.charge.rows import Row

GRAIN, BALL = 0.001, 0.010
M1, STEEL = (1e9, 0.2), (210e9, 0.2)
DT = 1.5e-6
LET_IN = 0.015
OTHERS = "LAMMPS 2025, LIGGGHTS 3.8 and YADE 2023, one run each on the authors' input with this substep"


def contact(a, b, e, mu):
    """Numbers of the contact of two solids."""
    return pair(
        modulus=modulus(a, b),
        shear_modulus=shear_modulus(a, b),
        zeta=damping_ratio_from_restitution(e, False),
        friction=mu,
    )


def penetration() -> list[Row]:
    """Height and speed of the ball, and where it turns.

    The ball is let in at 15 ms, where its free fall has brought it to; it touches the bed at 21 ms.
    """
    grains = dosta_packing()
    places = np.vstack([grains, [0.0, 0.0, 0.06 - 5.0 * LET_IN - 0.5 * G * LET_IN**2]])
    materials = np.append(np.zeros(len(grains), int), 1)
    speeds = np.zeros_like(places)
    speeds[-1] = [0.0, 0.0, -5.0 - G * LET_IN]
    numbers = {
        (0, 0): contact(M1, M1, 0.5, 0.3),
        (0, 1): contact(M1, STEEL, 0.4, 0.2),
        (1, 1): contact(STEEL, STEEL, 0.6, 0.5),
    }
    axes = np.eye(3)
    walls = [plane("bottom", axes[2], -0.0902431, material=1)]
    for axis, half in ((0, 0.049), (1, 0.03)):
        walls += [plane(f"{axis}{sign}", sign * axes[axis], -half, material=1) for sign in (1.0, -1.0)]
    bench = Bench(
        places,
        numbers,
        DT,
        walls,
        np.append(np.full(len(grains), GRAIN), BALL),
        (2500.0, 7200.0),
        ("hertz", "displacement", "none"),
        DOWN,
        materials=materials,
        velocities=speeds,
        threads=THREADS,
        precision="single",
        skin=5e-4,
    )
    ball = len(grains)
    times, heights, falls = [], [], []
    while LET_IN + bench.time < 0.036:
        bench.step(20)
        slot = int(np.flatnonzero(bench.state.ids == ball)[0])
        state = bench.state
        times.append(LET_IN + bench.time)
        heights.append(state.x[2, slot] - 0.5 * DT * state.v[2, slot])
        falls.append(state.v[2, slot])
    at = lambda values, t: float(np.interp(t, times, values))  # noqa: E731
    lowest = int(np.argmin(heights))
    spread = "1.6 to 2.5 times the spread of the three codes"
    return [
        Row(
            "height after 20 ms, in free fall [m]",
            -0.041962,
            "free fall",
            at(heights, 0.020),
            2e-6,
            "printed figures",
        ),
        Row("height after 24 ms [m]", -0.0603, OTHERS, at(heights, 0.024), 2e-4, spread),
        Row("height after 28 ms [m]", -0.0735, OTHERS, at(heights, 0.028), 6e-4, spread),
        Row("velocity after 24 ms [m/s]", -3.83, OTHERS, at(falls, 0.024), 0.06, spread),
        Row("velocity after 28 ms [m/s]", -2.77, OTHERS, at(falls, 0.028), 0.12, spread),
        Row("lowest height [m]", -0.07876, OTHERS, heights[lowest], 2e-4, spread),
        Row("time of the lowest height [s]", 0.03035, OTHERS, times[lowest], 4e-4, spread),
        Row(
            "speed of the rebound [m/s]",
            1.9,
            OTHERS,
            float(np.max(falls[lowest:])),
            0.2,
            "their spread, 1.7 to 2.1",
        ),
    ]


CASES = {"Dosta penetration": penetration}
