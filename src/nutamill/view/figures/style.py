"""What all figures share: the style file, and the width the colours of what is drawn, and labels of axes."""

from pathlib import Path

from nutamill.result.fields import Field

STYLE = Path(__file__).with_name("nutamill.mplstyle")
BINS = 500
"""Columns of a drawn series: about two per printed dot of one journal column."""
WIDTH = 3.386
"""One journal column [inch]."""
PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000")
"""Colours of curves that belong together, distinct for colour-blind readers.

Source: Okabe and Ito, Color Universal Design, 2008.
"""
ENVELOPE, MEAN, RMS, MARK = "#A6CEE8", "#0072B2", "#D55E00", "#444444"


def unit_of(field: Field) -> str:
    """Return the unit of a series as figures write it: ``m/s$^2$``."""
    return field.unit.replace("^2", "$^2$")


def label_of(field: Field) -> str:
    """Return label and unit of a series, for an axis: ``crank-pin force (N)``."""
    return f"{field.label} ({unit_of(field)})"
