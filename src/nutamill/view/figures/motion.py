"""Figures of how the mill moves: histories of any series, spectra, the orbit of the charge's mass centre.

One function, one figure; saving is left to the caller.
"""

import math
import textwrap
from collections.abc import Mapping, Sequence

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from nutamill.analysis.flow import mass_centre_orbit
from nutamill.analysis.source import any_case_of
from nutamill.analysis.spectra import spectrum
from nutamill.analysis.windows import PAPER_WINDOW, steady_window
from nutamill.base.errors import CaseError, Fault
from nutamill.base.steady import Estimate
from nutamill.base.units import in_unit, shown
from nutamill.case.mill_quantities import crank_radius
from nutamill.result import Result
from nutamill.result.fields import Field
from nutamill.view.figures.style import ENVELOPE, MARK, MEAN, RMS, STYLE, WIDTH, label_of

LABEL = 18
"""Letters in a line of the label of an axis [1]: more are longer than the axis of a panel."""
FLOOR = 1e-8
"""Lowest density of a spectrum over its largest [1]."""
LAG = "angle of the crank ahead of the\nmass centre of the charge, about the driveshaft"
"""What the phase lag of a charge is."""
HIGHEST = 500.0
"""Highest frequency drawn [Hz]."""


def draw_histories(result: Result, names: Sequence[str]) -> Figure:
    """Draw every sample of some series over time, one panel each.

    Raises CaseError for a series that the result does not hold.
    """
    held_series(result, names)
    time = result.series["time"].values
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.5 + 1.2 * len(names)), layout="constrained")
        for axes, name in zip(np.atleast_1d(figure.subplots(len(names), 1, sharex=True)), names, strict=True):
            axes.plot(time, result.series[name].values, linewidth=0.6)
            words, _, unit = label_of(result.field(name)).rpartition(" (")
            axes.set_ylabel(f"{textwrap.fill(words, LABEL)}\n({unit}")
        axes.set_xlabel("time (s)")
        axes.set_xlim(time[0], time[-1])
        figure.align_ylabels()
    return figure


def draw_spectrum(result: Result, names: Sequence[str], last: float | str = PAPER_WINDOW) -> Figure:
    """Draw the power spectral density of some series over the steady window, up to 500 Hz, with a dotted line
    at the speed and at twice it.

    Raises CaseError for a series that the result does not hold, ResultError as `steady_window`.
    """
    held_series(result, names)
    steady = steady_window(result, last)
    inside = result.series["time"].values >= steady.start
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.5 + 1.5 * len(names)), layout="constrained")
        for axes, name in zip(np.atleast_1d(figure.subplots(len(names), 1, sharex=True)), names, strict=True):
            lines = spectrum(result.series[name].values[inside], result.rate)
            shown = (lines.frequency > 0.0) & (lines.frequency <= HIGHEST)
            largest = lines.density[shown].max(initial=0.0)
            axes.semilogy(
                lines.frequency[shown],
                np.where(lines.density[shown] > 0.0, lines.density[shown], math.nan),
                linewidth=0.7,
            )
            axes.set_xlim(left=0.0)
            if largest > 0.0:  # below, the leakage of the window and round-off
                axes.set_ylim(bottom=max(axes.get_ylim()[0], FLOOR * largest))
            for order in (1, 2):
                axes.axvline(
                    order * steady.turn_rate,
                    color=MARK,
                    linewidth=0.6,
                    linestyle=":",
                    label="speed, twice the speed" if order == 1 else None,
                )
            axes.set_ylabel(f"power spectral\ndensity ({density_unit(result.field(name))})")
            axes.set_title(result.field(name).label, loc="left")
        axes.set_xlabel("frequency (Hz)")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center")
        figure.align_ylabels()
    return figure


def draw_orbit(result: Result, last: float | str = PAPER_WINDOW) -> Figure:
    """Draw the path of the charge's mass centre in the steady window, seen from above, in axes that turn with
    the crank, with its mean and phase lag.

    Raises ResultError for an empty chamber, a machine without a crank, and as `steady_window`.
    """
    orbit = mass_centre_orbit(result, last)
    start = steady_window(result, last).turns[0]
    inside = result.series["time"].values >= start
    x, y, angle = (
        result.series[name].values[inside]
        for name in ("charge_mass_centre_x", "charge_mass_centre_y", "crank_angle")
    )
    path = (in_unit(x, "mm") + 1j * in_unit(y, "mm")) * np.exp(-1j * angle)
    mean = complex(path.mean())
    reach = 1.15 * float(np.abs(path).max())
    heights = result.series["charge_mass_centre_z"].values[inside]
    bore, pin = _bore_and_pin(result, float(heights.mean()))
    if bore is not None:
        reach = max(reach, 1.05 * float(np.abs(bore).max()))
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 3.2), layout="constrained")
        axes = figure.subplots()
        axes.plot(path.real, path.imag, linewidth=0.6, color=ENVELOPE, label="path")
        axes.plot([0.0, reach], [0.0, 0.0], color=MARK, linewidth=0.9, label="crank")
        if bore is not None:
            axes.plot(bore.real, bore.imag, color=MARK, linewidth=0.6, linestyle="--", label="bore")
        if pin:
            axes.plot([pin], [0.0], color=MARK, marker="+", markersize=7, linestyle="none", label="crank pin")
        axes.plot([0.0, mean.real], [0.0, mean.imag], color=RMS, marker="o", markersize=3, label="mean")
        arc = np.linspace(0.0, -orbit.phase_lag, 40)
        axes.plot(0.4 * reach * np.cos(arc), 0.4 * reach * np.sin(arc), color=MEAN, linewidth=0.8)
        middle = -0.5 * orbit.phase_lag
        axes.annotate(
            f"lag {shown(orbit.phase_lag, 'deg', '.0f')}",
            (0.45 * reach * math.cos(middle), 0.45 * reach * math.sin(middle)),
            va="center",
        )
        axes.set_aspect("equal")
        axes.set_xlim(-reach, reach)
        axes.set_ylim(-reach, reach)
        axes.set_xlabel("towards the crank (mm)")
        axes.set_ylabel("in the direction of rotation (mm)")
        axes.set_title(f"lag: {LAG}", loc="left", fontsize=6.5)
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _bore_and_pin(result: Result, height: float) -> tuple[np.ndarray | None, float]:
    """Return the bore at a height [m] and the distance of the crank pin from the axis, in axes that turn with
    the crank [mm]. The chamber leans towards the crank. None without a round region, zero without a pin.
    """
    machine = any_case_of(result).machine if result.case_text else None
    region = None if machine is None else next(iter(machine.regions), None)
    if machine is None or region is None or region.radius is None or not region.axis[2]:
        return None, 0.0
    across, along = np.array(region.axis[:2]), region.axis[2]
    middle = np.array(region.point[:2]) + (height - region.point[2]) / along * across
    around = np.exp(1j * np.linspace(0.0, math.tau, 121))
    bore = in_unit(region.radius, "mm") * around + complex(*in_unit(middle, "mm"))
    return bore, in_unit(crank_radius(machine), "mm")


def draw_steady_values(
    runs: Sequence[tuple[float, Mapping[str, Estimate]]], over: str, joined: bool
) -> Figure:
    """Draw the means of several runs, one panel for each reading, with their 95 % intervals.

    Parameters
    ----------
    runs : for each its position on the axis, and its estimates by their label, the same for all runs
    over : label of that axis
    joined : whether a line joins the runs, because they differ in that number only
    """
    ordered = sorted(runs, key=lambda run: run[0])
    labels = list(ordered[0][1])
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.5 + 1.3 * len(labels)), layout="constrained")
        for axes, label in zip(
            np.atleast_1d(figure.subplots(len(labels), 1, sharex=True)), labels, strict=True
        ):
            values = [estimates[label] for _, estimates in ordered]
            width = [value.half_width if math.isfinite(value.half_width) else 0.0 for value in values]
            line = "o-" if joined else "o"
            axes.errorbar(
                [position for position, _ in ordered],
                [value.mean for value in values],
                width,
                fmt=line,
                markersize=3,
                capsize=2,
                linewidth=0.8,
            )
            axes.set_ylabel(label.replace("driveshaft ", "").replace("charge ", ""))
            axes.margins(x=0.05)
        axes.set_xlabel(over)
        figure.align_ylabels()
    return figure


def held_series(result: Result, names: Sequence[str]) -> None:
    """Refuse names of series that the result does not hold, all at once."""
    faults: list[Fault] = []
    for name in names:
        try:
            result.field(name)
        except CaseError as error:
            faults += error.faults
    if not names:
        faults.append(
            Fault("series", "at least one must be named, got none", "`nutamill info fields` lists all series")
        )
    if faults:
        raise CaseError(*faults)


def density_unit(field: Field) -> str:
    """Return the unit of the power spectral density of a series: ``(N m)²/Hz``."""
    unit = field.unit
    return f"({unit.replace('^2', '²')})²/Hz" if len(unit) > 1 else f"{unit}²/Hz"
