"""A trial: the case itself, marched for about two seconds of wall time, to forecast what its run takes."""

import itertools
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from nutamill.base.errors import MillError
from nutamill.case.drive import DriveProgramme, Profile
from nutamill.case.machine import Machine
from nutamill.result import Recorder
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.lammps.lead import in_lammps
from nutamill.simulation.lammps.ranks import launched
from nutamill.simulation.setup.bed import cached_bed, loose_bed
from nutamill.simulation.setup.charge import contact_law_of
from nutamill.simulation.setup.model import build
from nutamill.simulation.setup.particles import charge_parts
from nutamill.simulation.warm_up import is_compiled

TRIAL_TIME = 2.0
"""Wall time of a trial [s]; 0 for none."""
JUMP = 2e-3
"""Time in which the drives of a trial come to speed [s]."""
MOST_LOOSE = 20_000
"""Spheres up to which a bed that has not settled yet is filled loosely for a trial [1]: more take too long to
place.
"""
LONGEST_TRIAL = 0.5
"""Simulated time after which a trial ends however short it was [s]."""


def trial_rate(machine: Machine, clock: Callable[[], float] = time.perf_counter) -> float | None:
    """March a machine at full speed for `TRIAL_TIME`, and return the wall time that a simulated second takes
    [1], recording included.

    A trial starts from the settled bed, or from a loose one where none has settled yet, and its drives jump
    to their largest speed: a charge in motion costs more than one at rest, and a run is mostly in motion.
    The first half is not counted.  Return None where nothing can be marched within that time: kernels that
    are not compiled, a bed of many particles that has not settled, LAMMPS that is
    missing or on several processes, a fault.

    `clock` reads the time that is measured [s]; `time.process_time` leaves out what other programs take.
    """
    law = contact_law_of(machine) if machine.charge.parts else None
    many = machine.charge.engine is not None and launched() > 1
    if TRIAL_TIME <= 0.0 or many or not is_compiled(law, machine.charge.engine):
        return None
    try:
        bed = _bed(machine)
        if machine.charge.parts and bed is None:
            return None
        with tempfile.TemporaryDirectory() as folder:
            return _trial_rate(at_speed(machine), bed, Path(folder) / "trial.h5", clock)
    except MillError:
        return None


def at_speed(machine: Machine) -> Machine:
    """Return a machine whose drives come to their largest speed within `JUMP`."""
    drives = tuple(
        drive.model_copy(update={"ramp": None, "profile": _jump(drive)}) for drive in machine.drives
    )
    return machine.model_copy(update={"drives": drives})


def _jump(drive: DriveProgramme) -> Profile:
    speeds = drive.breakpoints()[1]
    return Profile(points=((0.0, 0.0), (JUMP, float(speeds[np.argmax(np.abs(speeds))]))))


def _bed(machine: Machine) -> np.ndarray | None:
    """Return the settled bed if it is there, else a loose one if it is quickly made."""
    if not machine.charge.parts:
        return None
    bed = cached_bed(machine)
    if bed is None and sum(particles.pebbles for particles in charge_parts(machine)) <= MOST_LOOSE:
        return loose_bed(machine)
    return bed


def _trial_rate(machine, bed, path, clock) -> float | None:
    """Return the time that a simulated second takes, of the later half of a trial that records to `path`."""
    model, state, scratch = build(machine, bed)
    with in_lammps(model, state, scratch, bed):
        return _marched_rate(machine, model, state, scratch, path, clock)


def _marched_rate(machine, model, state, scratch, path, clock) -> float | None:
    """Return the time of `_trial_rate`, of a machine that has been built."""
    record_first_row(model, state, scratch)
    fields, rate = model.readout.fields, machine.run.series_rate
    recorder = Recorder.create(path, "", {}, fields, rate)
    model, _, fault = enter(model, state, scratch, 1)  # loads the compiled code
    entries: list[tuple[float, int]] = []
    spent, count = 0.0, 1
    while fault is None and spent < TRIAL_TIME and sum(rows for _, rows in entries) < LONGEST_TRIAL * rate:
        begun = clock()
        model, rows, fault = enter(model, state, scratch, count)
        recorder.append(model.readout.series(rows, state.first_row))
        lasted = clock() - begun
        entries.append((lasted, len(rows)))
        spent += lasted
        count = int(np.clip(count * TRIAL_TIME / 16 / max(lasted, 1e-6), 1, 480))
    if not any(rows for _, rows in entries):
        return None
    until = np.cumsum([seconds for seconds, _ in entries])
    later = list(itertools.compress(entries, until > 0.5 * spent))
    seconds, rows = (sum(numbers) for numbers in zip(*later, strict=True))
    return (seconds / max(rows, 1) + _packing_time(recorder, entries, clock)) * rate


def _packing_time(recorder, entries, clock) -> float:
    """Return the time [s] that a row takes to be packed into a file, what a commit without rows takes
    left out.
    """
    begun = clock()
    recorder.commit(force=True)
    with_rows = clock()
    recorder.close()
    without = clock() - with_rows
    return max(0.0, with_rows - begun - without) / sum(rows for _, rows in entries)
