"""How much a shorter charge substep changes: 10, 20 and 40 substeps in the shortest contact.

    python benchmarks/substeps.py

The pellets on rigid mounts, from rest to 700 rpm in 0.7 s and 0.6 s of steady running; means of the last 0.5
s.  The flow is chaotic: the scatter of a mean is that of five tenths of a second, over sqrt(5).  Restitution
errors are those of single impacts, single precision, at eight phases of the first substep.
"""

import time

import numpy as np

from nutamill.base.provenance import processor
from nutamill.case import Case, load_case
from nutamill.charge.face import Charge
from nutamill.charge.particles.particles import spheres
from nutamill.charge.walls.surface import plane
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.setup.bed import settled_bed
from nutamill.simulation.setup.clock import ContactFacts, contact_facts
from nutamill.simulation.setup.model import build
from nutamill.simulation.setup.particles import quickest_pebble

SETTINGS = ["mechanism.mounting=rigid", "drive.ramp=1000 rpm/s", "run.until=1.3 s"]
AVERAGED = 0.5


def restitution_errors(
    fact: ContactFacts, density: float, radius: float, wall: bool, dt: float
) -> np.ndarray:
    """Restitution of a pellet that strikes a wall or another pellet at 1 m/s, less the one asked for, at
    eight phases (8,).
    """
    errors = []
    for phase in (np.arange(8) + 0.3) / 8:
        gap = (3 + phase) * dt
        walls = [plane("floor")] if wall else []
        x = [[0, 0, radius + gap]] if wall else [[0, 0, 0], [0, 0, 2 * radius + gap]]
        v = [[0, 0, -1.0]] if wall else [[0, 0, 0.5], [0, 0, -0.5]]
        pellets = spheres([2 * radius] * len(x)).placed(np.array(x))
        charge = Charge(
            pellets, [density], fact.law, walls, dt=dt, gravity=(0.0, 0.0, 0.0), velocities=np.array(v)
        )
        after = charge.step(80).velocities[:, 2]
        errors.append((after[0] if wall else after[1] - after[0]) - fact.restitution)
    return np.array(errors)


def march(case: Case, bed: np.ndarray) -> dict[str, np.ndarray]:
    """Series of the whole run, by name."""
    model, state, scratch = build(case.machine, bed)
    record_first_row(model, state, scratch)
    _, rows, fault = enter(model, state, scratch, round(case.run.until * case.run.series_rate))
    if fault is not None:
        raise fault
    return dict(zip(model.readout.names, model.readout.series(rows, state.first_row).T, strict=True))


def main() -> None:
    case = load_case("numill", SETTINGS)
    bed = settled_bed(case.machine)
    facts = contact_facts(case.machine)
    shortest = min(fact.time for fact in facts)
    print(f"{processor()}, {time.strftime('%Y-%m-%d', time.gmtime())}\n")
    print(
        f"Means of the last {AVERAGED} s of {case.run.until} s, and their scatter; shortest contact "
        f"{shortest * 1e6:.3g} us.\n"
    )
    print(
        "| substeps per contact | substep [us] | crank-pin force [N] | torque [N m] | power [W] | "
        "ledger over work | overlap [%] |"
    )
    print("|---|---|---|---|---|---|---|")
    for number in (10, 20, 40):
        series = march(case.with_("run.dt", shortest / number), bed)
        count = round(AVERAGED * case.run.series_rate)
        cells = []
        for name in ("crank_pin_force_resultant", "driveshaft_torque"):
            tenths = series[name][-count:].reshape(5, -1).mean(axis=1)
            cells.append(f"{tenths.mean():.2f} +- {tenths.std(ddof=1) / 5**0.5:.2f}")
        work = series["motor_work"]
        power = (work[-1] - work[-1 - count]) / AVERAGED
        residual = np.abs(series["ledger_residual"]).max() / work[-1]
        overlap = 100 * series["largest_pair_overlap"].max()
        cells += [f"{power:.1f}", f"{residual:.1e}", f"{overlap:.2f}"]
        print(f"| {number} | {shortest / number * 1e6:.3g} | {' | '.join(cells)} |", flush=True)
    print("\n| substeps per contact | impact at 1 m/s | restitution | mean error | largest error |")
    print("|---|---|---|---|---|")
    pellet = quickest_pebble(case, case.charge.materials[0])
    density = case.materials[case.charge.materials[0]].density
    for number in (10, 20, 40):
        for fact in facts:
            errors = restitution_errors(
                fact, density, pellet.diameter / 2, "wall" in fact.pair, fact.time / number
            )
            print(
                f"| {number} | {fact.pair} | {fact.restitution:.2f} | {errors.mean():+.4f} | "
                f"{np.abs(errors).max():.4f} |"
            )


if __name__ == "__main__":
    main()
