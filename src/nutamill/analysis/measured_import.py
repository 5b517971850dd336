"""From a test file to a file like that of a run, so that everything that reads runs reads tests."""

import math
from pathlib import Path

import numpy as np

from nutamill import __version__
from nutamill.analysis.measured_columns import Column, read_columns
from nutamill.analysis.measured_mapping import Mapping, load_mapping
from nutamill.analysis.windows import TURNING
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.file_kind import FileKind, refuse_other_kind
from nutamill.base.files import exists
from nutamill.result import Recorder, Result

STATE = "measured"
"""State of a file that holds a test."""


def import_test(path: str | Path, mapping_file: str | Path, to: str | Path) -> Path:
    """Read a test file with its mapping and write it as a result file of state ``measured``, and return its
    path.

    All channels are put on one clock, evenly spaced at the highest rate among them, linear in between.  Where
    the angle of the drive is not measured it is the integral of its speed, zero at the start.

    Raises
    ------
    CaseError : as `load_mapping` and `read_columns`; channels without time, or with times that do not rise
    ResultError : the file exists, or cannot be written
    """
    refuse_other_kind(path, FileKind.RECORD, FileKind.MOUNT_TEST)
    if exists(to):
        raise ResultError(f"{to}: exists already. Choose another name with --to.")
    mapping, tested = load_mapping(mapping_file)
    columns = read_columns(path, mapping)
    clocks = {
        name: _clock(columns[channel.column], columns, mapping, f"{path}: {name}")
        for name, channel in mapping.channel.items()
    }
    rate = max((len(clock) - 1) / (clock[-1] - clock[0]) for clock in clocks.values())
    first, last = max(clock[0] for clock in clocks.values()), min(clock[-1] for clock in clocks.values())
    if not last > first:
        raise CaseError(
            Fault(str(path), "its channels have no time in common", "Check the clocks of the test")
        )
    time = first + np.arange(math.floor((last - first) * rate + 1e-6) + 1) / rate
    series = {"time": time + mapping.offset}
    for name, channel in mapping.channel.items():
        series[name] = tested.scale(name, channel) * np.interp(
            time, clocks[name], columns[channel.column].values
        )
    if tested.motion is not None:
        series |= _motion(series, tested.motion, mapping, rate, str(mapping_file))
    sensors = {
        f"sensor {name}": f"{c.sensor} (column {c.column}, {c.unit or 1})"
        for name, c in mapping.channel.items()
    }
    turning = {} if tested.motion is None else dict(zip(TURNING, tested.motion, strict=True))
    facts = {"source": Path(path).name, "version": __version__, **turning, **sensors}
    recorder = Recorder.create(to, "", facts, [tested.field(name) for name in series], rate)
    recorder.append(np.stack(list(series.values()), axis=1))
    recorder.state(STATE)
    recorder.close()
    return Path(to)


def measured_lines(test: Result) -> list[str]:
    """Describe an imported test: duration, rate, and the mean and r.m.s. about it of each channel."""
    series = test.series
    count = series.sizes["time"]
    lines = [f"measured: {count} samples over {(count - 1) / test.rate:.4g} s, {test.rate:.6g} Hz"]
    width = max(map(len, map(str, series.data_vars)))
    for name in map(str, series.data_vars):
        values = series[name].values
        lines.append(
            f"{name:{width}}  mean {values.mean():.4g}, r.m.s. about it {values.std():.4g} "
            f"{test.field(name).unit}"
        )
    return lines


def _clock(column: Column, columns: dict[str, Column], mapping: Mapping, where: str) -> np.ndarray:
    """Return the times [s] (n,) of a column: a column of its own, the file's, or from the rate."""
    count = len(column.values)
    if mapping.time is not None:
        time = columns[mapping.time].values
    elif mapping.rate is not None:
        time = np.arange(count) / mapping.rate
    elif column.time is not None:
        time = column.time
    else:
        raise CaseError(
            Fault(
                where,
                "needs times, the file holds none",
                'Write time = "COLUMN" or rate = "4800 Hz" in the mapping',
            )
        )
    if len(time) != count or count < 2:
        raise CaseError(
            Fault(
                where,
                f"must have a time for each of at least two samples, got {len(time)} for {count}",
                "Repair the file",
            )
        )
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        raise CaseError(
            Fault(
                where,
                f"its times do not rise after sample {back[0] + 1}",
                "Repair the time column",
            )
        )
    return time


def _motion(
    series: dict[str, np.ndarray], motion: tuple[str, str], mapping: Mapping, rate: float, where: str
) -> dict[str, np.ndarray]:
    """Compute speed and angle of the drive where they are not measured. `motion` are their series."""
    added = {}
    turned, speed = motion
    if speed not in series:
        if mapping.speed is None:
            hint = f'Write speed = "700 rpm", or map a channel to {speed}'
            raise CaseError(Fault(where, "the speed of the drive is missing", hint))
        added[speed] = np.full_like(series["time"], mapping.speed)
    if turned not in series:
        speeds = (series | added)[speed]
        steps = np.cumsum(0.5 * (speeds[1:] + speeds[:-1]))
        added[turned] = np.concatenate((np.zeros(1), steps)) / rate
    return added
