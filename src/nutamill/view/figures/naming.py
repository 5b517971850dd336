"""The lines above a figure that name the run it is drawn from."""

import textwrap

from matplotlib.figure import Figure

from nutamill.analysis.source import any_case_of
from nutamill.base.units import rpm, shown
from nutamill.case import Case, Machine
from nutamill.case.charge import Portion
from nutamill.result import Result
from nutamill.view.figures.style import MARK

CHARACTERS = 21
"""Characters of a line for each inch of a figure [1/inch]."""


def named_after(figure: Figure, result: Result) -> Figure:
    """Return the figure with its run above it: case, what was changed, demonstration or not, speed and charge
    in a line of their own.
    """
    case = any_case_of(result) if result.case_text else None
    title = case.title if case is not None else ""
    facts = [] if case is None else [*_speed(result), *_charge(case)]
    width = max(20, int(CHARACTERS * figure.get_figwidth()))
    lines = [textwrap.fill(text, width) for text in (title or result.path.stem, ", ".join(facts)) if text]
    figure.suptitle("\n".join(lines), fontsize=5.5, color=MARK, x=0.01, ha="left")
    return figure


def _speed(result: Result) -> list[str]:
    """Return the last speed of the driveshaft as text, none without a driveshaft."""
    if "driveshaft_speed" not in result.series or not result.series.sizes["time"]:
        return []
    return [f"{rpm(float(result.series['driveshaft_speed'].values[-1])):.0f} rpm"]


def _charge(case: Case | Machine) -> list[str]:
    """Return amount, material and sizes of each part of a charge, or that there is none."""
    if not case.charge.parts:
        return ["no charge"] if case.machine.regions else []
    return [_portion(part) for part in case.charge.parts]


def _portion(part: Portion) -> str:
    """Return one part of a charge: ``1.35 kg of steel 5 mm``."""
    if part.mass is not None:
        amount = f"{shown(part.mass, 'kg')} of"
    elif part.fill is not None:
        amount = f"fill {100.0 * part.fill:.3g} % of"
    else:
        amount = f"{part.count} particles of"
    small, large = part.size_range
    sizes = shown(large, "mm") if small == large else f"{shown(small, 'mm')} to {shown(large, 'mm')}"
    return f"{amount} {part.material} {sizes}"
