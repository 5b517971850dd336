"""Spectra of a series, simulated or measured: power spectral density, and how it changes over time."""

import math
from typing import NamedTuple

import numpy as np

from nutamill.errors import CaseError, Fault

RESOLUTION = 1.0
"""Wanted distance of two lines of a spectrum [Hz]."""
SLICE = 0.5
"""Length of one spectrum of a waterfall [s]."""


class Spectrum(NamedTuple):
    """Power spectral density of a series."""

    frequency: np.ndarray
    """[Hz] (n,)."""
    density: np.ndarray
    """One-sided, unit of the series squared per Hz (n,); its integral is the variance."""


class Waterfall(NamedTuple):
    """Amplitude spectra one after the other."""

    time: np.ndarray
    """Middle of each [s] (n_slices,)."""
    frequency: np.ndarray
    """[Hz] (n,)."""
    amplitude: np.ndarray
    """Peak amplitude of a sine at that frequency, unit of the series (n, n_slices)."""


def spectrum(values: np.ndarray, rate: float) -> Spectrum:
    """Spectrum of `values` (n,) sampled at `rate` [Hz], mean of half-overlapping Hann windows, each freed of its mean.

    Windows are one second long, or a quarter of a shorter series.

    Raises
    ------
    CaseError : fewer than 32 samples

    Source
    ------
    P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967), 70-73
    """
    from scipy.signal import welch  # a second

    _enough(values)
    length = min(round(rate / RESOLUTION), max(32, len(values) // 4), len(values))
    return Spectrum(*welch(values, rate, window="hann", nperseg=length, detrend="constant"))


def waterfall(time: np.ndarray, values: np.ndarray, rate: float) -> Waterfall:
    """Amplitude spectra of half-overlapping slices of half a second, or an eighth of a shorter series, Hann windows.

    `time` [s] (n,) and `values` (n,) are evenly sampled at `rate` [Hz].  A sine of amplitude a at a line of the spectrum shows a.
    """
    from scipy.signal import ShortTimeFFT, get_window

    _enough(values)
    length = min(round(SLICE * rate), max(32, len(values) // 8))
    hop = max(1, length // 2)
    window = get_window("hann", length)
    transform = ShortTimeFFT(window, hop, rate, scale_to="magnitude", fft_mode="onesided2X")
    first = math.ceil(length / 2 / hop)
    last = 1 + (len(values) - math.ceil(length / 2)) // hop
    amplitude = np.abs(transform.stft(values - np.mean(values), p0=first, p1=max(last, first + 1)))
    return Waterfall(time[0] + transform.t(len(values), p0=first, p1=max(last, first + 1)), transform.f, amplitude)


def _enough(values: np.ndarray) -> None:
    if len(values) < 32:
        raise CaseError(
            Fault("spectrum", f"needs 32 samples, got {len(values)}", "Take a longer run, or a longer window")
        )  # fmt: skip
