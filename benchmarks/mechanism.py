"""What the mechanism costs: its step beside a charge and alone, and the empty runs of MCA 2026 as an engineer
would sweep them.

    python benchmarks/mechanism.py [--processes N]

22 runs, empty and with rigid bars at 11 speeds from 100 to 700 rpm, flexible mounts, each ramped at 70 rpm/s
and held for 3 s, every one written to a result file.  The step beside a charge is measured by
`nutamill bench`.
"""

import argparse
import statistics
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

import nutamill as nm
from nutamill.base.provenance import processor
from nutamill.simulation.setup.model import build
from nutamill.simulation.setup.threads import usable_cores
from nutamill.simulation.speed import mechanism_step
from nutamill.simulation.warm_up import warm_up

SPEEDS = np.linspace(100.0, 700.0, 11)
"""Speeds of the runs [rpm]."""
HOLD = 3.0
"""Time at full speed [s]."""
BARS = {"empty": 0.0, "bars": 1.347}
"""Mass of the rigid bars in each configuration [kg]."""


def sweep_case(name: str, rpm: float) -> nm.Case:
    """An empty mill or one with bars, ramped to `rpm` and held."""
    case = nm.load_case("numill", ["charge.kind=none"]).with_("chamber.bars.mass", BARS[name])
    return case.with_(**{"drive.speed": f"{rpm:g} rpm", "run.until": rpm / 70.0 + HOLD})


def swept(name: str, rpm: float, folder: str) -> tuple[str, float, float, float, float]:
    """Run one case to a file: configuration, speed [rpm], mean force [N] and torque [N m] over the hold,
    processor time [s].
    """
    begun = time.process_time()
    with nm.run(sweep_case(name, rpm), to=Path(folder) / f"{name}-{rpm:g}.h5") as result:
        series = result.series
        held = series["time"].values > series["time"].values[-1] - HOLD
        force, torque = (
            float(series[key].values[held].mean())
            for key in ("crank_pin_force_resultant_tared", "driveshaft_torque")
        )
    return name, rpm, force, torque, time.process_time() - begun


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--processes", type=int, default=usable_cores(), help="runs at a time")
    processes = parser.parse_args().processes
    warm_up()
    print(f"{processor()}, {usable_cores()} cores, {time.strftime('%Y-%m-%d')}")
    model, state, scratch = build(sweep_case("empty", 700.0).machine, None)
    steps = [mechanism_step(model, state, scratch) for _ in range(3)]
    clock, alone = model.clock, 1e6 * statistics.median(steps)
    print(
        f"mechanism step alone {alone:.1f} us, {len(model.mechanism.rows)} constraints, "
        f"{model.readout.n_columns} columns every"
    )
    print(f"{clock.windows_per_row} steps of {1e6 * clock.window:.0f} us")
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor(processes) as pool:
        runs = [pool.submit(swept, name, float(rpm), folder) for name in BARS for rpm in SPEEDS[::-1]]
        done = sorted(run.result() for run in runs)
    whole = time.perf_counter() - begun
    print(f"\n{'':6} {'rpm':>5} {'force (N)':>10} {'torque (N m)':>13} {'cpu (s)':>9}")
    for name, rpm, force, torque, cpu in done:
        print(f"{name:6} {rpm:5.0f} {force:10.1f} {torque:13.3f} {cpu:9.1f}")
    simulated = sum(2 * (rpm / 70.0 + HOLD) for rpm in SPEEDS)
    cpu = sum(run[4] for run in done)
    print(
        f"\n{len(done)} runs, {simulated:.0f} s simulated, {processes} at a time: {whole:.0f} s "
        f"({cpu:.0f} s of processor time)"
    )


if __name__ == "__main__":
    main()
