"""Names of the figures that `nutamill plot` draws, for completion: they load no library of pictures."""

OF_A_RUN = ("run", "power", "impacts", "wall", "flow", "orbit")
"""Figures of a whole result."""
OF_SERIES = ("history", "spectrum", "orders")
"""Figures of series, written ``history:driveshaft_torque``."""
