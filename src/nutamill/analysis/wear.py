"""Wear of the walls in units of a workshop: depth per time of each patch, the worst places, the life of a
liner.
"""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nutamill.analysis.flow import wear_table, window, window_parts
from nutamill.analysis.source import any_case_of
from nutamill.analysis.summary import hours_text
from nutamill.analysis.windows import PAPER_WINDOW
from nutamill.base.errors import CaseError, Fault
from nutamill.base.steady import batch_half_width
from nutamill.base.units import in_unit, shown, si_value
from nutamill.case.machine import Machine
from nutamill.case.walls import WallEntry
from nutamill.result import Result

if TYPE_CHECKING:
    import xarray

SERVICE = si_value(1000.0, "h")
"""Time that tables give the depth of wear for [s]."""
LARGEST_COEFFICIENT = 1.0
"""Largest wear coefficient of Archard [1]: all that is sheared is lost."""


class Liner(NamedTuple):
    """What a wall is made of, as its wear has it."""

    hardness: float
    """Hardness, also taken for the flow pressure [Pa]."""
    coefficient: float
    """Wear coefficient of sliding after Archard [1]; 0: none."""
    cutting: float
    """Share of the impacts that cut as a sharp grain does after Finnie [1]; 0: none."""


class Wear(NamedTuple):
    """Wear of every patch of the walls, (n,) each."""

    path: str
    """The result file."""
    surface: np.ndarray
    """Name of the surface."""
    column: np.ndarray
    """Place along the azimuth, or face [1]."""
    azimuth: np.ndarray
    """Middle of the patch [rad]; not a number on a box."""
    along: np.ndarray
    """Its height or radius [m]."""
    area: np.ndarray
    """Its free area [m^2]."""
    sliding: np.ndarray
    """Depth of sliding wear per time [m/s]; 0 where there is no area."""
    cutting: np.ndarray
    """Depth that impacts cut per time [m/s]."""
    parts: np.ndarray
    """Depth of both per time in each part of the window [m/s] (n_parts, n)."""

    @property
    def depth(self) -> np.ndarray:
        """Return the depth of both per time [m/s] (n,)."""
        return self.sliding + self.cutting


class SurfaceWear(NamedTuple):
    """Wear of one surface."""

    name: str
    """The surface."""
    sliding: float
    """Mean depth of sliding wear per time [m/s]."""
    cutting: float
    """Mean depth that impacts cut per time [m/s]."""
    half_width: float
    """Of the sum of both: half of its 95 % interval [m/s]; not a number with one window of statistics."""
    worst: float
    """Depth of the worst patch per time [m/s]."""
    azimuth: float
    """Azimuth of that patch [rad]; not a number on a box."""
    along: float
    """Its height or radius [m]."""


def archard_depth(sliding_work: np.ndarray, friction: float, liner: Liner) -> np.ndarray:
    """Return the depth of sliding wear [m] under a work of friction [J/m^2]: ``K p s/H``, with the work ``mu
    p s``.

    Source: J. F. Archard, J. Appl. Phys. 24 (1953) 981-988.
    """
    return liner.coefficient * sliding_work / (friction * liner.hardness)


def finnie_depth(cutting_energy: np.ndarray, liner: Liner) -> np.ndarray:
    """Return the depth [m] that impacts cut: their energy weighed by the angle [J/m^2] over twice the flow
    pressure, times the share that cuts.

    Source: I. Finnie, Wear 3 (1960) 87-103; the weights are those of
    `nutamill.charge.kernels.impacts.cutting_energy`.
    """
    return liner.cutting * cutting_energy / (2.0 * liner.hardness)


def liner_of(hardness: float, coefficient: float = 0.0, cutting: float = 0.0) -> Liner:
    """Return a liner.

    Raises
    ------
    CaseError : a hardness that is not positive, a coefficient or a share below 0 or above 1, both 0
    """
    faults = []
    if not hardness > 0.0:
        faults.append(
            Fault("--hardness", f"must be positive, got {shown(hardness, 'GPa')}", 'Write e.g. "6 GPa"')
        )
    if not 0.0 <= coefficient <= LARGEST_COEFFICIENT:
        faults.append(
            Fault(
                "--coefficient",
                f"must be 0 to 1, got {coefficient:g}",
                "It has no unit; for dry sliding metals tables give 1e-5 to 1e-2",
            )
        )
    if not 0.0 <= cutting <= 1.0:
        faults.append(Fault("--cutting", f"must be 0 to 1, got {cutting:g}", "It is a share of the impacts"))
    if coefficient == cutting == 0.0:
        what = "needs --coefficient for wear by sliding, --cutting for wear by impacts, or both, got none"
        faults.append(Fault("wear", what, "They come from a test of liner and charge; none has a default"))
    if faults:
        raise CaseError(*faults)
    return Liner(hardness, coefficient, cutting)


def wall_wear(result: Result, liner: Liner, last: float | str = PAPER_WINDOW) -> Wear:
    """Compute the wear of every patch of the walls in the last part of a run.

    Raises
    ------
    ResultError : an empty chamber, no statistics, or only at one time
    """
    done = window(result, last)
    machine = any_case_of(result).machine
    names = done["patch_surface"].values.astype(str)
    frictions = {name: friction_at(machine, name) for name in np.unique(names)}
    friction = np.array([frictions[name] for name in names])

    def depths(part: "xarray.Dataset") -> tuple[np.ndarray, np.ndarray]:
        table = wear_table(part).fillna(0.0)
        sliding = archard_depth(table["shear_intensity"].values, 1.0, liner) / friction
        return sliding, finnie_depth(table["cutting_intensity"].values, liner)

    sliding, cutting = depths(done)
    return Wear(
        str(result.path),
        names,
        done["patch_column"].values,
        done["patch_azimuth"].values,
        done["patch_along"].values,
        done["patch_area"].values,
        sliding,
        cutting,
        np.array([sum(depths(part)) for part in window_parts(result, last)]),
    )


def friction_at(machine: Machine, surface: str) -> float:
    """Return the coefficient of sliding friction at a surface [1], the smallest of the materials of the
    charge.

    It turns a work of friction into load times sliding distance; infinite where nothing rubs.
    """
    # the longest name that fits: a wall "lid" has no part in the wall "lid_top"
    wall = max(machine.walls, key=lambda wall: _fit(wall, surface))
    pairs = [machine.contact.pair(own, wall.material) for own in machine.charge.materials]
    smallest = min(pair.sliding_friction for pair in pairs)
    return smallest if smallest > 0.0 else math.inf


def _fit(wall: WallEntry, surface: str) -> int:
    """Return the length of the name under which a surface belongs to a wall, 0 if it does not."""
    plain = wall.name.replace("_", " ")
    names = [plain] if surface == plain else []
    names += [name for name in (wall.name, plain) if surface.startswith(f"{name} ")]
    if wall.file and surface.startswith(f"{_file_name(wall.file)} patch "):
        names.append(surface)
    return max(map(len, names), default=0)


def _file_name(file: str) -> str:
    """Return the name of a mesh file without its folder."""
    return file.replace("\\", "/").rsplit("/", 1)[-1]


def by_surface(wear: Wear) -> list[SurfaceWear]:
    """Return the wear of each surface with free area, the worst first."""
    rows = []
    for name in dict.fromkeys(wear.surface):
        own = np.flatnonzero((wear.surface == name) & (wear.area > 0.0))
        if not len(own):
            continue
        weight = wear.area[own] / wear.area[own].sum()
        worst = own[np.argmax(wear.depth[own])]
        scatter = batch_half_width((wear.parts[:, own] @ weight)[:, None])
        rows.append(
            SurfaceWear(
                str(name),
                float(wear.sliding[own] @ weight),
                float(wear.cutting[own] @ weight),
                float(scatter[0]),
                float(wear.depth[worst]),
                float(wear.azimuth[worst]),
                float(wear.along[worst]),
            )
        )
    return sorted(rows, key=lambda row: -row.worst)


def life_of(thickness: float, depth: float) -> float:
    """Return the time [s] after which a `thickness` [m] is worn at a `depth` per time [m/s], infinite without
    wear.
    """
    return thickness / depth if depth > 0.0 else math.inf


def wear_lines(surfaces: list[SurfaceWear], thickness: float | None = None) -> list[str]:
    """Format the wear of the surfaces in mm per 1000 h, with the life of a `thickness` [m]."""
    rows = [
        f"{'mm per 1000 h':24} {'sliding':>9} {'cutting':>9} {'mean':>9} {'±':>8} {'worst':>9}  at"
        + (f"{'life (h)':>24}" if thickness else "")
    ]
    for one in surfaces:
        numbers = [one.sliding, one.cutting, one.sliding + one.cutting, one.half_width, one.worst]
        sliding, cutting, mean, half, worst = (in_unit(SERVICE * value, "mm") for value in numbers)
        angle = "" if math.isnan(one.azimuth) else f"{in_unit(one.azimuth, 'deg'):.0f}°, "
        place = f"{angle}{in_unit(one.along, 'mm'):.3g} mm"
        life = f" {hours_text(life_of(thickness, one.worst)):>11}" if thickness else ""
        doubt = f"{half:.2g}" if math.isfinite(half) else "-"
        rows.append(
            f"{one.name:24} {sliding:9.3g} {cutting:9.3g} {mean:9.3g} {doubt:>8} {worst:9.3g}  {place:14}"
            + life
        )
    return [row.rstrip() for row in rows]
