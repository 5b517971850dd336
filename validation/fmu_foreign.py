"""FMUs of other programs in runs of ours, from archives that no package carries.

    python -m validation.fmu_foreign FOLDER       the rows whose archives are in FOLDER, and write the table

The archives, and the repositories that have them:
emachine_model.fmu, of Dymola 2024x: OpenModelica/OMSimulator, testsuite/tests/resources/dcmotor
Controller.fmu, of Dymola 2021x: CATIA-Systems/FMPy, tests/resources
Chassis.fmu, of fmiCpp: open-simulation-platform/libcosim, tests/data/fmi2/quarter_truck
Feedthrough.fmu: modelica/Reference-FMUs, built for FMI 3

Needs the extra fmu.  It runs native code of these archives.
"""

import sys
import tempfile
from collections.abc import Callable, Iterator
from datetime import date
from pathlib import Path

import numpy as np

import nutamill as nm
from nutamill import __version__
from nutamill.base.provenance import processor
from nutamill.simulation.fmus.description import read_description

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "cross"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "unit"))
from box_and_ball import BALL, BOX, rows_of
from motor_on_shaft import SHAFT

TABLE = Path(__file__).parent / "results" / "fmu-foreign.txt"
MILL = """
schema = 1
base   = "numill"

[charge]
kind = "none"

[drive]
ramp = "3000 rpm/s"

[run]
until       = "0.5 s"
series_rate = "1000 Hz"
"""
DC_MOTOR = """
[[fmus]]
name  = "motor"
file  = "emachine_model.fmu"
start = { "resistor.R" = 2.0, "emf.k" = 0.5, "inductor.L" = 0.01, U = 24.0 }

[[fmus.drives]]
drive  = "shaft"
torque = "M"
speed  = "w"
"""
CONTROLLED = """
[[fmus]]
name  = "controller"
file  = "Controller.fmu"
start = { "PI.k" = 10.0, "PI.Ti" = 0.1, "PI.yMax" = 100.0 }

[[fmus.drives]]
drive     = "motor"
speed     = "u_m"
set_speed = "u_s"

[[fmus]]
name  = "motor"
file  = "emachine_model.fmu"
start = { "resistor.R" = 0.5, "emf.k" = 1.0, "inductor.L" = 0.001 }
links = { U = "controller.y" }

[[fmus.drives]]
drive  = "motor"
torque = "M"
speed  = "w"
"""
FEEDTHROUGH = """
[[fmus]]
name = "controller"
file = "Feedthrough.fmu"

[[fmus.drives]]
drive     = "shaft"
torque    = "Float64_continuous_output"
set_speed = "Float64_continuous_input"
"""
CHASSIS = """
[[fmus]]
name  = "chassis"
file  = "Chassis.fmu"
start = { mass = 2.0, gravity = 0.0, mediumDensity = 0.0 }

[[fmus.bodies]]
body         = "box"
origin       = ["0 mm", "0 mm", "-10 mm"]
position     = ["", "", "position"]
velocity     = ["", "", "velocity"]
acceleration = ["", "", "acceleration"]
force        = ["", "", "-force"]
"""
GUIDE = """
[[joints]]
name    = "guide"
kind    = "prismatic"
between = ["ground", "box"]
point   = ["0 mm", "0 mm", "-10 mm"]
axis    = [0, 0, 1]

[[forces]]
name  = "weight_taken_off"
body  = "box"
force = ["0 N", "0 N", "19.62 N"]
"""
Row = tuple[str, str]
"""What is compared, and what it gave."""


def motor(folder: Path) -> Iterator[Row]:
    """Run a shaft up by a direct-current motor of Dymola at a constant voltage."""
    (folder / "case.toml").write_text(SHAFT + DC_MOTOR, encoding="utf-8")
    with nm.run(folder / "case.toml", to=folder / "motor.h5", trust_fmu=True) as result:
        time, speed = (result.series[name].values for name in ("time", "drive_shaft_speed"))
        work, residual = (result.series[name].values for name in ("drive_shaft_work", "ledger_residual"))
    matrix = np.array([[-2.0 / 0.01, -0.5 / 0.01], [0.5 / 0.02, -0.02 / 0.02]])
    steady = -np.linalg.solve(matrix, [24.0 / 0.01, 0.0])
    values, vectors = np.linalg.eig(matrix)
    free = np.linalg.solve(vectors, -steady)
    exact = steady[1] + (vectors @ (np.exp(np.outer(values, time)) * free[:, None]))[1]
    yield "speed of a shaft against the closed form [1]", f"{np.abs(speed - exact).max() / exact[-1]:.1e}"
    yield "energy that the ledger leaves open, of the work [1]", f"{np.abs(residual).max() / work[-1]:.1e}"


def controlled(folder: Path) -> Iterator[Row]:
    """Run the empty NuMill up by that motor behind a PI controller of Dymola with a voltage limit."""
    (folder / "case.toml").write_text(MILL + CONTROLLED, encoding="utf-8")
    case = nm.load_case(folder / "case.toml")
    with nm.run(case, to=folder / "mill.h5", trust_fmu=True) as result:
        series = result.series
        work, residual = series.motor_work.values, series.ledger_residual.values
        speed, wanted = series.driveshaft_speed.values[-1], case.drive.speed
    yield "speed of the empty NuMill after 0.5 s over the set one [1]", f"{speed / wanted - 1.0:+.1e}"
    yield "energy that the ledger leaves open, of the work [1]", f"{np.abs(residual).max() / work[-1]:.1e}"


def chassis(folder: Path) -> Iterator[Row]:
    """Let a ball fall on a free mass of another program, and on ours."""
    texts = {"own": GUIDE + BALL, "foreign": CHASSIS + BALL}
    texts["iterated"] = texts["foreign"].replace("[run]", '[run]\ncoupling = "iterated"')
    ends = {}
    for name, text in texts.items():
        (folder / "case.toml").write_text(BOX + text, encoding="utf-8")
        case = nm.load_case(folder / "case.toml").with_("run.window", 4)
        rows = rows_of(case, 0.04)
        ends[name] = np.column_stack([rows["box_position_z"], rows["charge_mass_centre_z"]])
    moved = np.abs(ends["own"] - ends["own"][0]).max(axis=0)
    for name in ("foreign", "iterated"):
        apart = np.abs(ends[name] - ends["own"]).max(axis=0) / moved
        scheme = "staggered" if name == "foreign" else name
        yield f"box and ball, {scheme}, against our own box [1]", f"{apart[0]:.1e} and {apart[1]:.1e}"


def feedthrough(folder: Path) -> Iterator[Row]:
    """Run a shaft by the reference FMU of FMI 3 that gives what it gets: as torque the speed asked for."""
    (folder / "case.toml").write_text(SHAFT + FEEDTHROUGH, encoding="utf-8")
    with nm.run(folder / "case.toml", to=folder / "feedthrough.h5", trust_fmu=True) as result:
        time, speed = (result.series[name].values for name in ("time", "drive_shaft_speed"))
    inertia, rate, ramp = 0.02, 1.0, 3000.0 * np.pi / 30.0  # friction over inertia is 1/s
    exact = ramp / inertia * (time / rate - (1.0 - np.exp(-rate * time)) / rate**2)
    yield "speed of a shaft against the closed form [1]", f"{np.abs(speed - exact).max() / exact[-1]:.1e}"


ROWS: dict[tuple[str, ...], Callable[[Path], Iterator[Row]]] = {
    ("emachine_model.fmu",): motor,
    ("Controller.fmu", "emachine_model.fmu"): controlled,
    ("Chassis.fmu",): chassis,
    ("Feedthrough.fmu",): feedthrough,
}
"""What is run, by the archives that it needs."""


def main(source: Path) -> None:
    """Print the table and write it."""
    folder = Path(tempfile.mkdtemp())
    lines = [f"nutamill {__version__}, FMUs of other programs, {date.today()}", processor(), ""]
    for names, rows in ROWS.items():
        files = [source / name for name in names]
        if not all(file.is_file() for file in files):
            lines.append(f"{' and '.join(names)}: not at hand, not run")
            print(lines[-1], flush=True)
            continue
        for file in files:
            (folder / file.name).write_bytes(file.read_bytes())
            lines.append(read_description(file, file.name).title)
            print(lines[-1], flush=True)
        for what, value in rows(folder):
            lines.append(f"    {what:62} {value}")
            print(lines[-1], flush=True)
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
