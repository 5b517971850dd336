"""What all figures share: the style file, and the colours of what is drawn over time."""

from pathlib import Path

STYLE = Path(__file__).with_name("nutamill.mplstyle")
BINS = 500
"""Columns of a drawn series: about two per printed dot of one journal column."""
ENVELOPE, MEAN, RMS, MARK = "#A6CEE8", "#0072B2", "#D55E00", "#444444"
