"""What the loops over contacts do more where the charge is wet: gaps instead of overlaps, the numbers of film
and bridge, their power.

Each function is chosen by the film of the charge when the loops are compiled; of a dry charge nothing is left
of them.
"""

from nutamill.base.kernel import by_type, kernel, like
from nutamill.charge.kernels.rows import BRIDGE, FILM_POWER, LIQUID, WEIGHT
from nutamill.charge.laws.capillary import CapillaryBridge
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.laws.no_film import NoFilm
from nutamill.charge.laws.pair import BRIDGE_NUMBERS, FILM_NUMBERS, LAW_NUMBERS
from nutamill.charge.laws.viscous_film import ViscousFilm


@kernel(inline="always")
def overlap_dry(film, overlap, reach):
    """Return the overlap [m] of two bodies as it was measured."""
    return overlap


@kernel(inline="always")
def overlap_wet(film, overlap, reach):
    """Return the overlap [m], negative where there is a gap, of two bodies whose measured radii together are
    larger by the `reach` of the film [m].
    """
    return overlap - reach


@kernel(inline="always")
def set_nothing(film, laws, law, b, columns_out):
    """Write nothing: a dry charge has no film."""


@kernel(inline="always")
def set_liquid(film, laws, law, b, columns_out):
    """Set the numbers of the film of pair law `law` in lane `b`."""
    for k in range(FILM_NUMBERS):
        columns_out[(LIQUID + k) * BATCH + b] = laws[law, LAW_NUMBERS + k]


@kernel(inline="always")
def set_bridge(film, laws, law, b, columns_out):
    """Set the numbers of film and bridge of pair law `law` in lane `b`."""
    set_liquid(film, laws, law, b, columns_out)
    for k in range(BRIDGE_NUMBERS):
        columns_out[(BRIDGE + k) * BATCH + b] = laws[law, LAW_NUMBERS + FILM_NUMBERS + k]


@kernel(inline="always")
def load_nothing(film, columns, b, zero):
    """Return zeros (3), which nobody reads."""
    return zero, zero, zero


@kernel(inline="always")
def load_liquid(film, columns, b, zero):
    """Return the numbers of the film of lane `b`, as `viscous_film.numbers` (3). `zero` is not used."""
    return columns[b + LIQUID * BATCH], columns[b + (LIQUID + 1) * BATCH], columns[b + (LIQUID + 2) * BATCH]


@kernel(inline="always")
def load_bridge(film, columns, b, zero):
    """Return the numbers of film and bridge of lane `b`, as `capillary.numbers` (7). `zero` is not used."""
    return (
        columns[b + LIQUID * BATCH], columns[b + (LIQUID + 1) * BATCH], columns[b + (LIQUID + 2) * BATCH],
        columns[b + BRIDGE * BATCH], columns[b + (BRIDGE + 1) * BATCH], columns[b + (BRIDGE + 2) * BATCH],
        columns[b + (BRIDGE + 3) * BATCH],
    )  # fmt: skip


@kernel(inline="always")
def store_nothing(film, power, b, columns_out):
    """Write nothing: a dry charge has no film."""


@kernel(inline="always")
def store_power(film, power, b, columns_out):
    """Write the power of the film of lane `b` [W]."""
    columns_out[b + FILM_POWER * BATCH] = power


@kernel(inline="always")
def no_power(film, columns):
    """Return 0 [W]."""
    return 0.0


@kernel(fast=True)
def power_of_lanes(columns):
    """Return the sum of the powers of the films of a batch on the relative motion [W]."""
    total = 0.0
    for b in range(BATCH):
        weight = columns[b + WEIGHT * BATCH]
        power = weight * columns[b + FILM_POWER * BATCH]
        total += float(power) if weight > like(0.0, weight) else 0.0
    return total


@kernel(inline="always")
def sum_power(film, columns):
    """Return what `power_of_lanes` does."""
    return power_of_lanes(columns)


@kernel(inline="always")
def radii_dry(film, radius, reach, lo, hi, wider_out):
    """Return the radii with which walls are measured [m] (M,): those of the particles."""
    return radius


@kernel(inline="always")
def radii_wet(film, radius, reach, lo, hi, wider_out):
    """Return the radii with which walls are measured [m] (M,): those of the particles of slots `lo` to `hi`,
    and the `reach` of the film [m].
    """
    for i in range(lo, hi):
        wider_out[i] = radius[i] + reach
    return wider_out


true_overlap = by_type({NoFilm: overlap_dry, ViscousFilm: overlap_wet, CapillaryBridge: overlap_wet})
"""Overlap from what was measured, under the film whose tag comes first; as `overlap_wet`."""

set_film = by_type({NoFilm: set_nothing, ViscousFilm: set_liquid, CapillaryBridge: set_bridge})
"""Set the numbers of the film in a lane; as `set_liquid`."""

load_film = by_type({NoFilm: load_nothing, ViscousFilm: load_liquid, CapillaryBridge: load_bridge})
"""Numbers of the film of a lane; as `load_liquid`."""

store_film_power = by_type({NoFilm: store_nothing, ViscousFilm: store_power, CapillaryBridge: store_power})
"""Write the power of the film of a lane; as `store_power`."""

film_power = by_type({NoFilm: no_power, ViscousFilm: sum_power, CapillaryBridge: sum_power})
"""Power of the films of a batch; as `sum_power`."""

measured_radii = by_type({NoFilm: radii_dry, ViscousFilm: radii_wet, CapillaryBridge: radii_wet})
"""Radii with which walls are measured; as `radii_wet`."""
