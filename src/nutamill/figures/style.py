"""What all figures share: the style file, and the width and the colours of what is drawn."""

from pathlib import Path

STYLE = Path(__file__).with_name("nutamill.mplstyle")
BINS = 500
"""Columns of a drawn series: about two per printed dot of one journal column."""
WIDTH = 3.386
"""One journal column [inch]."""
PALETTE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#000000")
"""Colours of curves that belong together, told apart by colour-blind eyes.

Source: Okabe and Ito, Color Universal Design, 2008.
"""
ENVELOPE, MEAN, RMS, MARK = "#A6CEE8", "#0072B2", "#D55E00", "#444444"
