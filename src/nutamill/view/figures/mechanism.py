"""The picture of a mechanism's run."""

import matplotlib
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nutamill.analysis.mechanism import magnitude, part_loads
from nutamill.result import Result
from nutamill.view.figures.style import PALETTE, STYLE, WIDTH

MOST_LINES = 5
"""Joints drawn at most: those with the largest peaks."""


def draw_reactions(result: Result) -> Figure:
    """Draw the magnitudes of the largest joint and bushing forces over the run, and below them the torques of
    the drives.
    """
    time = result.series["time"].values
    loads = sorted(part_loads(result), key=lambda load: -load.peak_force)[:MOST_LINES]
    torques = [
        str(name)
        for name in result.series.data_vars
        if str(name).startswith("drive_") and str(name).endswith("_torque")
    ]
    panels = (
        [("force (N)", [(load.part, magnitude(result, f"{load.part}_force")) for load in loads])]
        if loads
        else []
    )
    if torques:
        panels.append(
            ("torque (N m)", [(name.removesuffix("_torque"), result.series[name].values) for name in torques])
        )
    if not panels:
        names = ("kinetic_energy_mechanism", "potential_energy", "elastic_energy")
        panels = [("energy (J)", [(name, result.series[name].values) for name in names])]
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.5 + 1.9 * len(panels)), layout="constrained")
        for axes, (label, lines) in zip(
            figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0], panels, strict=True
        ):
            for number, (colour, (name, values)) in enumerate(zip(PALETTE, lines, strict=False)):
                # thinner and thinner: of two joints with the same force both are seen
                axes.plot(
                    time,
                    values,
                    color=colour,
                    label=name.replace("_", " "),
                    linewidth=2.2 / (1 + number) ** 0.7,
                )
            axes.set_ylabel(label)
            axes.set_xlim(time[0], time[-1])
            axes.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))
            axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
        figure.axes[-1].set_xlabel("time (s)")
        figure.align_ylabels()
    return figure
