"""Wet impacts of the engine beside the closed form of their film, and the cost of a wet charge.

    python -m validation.wet                 all rows, and write the table
    python -m validation.wet cost            wet and dry by turns, printed only

Balls fall on a wet floor, or on each other, at eight speeds each.  Their restitutions are fitted by a line
over the inverse Stokes number: its end at 1/St = 0 is the dry restitution, its slope is
-(1 + e_dry) ln(thickness/roughness).
"""

import dataclasses
import math
import os
import sys
import time
from pathlib import Path

import numpy as np

import nutamill as nm
from nutamill import __version__
from nutamill.base.provenance import processor
from nutamill.charge.laws.composition import contact_law
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.viscous_film import stokes_number
from validation.charge.rows import Row, lines

TABLE = Path(__file__).parent / "results" / "wet.txt"
DIAMETER, DENSITY, STIFFNESS, DRY, ROUGHNESS = 5e-3, 7850.0, 1e5, 0.9, 1e-6
RADIUS, MASS = DIAMETER / 2, DENSITY * math.pi / 6 * DIAMETER**3
VISCOSITY = 0.1
THICKNESSES = (20e-6, 50e-6, 100e-6)
SPEEDS = np.array([1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0])
DT = math.pi * math.sqrt(MASS / 2 / STIFFNESS) / 100
"""A hundredth of the contact of a pair [s]."""
PER_CONTACT = (math.pi / 100) ** 2 / 4
"""Error of a restitution: the spring is met at any phase of a substep [1]."""
CLOSED = "closed form of the law: Barnocky and Davis 1988 for the way in, the same for the way out"


def film(thickness: float) -> PairLaw:
    """Return the contact of wet steel."""
    dry = nm.linear_pair(STIFFNESS, DRY)
    return dataclasses.replace(
        dry, liquid_viscosity=VISCOSITY, film_thickness=thickness, film_roughness=ROUGHNESS
    )


def rebounds(thickness: float, pairs: bool) -> tuple[np.ndarray, np.ndarray, float]:
    """Return Stokes numbers and restitutions [1], and what the ledger leaves open of the energy [1]."""
    n, gap, law = len(SPEEDS), 1.1 * thickness, film(thickness)
    x = 0.02 * np.arange(n)
    down = np.stack([0 * x, 0 * x, -SPEEDS], 1)
    upper = np.stack([x, 0 * x, np.full(n, gap + (DIAMETER if pairs else RADIUS))], 1)
    places = np.concatenate([np.stack([x, 0 * x, 0 * x], 1), upper]) if pairs else upper
    speeds = np.concatenate([0 * down, down]) if pairs else down
    charge = nm.Charge(
        nm.spheres([DIAMETER] * len(places)).placed(places), [DENSITY], law,
        [] if pairs else [nm.plane("floor")], dt=DT, law=contact_law(film="viscous"), velocities=speeds,
        gravity=(0.0, 0.0, 0.0),
    )  # fmt: skip
    before = charge.reading().energy[:2].sum()
    charge.march(8e-4)
    v = charge.velocities[:, 2]
    left = charge.state.ledger.sum() - (charge.reading().energy[:2].sum() - before)
    reduced = (MASS / 2, RADIUS / 2) if pairs else (MASS, RADIUS)
    stokes = np.array([stokes_number(law, *reduced, speed) for speed in SPEEDS])
    return stokes, (v[n:] - v[:n] if pairs else v) / SPEEDS, left / before


def restitution() -> list[Row]:
    """Restitution against 1/St is a line, for walls and for pairs."""
    rows, slopes = [], []
    for pairs in (False, True):
        for thickness in THICKNESSES:
            stokes, e, left = rebounds(thickness, pairs)
            slope, end = np.polyfit(1 / stokes, e, 1)
            wanted = -(1 + DRY) * math.log(thickness / ROUGHNESS)
            what = f"{'two balls' if pairs else 'ball and floor'}, film {1e6 * thickness:.0f} um"
            spread = float(np.ptp(1 / stokes))
            why = f"{PER_CONTACT:.1e} of each restitution, from the phase of the first substep"
            rows += [
                Row(f"{what}: e at 1/St = 0 [1]", DRY, CLOSED, float(end), 4 * PER_CONTACT, why),
                Row(
                    f"{what}: slope of e over 1/St [1]", wanted, CLOSED, float(slope),
                    4 * PER_CONTACT / spread, why,
                ),
                Row(
                    f"{what}: farthest from its line [1]", 0.0, CLOSED,
                    float(np.abs(e - end - slope / stokes).max()), 4 * PER_CONTACT, why,
                ),
                Row(f"{what}: ledger open [1]", 0.0, "conservation of energy", left, 1e-5, "float32"),
            ]  # fmt: skip
            slopes.append((pairs, math.log(thickness), slope))
    for pairs in (False, True):
        logs, values = np.array([[log, slope] for who, log, slope in slopes if who == pairs]).T
        rows.append(
            Row(
                f"{'two balls' if pairs else 'ball and floor'}: slope over ln(film thickness) [1]",
                -(1 + DRY), CLOSED, float(np.polyfit(logs, values, 1)[0]), 0.1, "that of the slopes",
            )
        )  # fmt: skip
    return rows


def shaken(law: str, thickness: float = 50e-6) -> nm.Charge:
    """Return a loose crowd of 2000 balls in a box, thrown together."""
    n = 2000
    rng = np.random.default_rng(1)
    grid = np.array([[a, b, c] for c in range(20) for a in range(10) for b in range(10)], float)
    x = 1.06 * DIAMETER * (grid + 0.6 + rng.uniform(-0.02, 0.02, (n, 3)))
    wide = 10.7 * 1.06 * DIAMETER
    walls = [
        nm.plane("floor"),
        nm.plane("left", [0, 0, 0], [1, 0, 0]),
        nm.plane("back", [0, 0, 0], [0, 1, 0]),
    ]
    walls += [nm.plane("right", [wide, 0, 0], [-1, 0, 0]), nm.plane("front", [0, wide, 0], [0, -1, 0])]
    dry = nm.linear_pair(STIFFNESS, 0.5, 0.5, 0.01)
    pair = dataclasses.replace(dry, liquid_viscosity=1e-3, film_thickness=thickness, film_roughness=ROUGHNESS)
    return nm.Charge(
        nm.spheres([DIAMETER] * n).placed(x), [DENSITY], dry if law == "none" else pair, walls, dt=2e-6,
        law=contact_law(film=law), velocities=rng.normal(size=(n, 3)), gravity=(0.0, 0.0, -300.0),
    )  # fmt: skip


def cost() -> list[str]:
    """Time wet and dry by turns, in the same flow: a bed that settles at 30 g, in water 50 micrometres
    thick.
    """
    dry, wet = shaken("none").step(8000), shaken("viscous").step(8000)
    spent = {"dry": [], "wet": []}
    for _ in range(15):
        for name, charge in (("dry", dry), ("wet", wet)):
            begun = time.process_time()
            charge.step(100)
            spent[name].append(time.process_time() - begun)
    per = {name: 1e9 * np.array(times) / (100 * 2000) for name, times in spent.items()}
    ratio = np.median(per["wet"]) / np.median(per["dry"])
    return [
        "cost",
        "----",
        f"contacts of 2000 balls: dry {dry.contacts}, wet {wet.contacts} (pairs, walls)",
        *(
            f"{name}: {np.median(times):.1f} ns a ball and substep, least {times.min():.1f}"
            for name, times in per.items()
        ),
        f"wet over dry: {ratio:.2f} (medians of 15 turns), {per['wet'].min() / per['dry'].min():.2f} (least)",
        "",
    ]


def main(names: list[str]) -> int:
    """Run the comparisons; 1 if a row fails."""
    text = [
        f"nutamill {__version__}, wet impacts, {time.strftime('%Y-%m-%d', time.gmtime())}",
        f"{processor()}, {os.cpu_count()} cores",
        "",
    ]
    rows = [] if names else restitution()
    text += lines("restitution of a film", rows) if rows else []
    text += cost()
    if rows:
        text.append(
            "Measured lines over 1/St (Gollwitzer et al. 2012; Mueller and Huang 2016): not compared, their "
            "tables could not be read."
        )
        text.append(f"{sum(row.passes for row in rows)} of {len(rows)} rows pass")
    print("\n".join(text))
    if not names:
        TABLE.write_text("\n".join(text) + "\n", encoding="utf-8")
    return 0 if all(row.passes for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
