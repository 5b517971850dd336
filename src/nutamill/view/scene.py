"""The mill in three dimensions, with PyVista: pictures and films, on a server without a screen as on a desk.

PyVista is the extra ``view``, imported in this file only.
"""

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from nutamill.analysis.replay import Frame, chosen_snapshots, replay
from nutamill.analysis.source import any_case_of
from nutamill.base.atomic_file import check_writable, io_errors
from nutamill.base.errors import CaseError, Fault, NotInstalledError, OutputError, ResultError, missing_extra
from nutamill.base.units import in_unit
from nutamill.case import Case, Machine
from nutamill.result import Result
from nutamill.view.cameras import VIEWS, Camera, View
from nutamill.view.drawing import Part
from nutamill.view.drawn import camera_called, drawn

if TYPE_CHECKING:
    import pyvista

SIZE = (1280, 960)
"""Pixels of a picture, across and down."""
SURFACE = {"ambient": 0.25, "specular": 0.35, "specular_power": 20.0}
"""Share of light that comes from everywhere, and the gloss, of all surfaces [1]."""
NEAR = 0.04
"""Distance within which surfaces shade each other, share of the size of the machine [1]."""
OPENING = 0.9 * math.pi
"""Azimuth over which the chamber's wall is cut open [rad]."""
FILM_RATE = 25
"""Pictures per second of a film [1/s]."""
LOGGED = 20
"""Snapshots drawn between two lines of the log of a film [1]."""
PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
"""Suffixes of pictures."""
FILMS = (".mp4",)
"""Suffixes of films."""
SLOWED = 40.0
"""Default of how many times slower than real a film runs [1]."""

Colour = Literal["speed", "height", "force", "material"]
BARS = {
    "speed": "speed (m/s)",
    "height": "height over the floor (m)",
    "force": "contact force (N)",
    "material": "material",
}

MATERIALS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00")
"""Colours of the charge's materials, in their order."""
BAR = {
    "vertical": True,
    "position_x": 0.04,
    "position_y": 0.06,
    "width": 0.05,
    "height": 0.35,
    "n_labels": 2,
    "fmt": "%.3g",
    "title_font_size": 22,
    "label_font_size": 20,
    "color": "black",
}
"""Colour bar, position and size in shares of the picture."""


def draw_scene(
    result: Result,
    path: str | Path,
    view: View = "front",
    colour: Colour = "speed",
    number: int = -1,
    time: float | None = None,
    size: tuple[int, int] = SIZE,
) -> Path:
    """Write a picture (PNG) of one snapshot, and return its path.

    Parameters
    ----------
    result : an opened result with snapshots
    view : ``front``; ``inside``, riding on the chamber under its ceiling as the camera of the NuMill papers;
        ``axis``, down the shaft
    colour : quantity by which the particles are coloured
    number : which snapshot; -1 is the last
    time : simulated time [s]; the snapshot nearest to it is drawn in place of `number`
    size : width and height of the picture [px]

    Raises
    ------
    CaseError : an unknown view or colour, or a file that is no picture
    ResultError : no snapshots, or snapshots without the quantity of the colour
    NotInstalledError : PyVista or OpenGL is missing
    """
    check_writable(Path(path), PICTURES)
    snapshots = chosen_snapshots(result)
    if time is not None:
        number = int(np.abs(result.snapshots.time[snapshots] - time).argmin())
    return _rendered(result, Path(path), view, colour, [range(len(snapshots))[number]], _pictured, size=size)


FRAGMENTS = ["-movflags", "+frag_keyframe+empty_moov+default_base_moof", "-g", "50"]
"""Options of ffmpeg: fragments of two seconds, each complete, so that a truncated film still plays."""


def film_scene(
    result: Result,
    path: str | Path,
    view: View = "front",
    colour: Colour = "speed",
    slowed: float = SLOWED,
    log: Callable[[str], None] | None = None,
) -> Path:
    """Write a film (MP4) of all snapshots, and return its path.

    Parameters
    ----------
    slowed : how many times slower than real the film runs [1]
    log : receives now and then how many snapshots have been drawn

    Raises
    ------
    as `draw_scene`; NotInstalledError also where ffmpeg is missing
    """
    path = Path(path)
    check_writable(path, FILMS)
    times = result.snapshots.time[chosen_snapshots(result)]
    pictures = max(2, round(float(times[-1] - times[0]) * slowed * FILM_RATE) + 1)
    nearest = np.abs(np.linspace(times[0], times[-1], pictures)[:, None] - times).argmin(axis=1)

    def open_film(plotter: "pyvista.Plotter") -> Callable:
        if ffmpeg_trouble():
            raise missing_extra(f"{path}: a film", "ffmpeg", "view")
        plotter.open_movie(str(path), framerate=FILM_RATE, quality=7, output_params=FRAGMENTS)
        return functools.partial(_filmed, plotter)

    return _rendered(result, path, view, colour, [int(k) for k in nearest], open_film, log)


def _pictured(plotter: "pyvista.Plotter") -> Callable:
    return lambda path, times: plotter.screenshot(path)


def _filmed(plotter: "pyvista.Plotter", path: str, times: int) -> None:
    """Render the scene once and append it to the film `times` times."""
    try:
        plotter.write_frame()
        drawn = plotter.image
        for _ in range(times - 1):
            plotter.mwriter.append_data(drawn)
    except OSError:  # holds the command line of ffmpeg
        raise OutputError(
            f"{path}: ffmpeg cannot write the film any further. Free some room, or choose another folder."
        ) from None


def _rendered(
    result: Result,
    path: Path,
    view: View,
    colour: str,
    numbers: list[int],
    open_writer: Callable,
    log: Callable[[str], None] | None = None,
    size: tuple[int, int] = SIZE,
) -> Path:
    """Render each snapshot and pass it to the writer with its repeat count.

    Parameters
    ----------
    numbers : snapshots in the order of the pictures, equal ones in a row
    open_writer : makes of the plotter the function that writes a rendered picture some times to a path
    log : receives how many snapshots have been drawn
    """
    _check(view, colour)
    case = any_case_of(result)
    machine = drawn(case, OPENING if view == "front" else 0.0, result.walls)
    camera = camera_called(machine, view)
    limits = _limits(result, colour, numbers, case, machine.floor)
    repeats = [(number, len(list(same))) for number, same in itertools.groupby(numbers)]
    with _plotter() as plotter:
        plotter.window_size = list(size)
        if len(repeats) == 1:  # a film would take several times as long
            near = NEAR * machine.reach
            plotter.enable_ssao(radius=near, bias=0.1 * near, kernel_size=64)
        write = open_writer(plotter)
        stage = Stage(plotter, case, machine.parts, colour, limits)
        for done, (number, times) in enumerate(repeats):
            if log is not None and done % LOGGED == 0:
                log(f"{done} of {len(repeats)} moments drawn")
            frame = next(replay(result, [number]))
            stage.show(frame, _values(result, number, frame, colour, machine.floor), camera)
            with io_errors(path):
                write(str(path), times)
    return path


class Stage:
    """The machine and the charge in front of the camera, moved from frame to frame of one picture or film."""

    def __init__(
        self,
        plotter: "pyvista.Plotter",
        case: Case | Machine,
        parts: Sequence[Part],
        colour: str,
        limits: tuple[float, float],
    ):
        import pyvista

        self._plotter, self._colour, self._limits = plotter, colour, limits
        self._parts = [(part, plotter.add_mesh(_mesh(part), **_look(part))) for part in parts]
        self._charge: pyvista.PolyData | None = None
        self._actor = None
        self._names = case.charge.materials if colour == "material" else ()
        if self._names:
            legend = [[name, colour] for name, colour in zip(self._names, MATERIALS, strict=False)]
            plotter.add_legend(
                legend, bcolor="white", face="circle", loc="lower left", size=(0.2, 0.05 * len(legend))
            )

    def show(self, frame: Frame, values: np.ndarray, camera: Camera) -> None:
        """Move all parts to their poses in `frame`, and colour the particles by `values` (n,)."""
        import pyvista

        for part, actor in self._parts:
            pose = frame.bodies[part.body]
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.origin
            actor.user_matrix = matrix
            actor.SetVisibility(part.name not in camera.hides)
        if len(frame.positions):
            charge = pyvista.PolyData(frame.positions)
            charge["radius"], charge[BARS[self._colour]] = frame.radii, values
            ball = pyvista.Sphere(radius=1.0, theta_resolution=14, phi_resolution=14)
            balls = charge.glyph(scale="radius", geom=ball, orient=False)
            if self._actor is not None:
                self._plotter.remove_actor(self._actor, render=False)
            self._actor = self._plotter.add_mesh(
                balls,
                scalars=BARS[self._colour],
                cmap=list(MATERIALS[: len(self._names)]) if self._names else "viridis",
                clim=self._limits,
                smooth_shading=True,
                **SURFACE,
                show_scalar_bar=not self._names,
                scalar_bar_args=BAR,
                render=False,
            )
        camera, lens = camera.in_world(frame), self._plotter.camera
        lens.position, lens.focal_point, lens.up = camera.eye, camera.target, camera.up
        lens.view_angle = in_unit(camera.angle, "deg")
        self._plotter.reset_camera_clipping_range()


def _check(view: str, colour: str) -> None:
    faults = []
    for where, given, names in (("--camera", view, VIEWS), ("--colour", colour, get_args(Colour))):
        if given not in names:
            faults.append(
                Fault(
                    where,
                    f'must be one of {", ".join(names)}, got "{given}"',
                    f"Write e.g. {where} {names[0]}",
                )
            )
    if faults:
        raise CaseError(*faults)


def _values(result: Result, number: int, frame: Frame, colour: str, floor: float) -> np.ndarray:
    """Return the values by which the particles of a snapshot are coloured, (n,)."""
    if colour == "speed":
        return np.linalg.norm(frame.velocities, axis=1)
    if colour == "height":
        return frame.at_home()[:, 2] - floor
    array = "contact_forces" if colour == "force" else "materials"
    snapshot = result.snapshots[number]
    if array not in snapshot and len(frame.positions):
        raise ResultError(
            f"{result.path}: its snapshots hold no {array}, which colouring by {colour} needs. Run the case "
            "again."
        )
    return np.asarray(snapshot.get(array, np.empty(0)), float)


def _limits(
    result: Result, colour: str, numbers: list[int], case: Case | Machine, floor: float
) -> tuple[float, float]:
    """Return the ends of the colour bar over all snapshots shown: zero, and the 99.9 % quantile."""
    if colour == "material":
        return -0.5, max(1, len(case.charge.materials)) - 0.5
    shown = sorted(set(numbers))[:: max(1, len(set(numbers)) // 20)]
    values = [_values(result, number, next(replay(result, [number])), colour, floor) for number in shown]
    together = np.concatenate(values)
    return 0.0, float(np.quantile(together, 0.999)) if len(together) else 1.0


def _mesh(part: Part) -> "pyvista.PolyData":
    import pyvista

    faces = np.column_stack([np.full(len(part.triangles), 3), part.triangles])
    return pyvista.PolyData(part.vertices, faces.ravel())


def _look(part: Part) -> dict:
    return {
        "color": part.colour,
        "opacity": part.opacity,
        "smooth_shading": True,
        "split_sharp_edges": True,
        **SURFACE,
        "render": False,
    }


def opengl_trouble() -> str:
    """Return why no picture can be drawn in three dimensions, or "" if one can."""
    try:
        with _plotter() as plotter:
            import pyvista

            plotter.add_mesh(pyvista.Sphere())
            plotter.screenshot(None, return_img=True)
    except NotInstalledError as error:
        return str(error)
    return ""


def ffmpeg_trouble() -> str:
    """Return why no film can be written, or "" if one can."""
    try:
        import imageio_ffmpeg

        imageio_ffmpeg.get_ffmpeg_exe()
    except (ImportError, RuntimeError):
        return str(missing_extra("a film", "ffmpeg", "view"))
    return ""


@contextmanager
def _plotter() -> "Iterator[pyvista.Plotter]":
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
