"""The picture of a machine in the documentation of its FMU."""

import io

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from nutamill.analysis.replay import rotation_of
from nutamill.base.units import in_unit
from nutamill.case.machine import Machine
from nutamill.case.machine_checks import GROUND
from nutamill.case.placement import quaternion_of
from nutamill.view.machine_drawing import machine_solids


def picture(machine: Machine) -> bytes:
    """Return a PNG of a machine as assembled, lengths in mm."""
    poses = {GROUND: (np.zeros(3), np.eye(3))}
    for body in machine.bodies:
        poses[body.name] = (np.array(body.position), rotation_of(quaternion_of(body.turn)))
    figure = Figure(figsize=(6.0, 6.0))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot(projection="3d")
    corners = [np.array([body.position for body in machine.bodies])]
    for part in machine_solids(machine):
        origin, rotation = poses[part.body]
        world = origin + part.vertices @ rotation.T
        corners.append(world)
        faces = in_unit(world, "mm")[part.triangles]
        axes.add_collection3d(Poly3DCollection(faces, facecolor=part.colour, alpha=max(0.3, part.opacity)))
    spread = in_unit(np.concatenate(corners), "mm")
    middle, half = (spread.max(0) + spread.min(0)) / 2.0, max(1.0, float(np.ptp(spread, axis=0).max()) / 2.0)
    low, high = middle - half, middle + half
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set(xlabel="x (mm)", ylabel="y (mm)", zlabel="z (mm)")
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=100, metadata={"Software": None})
    return content.getvalue()
