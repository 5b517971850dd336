"""The speed of this version on this machine: one developed flow, measured as ratios and medians."""

import dataclasses
import resource
import statistics
import subprocess
import sys
import time as wall
from collections.abc import Iterator

import numpy as np

from nutamill.base.provenance import processor
from nutamill.base.units import in_unit, shown
from nutamill.case import Case, Machine, load_case
from nutamill.charge.kernels.copying import copied
from nutamill.simulation.coupling import march_mechanism
from nutamill.simulation.coupling_model import coupling_state
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.setup.bed import settled_bed
from nutamill.simulation.setup.model import Model, Scratch, State, build
from nutamill.simulation.setup.threads import usable_cores
from nutamill.simulation.warm_up import warm_up

ROWS = 48
"""Rows of the record in one measured piece [1]: 2880 substeps."""

REPEATS = 7
"""Measured pieces of each kind [1]; the median counts."""


def developed_case() -> Case | Machine:
    """Return the published mill with pellets at 700 rpm on rigid mounts, 0.5 s after a fast ramp."""
    return load_case("numill", ["mechanism.mounting=rigid", "drive.ramp=1750 rpm/s", "run.until=0.9 s"])


def developed_flow(case: Case | Machine, bed: np.ndarray | None = None) -> tuple[Model, State, Scratch]:
    """March a case to its end without a file, from another `bed` than its own if that is given."""
    model, state, scratch = build(case.machine, settled_bed(case.machine) if bed is None else bed)
    record_first_row(model, state, scratch)
    for _ in range(round(case.run.end * case.run.series_rate / ROWS)):
        model, _, fault = enter(model, state, scratch, ROWS)
        if fault is not None:
            raise fault
    return model, state, scratch


def on_threads(model: Model, threads: int) -> Model:
    """Return the model with another number of threads."""
    return dataclasses.replace(model, machine=model.machine.with_("run.threads", threads))


def piece(model: Model, state: State, scratch: Scratch) -> tuple[Model, float]:
    """Measure the wall time of one piece of a coupled march [s], and return it after the model, whose lists
    may have grown.
    """
    begun = wall.perf_counter()
    model, _, fault = enter(model, state, scratch, ROWS)
    if fault is not None:
        raise fault
    return model, wall.perf_counter() - begun


def mechanism_step(model: Model, state: State, scratch: Scratch) -> float:
    """Measure the wall time of one mechanism step with its share of the record [s], median."""
    windows = ROWS * model.plan.windows_per_row
    rows = np.empty((ROWS, model.readout.n_columns))
    apart = copied(state.mechanism)
    times = []
    for _ in range(REPEATS):
        begun = wall.perf_counter()
        march_mechanism(
            model.mechanism,
            apart,
            scratch.mechanism,
            coupling_state(1),
            model.sensors,
            model.plan,
            model.readout.table.starts,
            windows,
            rows,
        )
        times.append((wall.perf_counter() - begun) / windows)
    return statistics.median(times)


def statistics_cost(model: Model, state: State, scratch: Scratch) -> tuple[Model, float]:
    """Measure the share of the time that the charge's statistics take on one thread [1], median of
    neighbouring pieces, and return it after the model.
    """
    ratios = []
    model = on_threads(model, 1)
    survey = model.survey
    assert survey is not None and state.charge is not None  # the case has a charge
    for _ in range(REPEATS):
        times = []
        for on in (0, 1):
            state.charge.impacts.on[0] = on
            model, seconds = piece(dataclasses.replace(model, survey=survey._replace(on=on)), state, scratch)
            times.append(seconds)
        ratios.append(times[1] / times[0] - 1)
    return model, statistics.median(ratios)


def process_time(*command: str) -> float:
    """Measure the wall time of a Python process, median [s]."""
    times = []
    for _ in range(5):
        begun = wall.perf_counter()
        subprocess.run([sys.executable, "-P", *command], check=True, capture_output=True)
        times.append(wall.perf_counter() - begun)
    return statistics.median(times)


def first_step() -> None:
    """Import, build and march the published mill through its first row, with kernels and bed cached."""
    case = load_case("numill")
    model, state, scratch = build(case.machine, settled_bed(case.machine))
    record_first_row(model, state, scratch)
    enter(model, state, scratch, 1)


def measure() -> Iterator[str]:
    """Yield the lines of the benchmark, one after another."""
    warm_up()
    yield f"{processor()}, {usable_cores()} cores for this process, {wall.strftime('%Y-%m-%d')}"
    model, state, scratch = developed_flow(developed_case())
    assert model.charge is not None  # the case has one
    particles, substeps = model.charge.n_particles, ROWS * model.plan.windows_per_row * model.plan.substeps
    mechanism = mechanism_step(model, state, scratch)
    counts = sorted({1, min(2, usable_cores()), usable_cores()})
    times: dict[int, list[float]] = {count: [] for count in counts}
    for _ in range(REPEATS):
        for count in counts:
            model, seconds = piece(on_threads(model, count), state, scratch)
            times[count].append(seconds)
    yield (
        f"developed flow at 700 rpm, {particles} pellets, {state.first_row.size} columns, substep "
        f"{shown(model.clock.substep, 'us', '.2f')}:"
    )
    for count in counts:
        whole = statistics.median(times[count])
        share = mechanism * ROWS * model.plan.windows_per_row / whole
        ns = in_unit(whole * (1 - share) / substeps / particles, "ns")
        yield (
            f"  {count} thread{'s' if count > 1 else ' '}  {ns:5.1f} ns per particle and substep (charge),"
            f" mechanism {100 * share:.1f} % of the time; scatter "
            f"{100 * (max(times[count]) - min(times[count])) / whole:.0f} %"
        )
    yield f"  mechanism step {shown(mechanism, 'us', '.1f')}"
    model, cost = statistics_cost(model, state, scratch)
    yield (
        f"  statistics of the charge, {round(model.machine.run.series_rate)} samples a second: "
        f"{100 * cost:.0f} % on top"
    )
    yield f"nutamill --help {process_time('-m', 'nutamill', '--help'):.2f} s"
    yield (
        "second start to the first row "
        f"{process_time('-c', 'from nutamill.simulation.speed import first_step; first_step()'):.2f} s"
    )
    peak = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    yield f"peak memory {peak / 1024:.0f} MB"
