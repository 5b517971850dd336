"""How much the charge's substep changes: 8 to 40 substeps in the shortest contact, and the evidence for
``dt = "auto"``.

    python benchmarks/integrators.py            single contacts, then the machines: about forty minutes
    python benchmarks/integrators.py contacts   single contacts only

Single contacts have closed forms, and are met at sixteen phases of the first substep, in single precision.
The machines are chaotic: each is run with several seeds, and a mean is given with its standard error, the
scatter of the seeds over the root of their number.
"""

import math
import sys
import time
from typing import NamedTuple

import numpy as np

from nutamill.base.provenance import processor
from nutamill.case import load_case
from nutamill.charge.face import Charge, linear_pair
from nutamill.charge.laws.oscillator import contact_time
from nutamill.charge.particles.particles import spheres
from nutamill.charge.walls.surface import plane
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.setup.bed import settled_bed
from nutamill.simulation.setup.clock import contact_facts, run_clock
from nutamill.simulation.setup.model import build

NUMBERS = (8, 10, 12, 15, 20, 30, 40)
"""Substeps in the shortest contact [1]."""

RADIUS, DENSITY, STIFFNESS, GRAVITY = 0.0025, 7800.0, 5e5, 9.81
MASS = DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3
PHASES = (np.arange(16) + 0.3) / 16


def ball(
    restitution: float, friction: float, substeps: int, phase: float, velocity, gravity: float
) -> Charge:
    """Return a ball that meets a floor after a few substeps, or rests on it if it does not fall."""
    pair = linear_pair(STIFFNESS, restitution, friction)
    dt = contact_time(STIFFNESS, MASS, pair.damping_ratio, pair.tension_cut) / substeps
    height = (
        RADIUS - MASS * gravity / STIFFNESS if velocity[2] == 0.0 else RADIUS - velocity[2] * (3 + phase) * dt
    )
    return Charge(
        spheres([2 * RADIUS]).placed(np.array([[0.0, 0.0, height]])),
        [DENSITY],
        pair,
        [plane("floor")],
        dt=dt,
        gravity=(0.0, 0.0, -gravity),
        velocities=np.array([velocity]),
    )


def restitution_errors(restitution: float, substeps: int) -> np.ndarray:
    """Restitution of a ball that falls on a floor at 1 m/s, less the one asked for, at each phase."""
    return np.array(
        [
            ball(restitution, 0.0, substeps, phase, (0.0, 0.0, -1.0), 0.0).step(3 * substeps).velocities[0, 2]
            - restitution
            for phase in PHASES
        ]
    )


def rebound(substeps: int) -> np.ndarray:
    """Tangential speed [m/s] of a ball that strikes a rough floor at 45 degrees, 1 m/s each way, at each
    phase.
    """
    return np.array(
        [
            ball(0.5, 0.5, substeps, phase, (1.0, 0.0, -1.0), 0.0).step(3 * substeps).velocities[0, 0]
            for phase in PHASES
        ]
    )


def sliding_error(substeps: int) -> float:
    """Path of a ball that slides at 50 mm/s until it rolls, over ``12 v^2/(49 mu g)``, less 1."""
    speed, friction = 0.05, 0.3
    moved = ball(0.5, friction, substeps, 0.0, (speed, 0.0, 0.0), GRAVITY)
    moved.march(2.0 * speed / (7.0 * friction * GRAVITY))
    return moved.positions[0, 0] / (12.0 * speed**2 / (49.0 * friction * GRAVITY)) - 1.0


FINE_CLOCK = ("run.window=5", "run.series_rate=1200 Hz")
"""Settings with which the substep, a whole part of a row, comes near the one asked for."""


class Trial(NamedTuple):
    """A machine whose means are compared."""

    case: str
    settings: list[str]
    averaged: float
    """Time at the end that is averaged [s]."""
    seeds: int
    series: dict[str, str]
    """Series that are averaged, and their headings."""
    work: str
    """Series of the work whose mean power is given."""


TRIALS = (
    Trial(
        "numill",
        ["mechanism.mounting=rigid", "drive.ramp=7000 rpm/s", "run.until=0.6 s", *FINE_CLOCK],
        0.4,
        3,
        {"crank_pin_force_resultant": "crank-pin force [N]", "driveshaft_torque": "torque [N m]"},
        "motor_work",
    ),
    Trial(
        "tumbling-mill",
        ["run.until=6 s", *FINE_CLOCK],
        4.0,
        4,
        {"drive_motor_torque": "torque [N m]", "kinetic_energy_charge": "kinetic energy of the charge [J]"},
        "drive_motor_work",
    ),
    Trial(
        "particle-damper",
        ["run.until=0.8 s", *FINE_CLOCK],
        0.8,
        8,
        {"kinetic_energy_mechanism": "mean kinetic energy of the box [J]"},
        "",
    ),
)


def machine_means(trial: Trial, substeps: int, seed: int) -> list[float]:
    """Return the means of one run: those of the series, power, ledger over work, largest overlap [%], and the
    substeps per contact that the clock has made of those asked for.
    """
    case = load_case(trial.case, [*trial.settings, f"run.seed={seed}"])
    machine = getattr(case, "machine", case)
    bed = settled_bed(machine)
    shortest = min(fact.resolve for fact in contact_facts(machine))
    machine = machine.with_("run.dt", shortest / substeps)
    model, state, scratch = build(machine, bed)
    record_first_row(model, state, scratch)
    rate = machine.run.series_rate
    _, rows, fault = enter(model, state, scratch, round(machine.run.end * rate))
    if fault is not None:
        raise fault
    series = dict(zip(model.readout.names, model.readout.series(rows, state.first_row).T, strict=True))
    count = round(trial.averaged * rate)
    means = [float(series[name][-count:].mean()) for name in trial.series]
    if trial.work:
        means.append(float(series[trial.work][-1] - series[trial.work][-count]) / trial.averaged)
    scale = np.abs(series[trial.work]).max() if trial.work else np.abs(series["kinetic_energy_charge"]).max()
    return [
        *means,
        float(np.abs(series["ledger_residual"]).max() / scale),
        100.0 * float(series["largest_pair_overlap"].max()),
        shortest / run_clock(machine).substep,
    ]


def print_contacts() -> None:
    """Print the table of single contacts."""
    fine = rebound(320)
    print("| substeps per contact | restitution 0.5: mean error | largest | 0.8: mean error | largest "
          "| speed after 45 degrees: mean error [%] | path of sliding: error [%] |")  # fmt: skip
    print("|---|---|---|---|---|---|---|")
    for number in NUMBERS:
        cells = []
        for restitution in (0.5, 0.8):
            errors = restitution_errors(restitution, number)
            cells += [f"{errors.mean():+.4f}", f"{np.abs(errors).max():.4f}"]
        cells.append(f"{100.0 * (rebound(number).mean() / fine.mean() - 1.0):+.3f}")
        cells.append(f"{100.0 * sliding_error(number):+.3f}")
        print(f"| {number} | {' | '.join(cells)} |", flush=True)


def print_machine(trial: Trial) -> None:
    """Print the table of one machine."""
    names = [
        *trial.series.values(),
        *(["power [W]"] if trial.work else []),
        "ledger over work",
        "overlap [%]",
    ]
    print(f"\n{trial.case}, {', '.join(trial.settings)}")
    print(f"means of the last {trial.averaged} s, {trial.seeds} seeds\n")
    print(f"| substeps per contact | {' | '.join(names)} |")
    print(f"|---|{'---|' * len(names)}")
    for number in NUMBERS:
        means = np.array([machine_means(trial, number, seed) for seed in range(1, trial.seeds + 1)])
        average, error = means.mean(axis=0), means.std(axis=0, ddof=1) / trial.seeds**0.5
        cells = [f"{a:.4g} +- {e:.2g}" for a, e in zip(average[:-3], error[:-3], strict=True)]
        cells += [f"{means[:, -3].max():.1e}", f"{means[:, -2].max():.2f}"]
        print(f"| {average[-1]:.1f} | {' | '.join(cells)} |", flush=True)


def main(words: list[str]) -> None:
    """Print the tables."""
    print(f"python benchmarks/integrators.py, {processor()}, {time.strftime('%Y-%m-%d', time.gmtime())}\n")
    print_contacts()
    if words != ["contacts"]:
        for trial in TRIALS:
            print_machine(trial)


if __name__ == "__main__":
    main(sys.argv[1:])
