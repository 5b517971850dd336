"""Spectrum of a series, simulated or measured."""

from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault

RESOLUTION = 1.0
"""Wanted distance of two lines of a spectrum [Hz]."""


class Spectrum(NamedTuple):
    """Power spectral density of a series."""

    frequency: np.ndarray
    """[Hz] (n,)."""
    density: np.ndarray
    """One-sided, unit of the series squared per Hz (n,); its integral is the variance."""


def spectrum(values: np.ndarray, rate: float) -> Spectrum:
    """Compute the spectrum of `values` (n,) sampled at `rate` [Hz], the mean of half-overlapping Hann
    windows, each freed of its mean.

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


def _enough(values: np.ndarray) -> None:
    if len(values) < 32:
        raise CaseError(
            Fault("spectrum", f"needs 32 samples, got {len(values)}", "Take a longer run, or a longer window")
        )  # fmt: skip
