"""What the charge does, from a result: impact spectra, wear of the walls, fields, crest and orbit.  Without
the engines.

Definitions and frames are those of docs/conventions.md, "Statistics of the charge".
"""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nutamill.analysis.replay import particle_snapshots, rotation_of
from nutamill.analysis.windows import PAPER_WINDOW, phase_lag, steady_mean, steady_window, window_length
from nutamill.base.errors import ResultError
from nutamill.base.steady import BATCHES
from nutamill.result import Result
from nutamill.result.fields import STATISTICS, STATISTICS_AXES

if TYPE_CHECKING:
    import xarray

CREST_SHARE = 0.95
"""Share of the solid volume of a sector below the surface of the charge [1]."""
BARE = 0.5
"""Sectors with less solid volume than this share of the mean sector's are bare: a few flying particles make
no surface [1].
"""
LATER = ("pair_share",)
"""Statistics that results of earlier versions lack, and most answers can do without."""
SECTORS = 36
"""Sectors around the chamber in which a snapshot's surface is sought [1]."""


class Crest(NamedTuple):
    """The surface of a charge around its chamber."""

    height: float
    """Largest height of the surface over the chamber's floor [m]."""
    azimuth: float
    """Azimuth of the sector with that height, from the crank in the direction of rotation [rad], in [0, 2
    pi).
    """
    mean_height: float
    """Mean height of the surface [m]."""
    amplitude: float
    """Amplitude of the first harmonic of the surface around the chamber [m]."""
    phase_lag: float
    """Angle by which the first harmonic is behind the crank, about the chamber's axis [rad], in (-pi, pi]."""


class CrestHistory(NamedTuple):
    """Crests of the snapshots, (n,) each."""

    time: np.ndarray
    """Times of the snapshots [s]."""
    height: np.ndarray
    """As `Crest.height` [m]."""
    phase_lag: np.ndarray
    """As `Crest.phase_lag` [rad]."""


class Orbit(NamedTuple):
    """Path of the charge's mass centre in axes that turn with the crank, about the driveshaft's axis."""

    radius: float
    """Distance of the mean place from the driveshaft's axis [m]."""
    phase_lag: float
    """Steady mean of the angle by which the mass centre is behind the crank [rad]: that of the series
    ``charge_phase_lag`` in the table of steady means.
    """
    height: float
    """Mean height over the nutation point as assembled [m]; negative below it."""
    scatter: float
    """Root mean square distance from the mean place [m]."""


def window(result: Result, last: float | str = PAPER_WINDOW) -> "xarray.Dataset":
    """Return what the charge did in the last part of a run: differences of `Result.statistics` between two of
    its times.

    Statistics are recorded at every checkpoint; the window begins at the latest of these times that is at
    least `last` before the end, or with the first.  Attributes ``start`` and ``end`` [s] are its limits;
    ``sampled_time`` [s] is its length.

    Parameters
    ----------
    last : length of the window [s], or a text with a unit as ``"3 s"``

    Raises
    ------
    CaseError : as `window_length`
    ResultError : an empty chamber, no statistics, or only at one time
    """
    refuse_empty(result)
    length = window_length(last)
    sums = result.statistics
    needed = [field.name for field in (*STATISTICS, *STATISTICS_AXES) if field.name not in LATER]
    missing = [name for name in needed if name not in sums.variables]
    if missing:
        raise ResultError(
            f"{result.path}: lacks the statistics {', '.join(missing[:3])}. Run the case again."
        )
    time = sums["time"].values
    if len(time) < 2:
        raise ResultError(
            f"{result.path}: holds statistics at one time, two are needed. Continue it with "
            "`nutamill resume`."
        )
    first = max(0, int(np.searchsorted(time, time[-1] - length + 1e-9, side="right")) - 1)
    first = min(first, len(time) - 2)
    return (sums.isel(time=-1, drop=True) - sums.isel(time=first, drop=True)).assign_attrs(
        start=float(time[first]), end=float(time[-1])
    )


def window_parts(result: Result, last: float | str = PAPER_WINDOW) -> list["xarray.Dataset"]:
    """Return the `window` of a run in up to `BATCHES` successive parts, from whose scatter intervals are
    estimated. Raises as `window` does.
    """
    done, sums = window(result, last), result.statistics
    time = sums["time"].values
    inside = np.flatnonzero((time >= done.attrs["start"]) & (time <= done.attrs["end"]))
    ends = [int(group[-1]) for group in np.array_split(inside[1:], min(BATCHES, len(inside) - 1))]
    starts = [int(inside[0]), *ends[:-1]]
    return [
        sums.isel(time=end, drop=True) - sums.isel(time=start, drop=True)
        for start, end in zip(starts, ends, strict=True)
    ]


def refuse_empty(result: Result) -> None:
    """Raise ResultError for the run of an empty chamber."""
    if "charge_mass_centre_x" not in result.series:
        raise ResultError(
            f"{result.path}: must hold a charge, its chamber is empty. Run a case with a charge."
        )


def refuse_without_crank(result: Result) -> None:
    """Raise ResultError for a machine without a crank, with which axes turn."""
    if "crank_angle" not in result.series:
        raise ResultError(
            f"{result.path}: has no crank, with which the axes of this answer turn. Take the series "
            "charge_mass_centre_x and charge_mass_centre_y instead."
        )


def impact_spectra(done: "xarray.Dataset") -> "xarray.Dataset":
    """Return the rates of impacts by pair, part and energy: ``rate`` [1/s] and ``power`` [W] of each bin. A
    pair is one of materials, and of classes of size where a material has several.

    `done` is a `window`.  Sums over ``energy`` are totals; power over rate is the mean energy of an impact.
    The part ``loading`` counts contacts by the work that loads them; one that is pressed deeper in this
    window than before leaves its old bin, whose rate may then be negative.
    """
    rates = done[["impact_number", "impact_energy"]] / done["sampled_time"]
    return rates.rename(impact_number="rate", impact_energy="power")


def refuse_without_loading(result: Result, done: "xarray.Dataset") -> None:
    """Raise ResultError where the impacts of a `window` have no work of loading."""
    if "loading" not in done["part"].values or "pair_share" not in done.variables:
        raise ResultError(
            f"{result.path}: holds no work of loading of its contacts, as it was made by an earlier version. "
            "Run the case again."
        )


def loading_spectra(result: Result, last: float | str = PAPER_WINDOW) -> "xarray.Dataset":
    """Return how much of the work of loading the bodies of each pair take, by pair, partner (``first`` or
    ``second``) and energy: ``rate`` [1/s] and ``power`` [W] of each bin.

    Two bodies are springs in series, and share the work of a contact inversely to their stiffness:
    ``k_j/(k_i + k_j)`` to i.  The part of each counts in the bin of its own energy.

    Raises
    ------
    ResultError : as `window`; a result of an earlier version
    """
    import xarray

    done = window(result, last)
    refuse_without_loading(result, done)
    number, work = (
        done[name].sel(part="loading", drop=True).values for name in ("impact_number", "impact_energy")
    )
    share = done["pair_share"].values
    octaves = np.log2(done["energy"].values)
    rates = np.zeros((2, 2, *number.shape))
    for partner, part in enumerate((share, 1.0 - share)):
        for pair, of_pair in enumerate(part):
            bins = np.arange(number.shape[1])
            seen = number[pair] > 0.0
            mean = np.log2(of_pair * work[pair, seen] / number[pair, seen])
            place = (mean - octaves[0]) / (octaves[1] - octaves[0])
            bins[seen] = np.clip(np.rint(place), 0, len(octaves) - 1).astype(int)
            np.add.at(rates[0, partner, pair], bins, number[pair])
            np.add.at(rates[1, partner, pair], bins, of_pair * work[pair])
    names = {"pair": done["pair"].values, "partner": ["first", "second"], "energy": done["energy"].values}
    dims = ("partner", "pair", "energy")
    rates /= float(done["sampled_time"])
    return xarray.Dataset({"rate": (dims, rates[0]), "power": (dims, rates[1])}, names)


def wear_table(done: "xarray.Dataset") -> "xarray.Dataset":
    """Load and wear of every wall patch in a `window`, mean values over its free area (not a number where it
    has none).

    ``pressure`` [Pa]; ``normal_intensity``, ``shear_intensity``, ``rolling_intensity`` [W/m^2]: work taken
    out by the law; and ``cutting_intensity`` [W/m^2], energy of impacts weighed by their angle.  Depth of
    wear per time [m/s] is

    * after Archard: shear intensity over friction, times wear coefficient over hardness [1/Pa];
    * after Finnie: cutting intensity over twice the flow pressure of the wall [Pa].

    Source
    ------
    J. F. Archard, J. Appl. Phys. 24 (1953); I. Finnie, Wear 3 (1960)
    """
    area = done["patch_area"].where(done["patch_area"] > 0.0)
    names = {
        "load": "pressure",
        "normal_work": "normal_intensity",
        "shear_work": "shear_intensity",
        "rolling_work": "rolling_intensity",
        "cutting_energy": "cutting_intensity",
    }
    sums = done[[f"wall_{name}" for name in names]].rename({f"wall_{old}": new for old, new in names.items()})
    return sums / (area * done["sampled_time"])


def flow_fields(done: "xarray.Dataset") -> "xarray.Dataset":
    """Return the mean fields of a `window` in the grid that turns with the crank, over radius, azimuth and
    height.

    ``solids_fraction`` [1]; ``velocity_r``, ``velocity_a``, ``velocity_z`` [m/s], means over mass relative to
    the chamber; ``granular_temperature`` [m^2/s^2], a third of the variance of that velocity;
    ``coordination`` [1].  Where no particle came they are not a number.
    """
    import xarray

    mass = done["cell_mass"].where(done["cell_mass"] > 0.0)
    velocity = {f"velocity_{axis}": done[f"cell_momentum_{axis}"] / mass for axis in "raz"}
    square = sum(component**2 for component in velocity.values())
    return xarray.Dataset(
        {
            "solids_fraction": done["cell_solid_volume"] / (done["cell_volume"] * done["sampled_time"]),
            **velocity,
            "granular_temperature": (done["cell_square_speed"] / mass - square) / 3.0,
            "coordination": done["cell_neighbours"]
            / done["cell_particles"].where(done["cell_particles"] > 0.0),
        }
    )


def surface_heights(done: "xarray.Dataset", share: float = CREST_SHARE) -> np.ndarray:
    """Compute the height of the surface over the floor in each sector of a `window`'s grid [m], (n_azimuth,).

    A share `share` of the sector's solid volume is below it.  The height is 0 where the sector is `BARE`.
    """
    volume = done["cell_solid_volume"].sum("radius").transpose("azimuth", "height").values
    middle = done["height"].values
    step = middle[1] - middle[0]
    edges = np.concatenate([middle - 0.5 * step, middle[-1:] + 0.5 * step])
    below = np.concatenate([np.zeros((len(volume), 1)), np.cumsum(volume, axis=1)], axis=1)
    least = BARE * below[:, -1].mean()
    return np.array(
        [np.interp(share * column[-1], column, edges) if column[-1] > least else 0.0 for column in below]
    )


def crest(heights: np.ndarray, azimuth: np.ndarray) -> Crest:
    """Return the crest and the phase lag of a surface.

    The lag is that of the first harmonic of the height around the chamber, so that a ragged crest does not
    move it.

    Parameters
    ----------
    heights : [m] (n,), of equal sectors all around
    azimuth : middles of the sectors [rad] (n,), from the crank in the direction of rotation

    Source
    ------
    C. van Tonder, D. Bredell, C. J. Coetzee and P. Branehog, J. S. Afr. Inst. Min. Metall. 125 (2025), figure
    10 (crest height and phase lag seen through the wall of the chamber)
    """
    harmonic = complex(2.0 * np.mean(heights * np.exp(1j * azimuth)))
    top = int(np.argmax(heights))
    lag = math.pi - (math.pi + math.atan2(harmonic.imag, harmonic.real)) % math.tau
    return Crest(float(heights[top]), float(azimuth[top]), float(np.mean(heights)), abs(harmonic), lag)


def snapshot_heights(
    snapshot: dict, crank_angle: float, share: float = CREST_SHARE, sectors: int = SECTORS
) -> np.ndarray:
    """Return the heights [m] (sectors,) of the surface in one snapshot (`Result.snapshots`) at a crank angle
    [rad], as `surface_heights` does.

    Each particle's volume is put at the eight points that have its second moments.
    """
    rotation = rotation_of(snapshot["chamber_attitude"])
    radii = np.asarray(snapshot["radii"], float)
    corners = np.stack(np.meshgrid(*([[-1.0, 1.0]] * 3)), axis=-1).reshape(8, 3) / math.sqrt(5.0)
    places = (np.asarray(snapshot["positions"], float) - snapshot["chamber_floor"]) @ rotation
    points = (places[:, None, :] + radii[:, None, None] * corners).reshape(-1, 3)
    volume = np.repeat(radii**3, 8)
    turns = (np.arctan2(points[:, 1], points[:, 0]) - crank_angle) / math.tau
    sector = np.minimum((np.mod(turns, 1.0) * sectors).astype(int), sectors - 1)
    held = np.bincount(sector, volume, sectors)
    heights = np.zeros(sectors)
    for k in np.flatnonzero(held > BARE * held.mean()):
        inside = np.flatnonzero(sector == k)
        order = inside[np.argsort(points[inside, 2])]
        below = np.cumsum(volume[order]) - 0.5 * volume[order]
        heights[k] = np.interp(share * held[k], below, points[order, 2])
    return heights


def crest_history(result: Result) -> CrestHistory:
    """Return the crest height and phase lag of every snapshot that holds particles.

    Raises
    ------
    ResultError : no snapshots of particles, or a machine without a crank
    """
    refuse_without_crank(result)
    snapshots, angles = particle_snapshots(result)
    azimuth = (np.arange(SECTORS) + 0.5) * math.tau / SECTORS
    crests = [
        crest(snapshot_heights(snapshot, angle), azimuth)
        for snapshot, angle in zip(snapshots, angles, strict=True)
    ]
    return CrestHistory(
        snapshots.time, np.array([c.height for c in crests]), np.array([c.phase_lag for c in crests])
    )


def mass_centre_orbit(result: Result, last: float | str = PAPER_WINDOW) -> Orbit:
    """Return the mean position of the charge's mass centre over the whole turns of the steady window, in axes
    that turn with the crank.

    Raises ResultError for an empty chamber, a machine without a crank, and as `steady_window`.
    """
    refuse_empty(result)
    refuse_without_crank(result)
    turns = steady_window(result, last).turns
    series = result.series
    inside = (series["time"].values >= turns[0]) & (series["time"].values <= turns[-1])
    x, y, z = (series[f"charge_mass_centre_{axis}"].values[inside] for axis in "xyz")
    place = (x + 1j * y) * np.exp(-1j * series["crank_angle"].values[inside])
    mean = complex(place.mean())
    scatter = math.sqrt(float(np.mean(np.abs(place - mean) ** 2 + (z - z.mean()) ** 2)))
    return Orbit(abs(mean), steady_mean(result, phase_lag(result), last=last).mean, float(z.mean()), scatter)
