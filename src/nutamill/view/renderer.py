"""The renderer of pictures: a plotter of PyVista, its meshes and finishes, and why it may not start."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from nutamill.base.errors import NotInstalledError, missing_extra
from nutamill.view.drawing import BRASS, DARK, GLASS, RUBBER, STEEL, Part

if TYPE_CHECKING:
    import pyvista

SIZE = (1280, 960)
"""Pixels of a picture, across and down."""

SURFACE = {"ambient": 0.25, "specular": 0.35, "specular_power": 20.0}
"""Share of light that comes from everywhere, and the gloss, of all surfaces [1]."""
FINISH: dict[str, dict[str, float]] = {
    STEEL: {"ambient": 0.3, "diffuse": 0.8, "specular": 0.55, "specular_power": 40.0},
    DARK: {"ambient": 0.3, "diffuse": 0.8, "specular": 0.45, "specular_power": 30.0},
    RUBBER: {"ambient": 0.4, "diffuse": 0.7, "specular": 0.03, "specular_power": 2.0},
    GLASS: {"ambient": 0.4, "diffuse": 0.6, "specular": 1.0, "specular_power": 90.0},
    BRASS: {"ambient": 0.3, "diffuse": 0.8, "specular": 0.7, "specular_power": 40.0},
}
"""How the materials of a machine shine, by their colour: steel is bright in a spot, rubber nowhere."""


def part_mesh(part: Part) -> "pyvista.PolyData":
    """Return the triangles of a part as a mesh of PyVista."""
    import pyvista

    faces = np.column_stack([np.full(len(part.triangles), 3), part.triangles])
    return pyvista.PolyData(part.vertices, faces.ravel())


def part_style(part: Part) -> dict:
    """Return colour, opacity and finish of a part, as PyVista takes them."""
    return {
        "color": part.colour,
        "opacity": part.opacity,
        "smooth_shading": True,
        "split_sharp_edges": True,
        **FINISH.get(part.colour, SURFACE),
        "render": False,
    }


def opengl_trouble() -> str:
    """Return why no picture can be drawn in three dimensions, or "" if one can."""
    try:
        with offscreen_plotter() as plotter:
            import pyvista

            plotter.add_mesh(pyvista.Sphere())
            plotter.screenshot(None, return_img=True)
    except NotInstalledError as error:
        return str(error)
    return ""


@contextmanager
def offscreen_plotter() -> "Iterator[pyvista.Plotter]":
    """Open an off-screen plotter.

    Raises
    ------
    NotInstalledError : PyVista or OpenGL is missing
    """
    try:
        import pyvista
    except ImportError as fault:
        raise missing_extra("a picture in three dimensions", "PyVista", "view") from fault
    pyvista.vtk_verbosity("off")  # silences VTK's warning of a missing screen
    try:
        plotter = pyvista.Plotter(off_screen=True, window_size=list(SIZE), lighting="light kit")
    except Exception as fault:
        raise NotInstalledError(
            f"pictures in three dimensions need OpenGL, which is not available here ({fault})."
            " Install libegl1 or libosmesa6, or use `nutamill view`, which needs neither."
        ) from fault
    plotter.set_background("white")
    plotter.enable_anti_aliasing("ssaa")
    try:
        yield plotter
    finally:
        plotter.close()
