"""The mill in three dimensions, with PyVista: pictures, on a server without a screen as on a desk.

PyVista is the extra ``view``, imported in this file only.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nutamill.analysis.replay import Frame, between, chosen_snapshots, replay
from nutamill.analysis.source import any_case_of
from nutamill.base.atomic_file import check_writable, io_errors
from nutamill.base.errors import ResultError
from nutamill.base.units import in_unit
from nutamill.result import Result
from nutamill.view.cameras import Camera
from nutamill.view.drawn import Appearance, camera_called, drawn
from nutamill.view.looks import CLEAR, Look, check_look

if TYPE_CHECKING:
    import pyvista
from nutamill.view.renderer import SIZE, SURFACE, offscreen_plotter, part_mesh, part_style

NEAR = 0.04
"""Distance within which surfaces shade each other, share of the size of the machine [1]."""
OPENING = 0.9 * math.pi
"""Azimuth over which the chamber's wall is cut open [rad]."""
PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
"""Suffixes of pictures."""
BARS = {
    "speed": "speed (m/s)",
    "height": "height over the floor (m)",
    "force": "contact force (N)",
    "material": "material",
    "size": "diameter (m)",
}

MATERIALS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00")
"""Colours of the charge's materials, in their order."""
BAR: dict[str, Any] = {
    "vertical": True,
    "position_y": 0.06,
    "width": 0.05,
    "height": 0.35,
    "n_labels": 2,
    "fmt": "%.3g",
}
"""Colour bar, position and size in shares of the picture."""
BAR_LETTERS = 22
"""Size of the letters of the colour bar in a picture of the default width [pt]."""
CAPTION_SIZE = 12
"""Size of the letters of a caption [pt]."""
LOOK = Look()
"""The default look."""


def draw_scene(
    result: Result,
    path: str | Path,
    look: Look = LOOK,
    times: Sequence[float] = (),
    size: tuple[int, int] = SIZE,
) -> Path:
    """Write a picture (PNG) of one snapshot, or of several side by side, and return its path.

    Parameters
    ----------
    result : an opened result with snapshots
    look : camera, colours, cut and background
    times : simulated times [s], of each of which the nearest snapshot is drawn; the last snapshot if none
    size : width and height of the picture [px]; several snapshots share the width

    Raises
    ------
    CaseError : an unknown view or colour, or a file that is no picture
    ResultError : no snapshots, or snapshots without the quantity of the colour
    NotInstalledError : PyVista or OpenGL is missing
    """
    path = Path(path)
    check_writable(path, PICTURES)
    check_look(look)
    known = chosen_snapshots(result)
    chosen = [int(np.abs(result.snapshots.time[known] - time).argmin()) for time in times] or [len(known) - 1]
    images = []
    with open_stage(result, look, chosen, (size[0] // len(chosen), size[1])) as stage:
        stage.shade()
        for number in chosen:
            shown = stage.moment(number)
            stage.show(shown, f"t = {shown.frame.time:.4f} s" if len(chosen) > 1 else "")
            images.append(stage.image())
    from matplotlib.image import imsave  # a picture of several, in the format of its suffix

    with io_errors(path):
        imsave(path, np.ascontiguousarray(np.hstack(images)))
    return path


class Moment(NamedTuple):
    """What is shown at one time."""

    frame: Frame
    """Bodies and particles."""
    values: np.ndarray
    """What colours the particles (n,)."""


class Stage:
    """The machine and the charge in front of the camera, moved from picture to picture.

    Parameters
    ----------
    plotter : an open one
    result : the run
    look : camera, colours, cut and background
    machine : solids and cameras
    limits : ends of the colour bar
    """

    def __init__(
        self,
        plotter: "pyvista.Plotter",
        result: Result,
        look: Look,
        machine: Appearance,
        limits: tuple[float, float],
    ):
        self._plotter, self._result, self._look, self._machine = plotter, result, look, machine
        self._limits = limits
        self._camera = look.aimed(camera_called(machine, look.view))
        self._parts = [
            (part, plotter.add_mesh(part_mesh(part), **part_style(part))) for part in machine.parts
        ]
        self._pair: tuple[int, Moment, Moment] | None = None
        self._actor: Any = None
        self._names = any_case_of(result).charge.materials if look.colour == "material" else ()
        if self._names:
            legend = [[name, colour] for name, colour in zip(self._names, MATERIALS, strict=False)]
            plotter.add_legend(
                legend, bcolor="white", face="circle", loc="lower left", size=(0.2, 0.05 * len(legend))
            )

    def shade(self) -> None:
        """Make surfaces that are near each other darker, which takes too long for a film.

        Cast shadows are left out: they fall on the charge, whose colours are to be read.
        """
        near = NEAR * self._machine.reach
        self._plotter.enable_ssao(radius=near, bias=0.1 * near, kernel_size=64)

    def moment(self, number: int) -> Moment:
        """Return a snapshot and what colours its particles."""
        frame = next(replay(self._result, [number]))
        return Moment(frame, _values(self._result, number, frame, self._look.colour, self._machine.floor))

    def moment_at(self, time: float, at: np.ndarray) -> Moment:
        """Return a moment between two of the snapshots, whose times [s] are `at` (n,)."""
        if len(at) < 2:
            return self.moment(0)
        k = int(np.clip(np.searchsorted(at, time, side="right") - 1, 0, len(at) - 2))
        if self._pair is None or self._pair[0] != k:
            first = self._pair[2] if self._pair is not None and self._pair[0] == k - 1 else self.moment(k)
            self._pair = (k, first, self.moment(k + 1))
        _, one, other = self._pair
        share = float((time - at[k]) / (at[k + 1] - at[k]))
        fixed = self._look.colour == "material"
        values = one.values if fixed else (1.0 - share) * one.values + share * other.values
        return Moment(between(one.frame, other.frame, share), values)

    def show(self, moment: Moment, words: str = "") -> None:
        """Move all parts to their poses at a moment, and colour the particles. Write `words` below."""
        camera = self._camera.in_world(moment.frame)
        self._place_parts(moment.frame, camera)
        self._place_charge(moment, camera)
        if words:
            self._plotter.add_text(
                words,
                position="lower_right",
                font_size=CAPTION_SIZE,
                color=self._look.ink,
                name="caption",
                render=False,
            )
        lens = self._plotter.camera
        lens.position, lens.focal_point, lens.up = camera.eye, camera.target, camera.up
        lens.view_angle = in_unit(_angle_in(camera.angle, self._plotter.window_size), "deg")
        self._plotter.reset_camera_clipping_range()

    def image(self) -> np.ndarray:
        """Return the picture, (height, width, 3), or 4 colours with a transparent background."""
        clear = self._look.background == CLEAR
        self._plotter.render()
        return self._plotter.screenshot(None, return_img=True, transparent_background=clear)

    def _place_parts(self, frame: Frame, camera: Camera) -> None:
        for part, actor in self._parts:
            pose = frame.bodies[part.body]
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.origin
            actor.user_matrix = matrix
            actor.SetVisibility(part.name not in camera.hides)
            if self._look.cut is not None:
                actor.mapper.RemoveAllClippingPlanes()
                actor.mapper.AddClippingPlane(self._plane(camera))

    def _plane(self, camera: Camera) -> Any:
        """Return the plane of the cut, whose normal points away from the camera."""
        from vtkmodules.vtkCommonDataModel import vtkPlane

        point, normal = self._cut(camera)
        plane = vtkPlane()
        plane.SetOrigin(*point)
        plane.SetNormal(*normal)
        return plane

    def _cut(self, camera: Camera) -> tuple[np.ndarray, np.ndarray]:
        """Return a point of the cut and its normal away from the camera, world."""
        assert self._look.cut is not None  # asked for with a cut only
        point, normal = np.zeros(3), np.zeros(3)
        axis, point[self._look.cut.axis] = self._look.cut
        normal[axis] = -1.0 if camera.eye[axis] > point[axis] else 1.0
        return point, normal

    def _bar(self) -> dict[str, float]:
        """Return place and letters of the colour bar, so that its title is inside a narrow picture."""
        width, title = self._plotter.window_size[0], BARS[self._look.colour]
        letters = round(BAR_LETTERS * min(1.0, max(0.6, width / SIZE[0])))
        half_title = 0.28 * letters * len(title) / width
        place = max(0.04, half_title - 0.5 * BAR["width"])
        return {"position_x": place, "title_font_size": letters, "label_font_size": letters - 2}

    def _place_charge(self, moment: Moment, camera: Camera) -> None:
        import pyvista

        if self._actor is not None:
            self._plotter.remove_actor(self._actor, render=False)
            self._actor = None
        frame, values = moment
        seen = np.ones(len(frame.positions), bool)
        if self._look.cut is not None:
            point, normal = self._cut(camera)
            seen = (frame.positions - point) @ normal >= 0.0
        if not seen.any():
            return
        charge = pyvista.PolyData(frame.positions[seen])
        charge["radius"], charge[BARS[self._look.colour]] = frame.radii[seen], values[seen]
        ball = pyvista.Sphere(radius=1.0, theta_resolution=14, phi_resolution=14)
        self._actor = self._plotter.add_mesh(
            charge.glyph(scale="radius", geom=ball, orient=False),
            scalars=BARS[self._look.colour],
            cmap=list(MATERIALS[: len(self._names)]) if self._names else "viridis",
            clim=self._limits,
            smooth_shading=True,
            **SURFACE,
            show_scalar_bar=not self._names,
            scalar_bar_args={**BAR, **self._bar(), "color": self._look.ink},
            render=False,
        )
        for bar in self._plotter.scalar_bars.values():
            bar.SetVerticalTitleSeparation(BAR_LETTERS)  # else the title touches the largest number


@contextmanager
def open_stage(result: Result, look: Look, numbers: list[int], size: tuple[int, int]) -> Iterator[Stage]:
    """Open the stage of a result, with a colour bar that covers the snapshots of these numbers."""
    machine = drawn(any_case_of(result), OPENING if look.view == "front" else 0.0, result.walls)
    camera_called(machine, look.view)
    limits = look.limits or _limits(result, look.colour, numbers, machine.floor)
    with offscreen_plotter() as plotter:
        plotter.window_size = list(size)
        if look.background != CLEAR:
            plotter.set_background(look.background)
        yield Stage(plotter, result, look, machine, limits)


def _values(result: Result, number: int, frame: Frame, colour: str, floor: float) -> np.ndarray:
    """Return the values by which the particles of a snapshot are coloured, (n,)."""
    if colour == "speed":
        return np.linalg.norm(frame.velocities, axis=1)
    if colour == "height":
        return frame.at_home()[:, 2] - floor
    if colour == "size":
        return 2.0 * frame.radii
    array = "contact_forces" if colour == "force" else "materials"
    snapshot = result.snapshots[number]
    if array not in snapshot and len(frame.positions):
        raise ResultError(
            f"{result.path}: its snapshots hold no {array}, which colouring by {colour} needs. Run the case "
            "again."
        )
    return np.asarray(snapshot.get(array, np.empty(0)), float)


def _limits(result: Result, colour: str, numbers: list[int], floor: float) -> tuple[float, float]:
    """Return the ends of the colour bar over all snapshots shown: zero, and the 99.9 % quantile."""
    if colour == "material":
        return -0.5, max(1, len(any_case_of(result).charge.materials)) - 0.5
    shown = sorted(set(numbers))[:: max(1, len(set(numbers)) // 20)]
    values = [_values(result, number, next(replay(result, [number])), colour, floor) for number in shown]
    together = np.concatenate(values)
    if colour == "size" and len(together) and np.ptp(together) > 0.0:
        return float(together.min()), float(together.max())
    return 0.0, float(np.quantile(together, 0.999)) if len(together) else 1.0


def _angle_in(angle: float, size: Sequence[int]) -> float:
    """Return the angle of view from top to bottom [rad] with which a narrow picture shows as much across as
    one of the default size.
    """
    narrower = max(1.0, SIZE[0] / SIZE[1] * size[1] / size[0])
    return 2.0 * math.atan(narrower * math.tan(0.5 * angle))
