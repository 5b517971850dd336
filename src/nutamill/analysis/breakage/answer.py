"""What a run does to an ore: rates, sizes and energy, each with the interval that the scatter of its impacts
leaves.
"""

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from nutamill.analysis.breakage.balance import grind, middles, passing_of, percentile, size_edges
from nutamill.analysis.breakage.conditions import response, unharmed
from nutamill.analysis.breakage.impacts import Grinding, Impacts, captured_mass
from nutamill.analysis.breakage.ore import Ore
from nutamill.analysis.breakage.rates import Rates, rates_of
from nutamill.base.errors import ResultError
from nutamill.base.steady import batch_half_width
from nutamill.base.units import in_unit, shown

FEWEST_IMPACTS = 10.0
"""Fewest impacts on which the breakage of the feed must rest [1]."""
BELOW_PRODUCT = 32.0
"""Size of the product over the finest size that is followed [1]."""
LARGEST_ENERGY = 3.6e9
"""Specific energy beyond which a product is not sought [J/kg]: a million kWh/t."""
CURVE = 16
"""Energies of the curve of P80 over the specific energy [1]."""
SPAN = 50.0
"""Last over first energy of that curve [1]."""


class Breakage(NamedTuple):
    """What a run does to an ore; half widths are of 95 % intervals, not a number with fewer than two windows
    of statistics.
    """

    ore: Ore
    """The ore."""
    grinding: Grinding
    """The impacts and the power of the run."""
    sizes: np.ndarray
    """Middles of the classes of size [m] (n,), falling."""
    selection: np.ndarray
    """Rate at which unharmed particles of each size break, over the energy that the mill takes up [kg/J]
    (n,).
    """
    selection_half_width: np.ndarray
    """Of `selection` [kg/J] (n,)."""
    energies: np.ndarray
    """Specific energies [J/kg] (m,), up to that of the product."""
    p80: np.ndarray
    """Size than which 80 % is finer after each [m] (m,)."""
    p80_half_width: np.ndarray
    """Of `p80` [m] (m,)."""
    edges: np.ndarray
    """Edges of the classes of size [m] (n + 1,)."""
    passing: np.ndarray
    """Share of the product that is finer than each edge [1] (n + 1,)."""
    energy: float
    """Specific energy that grinds the feed to the product [J/kg]; infinite where none does."""
    energy_half_width: float
    """Of `energy` [J/kg]."""
    useful: float
    """Share of the power in impacts that break or weaken the coarsest of the feed [1]."""


def breakage(grinding: Grinding, ore: Ore, energy: float | None = None) -> Breakage:
    """Compute the product of a mill for an ore, against the energy that it takes up.

    Parameters
    ----------
    grinding : of `nutamill.analysis.breakage.impacts.grinding_of`
    energy : last energy of the curve [J/kg]; that of the product if None

    Raises
    ------
    ResultError : particles larger than the balls; impacts too few or too weak for the ore
    """
    refuse_large(grinding, ore)
    refuse_coarse(grinding, ore)
    edges = size_edges(ore.top_size, ore.product / BELOW_PRODUCT)
    whole = rates_of(ore, grinding.whole, edges)
    parts = [rates_of(ore, part, edges) for part in grinding.parts if part.number.any()]
    needed = energy_to_product(whole, ore)
    last = energy or (needed if math.isfinite(needed) else LARGEST_ENERGY)
    energies = last * SPAN ** np.linspace(-1.0, 0.0, CURVE)
    passing = passing_of(grind(whole.balance, whole.feed, energies))
    return Breakage(
        ore,
        grinding,
        middles(edges),
        whole.selection,
        _scatter(parts, lambda rates: rates.selection),
        energies,
        np.array([percentile(edges, row) for row in passing]),
        _scatter(parts, lambda rates: p80_of(rates, energies)),
        edges,
        passing[-1],
        needed,
        float(_scatter(parts, lambda rates: np.array([energy_to_product(rates, ore)]))[0]),
        useful_share(grinding.whole, ore),
    )


def _scatter(parts: list[Rates], number: Callable[[Rates], np.ndarray]) -> np.ndarray:
    """Return the half width of the interval of the mean of numbers of the parts of a run."""
    with np.errstate(invalid="ignore"):
        return batch_half_width(np.array([number(rates) for rates in parts]))


def p80_of(rates: Rates, energies: np.ndarray) -> np.ndarray:
    """Return the size than which 80 % is finer after each specific energy [m] (m,)."""
    passing = passing_of(grind(rates.balance, rates.feed, energies))
    return np.array([percentile(rates.edges, row) for row in passing])


def energy_to_product(rates: Rates, ore: Ore) -> float:
    """Return the specific energy that grinds the feed to the product [J/kg], infinite beyond
    `LARGEST_ENERGY`.
    """

    def excess(logarithm: float) -> float:
        return float(p80_of(rates, np.array([math.exp(logarithm)]))[0]) / ore.product - 1.0

    high = math.log(LARGEST_ENERGY)
    if excess(high) > 0.0:
        return math.inf
    return math.exp(brentq(excess, 0.0, high, xtol=1e-4))


def harm(impacts: Impacts, ore: Ore) -> np.ndarray:
    """Return the share of the coarsest particles of the feed that each impact breaks, or of their stiffness
    that it takes [1] (n_pairs, n_bins).
    """
    mass = captured_mass(ore.top_size, impacts.reduced_radius, ore.density)
    energy = np.broadcast_to(impacts.energy / mass, impacts.number.shape)
    does = response(ore.breakage, ore.top_size, energy.ravel())
    return (unharmed(ore.breakage) @ (does.broken + does.lost)).reshape(impacts.number.shape)


def useful_share(impacts: Impacts, ore: Ore) -> float:
    """Return the share of the power [1] in impacts, each with the share of particles that it harms."""
    return float((impacts.rate * impacts.energy * harm(impacts, ore)).sum())


def refuse_large(grinding: Grinding, ore: Ore) -> None:
    """Raise ResultError where the feed is coarser than the balls."""
    if ore.top_size >= grinding.smallest_ball:
        raise ResultError(
            f"{grinding.path}: the ore must be finer than the balls that grind it, got a feed up to "
            f"{shown(ore.top_size, 'mm')} and balls of {shown(grinding.smallest_ball, 'mm')}. Give the ore a "
            "finer feed."
        )


def refuse_coarse(grinding: Grinding, ore: Ore) -> None:
    """Raise ResultError where too few impacts break the coarsest of the feed."""
    impacts = grinding.whole
    harmed = harm(impacts, ore)
    weight = impacts.number * harmed
    resting = float(weight.sum() ** 2 / max((impacts.number * harmed**2).sum(), 1e-300))
    if resting >= FEWEST_IMPACTS:
        return
    bins = impacts.number.sum(0) == 0.0
    needed = harmed.max(0) > 0.0
    empty = np.flatnonzero(bins & needed)
    ranges = np.split(empty, np.flatnonzero(np.diff(empty) > 1) + 1) if len(empty) else []
    between = ", ".join(
        f"{impacts.edges[some[0]]:.2g} to {impacts.edges[some[-1] + 1]:.2g} J" for some in ranges
    )
    raise ResultError(
        f"{grinding.path}: its impacts are too few or too weak for this ore: the breakage of "
        f"{shown(ore.top_size, 'mm')} rests on {resting:.2g} of {impacts.number.sum():.0f} impacts, at least "
        f"{FEWEST_IMPACTS:g} are needed. Empty bins: {between or 'none'}. Run longer, or give a finer feed."
    )


def breakage_lines(answer: Breakage) -> list[str]:
    """Format the answer for one run as tables."""
    ore, grinding = answer.ore, answer.grinding
    head = [
        f"estimate for {ore.title or 'the ore'}: {grinding.duration:.3g} s of {Path(grinding.path).name}, "
        f"{grinding.power:.4g} W, {grinding.whole.number.sum():.0f} impacts in {len(grinding.parts)} windows",
        f"{100.0 * answer.useful:.2g} % of the power in impacts that harm {shown(ore.top_size, 'mm', '.3g')}",
    ]
    rows = [f"{'size (mm)':>10} {'breaks (t/kWh)':>15} {'±':>9}"]
    per = in_unit(1.0, "kWh/t")
    for size, rate, half in list(
        zip(answer.sizes, answer.selection, answer.selection_half_width, strict=True)
    )[::4]:
        rows.append(f"{in_unit(size, 'mm'):10.4g} {rate / per:15.4g} {_half(half / per):>9}")
    rows.append(f"{'kWh/t':>10} {'P80 (mm)':>15} {'±':>9}")
    for energy, size, half in zip(answer.energies, answer.p80, answer.p80_half_width, strict=True):
        sizes = f"{in_unit(size, 'mm'):15.4g} {_half(in_unit(half, 'mm')):>9}"
        rows.append(f"{in_unit(energy, 'kWh/t'):10.4g} {sizes}")
    return head + rows


def comparison_lines(answers: list[Breakage]) -> list[str]:
    """Format runs with one ore side by side: power, energy to the product, and the size after the energy that
    the first one needs. The titles of their cases follow.
    """
    first = answers[0]
    rows = [f"{'run':28} {'W':>8} {'kWh/t':>8} {'±':>7} {'of first':>9} {'±':>6} {'P80 (mm)':>9} {'±':>7}"]
    for one in answers:
        share = one.energy / first.energy if math.isfinite(first.energy) else math.nan
        doubt = math.hypot(one.energy_half_width / one.energy, first.energy_half_width / first.energy)
        doubt = 0.0 if one is first else share * doubt
        rows.append(
            f"{Path(one.grinding.path).name:28} {one.grinding.power:8.4g} "
            f"{in_unit(one.energy, 'kWh/t'):8.4g} {_half(in_unit(one.energy_half_width, 'kWh/t')):>7} "
            f"{share:9.3f} {_half(doubt):>6} "
            f"{in_unit(one.p80[-1], 'mm'):9.4g} {_half(in_unit(one.p80_half_width[-1], 'mm')):>7}"
        )
    return rows + [f"{Path(one.grinding.path).name}: {one.grinding.title}" for one in answers]


def _half(value: float) -> str:
    """Return the half width of an interval as text, a dash where there is none."""
    return f"{value:.2g}" if math.isfinite(value) else "-"
