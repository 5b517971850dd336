"""The published NuMill: measured, simulated by the authors, simulated here.

    python benchmarks/accuracy.py [RESULT.h5 of `nutamill run numill`]

Steady means over the last three seconds, as in the papers.  Rows marked F were fitted to (the numbers in the machine file say to
what); the others are predictions.  Sources: SAIMM 2025 Table 4; MCA 2026 Table 7, whose measured granular row was taken
at 723 rpm while its simulation ran at 700 rpm.
"""

import sys

import numpy as np

from nutamill.advance import enter, record_first_row
from nutamill.analysis import steady_window
from nutamill.build.model import build
from nutamill.case import load_case
from nutamill.preflight import preflight
from nutamill.result import open_result


def empty_mill(*changes: str) -> tuple[float, float]:
    """Mean resultant at the load cell, gravity's share taken off [N], and mean torque [N m], last three of 13 s."""
    case = load_case("numill", ["charge.kind=none", *changes])
    model, state = build(case, None)
    record_first_row(model, state)
    model, rows, fault = enter(model, state, round(case.run.until * case.run.series_rate))
    if fault is not None:
        raise fault
    last = model.readout.series(rows, state.first_row)[-round(3 * case.run.series_rate) :]
    column = model.readout.names.index
    return float(np.mean(last[:, column("crank_pin_force_resultant_tared")])), float(np.mean(last[:, column("driveshaft_torque")]))


def row(what: str, unit: str, measured: float | None, theirs: float | None, ours: float, mark: str = "") -> None:
    """One line of the table."""

    def shown(value: float | None) -> str:
        return f"{value:.4g}" if value is not None else ""

    def error(value: float) -> str:
        return f"{100 * (value / measured - 1):+.0f} %" if measured else ""

    their_error = error(theirs) if theirs is not None else ""
    print(f"| {what} | {unit} | {shown(measured)} | {shown(theirs)} | {their_error} | {shown(ours)} | {error(ours)} | {mark} |")


def main() -> None:
    print("| quantity | unit | measured | authors' simulation | its error | nutamill | its error | |")
    print("|---|---|---|---|---|---|---|---|")
    rigid = {rpm: empty_mill("mechanism.mounting=rigid", f"drive.speed={rpm} rpm") for rpm in (100, 400, 700)}
    for rpm, measured, theirs in ((100, 13.9, 14.7), (400, 240.0, 235.0), (700, 703.0, 719.0)):
        row(f"crank-pin force, empty, rigid mounts, {rpm} rpm", "N", measured, theirs, rigid[rpm][0], "F" if rpm == 700 else "")
    for rpm, measured, theirs in ((100, 0.09, 0.04), (400, 0.35, 0.36), (700, 0.67, 1.0)):
        row(f"torque, empty, rigid mounts, {rpm} rpm", "N m", measured, theirs, rigid[rpm][1], "F" if rpm == 400 else "")
    passed = preflight(load_case("numill")).crossings[0].frequency
    row("lowest natural frequency, pellets", "Hz", 7.33, 7.88, passed, "F to 7.88")
    force, torque = empty_mill()
    row("crank-pin force, empty, flexible mounts, 700 rpm", "N", 603, 768, force, "F")
    row("torque, same", "N m", 1.2, 4.1, torque)
    force, torque = empty_mill("chamber.bars.mass=1.347 kg")
    row("crank-pin force, rigid bars, flexible mounts, 700 rpm", "N", 817, 1031, force, "bars' depth F")
    row("torque, same", "N m", 1.2, 4.2, torque)
    if len(sys.argv) > 1:
        with open_result(sys.argv[1]) as result:
            steady = steady_window(result).values
        row(
            "crank-pin force, pellets, flexible mounts, 700 rpm (measured at 723)",
            "N",
            935,
            980,
            steady["crank_pin_force_resultant_tared"].mean,
        )
        row("torque, same", "N m", 10.2, 9.1, steady["driveshaft_torque"].mean)


if __name__ == "__main__":
    main()
