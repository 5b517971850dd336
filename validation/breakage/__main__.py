"""Breakage of particles and the population balance beside closed forms and published numbers.

    python -m validation.breakage

The table goes to `validation/results/breakage.txt`.
"""

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import quad

from nutamill.analysis.breakage import laws
from nutamill.analysis.breakage.balance import Balance, grind, middles, passing_of, shares_of

TABLE = Path(__file__).parents[1] / "results" / "breakage.txt"
SMC = {
    "A": (87.9, 0.31, {14.5: (0.51, 1.11, 1.83), 28.9: (0.39, 0.82, 1.31), 57.8: (0.29, 0.61, 0.95)}),
    "B": (84.3, 0.31, {14.5: (0.55, 1.19, 1.96), 28.9: (0.41, 0.88, 1.40), 57.8: (0.31, 0.65, 1.02)}),
}
"""A [%], b [t/kWh], and energies [kWh/t] for t10 = 10, 20, 30 % by size [mm]: SMC Testing, About the SMC
Test, table 1.
"""
SIZE_EXPONENT = 0.44
"""Growth of b with size of the ore smc-sample-a [1]."""
UNREAD = (
    ("single particles in Rocky", "Andre, Potapov, Maliska, Tavares, IMCET 2019"),
    ("batch mill of 30 cm", "Rodriguez, Carvalho, Tavares, Miner. Eng. 127 (2018)"),
    ("ore with fracture energies", "Tavares, King, Int. J. Miner. Process. 54 (1998)"),
    ("table of t_n over t10", "Napier-Munn et al., Mineral Comminution Circuits (1996)"),
)
"""Published cases whose numbers could not be read."""


class Row(NamedTuple):
    """One comparison."""

    what: str
    source: str
    error: float
    limit: float


def uniform(edges: np.ndarray, power: float) -> Balance:
    """Return the balance of particles that break at size^power into uniform fragments."""
    size, n = middles(edges), len(edges) - 1
    births = np.zeros((n, 1, n + 1))
    for j in range(n):
        births[j, 0] = size[j] ** power * shares_of(np.minimum((edges / size[j]) ** 2, 1.0))
    return Balance(-births.sum(axis=2)[:, :, None], births, np.ones(1))


def fragmentation() -> list[Row]:
    """Return the two solutions of Ziff and McGrady and the balance of mass."""
    rows, source = [], "Ziff, McGrady, J. Phys. A 18 (1985) 3027"
    edges = 2.0 ** (-0.25 * np.arange(41.0))
    feed = np.append(1.0, np.zeros(len(edges) - 1))
    times = np.geomspace(1e-2, 1e4, 13)
    masses = grind(uniform(edges, 2), feed, times)
    exact = 1.0 - np.exp(-times[:, None] * edges[1:] ** 2)
    rows.append(
        Row("rate x^2, uniform: share finer", source, np.abs(passing_of(masses)[:, 1:] - exact).max(), 1e-11)
    )
    rows.append(Row("the same: mass", "1", np.abs(masses.sum(axis=1) - 1.0).max(), 1e-12))
    for parts, limit in ((4, 0.06), (8, 0.03), (16, 0.015)):
        edges = 2.0 ** (-np.arange(13.0 * parts + 1.0) / parts)
        feed = np.append(1.0, np.zeros(len(edges) - 1))
        finer = passing_of(grind(uniform(edges, 1), feed, np.array([5.0])))[0, 1:]
        exact = np.array(
            [
                quad(lambda x: x * math.exp(-5 * x) * (10.0 + 25.0 * (1.0 - x)), 0.0, edge)[0]
                for edge in edges[1:]
            ]
        )
        rows.append(
            Row(f"rate x, uniform, classes of 2^(1/{parts})", source, np.abs(finer - exact).max(), limit)
        )
    return rows


def single_particles() -> list[Row]:
    """Return damage against the work of the contact, and the drop-weight tables."""
    rows = []
    for g in (1.0, 5.0, 20.0):

        def work(x: float, g: float = g) -> float:
            return quad(lambda u: (1.0 - u**g) * u**1.5, 0.0, x, epsabs=0.0, epsrel=1e-12)[0]

        lost = np.linspace(0.05, 0.95, 10)
        error = max(abs(float(laws.damage(work(D ** (1.0 / g)) / work(1.0), g)) - D) for D in lost)
        rows.append(Row(f"damage, exponent {g:g}", "work of the fading contact by quadrature", error, 1e-9))
    for name, (most, b, table) in SMC.items():
        for size, printed in table.items():
            weakness = b * (size / 28.9) ** SIZE_EXPONENT
            energies = [-math.log1p(-t10 / (most / 100.0)) / weakness for t10 in (0.1, 0.2, 0.3)]
            error = max(abs(e / p - 1.0) for e, p in zip(energies, printed, strict=True))
            rows.append(
                Row(f"energies of t10, sample {name}, {size} mm", "SMC Testing, table 1", error, 0.05)
            )
    return rows


def main() -> None:
    """Print the table and write it."""
    rows = [*fragmentation(), *single_particles()]
    lines = [f"{'compared':38} {'with':42} {'error':>8} {'limit':>8}  ok"]
    for row in rows:
        lines.append(
            f"{row.what:38} {row.source:42} {row.error:8.1e} {row.limit:8.0e}  "
            f"{'yes' if row.error <= row.limit else 'NO'}"
        )
    lines += [f"{what:38} {source}: no text with its numbers could be read" for what, source in UNREAD]
    lines += ["", "error: largest of shares and damage, relative of energies; b has two digits, 1.6 %."]
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
