"""Order tracking: amplitude and phase of what repeats once, twice, ... per turn of the driveshaft, and
spectra over a run-up.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.signal import ShortTimeFFT, oaconvolve
from scipy.signal.windows import hann

from nutamill.analysis.source import any_case_of
from nutamill.analysis.windows import turn_series
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.library import similar
from nutamill.base.units import in_unit, rpm
from nutamill.case.machine import drive_series
from nutamill.result import Result
from nutamill.result.fields import Field

PER_TURN = 128
"""Samples per turn after resampling over the crank angle [1]: orders up to 16 with 8 samples each."""
TURNS = 4
"""Turns in the window of an order [1]; half of them count, by its Hann shape."""


class Orders(NamedTuple):
    """Orders of a signal over the run."""

    time: np.ndarray
    """Middles of the windows [s], (n,)."""
    speed: np.ndarray
    """Driveshaft speed there [rad/s], (n,)."""
    orders: tuple[float, ...]
    """Repetitions per turn [1]."""
    amplitude: np.ndarray
    """Amplitudes, unit of the signal, (n_orders, n)."""
    lag: np.ndarray
    """Angle by which the maximum comes after that of ``cos(order x crank angle)`` [rad], (n_orders, n), in
    (-pi, pi].
    """


class Peak(NamedTuple):
    """The largest amplitude of an order on the way through a run-up."""

    order: float
    """Repetitions per turn [1]."""
    speed: float
    """Driveshaft speed at the peak [rad/s]."""
    time: float
    """When [s]."""
    amplitude: float
    """Amplitude, unit of the signal."""
    lag: float
    """Lag there [rad]."""


class Waterfall(NamedTuple):
    """Spectra of a signal over the run."""

    time: np.ndarray
    """Middles of the windows [s], (n,)."""
    speed: np.ndarray
    """Driveshaft speed there [rad/s], (n,)."""
    frequency: np.ndarray
    """Frequencies [Hz], (m,)."""
    amplitude: np.ndarray
    """Amplitude of a sine of each frequency, unit of the signal, (m, n)."""


def track(
    time: np.ndarray,
    angle: np.ndarray,
    value: np.ndarray,
    orders: Sequence[float] = (1.0, 2.0),
    turns: int = TURNS,
) -> Orders:
    """Return the track orders of a signal, by resampling over the angle and a Hann window of whole turns.

    The signal ``A cos(order angle - lag)`` of any steady A gives A and lag exactly, whatever the speed does;
    other whole orders at least ``2/turns`` away do not show.

    Parameters
    ----------
    time, angle, value : samples [s], [rad], unit of the signal, (n,); the angle must rise
    orders : repetitions per turn [1]
    turns : length of the window [1]

    Raises
    ------
    ResultError : fewer turns than the window has, or no samples

    Source
    ------
    Fyfe and Munck, Mechanical Systems and Signal Processing 11(2), 187-205, 1997 (computed order tracking)
    """
    if not len(time):
        raise ResultError("orders: the record is empty. Run longer")
    moving = np.concatenate(([True], np.diff(angle) > 0.0))
    time, angle, value = time[moving], angle[moving], value[moving]
    step, length = 2.0 * np.pi / PER_TURN, turns * PER_TURN
    even = np.arange(np.ceil(angle[0] / step), np.floor(angle[-1] / step) + 1.0) * step
    if len(even) <= length:
        made = (angle[-1] - angle[0]) / (2.0 * np.pi)
        raise ResultError(f"orders: must have {turns} turns of the drive, got {made:.3g}. Run longer")
    at, signal = np.interp(even, angle, time), np.interp(even, angle, value)
    window = hann(length, sym=False)
    window /= window.sum()
    parts = [2.0 * oaconvolve(signal * np.exp(-1j * order * even), window, mode="valid") for order in orders]
    # a window of `length` samples is centred between two: `length / 2` samples after its first
    middle = slice(length // 2, length // 2 + len(parts[0]))
    phasors = np.array(parts)[:, :: PER_TURN // 8]
    speed = np.gradient(even, at)[middle][:: PER_TURN // 8]
    return Orders(at[middle][:: PER_TURN // 8], speed, tuple(orders), np.abs(phasors), -np.angle(phasors))


def sensor_orders(
    result: Result,
    name: str,
    orders: Sequence[float] = (1.0, 2.0),
    turns: int = TURNS,
    drive: str | None = None,
) -> Orders:
    """Return the track orders of a recorded series over the turns of a drive, as `track`.

    Parameters
    ----------
    drive : name of the drive; that of the period of the case, or its only drive, if None

    Raises
    ------
    CaseError : no such series or drive
    ResultError : nothing that turns, or fewer turns than the window has
    """
    value, angle = recorded(result, name), result.series[drive_angle(result, drive)].values
    return track(result.series["time"].values, angle, value, orders, turns)


def drive_angle(result: Result, drive: str | None = None) -> str:
    """Return the series with the angle of a drive. None is that of the period of the case, or its only one.

    Raises
    ------
    CaseError : no such drive
    ResultError : no drive whose angle is recorded, or several
    """
    if drive is None and (turning := turn_series(result)) is not None:
        return turning
    machine = any_case_of(result).machine if result.case_text else None
    names: list[str] = []
    if machine is not None:
        names = [entry.name for entry in machine.drives]
        names += [entry.name for entry in machine.unbalance_motors]
    angles = {name: drive_series(machine, name, "angle") for name in names if machine is not None}
    angles = {name: angle for name, angle in angles.items() if angle in result.series}
    if drive is not None:
        if drive not in angles:
            raise CaseError(Fault("--drive", f'no drive is called "{drive}"', similar(drive, list(angles))))
        return angles[drive]
    if not angles:
        raise ResultError(
            f"{result.path}: orders are repetitions per turn, and no drive of this machine turns. "
            "`nutamill plot` draws the spectrum of a series."
        )
    if len(angles) > 1:
        raise ResultError(
            f"{result.path}: several drives turn: {', '.join(angles)}. Choose one with --drive NAME."
        )
    return next(iter(angles.values()))


def default_series(result: Result, drive: str | None = None) -> str:
    """Return the series whose orders are asked for most: the crank-pin force, else the torque of the drive.
    Raises as `drive_angle`.
    """
    if "crank_pin_force_resultant" in result.series:
        return "crank_pin_force_resultant"
    torque = drive_angle(result, drive).removesuffix("_angle") + "_torque"
    torques = [name for name in map(str, result.series.data_vars) if name.endswith("_torque")]
    return torque if torque in torques or not torques else torques[0]


def recorded(result: Result, name: str) -> np.ndarray:
    """Return the samples of a series (n,). Raises CaseError where the result has none of this name."""
    result.field(name)
    return result.series[name].values


def peaks(history: Orders) -> list[Peak]:
    """Return the largest amplitude of each order."""
    at = history.amplitude.argmax(axis=1)
    return [
        Peak(
            order,
            float(history.speed[k]),
            float(history.time[k]),
            float(history.amplitude[n, k]),
            float(history.lag[n, k]),
        )
        for n, (order, k) in enumerate(zip(history.orders, at, strict=True))
    ]


def waterfall(result: Result, name: str, window: float = 1.0, drive: str | None = None) -> Waterfall:
    """Compute amplitude spectra of a recorded series over time.  The Hann window is `window` seconds long, a
    third of a short record, and moves by a quarter of it.  The mean in each window is left out: it would hide
    what is near it.  `drive` is as for `sensor_orders`.
    """
    window = min(window, result.reached / 3.0)
    angle = result.series[drive_angle(result, drive)].values
    return spectra(result.series["time"].values, angle, recorded(result, name), window)


def spectra(time: np.ndarray, angle: np.ndarray, value: np.ndarray, window: float = 1.0) -> Waterfall:
    """Compute amplitude spectra over time, as `waterfall`."""
    rate = (len(time) - 1) / (time[-1] - time[0])
    length = min(round(window * rate), len(time))
    transform = ShortTimeFFT(
        hann(length, sym=False), max(length // 4, 1), rate, scale_to="magnitude", fft_mode="onesided2X"
    )
    first, end = transform.lower_border_end[1], transform.upper_border_begin(len(value))[1]
    amplitude = np.abs(transform.stft_detrend(value, "constant", p0=first, p1=max(end, first + 1)))
    at = time[0] + transform.delta_t * np.arange(first, first + amplitude.shape[1])
    speed = np.interp(at, time, np.gradient(angle, time))
    return Waterfall(at, speed, transform.f, amplitude)


def orders_lines(history: Orders, field: Field) -> list[str]:
    """Format the peaks of the orders of a series, and the orders at the end, as a table."""
    rows = [
        f"{field.label} ({field.unit})",
        f"{'order':>5} {'peak':>10} {'at rpm':>8} {'t (s)':>7} {'lag':>8} {'at the end':>11} {'lag':>8}",
    ]
    for n, peak in enumerate(peaks(history)):
        end, lag = history.amplitude[n, -1], in_unit(history.lag[n, -1], "deg")
        rows.append(
            f"{peak.order:4.3g}x {peak.amplitude:10.4g} {rpm(peak.speed):8.1f} {peak.time:7.2f}"
            f" {in_unit(peak.lag, 'deg'):6.1f} ° {end:11.4g} {lag:6.1f} °"
        )
    return rows
