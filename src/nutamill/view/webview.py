"""One HTML file in which the mill turns: no server, no network, opens in any browser with WebGL 2.

The page is `data/pages/viewer.html` with `data/pages/viewer.js`; here it is filled.  Positions are whole
numbers of 16 bits in chamber axes, written as differences from frame to frame and deflated: 200 frames of
2618 pellets are about 4 MB.
"""

import base64
import html
import json
import math
import zlib
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from string import Template

import numpy as np

from nutamill.analysis.replay import Frame, chosen_snapshots, replay
from nutamill.analysis.source import any_case_of
from nutamill.analysis.traces import thinned, traced
from nutamill.base.atomic_file import PAGES, check_writable, write_whole
from nutamill.result import Result
from nutamill.view.cameras import Camera
from nutamill.view.drawing import Part
from nutamill.view.drawn import drawn

MOST_FRAMES = 200
"""Frames in a page by default [1]."""
STEEPEST = 1.57
"""Largest elevation of a camera of the page [rad]; exactly above its target it has no upward direction."""
COLOURS = ("#0072B2", "#D55E00")
"""Colours of the two traces."""


def write_view(result: Result, path: str | Path, frames: int = MOST_FRAMES) -> Path:
    """Write the page of a result, and return its path.

    Parameters
    ----------
    result : an opened result with snapshots
    path : the HTML file, replaced if it exists
    frames : most snapshots to show [1]; of more, evenly spaced ones are taken

    Raises
    ------
    ResultError : no snapshots, or the file cannot be written
    """
    check_writable(Path(path), PAGES)
    return write_whole(path, view_page(result, frames))


def view_page(result: Result, frames: int = MOST_FRAMES) -> str:
    """Return the page as text. Parameters and errors are those of `write_view`."""
    chosen = chosen_snapshots(result, frames)
    moments = list(replay(result, chosen))
    case = any_case_of(result)
    machine = drawn(case, 0.75 * math.pi, result.walls)
    packed, scales = _packed(moments, _forces(result, chosen))
    radii = moments[0].radii
    materials = np.asarray(result.snapshots[chosen[0]].get("materials", np.empty(0)), np.uint8)
    facts = {
        "frames": len(moments),
        "particles": len(moments[0].radii),
        "times": [round(moment.time, 7) for moment in moments],
        "bodies": _moves(moments),
        "parts": [_part(part) for part in machine.parts],
        "radii": _coded(radii.astype("<f4")),
        "sizes": [2.0 * float(radii.min()), 2.0 * float(radii.max())] if len(radii) else [0.0, 0.0],
        "material": _coded(materials),
        "materials": list(case.charge.materials) if len(materials) else [],
        "views": {view: _view(camera) for view, camera in machine.cameras.items()},
        "reach": machine.reach,
        "home": moments[0].home,
        "heights": [machine.floor, _highest(moments) - machine.floor],
        **scales,
        **_traces(result),
    }
    pages = resources.files("nutamill") / "data" / "pages"
    return Template((pages / "viewer.html").read_text(encoding="utf-8")).substitute(
        title=html.escape(case.title or result.path.stem),
        packed=packed,
        # no "<" within a script: "</script>" would end it, and "<!--<script>" would swallow the rest of the
        # page
        facts=json.dumps(facts, separators=(",", ":")).replace("<", "\\u003c"),
        script=(pages / "viewer.js").read_text(encoding="utf-8"),
    )


def _coded(array: np.ndarray | bytes) -> str:
    """Return bytes as base64 text."""
    return base64.b64encode(array if isinstance(array, bytes) else array.tobytes()).decode("ascii")


def _forces(result: Result, chosen: Sequence[int]) -> np.ndarray | None:
    """Return the contact forces of the particles in the chosen snapshots [N] (frames, n), or None where they
    are not recorded.
    """
    forces = [result.snapshots[number].get("contact_forces") for number in chosen]
    known = [np.asarray(force, float) for force in forces if force is not None]
    return np.stack(known) if len(known) == len(forces) and known[0].size else None


def _packed(moments: list[Frame], forces: np.ndarray | None) -> tuple[str, dict]:
    """Return positions in chamber axes, speeds and forces of all frames, deflated, and what turns them back
    into m, m/s and N.
    """
    places = np.stack([moment.at_home() for moment in moments])
    speeds = np.stack([np.linalg.norm(moment.velocities, axis=1) for moment in moments])
    none = places.size == 0
    low = np.zeros(3) if none else places.min(axis=(0, 1))
    span = np.ones(3) if none else np.maximum(places.max(axis=(0, 1)) - low, 1e-9)
    fastest = 1.0 if none else _end(speeds)
    strongest = 0.0 if forces is None else _end(forces)
    whole = np.round((places - low) / span * 65535.0).astype(np.uint16)
    scaled = [(speeds, fastest)] + ([] if forces is None else [(forces, strongest)])
    rates = [np.round(np.minimum(values / end, 1.0) * 255.0).astype(np.uint8) for values, end in scaled]
    change = np.diff(whole, axis=0, prepend=np.zeros_like(whole[:1])).reshape(len(moments), -1)
    changes = [np.diff(one, axis=0, prepend=np.zeros_like(one[:1])) for one in rates]
    rows = np.concatenate([(change >> 8).astype(np.uint8), (change & 255).astype(np.uint8), *changes], axis=1)
    return _coded(zlib.compress(rows.tobytes(), 9)), {
        "low": low.tolist(),
        "span": span.tolist(),
        "speed": fastest,
        "force": strongest,
    }


def _end(values: np.ndarray) -> float:
    """Return the upper end of a colour bar: one particle that flies must not darken all others."""
    return max(float(np.quantile(values, 0.999)), 1e-9)


def _moves(moments: list[Frame]) -> dict[str, list[list[float]]]:
    """Return origin [m] and quaternion (w, x, y, z) of each body in each frame, without jumps of sign."""
    from scipy.spatial.transform import Rotation  # a third of a second

    moves = {}
    for body in moments[0].bodies:
        turns = Rotation.from_matrix(
            np.stack([moment.bodies[body].rotation for moment in moments])
        ).as_quat()[:, [3, 0, 1, 2]]
        flips = np.cumprod(np.where(np.sum(turns[1:] * turns[:-1], axis=1) < 0.0, -1.0, 1.0))
        turns[1:] *= flips[:, None]
        origins = np.stack([moment.bodies[body].origin for moment in moments])
        moves[body] = np.round(np.concatenate([origins, turns], axis=1), 6).tolist()
    return moves


def _part(part: Part) -> dict:
    """Return a part of the machine as the page reads it."""
    return {
        "name": part.name,
        "body": part.body,
        "colour": part.colour,
        "opacity": part.opacity,
        "vertices": _coded(part.vertices.astype("<f4")),
        "triangles": _coded(part.triangles.astype("<u2")),
    }


def _view(camera: Camera) -> dict:
    """Return a camera as the page reads it: its target, and its position about the target as angles."""
    return {
        "rides": camera.rides,
        "hides": list(camera.hides),
        "angle": camera.angle,
        "azimuth": camera.azimuth,
        "height": min(camera.elevation, STEEPEST),
        "distance": camera.distance,
        "target": camera.target.tolist(),
    }


def _highest(moments: list[Frame]) -> float:
    """Return the largest height of a particle [m]."""
    places = [float(moment.at_home()[:, 2].max()) for moment in moments if len(moment.positions)]
    return max(places, default=0.0)


def _traces(result: Result) -> dict:
    """Return the traces over the whole run, thinned to what a screen shows."""
    names = traced(result)
    time, series = result.series["time"].values, [result.series[name].values for name in names]
    shown = thinned(len(time), series)
    traces = []
    for name, values, colour in zip(names, series, COLOURS, strict=False):
        field = result.field(name)
        numbers = [float(f"{value:.5g}") for value in values[shown]]
        traces.append({"label": f"{field.label} ({field.unit})", "colour": colour, "values": numbers})
    return {"traceTimes": np.round(time[shown], 6).tolist(), "traces": traces}
