"""What a mount is, from a test: its dynamic stiffness and loss, from force and displacement over time at one
frequency.
"""

import csv
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import curve_fit

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault, reason
from nutamill.base.file_kind import FileKind, refuse_other_kind
from nutamill.base.files import MOST_RECORD_TEXT, read_text
from nutamill.base.units import Kind

COLUMNS = {"time": Kind.TIME, "displacement": Kind.LENGTH, "force": Kind.FORCE}
"""Columns of a test file, and what they hold."""
FEWEST_CYCLES = 3
"""Whole cycles below which a test is refused [1]."""
FEWEST_SAMPLES = 12
"""Samples in a cycle below which a test is refused [1]."""
ROUND = 0.05
"""Share of the displacement's amplitude that may lie outside its sine; beyond, the test was not at one
frequency [1].
"""


class MountTest(NamedTuple):
    """A record of a force-displacement test."""

    time: np.ndarray
    """Times, rising [s], (n,)."""
    displacement: np.ndarray
    """Displacement of the moved side [m], (n,)."""
    force: np.ndarray
    """Force on it [N], (n,), positive in the same sense: a spring gives positive force at positive
    displacement.
    """


class MountProperties(NamedTuple):
    """Dynamic properties at one frequency and amplitude, as reports of ASTM D5992 tests give them."""

    frequency: float
    """Frequency of the test [Hz]."""
    amplitude: float
    """Amplitude of the displacement [m]."""
    cycles: int
    """Whole cycles in the record [1]."""
    dynamic: float
    """Dynamic stiffness K*: amplitude of the force over that of the displacement, at the frequency of the
    test [N/m].
    """
    storage: float
    """Storage stiffness K', in phase with the displacement [N/m]."""
    loss: float
    """Loss stiffness K'', a quarter cycle ahead [N/m]."""
    storage_scatter: float
    """Standard deviation of K' from cycle to cycle [N/m]."""
    loss_scatter: float
    """Standard deviation of K'' from cycle to cycle [N/m]."""
    loop_loss: float
    """K'' from the area of the loop: energy lost in a cycle over pi amplitude^2 [N/m]."""
    distortion: float
    """Root mean square of the force outside its sine, share of that of its sine [1]; large where the mount is
    not linear.
    """

    @property
    def loss_factor(self) -> float:
        """tan delta = K''/K' [1]."""
        return self.loss / self.storage

    @property
    def damping(self) -> float:
        """Viscous damping of the same loss at this frequency, c = K''/(2 pi f) [N s/m]."""
        return self.loss / (math.tau * self.frequency)

    def lines(self) -> list[str]:
        """Format the properties as text, and as keys of a case file."""
        return [
            f"frequency          {self.frequency:.4g} Hz, amplitude {units.shown(self.amplitude, 'mm')}, "
            f"{self.cycles} cycles",
            f"dynamic stiffness  K*  {units.shown(self.dynamic, 'N/mm')}",
            f"storage stiffness  K'  {units.shown(self.storage, 'N/mm')}, from cycle to cycle ± "
            f"{units.in_unit(self.storage_scatter, 'N/mm'):.2g}",
            f"loss stiffness     K'' {units.shown(self.loss, 'N/mm')}, from cycle to cycle ± "
            f"{units.in_unit(self.loss_scatter, 'N/mm'):.2g};"
            f" from the area of the loop {units.in_unit(self.loop_loss, 'N/mm'):.4g}",
            f"loss factor        tan delta {self.loss_factor:.4g}; force outside its sine "
            f"{100 * self.distortion:.2g} %",
            f"viscous damping    c = K''/(2 pi f) = {self.damping:.4g} N s/m, at this frequency only",
            f'in a case file     [mounts] shear_stiffness = "{units.shown(self.storage, "N/mm")}", '
            f'shear_damping = "{self.damping:.4g} N s/m"'
            " (or axial_..., as tested)",
        ]


def mount_properties(test: MountTest) -> MountProperties:
    """Identify the dynamic stiffness and loss of a mount from a test with a sine motion.

    The sine of the displacement is fitted with its frequency, that of the force at the same frequency, both
    by least squares over whole cycles; stiffness is the ratio of their complex amplitudes.  Means do not
    matter, so that a preload may stand in the force.

    Raises
    ------
    CaseError : samples that are no numbers, times that do not rise, too few cycles or samples in a cycle, no
        single sine, or a force that the displacement does not explain as that of a spring with loss

    Source
    ------
    ASTM D5992-96(2018), Standard Guide for Dynamic Testing of Vulcanized Rubber (terms: K*, K', K'', tan
    delta); IEEE Std 1057-2017, section 4.6.3 (four-parameter sine fit)
    """
    _refuse_broken(test)
    omega = _frequency(test)
    cycles = math.floor((test.time[-1] - test.time[0]) * omega / math.tau + 1e-6)
    _refuse_short(test, omega, cycles)
    inside = test.time <= test.time[0] + math.tau * cycles / omega * (1.0 + 1e-9)
    time, displacement, force = (column[inside] for column in test)
    moved, moved_rest = _sine(time, displacement, omega)
    pushed, pushed_rest = _sine(time, force, omega)
    amplitude = abs(moved)
    if (share := math.sqrt(2.0 * np.mean(moved_rest**2)) / amplitude) > ROUND:
        what = f"must be a sine of one frequency, {100 * share:.2g} % of it is not"
        raise CaseError(
            Fault("displacement", what, "Give one frequency and amplitude at a time, without its start")
        )
    stiffness = pushed / moved
    if not stiffness.real > 0.0 or not stiffness.imag > 0.0:
        what = (
            f"must lead the displacement by less than a quarter cycle, K' = {stiffness.real:.3g} N/m and "
            f"K'' = {stiffness.imag:.3g} N/m"
        )
        raise CaseError(
            Fault("force", what, "Mind the sign of the force, and delays between the two channels")
        )
    each = _each_cycle(time, displacement, force, omega, cycles)
    trapezoid = getattr(np, "trapezoid", None) or getattr(np, "trapz")  # noqa: B009  NumPy 1 and 2
    loop = abs(trapezoid(force, displacement))
    return MountProperties(
        frequency=omega / math.tau,
        amplitude=amplitude,
        cycles=cycles,
        dynamic=abs(stiffness),
        storage=stiffness.real,
        loss=stiffness.imag,
        storage_scatter=float(each.real.std(ddof=1)),
        loss_scatter=float(each.imag.std(ddof=1)),
        loop_loss=float(loop / cycles / (math.pi * amplitude**2)),
        distortion=math.sqrt(2.0 * np.mean(pushed_rest**2)) / abs(pushed),
    )


def _sine(time: np.ndarray, value: np.ndarray, omega: float) -> tuple[complex, np.ndarray]:
    """Fit the complex amplitude A of `value` as Re(A exp(i omega t)) beside a mean, and return it with the
    residual.
    """
    columns = np.column_stack([np.cos(omega * time), -np.sin(omega * time), np.ones_like(time)])
    weights = np.linalg.lstsq(columns, value, rcond=None)[0]
    return complex(weights[0], weights[1]), value - columns @ weights


def _each_cycle(
    time: np.ndarray, displacement: np.ndarray, force: np.ndarray, omega: float, cycles: int
) -> np.ndarray:
    """Return the complex stiffness of each cycle, (cycles,)."""
    number = _cycle_numbers(time, omega, cycles)
    ratios = []
    for k in range(cycles):
        one = number == k
        ratios.append(_sine(time[one], force[one], omega)[0] / _sine(time[one], displacement[one], omega)[0])
    return np.array(ratios)


def _cycle_numbers(time: np.ndarray, omega: float, cycles: int) -> np.ndarray:
    """Return the number of the cycle that each sample is in (n,), from 0. What follows the last is in it."""
    return np.minimum(((time - time[0]) * omega / math.tau).astype(int), cycles - 1)


def _frequency(test: MountTest) -> float:
    """Return the angular frequency of the displacement [rad/s]: the largest line of its spectrum, refined by
    least squares.
    """
    even = np.linspace(test.time[0], test.time[-1], len(test.time))
    moved = np.interp(even, test.time, test.displacement - test.displacement.mean())
    lines = np.abs(np.fft.rfft(moved * np.hanning(len(moved)), 4 * len(moved)))
    first = math.tau * int(lines[1:].argmax() + 1) / (4 * len(moved) * (even[1] - even[0]))
    size = np.abs(moved).max()

    def wave(t, omega, cosine, sine, mean):
        return cosine * np.cos(omega * t) + sine * np.sin(omega * t) + mean

    begin = test.time - test.time[0]
    amplitude, _ = _sine(begin, test.displacement / size, first)
    guess = [first, amplitude.real, -amplitude.imag, 0.0]
    try:
        relative = test.displacement / size
        fitted, _ = curve_fit(wave, begin, relative - np.mean(relative), guess)
    except RuntimeError:
        raise CaseError(
            Fault("displacement", "must be a sine of one frequency, the fit has no frequency")
        ) from None
    return abs(float(fitted[0]))


def _refuse_broken(test: MountTest) -> None:
    """Raise where the record is none."""
    if (
        not all(len(column) == len(test.time) for column in test)
        or len(test.time) < FEWEST_CYCLES * FEWEST_SAMPLES
    ):
        raise CaseError(
            Fault(
                "test", f"must have columns of one length, at least {FEWEST_CYCLES * FEWEST_SAMPLES} samples"
            )
        )
    faults = [
        Fault(
            name, f"must be finite numbers, sample {int(np.flatnonzero(~np.isfinite(column))[0]) + 1} is not"
        )
        for name, column in zip(COLUMNS, test, strict=True)
        if not np.isfinite(column).all()
    ]
    if not faults and (falls := np.flatnonzero(np.diff(test.time) <= 0.0)).size:
        faults.append(Fault("time", f"does not rise after sample {falls[0] + 1}"))
    if not faults and np.ptp(test.displacement) == 0.0:
        faults.append(Fault("displacement", "is constant"))
    if faults:
        raise CaseError(*faults)


def _refuse_short(test: MountTest, omega: float, cycles: int) -> None:
    """Raise where there are too few cycles, or too few samples in each."""
    if cycles < FEWEST_CYCLES:
        raise CaseError(
            Fault(
                "test",
                f"needs {FEWEST_CYCLES} whole cycles, got {cycles} at {omega / math.tau:.4g} Hz",
            )
        )
    if (samples := (len(test.time) - 1) * math.tau / omega / (test.time[-1] - test.time[0])) < FEWEST_SAMPLES:
        raise CaseError(
            Fault(
                "test",
                f"needs {FEWEST_SAMPLES} samples in a cycle, got {samples:.1f}",
                "Sample faster",
            )
        )
    counts = np.bincount(_cycle_numbers(test.time, omega, cycles), minlength=cycles)
    if counts.min() < FEWEST_SAMPLES // 2:
        what = f"has a gap: {counts.min()} samples in cycle {counts.argmin() + 1} of {cycles}"
        raise CaseError(Fault("test", what, "Give a record without gaps"))


def read_mount_test(path: str | Path) -> MountTest:
    """Read a test from a CSV file with the columns time, displacement and force, in any order, each with its
    unit: ``force [kN]``.

    Raises
    ------
    CaseError : no such file, other columns or units, or cells that are no numbers (the first ten)
    """
    refuse_other_kind(path, FileKind.MOUNT_TEST, FileKind.RECORD)
    path = Path(path)
    try:
        text = read_text(path, MOST_RECORD_TEXT)
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError(Fault(str(path), f"cannot be read as a CSV file ({reason(error)})")) from None
    rows = [
        (number, row)
        for number, row in enumerate(csv.reader(text.splitlines()), start=1)
        if any(cell.strip() for cell in row)
    ]
    heads = [cell.partition("[") for cell in rows[0][1]] if rows else []
    units_of = {
        name.strip().lower(): (index, unit.removesuffix("]").strip())
        for index, (name, _, unit) in enumerate(heads)
    }
    if not all(name in units_of and units_of[name][1] in units.UNITS[kind] for name, kind in COLUMNS.items()):
        shown = ",".join(rows[0][1]) if rows else ""
        hint = 'Write "time [s],displacement [mm],force [N]"'
        raise CaseError(
            Fault(
                f"{path}:1", f'must name time, displacement and force with their units, got "{shown}"', hint
            )
        )
    columns: dict[str, list[float]] = {name: [] for name in COLUMNS}
    faults: list[Fault] = []
    for number, row in rows[1:]:
        for name, kind in COLUMNS.items():
            index, unit = units_of[name]
            try:
                columns[name].append(float(row[index]) * units.UNITS[kind][unit])
            except (ValueError, IndexError):
                cell = row[index] if index < len(row) else ""
                faults.append(Fault(f"{path}:{number}", f'column "{name}" must be a number, got "{cell}"'))
    if faults:
        raise CaseError(*faults[:10])
    return MountTest(*(np.array(column) for column in columns.values()))
