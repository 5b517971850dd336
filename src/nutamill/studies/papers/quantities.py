"""What is compared: each quantity of the papers by name, and the function that takes it from a result."""

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from nutamill.analysis.flow import crest, surface_heights, window
from nutamill.analysis.power import power_split
from nutamill.analysis.source import case_of, vector
from nutamill.analysis.windows import ramp_end, steady_mean, steady_window
from nutamill.base.errors import ResultError
from nutamill.base.steady import Estimate
from nutamill.base.units import Kind
from nutamill.result import Result
from nutamill.studies.papers import body, drum

MODES = "natural_frequency"
"""The one quantity that comes from the modes of the machine and not from a run."""


class Observable(NamedTuple):
    """One thing that can be compared."""

    label: str
    """A few words, for tables and axes."""
    kind: Kind | None
    """Kind of its unit; None for a plain number."""
    measure: Callable[..., Estimate] | None
    """Takes it from a result, averaged over the last seconds given, and where it needs one at a place or time
    in SI; None if it comes from the modes.
    """
    at: Kind | None = None
    """Kind of the place or time that it needs; None if it needs none."""


class PinForce(NamedTuple):
    """Force of the crank in the turning axes of the driveshaft, over time [N] (n,)."""

    radial: np.ndarray
    """Towards the driveshaft's axis."""
    tangential: np.ndarray
    """In the direction of rotation."""


def charge_at_pin(result: Result) -> PinForce:
    """Compute the force with which the crank balances the charge's wrench on a chamber without mass.

    The universal joint carries a force at the nutation point and the torsion about the chamber's axis, the
    crank pin a force across that axis.  With the chamber's axis `a` from the nutation point to the pin, at
    distances L01 down and L12 out, and the charge's moment M about the nutation point, moments across the
    axis give ``F_r = -M_t/L01`` and ``F_t = -(L01 M_r + L12 M_z)/(L01^2 + L12^2)``.  The second makes
    ``L12 F_t`` the torque that the charge asks of the driveshaft.

    Axes are those of a frame at rest: on soft mounts its rocking of some milliradians is left out.

    Raises
    ------
    ResultError : the run had no charge

    Source
    ------
    van Tonder, Bredell, Coetzee and Branehog, J. S. Afr. Inst. Min. Metall. 125, 2025, figure 8 (free body of
    the chamber)
    """
    series = result.series
    if "charge_moment_x" not in series:
        raise ResultError(f"{result.path}: has no charge. Run a configuration with a charge.")
    drawn = case_of(result).mechanism
    down, out = drawn.nutation_point_to_crank, drawn.crank_radius
    x, y, z = vector(series, "charge_moment").T
    angle = series["crank_angle"].values
    outward, along = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
    return PinForce(-along / down, -(down * outward + out * z) / (down**2 + out**2))


def superposed(result: Result) -> PinForce:
    """Compute the load-cell force of the mill without the charge's answer, gravity's share off, plus the
    charge's force at the pin.

    Of a run with a prescribed motion: the mechanism then moves as if it were empty, and the charge is moved
    by it.

    Raises
    ------
    ResultError : the charge acted on the mechanism
    """
    _of_prescribed(result)
    series, charge = result.series, charge_at_pin(result)
    radial, tangential = (series[f"crank_pin_force_{part}_tared"].values for part in ("radial", "tangential"))
    return PinForce(radial + charge.radial, tangential + charge.tangential)


def _of_prescribed(result: Result) -> None:
    if case_of(result).run.coupling != "prescribed":
        raise ResultError(
            f"{result.path}: cannot be superposed, because its charge acted on the mill. Run it with "
            'run.coupling = "prescribed".'
        )


def _series(name: str) -> Callable[[Result, float], Estimate]:
    """Return a reader of the steady mean of a recorded series."""

    def measure(result: Result, last: float) -> Estimate:
        return steady_mean(result, name, last=last)

    return measure


def _part(force: Callable[[Result], PinForce], part: str) -> Callable[[Result, float], Estimate]:
    """Return a reader of the steady mean of the radial or tangential part of a force, or of its magnitude."""

    def measure(result: Result, last: float) -> Estimate:
        radial, tangential = force(result)
        value = {"radial": radial, "tangential": tangential, "resultant": np.hypot(radial, tangential)}[part]
        return steady_mean(result, value, last=last)

    return measure


def _charge_lag(result: Result, last: float) -> Estimate:
    """Compute the angle by which the charge's force on the pin is behind the radial direction [rad], from the
    means of its two parts.
    """
    radial, tangential = (steady_mean(result, part, last=last) for part in charge_at_pin(result))
    square = radial.mean**2 + tangential.mean**2
    half_width = math.hypot(radial.mean * tangential.half_width, tangential.mean * radial.half_width) / square
    plain_mean = math.atan2(tangential.plain_mean, radial.plain_mean)
    steady = radial.steady and tangential.steady
    return Estimate(
        math.atan2(tangential.mean, radial.mean),
        half_width,
        plain_mean,
        min(radial.turns, tangential.turns),
        steady,
    )


def _crank_radius(result: Result) -> float:
    return case_of(result).mechanism.crank_radius


def _charge_torque(result: Result, last: float) -> Estimate:
    """Compute the torque that the charge's wrench asks of the driveshaft [N m]."""
    return steady_mean(result, _crank_radius(result) * charge_at_pin(result).tangential, last=last)


def _superposed_torque(result: Result, last: float) -> Estimate:
    """Compute the torque of the mill without the charge's answer plus that of the charge [N m]."""
    _of_prescribed(result)
    torque = (
        result.series["driveshaft_torque"].values + _crank_radius(result) * charge_at_pin(result).tangential
    )
    return steady_mean(result, torque, last=last)


def _unbalance(result: Result, last: float) -> Estimate:
    """Compute the radial force over the square of the speed [kg m]."""
    force = _series("crank_pin_force_radial_tared")(result, last)
    square = float(result.series["driveshaft_speed"].values[-1]) ** 2
    return force._replace(
        mean=force.mean / square, half_width=force.half_width / square, plain_mean=force.plain_mean / square
    )


def _sensor(result: Result, axis: str) -> np.ndarray:
    """Return the acceleration of the first sensor along an axis of its body [m/s^2]."""
    name = next(
        (name for name in map(str, result.series.data_vars) if name.endswith(f"_acceleration_{axis}")), None
    )
    if name is None:
        raise ResultError(
            f"{result.path}: has no acceleration of a sensor. Add to the case a [sensors] table."
        )
    return result.series[name].values


def _amplitude(axis: str) -> Callable[[Result, float], Estimate]:
    """Return a reader of half the range of the first sensor's acceleration within a turn, mean over the
    steady turns [m/s^2].
    """

    def measure(result: Result, last: float) -> Estimate:
        return steady_mean(result, _sensor(result, axis), "swing", last)

    return measure


class Sway(NamedTuple):
    """The turn of a ramp in which the frame sways most, by the standard deviation of the first mount's
    horizontal travel.
    """

    begin: float
    """Its beginning [s]."""
    end: float
    """Its end [s]."""
    travel: float
    """Half of the mount's largest less its smallest horizontal travel along x in that turn [m]."""


def _largest_sway(result: Result) -> Sway:
    series, end = result.series, ramp_end(result)
    if "mount_1_travel_x" not in series:
        raise ResultError(f"{result.path}: has rigid mounts and passes no resonance. Run it on soft mounts.")
    time, angle = series["time"].values, series["crank_angle"].values
    cuts = np.flatnonzero(np.diff(np.floor(angle[time <= end] / math.tau)))
    if len(cuts) < 2:
        raise ResultError(f"{result.path}: has fewer than two turns of a ramp. Run it with drive.ramp.")
    turns = list(itertools.pairwise(cuts))
    travel = series["mount_1_travel_x"].values
    first, stop = turns[int(np.argmax([travel[first:stop].std() for first, stop in turns]))]
    return Sway(float(time[first]), float(time[stop]), 0.5 * float(np.ptp(travel[first:stop])))


def _resonance_time(result: Result, last: float) -> Estimate:
    """Return the time on the ramp at which the frame sways most [s]. `last` is not used: the largest sway
    comes before the steady running.
    """
    sway = _largest_sway(result)
    middle = 0.5 * (sway.begin + sway.end)
    return Estimate(middle, 0.5 * (sway.end - sway.begin), middle, 1, True)


def _resonance_travel(result: Result, last: float) -> Estimate:
    """Return how far the first mount sways at the resonance [m]. `last` is not used."""
    return Estimate.exact(_largest_sway(result).travel)


def _crest_of(part: str) -> Callable[[Result, float], Estimate]:
    """Return a reader of height [m] or phase lag [rad] of the crest of the charge's mean surface, from the
    statistics of the last seconds.
    """

    def measure(result: Result, last: float) -> Estimate:
        done = window(result, last)
        value = getattr(crest(surface_heights(done), done["azimuth"].values), part)
        return Estimate.exact(value)

    return measure


def _ledger_gap(result: Result, last: float) -> Estimate:
    """Return the share of the motor's power that the power ledger leaves open over the steady turns [1]."""
    power = power_split(result, last)
    return Estimate.exact(power.residual / power.motor)


def _momentum_gap(result: Result, last: float) -> Estimate:
    """Return the momentum that the balance of the charge leaves open, over what its weight and the chamber
    gave it in the steady turns [1].
    """
    series = result.series
    if "interface_impulse_defect" not in series:
        raise ResultError(f"{result.path}: has no charge. Run a configuration with a charge.")
    turns = steady_window(result, last).turns
    time = series["time"].values
    force = np.linalg.norm(vector(series, "charge_force"), axis=1)
    given = steady_mean(result, force, last=last).mean * (turns[-1] - turns[0])
    first, end = np.interp(turns[[0, -1]], time, series["interface_impulse_defect"].values)
    return Estimate.exact(float((end - first) / given))


QUANTITIES: dict[str, Observable] = {
    "force": Observable("crank-pin force", Kind.FORCE, _series("crank_pin_force_resultant_tared")),
    "force_raw": Observable("crank-pin force with gravity", Kind.FORCE, _series("crank_pin_force_resultant")),
    "radial": Observable("radial crank-pin force", Kind.FORCE, _series("crank_pin_force_radial_tared")),
    "radial_raw": Observable(
        "radial crank-pin force with gravity", Kind.FORCE, _series("crank_pin_force_radial")
    ),
    "tangential": Observable(
        "tangential crank-pin force", Kind.FORCE, _series("crank_pin_force_tangential_tared")
    ),
    "torque": Observable("driveshaft torque", Kind.TORQUE, _series("driveshaft_torque")),
    "unbalance": Observable("radial force over speed squared", Kind.UNBALANCE, _unbalance),
    "charge_radial": Observable(
        "radial crank-pin force of the charge", Kind.FORCE, _part(charge_at_pin, "radial")
    ),
    "charge_tangential": Observable(
        "tangential crank-pin force of the charge", Kind.FORCE, _part(charge_at_pin, "tangential")
    ),
    "charge_resultant": Observable(
        "crank-pin force of the charge", Kind.FORCE, _part(charge_at_pin, "resultant")
    ),
    "charge_torque": Observable("driveshaft torque of the charge", Kind.TORQUE, _charge_torque),
    "charge_lag": Observable("lag of the charge's force", Kind.ANGLE, _charge_lag),
    "superposed_force": Observable(
        "crank-pin force, empty plus charge", Kind.FORCE, _part(superposed, "resultant")
    ),
    "superposed_torque": Observable("driveshaft torque, empty plus charge", Kind.TORQUE, _superposed_torque),
    "crest_height": Observable("crest height of the charge", Kind.LENGTH, _crest_of("height")),
    "crest_lag": Observable("phase lag of the crest", Kind.ANGLE, _crest_of("phase_lag")),
    MODES: Observable("lowest natural frequency", Kind.FREQUENCY, None),
    "resonance_time": Observable("time of the largest sway on the ramp", Kind.TIME, _resonance_time),
    "resonance_travel": Observable("largest sway of a mount on the ramp", Kind.LENGTH, _resonance_travel),
    "acceleration_horizontal": Observable(
        "horizontal frame acceleration", Kind.ACCELERATION, _amplitude("x")
    ),
    "acceleration_vertical": Observable("vertical frame acceleration", Kind.ACCELERATION, _amplitude("z")),
    "ledger_gap": Observable("power the ledger leaves open", None, _ledger_gap),
    "momentum_gap": Observable("momentum the charge's balance leaves open", None, _momentum_gap),
    "amplitude": Observable("amplitude, half the range", Kind.LENGTH, body.amplitude),
    "height": Observable("height", Kind.LENGTH, body.height, Kind.TIME),
    "upward_speed": Observable("upward speed, mean of 2 ms", Kind.VELOCITY, body.upward_speed, Kind.TIME),
    "lowest_height": Observable("lowest height", Kind.LENGTH, body.lowest_height),
    "time_of_lowest": Observable("time of the lowest height", Kind.TIME, body.time_of_lowest),
    "rebound_speed": Observable("largest upward speed after it", Kind.VELOCITY, body.rebound_speed),
    "drive_power": Observable("power of the drive", Kind.POWER, body.drive_power),
    "bed_angle": Observable("angle of the bed's surface", Kind.ANGLE, drum.bed_angle),
    "bed_speed": Observable("speed along the surface", Kind.VELOCITY, drum.bed_speed, Kind.LENGTH),
    "still_depth": Observable("place across the bed that stands still", Kind.LENGTH, drum.still_depth),
}
"""Every quantity a row may name."""
