"""Side views of the charge at several crank angles, as a camera on the chamber sees it."""

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

from nutamill.analysis.replay import particle_snapshots, rotation_of
from nutamill.analysis.source import case_of
from nutamill.base.units import in_unit
from nutamill.result import Result
from nutamill.view.figures.style import STYLE, WIDTH

PUBLISHED = "#444444"

ARM_POSITIONS = (0.0, 90.0, 180.0, 270.0)
"""Crank angles at which particles are shown [deg]."""


def draw_particles(result: Result, positions: Sequence[float] = ARM_POSITIONS) -> Figure:
    """Draw side views of the charge at several crank angles [deg] of the last turns, as a camera on the
    chamber sees it, coloured by height.

    Height is the world z over the nutation point as assembled; the chamber stands upright because the camera
    tilts with it.  The camera looks along +y of the chamber, so that at 0 deg the crank is on the right; what
    is nearer hides what is behind.

    Source
    ------
    van Tonder, Bredell, Coetzee and Branehog, J. S. Afr. Inst. Min. Metall. 125 (2025), figure 10 (form of
    the picture)

    Raises
    ------
    ResultError : no snapshots of particles
    """
    snapshots, turned = particle_snapshots(result)
    angles = in_unit(turned, "deg")
    chamber = case_of(result).chamber
    views = [_view(snapshots, angles, position) for position in positions]
    low, high = min(view[:, 3].min() for view in views), max(view[:, 3].max() for view in views)
    top = min(chamber.height, 1.15 * max(view[:, 2].max() for view in views))
    with matplotlib.rc_context(fname=STYLE):
        columns = 2
        lines = -(-len(positions) // columns)
        figure = Figure(
            figsize=(WIDTH, 0.7 + lines * (0.35 + 1.25 * top / chamber.inner_diameter)), layout="constrained"
        )
        all_axes = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
        radius, edge = in_unit(chamber.inner_diameter / 2, "mm"), in_unit(top, "mm")
        for axes, view, position in zip(all_axes.flat, views, positions, strict=False):
            axes.set_aspect("equal")
            axes.set_xlim(-1.08 * radius, 1.08 * radius)
            axes.set_ylim(-3.0, edge)
            axes.plot(
                [-radius, -radius, radius, radius],
                [edge, 0.0, 0.0, edge],
                color=PUBLISHED,
                linewidth=0.8,
            )
            axes.grid(False)
            axes.set_title(f"arm at {position:.0f}°", loc="left")
            shown = _balls(axes, view, low, high)
        for axes in all_axes[:, 0]:
            axes.set_ylabel("over the floor (mm)")
        for axes in all_axes[-1]:
            axes.set_xlabel("across (mm)")
        figure.colorbar(
            shown,
            ax=all_axes,
            location="bottom",
            shrink=0.8,
            aspect=30,
            label="height from the nutation point (mm)",
        )
    return figure


def _balls(axes: Axes, view: np.ndarray, low: float, high: float) -> EllipseCollection:
    """Draw the particles of a `_view` in their true size, coloured by height between `low` and `high`
    [m].
    """
    across = in_unit(2.0 * view[:, 4], "mm")
    balls = EllipseCollection(
        across,
        across,
        np.zeros(len(view)),
        units="x",
        offsets=in_unit(view[:, [0, 2]], "mm"),
        offset_transform=axes.transData,
    )
    balls.set(
        array=in_unit(view[:, 3], "mm"),
        cmap="viridis",
        clim=(in_unit(low, "mm"), in_unit(high, "mm")),
        linewidth=0.15,
        edgecolor="white",
        rasterized=True,
    )
    axes.add_collection(balls)
    return balls


def _view(snapshots, angles: np.ndarray, position: float) -> np.ndarray:
    """Return the particles (n, 5) of the last snapshot nearest to a crank angle [deg], those far from the
    camera first.

    Columns are x, y, z in chamber axes from the middle of the floor, world z from the nutation point, and
    radius [m].
    """
    off = np.abs((angles - position + 180.0) % 360.0 - 180.0)
    nearest = len(off) - 1 - int(np.argmin(off[::-1]))
    snapshot = snapshots[nearest]
    rotation = rotation_of(snapshot["chamber_attitude"])
    positions = np.asarray(snapshot["positions"], float)
    inside = (positions - snapshot["chamber_floor"]) @ rotation
    view = np.column_stack([inside, positions[:, 2], snapshot["radii"]])
    return view[np.argsort(-view[:, 1])]
