"""Figures of what the charge does: impact spectra, the worn wall, the flow.  One function, one figure; saving
is left to the caller.
"""

import math
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nutamill.analysis.flow import (
    crest,
    flow_fields,
    impact_spectra,
    mass_centre_orbit,
    surface_heights,
    wear_table,
    window,
)
from nutamill.analysis.windows import PAPER_WINDOW
from nutamill.base.units import in_unit, shown
from nutamill.result import Result
from nutamill.view.figures.motion import LAG
from nutamill.view.figures.style import MARK, RMS, STYLE, WIDTH

if TYPE_CHECKING:
    import xarray

WEAKEST = 0.02
"""Share of the impacts, the weakest ones, that may be left of the picture [1]."""
LEAST = 1e-3
"""Share of the power of the impacts, of the strongest ones, that may be right of it [1]."""
ARROWS = 10.0
"""Length of the longest arrow over the width of the picture, inverted [1]."""
PATTERN = {"normal": "-", "tangential": (0, (3, 1.2)), "loading": (0, (1, 1))}


def draw_spectra(result: Result, last: float | str = PAPER_WINDOW) -> Figure:
    """Draw how many contacts begin with how much energy, and the power they bring along, in bins of half an
    octave, and the same of the work that loads them.

    One line for each pair of materials, part of the relative velocity and loading.
    """
    spectra = impact_spectra(window(result, last))
    energy = spectra["energy"].values
    first, end = _energies_shown(spectra)
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
        number, power = figure.subplots(2, 1, sharex=True)
        materials = spectra["pair_materials"].values.astype(str)
        for k, pair in enumerate(dict.fromkeys(materials)):
            for part, line in PATTERN.items():
                if part not in spectra["part"].values:
                    continue
                one = spectra.sel(part=part).isel(pair=np.flatnonzero(materials == pair)).sum("pair")
                style = {
                    "color": f"C{k}",
                    "linestyle": line,
                    "drawstyle": "steps-mid",
                    "label": f"{pair}, {part}",
                }
                rate = one["rate"].values.copy()
                rate[rate <= 0.0] = math.nan  # a logarithm has no place for it
                number.plot(energy, rate, **style)
                power.plot(energy, one["power"].values, **style)
        number.set_yscale("log")
        number.set_xscale("log")
        number.set_xlim(energy[first], energy[end] * 2.0)
        number.set_ylabel("impacts (1/s)")
        power.set_ylabel("power (W)")
        power.set_ylim(bottom=0.0)
        power.set_xlabel("impact energy (J)")
        number.set_title("(a) number, in bins of half an octave", loc="left")
        power.set_title("(b) their energy per second", loc="left")
        figure.legend(*number.get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.align_ylabels()
    return figure


def _energies_shown(spectra: "xarray.Dataset") -> tuple[int, int]:
    """Return the first and the last bin of energy that are drawn: all impacts but the `WEAKEST`, all of the
    power but the `LEAST`. The lowest bin, which holds everything below it, does not count.
    """
    number, power = (spectra[name].sum(("pair", "part")).values.copy() for name in ("rate", "power"))
    number[0] = 0.0
    first = int(np.searchsorted(np.cumsum(number), WEAKEST * number.sum(), side="right"))
    end = int(np.searchsorted(np.cumsum(power), (1.0 - LEAST) * power.sum()))
    return min(first, end, len(power) - 1), max(min(first, len(power) - 1), min(end, len(power) - 1))


def draw_wall(result: Result, last: float | str = PAPER_WINDOW) -> Figure:
    """Draw the bore unrolled, in chamber axes, as high as the charge reaches: mean pressure, and shear work
    and cutting energy of impacts per area and time.

    Where the chamber is a mesh, or no cylinder, the wall with the largest area stands for the bore.
    """
    table = wear_table(window(result, last))
    number = np.unique(table["patch_surface"].values, return_inverse=True)[1]
    largest = np.argmax(np.bincount(number, table["patch_area"].values))
    table = table.isel(patch=np.flatnonzero(number == largest))
    columns = int(table["patch_column"].max()) + 1
    azimuth, along = (table[name].values.reshape(columns, -1) for name in ("patch_azimuth", "patch_along"))
    upright = len(np.unique(np.round(azimuth[:, 0], 6))) == columns
    if not upright:  # a wall that is no upright cylinder counts in its own angle
        azimuth = np.repeat((np.arange(columns) + 0.5)[:, None] * math.tau / columns, along.shape[1], axis=1)
    order = np.argsort(azimuth[:, 0])  # a wall may begin anywhere
    surface = str(table["patch_surface"].values[0])
    panels = (
        ("pressure", "pressure (Pa)"),
        ("shear_intensity", "shear power (W/m$^2$)"),
        ("cutting_intensity", "cutting power (W/m$^2$)"),
    )
    touched = table["pressure"].values.reshape(columns, -1).max(axis=0) > 0.0
    step = along[0, 1] - along[0, 0]
    highest = along[0, 0] + step * min(np.flatnonzero(touched).max(initial=0) + 2, along.shape[1] - 0.5)
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 5.0), layout="constrained")
        for k, (axes, (name, label)) in enumerate(
            zip(figure.subplots(len(panels), 1, sharex=True), panels, strict=True)
        ):
            values = table[name].values.reshape(columns, -1)[order]
            across = in_unit(azimuth[order, 0], "deg")
            most = float(values.max()) or 1.0
            drawn = axes.pcolormesh(
                across, along[0], values.T, cmap="viridis", vmin=0.0, vmax=most, rasterized=True
            )
            axes.set_ylim(along[0, 0] - 0.5 * step, highest)
            axes.grid(False)
            axes.set_ylabel("height (m)" if upright else "along the\nwall (m)")
            axes.set_title(f"({'abc'[k]}) {label.split(' (')[0]} on {surface}", loc="left")
            figure.colorbar(drawn, ax=axes, label=label)
        axes.set_xticks(range(0, 361, 90))
        axes.set_xlabel("azimuth in the chamber (°)" if upright else "angle about the middle of the wall (°)")
    return figure


def draw_flow(result: Result, last: float | str = PAPER_WINDOW) -> Figure:
    """Draw the charge as it stands in axes that turn with the crank: seen from above, and along the wall with
    its surface. The phase lag is that of the mass centre, as in `draw_orbit`.

    From above: solids fraction averaged over the height that the charge reaches, and the mean velocity
    relative to the chamber.  Along the wall: solids fraction of the outermost cells, and the height below
    which 95 % of the charge lie in each sector.
    """
    done = window(result, last)
    fields = flow_fields(done)
    heights = surface_heights(done)
    top = crest(heights, done["azimuth"].values)
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 5.2), layout="constrained")
        grid = figure.add_gridspec(2, 1, height_ratios=[3, 2])
        above = figure.add_subplot(grid[0], projection="polar")
        along = figure.add_subplot(grid[1])
        drawn = _seen_from_above(above, done, fields, top.height)
        figure.colorbar(drawn, ax=above, label="solids fraction", shrink=0.8)
        crank = "crank_angle" in result.series
        where = ", crank at 0°, turning anticlockwise" if crank else ""
        above.set_title(f"(a) from above{where}", loc="left")
        outermost = fields["solids_fraction"].isel(radius=-1).transpose("height", "azimuth").values
        degrees = in_unit(done["azimuth"].values, "deg")
        drawn = along.pcolormesh(
            degrees, done["height"].values, outermost, cmap="viridis", vmin=0.0, rasterized=True
        )
        surface = np.where(heights > 0.0, heights, math.nan)  # a bare sector has none
        along.plot(degrees, surface, color="white", linewidth=1.6)
        along.plot(
            degrees, surface, color=RMS, label=f"surface, its crest at {shown(top.height, 'mm', '.3g')}"
        )
        if crank:
            lag = shown(mass_centre_orbit(result, last).phase_lag, "deg", ".0f")
            along.plot([], [], " ", label=f"lag {lag}: {LAG}")
        along.set_ylim(0.0, min(1.3 * top.height, float(done["height"].values[-1])))
        along.set_xticks(range(0, 361, 90))
        along.grid(False)
        along.set_xlabel("azimuth from the crank (°)" if crank else "azimuth (°)")
        along.set_ylabel("height (m)")
        along.set_title("(b) along the wall", loc="left")
        figure.colorbar(drawn, ax=along, label="solids fraction")
        figure.legend(*along.get_legend_handles_labels(), loc="outside lower center")
    return figure


def _seen_from_above(axes: Axes, done, fields, height: float):
    """Draw mean solids fraction and velocity over the height up to `height` [m], in polar axes, and return
    what a colour bar needs.
    """
    reached = (
        done.sel(height=slice(0.0, height))
        if height > float(done["height"][0])
        else done.isel(height=slice(0, 1))
    )
    volume = reached["cell_volume"].sum("height") * done["sampled_time"]
    solids = (reached["cell_solid_volume"].sum("height") / volume).transpose("radius", "azimuth").values
    mass = reached["cell_mass"].sum("height").transpose("radius", "azimuth").values
    radial, azimuthal = (
        reached[f"cell_momentum_{k}"].sum("height").transpose("radius", "azimuth").values for k in "ra"
    )
    radius, azimuth = done["radius"].values, done["azimuth"].values
    step = radius[1] - radius[0]
    rings = np.concatenate([radius - 0.5 * step, radius[-1:] + 0.5 * step])
    drawn = axes.pcolormesh(
        np.linspace(0.0, math.tau, len(azimuth) + 1), rings, solids, cmap="viridis", vmin=0.0, rasterized=True
    )  # fmt: skip
    filled = solids > 0.1 * solids.max()
    angle, distance = np.meshgrid(azimuth, radius)
    with np.errstate(invalid="ignore", divide="ignore"):
        v_r, v_a = radial / mass, azimuthal / mass
    shown = filled & (np.arange(len(azimuth)) % 2 == 0)
    across, up = v_r * np.cos(angle) - v_a * np.sin(angle), v_r * np.sin(angle) + v_a * np.cos(angle)
    lengths = np.hypot(across[shown], up[shown])
    longest = float(lengths[np.isfinite(lengths)].max(initial=0.0)) or 1.0
    arrows = axes.quiver(
        angle[shown],
        distance[shown],
        across[shown],
        up[shown],
        color="white",
        scale=ARROWS * longest,
        width=0.006,
        pivot="mid",
    )
    key = float(f"{0.7 * longest:.1g}")
    axes.quiverkey(arrows, 0.0, -0.02, key, f"{key:g} m/s", labelpos="E", color=MARK, coordinates="axes")
    axes.grid(False)
    axes.set_yticks([])
    axes.set_ylim(0.0, rings[-1])
    return drawn
