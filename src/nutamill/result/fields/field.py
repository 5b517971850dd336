"""What a recorded quantity is, and the helpers that declare several at once."""

from dataclasses import dataclass

WORLD = "world"
O_FIXED = "nutation point as assembled"


@dataclass(frozen=True, slots=True)
class Field:
    """One recorded quantity, a number over time (or an array in a snapshot)."""

    name: str
    """Name in the file; ``{mount}`` and ``{sensor}`` stand for a part of the machine."""
    symbol: str
    """Symbol in formulas and figures, in mathtext without the dollar signs."""
    unit: str
    """SI unit; ``1`` for a ratio or a count."""
    label: str
    """A few words, for an axis or a table."""
    meaning: str
    """Meaning of the number, in one sentence."""
    frame: str = ""
    """Axes in which a component is written; empty for a scalar."""
    point: str = ""
    """Point at which, or about which, it is taken; empty where there is none."""
    shape: str = ""
    """Shape of one snapshot's array; empty for a series, which has one number per sample."""

    def attributes(self) -> dict[str, str]:
        """Return what is stored beside the numbers: the names xarray and netCDF readers know first."""
        stored = {"units": self.unit, "long_name": self.label, "symbol": self.symbol, "meaning": self.meaning}
        return stored | {key: text for key, text in (("frame", self.frame), ("point", self.point)) if text}


def vector(
    name: str, symbol: str, unit: str, label: str, meaning: str, frame: str, point: str
) -> tuple[Field, ...]:
    """Declare the three components of a vector, named ``_x``, ``_y``, ``_z``. `symbol` is one
    letter and the start of its index.
    """
    return tuple(
        Field(
            f"{name}_{axis}",
            f"{symbol[0]}_{{{symbol[2:]}{axis}}}",
            unit,
            f"{label}, {axis}",
            f"{meaning}, component along {axis}",
            frame,
            point,
        )
        for axis in "xyz"
    )


def energy(name: str, symbol: str, label: str, meaning: str) -> Field:
    """Declare one entry of the power ledger, in J."""
    return Field(name, symbol, "J", label, meaning)
