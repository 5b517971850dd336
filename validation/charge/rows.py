"""One row of the table: a number, what it should be and who says so."""

import math
from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """A comparison.

    Attributes
    ----------
    quantity : what is compared, with its unit
    reference : the value it should have
    source : who says so
    ours : the value of this engine
    tolerance : largest difference that passes, in the unit of the quantity
    why : where the tolerance comes from, and what is known of a difference
    """

    quantity: str
    reference: float
    source: str
    ours: float
    tolerance: float
    why: str

    @property
    def passes(self) -> bool:
        """Whether the difference is within the tolerance; never where a number is missing."""
        return math.isfinite(self.ours) and abs(self.ours - self.reference) <= self.tolerance


def largest(
    quantity: str, pairs: Iterable[tuple[float, float]], source: str, tolerance: float, why: str
) -> Row:
    """A row for a whole curve: the largest difference of (reference, ours) over its points, which should be
    zero.
    """
    differences = [ours - reference for reference, ours in pairs]
    worst = max(differences, key=abs)
    return Row(
        f"{quantity}: largest difference of {len(differences)} points", 0.0, source, worst, tolerance, why
    )


HEAD = f"{'quantity':<88} {'reference':>13} {'ours':>13} {'difference':>11} {'tolerance':>10}  pass"


def lines(case: str, rows: Iterable[Row]) -> list[str]:
    """The rows of one case as text; the sources and reasons stand below it, each once."""
    rows = list(rows)
    out = [case, "-" * len(case), HEAD]
    notes: dict[str, int] = {}
    for row in rows:
        note = notes.setdefault(f"{row.source}. Tolerance: {row.why}", len(notes) + 1)
        out.append(
            f"{row.quantity + f' [{note}]':<88} {row.reference:>13.7g} {row.ours:>13.7g} "
            f"{row.ours - row.reference:>11.2e}"
            f" {row.tolerance:>10.1e}  {'yes' if row.passes else 'NO'}"
        )
    return out + [f"[{number}] {note}." for note, number in notes.items()] + [""]
