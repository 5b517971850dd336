"""A mount's hysteresis loop, measured and as its dynamic stiffness has it."""

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from nutamill.analysis.mount_test import MountProperties, MountTest
from nutamill.base.units import in_unit, shown
from nutamill.view.figures.style import MEAN, STYLE, WIDTH


def draw_loop(test: MountTest, properties: MountProperties) -> Figure:
    """Draw force over displacement: the record, and the ellipse of K' and K'', both without their means."""
    phase = np.linspace(0.0, 2.0 * np.pi, 400)
    moved = properties.amplitude * np.cos(phase)
    pushed = properties.amplitude * (properties.storage * np.cos(phase) - properties.loss * np.sin(phase))
    storage, loss = (shown(value, "N/mm", ".3g") for value in (properties.storage, properties.loss))
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 2.6), layout="constrained")
        axes = figure.subplots()
        axes.plot(
            in_unit(test.displacement - test.displacement.mean(), "mm"),
            test.force - test.force.mean(),
            ".",
            color="#888888",
            ms=2,
            label="test",
        )
        axes.plot(
            in_unit(moved, "mm"),
            pushed,
            color=MEAN,
            label=f"K' {storage}, K'' {loss}",
        )
        axes.margins(x=0.04)
        axes.set_xlabel("displacement (mm)")
        axes.set_ylabel("force (N)")
        figure.legend(loc="outside lower center", ncols=2)
    return figure
