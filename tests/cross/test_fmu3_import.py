"""FMUs of FMI 3 in a run: our own, exported as such, as a motor and as the machine around a charge."""

import shutil

import numpy as np
import pytest
from box_and_ball import BALL, BOX, OWN, rows_of

from nutamill.base.errors import StepError
from nutamill.case import load_case
from nutamill.export.fmu.write import export_machine
from nutamill.simulation.fmus.trust import fmu_lines
from nutamill.simulation.runs import resume, run

pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]
pytest.importorskip("fmpy", reason="needs the extra fmu")
from fmu3_bench import write_fmu3  # noqa: E402

SPEED, SLOPE, INERTIA = 100.0, 0.05, 0.01
"""No-load speed of the motor [rad/s], fall of its torque with speed [N m s/rad], flywheel [kg m^2]."""
ROTOR = """
schema = 1

[[bodies]]
name     = "rotor"
mass     = "1 kg"
inertia  = ["1 kg m^2", "1 kg m^2", "{inertia} kg m^2"]
position = ["0 m", "0 m", "0 m"]

[[joints]]
name     = "bearing"
kind     = "revolute"
between  = ["ground", "rotor"]
point    = ["0 m", "0 m", "0 m"]
axis     = [0, 0, 1]
{more}

[[drives]]
name  = "shaft"
joint = "bearing"
speed = "100 rad/s"
ramp  = "1000 rad/s^2"

[run]
until = "60 ms"
"""
INSIDE = """friction = {{ viscous = "{slope} N m s/rad" }}

[[torques]]
name   = "field"
body   = "rotor"
moment = ["0 N m", "0 N m", "{stall} N m"]
"""
MOTOR = """
[[fmus]]
name = "motor"
file = "motor.fmu"

[[fmus.drives]]
drive  = "shaft"
torque = "-drive_shaft_torque"
speed  = "drives.shaft.speed"
"""


@pytest.fixture(scope="module")
def flywheels(tmp_path_factory):
    """By version of FMI: a flywheel under a motor whose torque falls with its speed, as an FMU."""
    cases = {}
    for version in (2, 3):
        folder = tmp_path_factory.mktemp("flywheel")
        inside = INSIDE.format(slope=SLOPE, stall=SLOPE * SPEED)
        (folder / "motor.toml").write_text(ROTOR.format(inertia=1e-9, more=inside), encoding="utf-8")
        motor = load_case(folder / "motor.toml").machine
        export_machine(motor, folder / "motor.fmu", version=version, drives="speed")
        (folder / "case.toml").write_text(ROTOR.format(inertia=INERTIA, more=MOTOR), encoding="utf-8")
        cases[version] = load_case(folder / "case.toml")
    return cases


def test_a_motor_of_fmi_3_runs_a_flywheel_up_with_the_bits_of_fmi_2(flywheels, tmp_path):
    """J dw/dt = c (Omega - w); the torque of a window acts from its end on, which delays it by one of 50 us:
    the error of the speed is that of a delay, c / J times the window, of Omega.
    """
    speeds = []
    for version, case in flywheels.items():
        with run(case, to=tmp_path / f"{version}.h5", trust_fmu=True) as result:
            assert f", FMI {version}, " in result.provenance["fmus.motor"]
            speeds.append(result.series.drive_shaft_speed.values)
            time = result.series.time.values
    assert np.array_equal(*speeds)
    exact = SPEED * (1.0 - np.exp(-SLOPE * time / INERTIA))
    assert np.abs(speeds[1] - exact).max() < SLOPE / INERTIA * 50e-6 * SPEED


def test_a_run_with_a_motor_of_fmi_3_is_resumed_with_the_bits_of_the_whole(flywheels, tmp_path):
    case = flywheels[3].with_("run.until", "20 ms")
    with run(case, to=tmp_path / "whole.h5", trust_fmu=True) as result:
        wanted = result.series.drive_shaft_speed.values
    run(case.with_("run.until", "10 ms"), to=tmp_path / "part.h5", trust_fmu=True).close()
    with resume(tmp_path / "part.h5", until="20 ms", trust_fmu=True) as result:
        assert np.array_equal(result.series.drive_shaft_speed.values, wanted)


def test_check_shows_the_step_that_an_fmu_of_fmi_3_declares_as_its_own(flywheels):
    assert "; its own step is 50 us" in fmu_lines(flywheels[3])[0]


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (1, "fmus.motor: the FMU refused at t = 0.01 s: it ended the simulation at 0.010025 s"),
        (2, "the FMU refused at t = 0.01 s: it stopped at 0.010025 s, before the end of the step"),
        (3, "fmus.motor: the FMU refused at t = 0.01 s: "),
    ],
)
def test_a_step_that_an_fmu_of_fmi_3_does_not_end_is_a_sentence(tmp_path, fault, message):
    write_fmu3(tmp_path / "motor.fmu")
    start = f"start = {{ late = 0.00999, fault = {fault} }}\n\n[[fmus.drives]]"
    fmu = MOTOR.replace("-drive_shaft_torque", "M").replace("drives.shaft.speed", "w")
    text = ROTOR.format(inertia=INERTIA, more=fmu.replace("[[fmus.drives]]", start))
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    with pytest.raises(StepError) as error:
        run(load_case(tmp_path / "case.toml"), to=tmp_path / "a.h5", trust_fmu=True)
    assert message in str(error.value)


PARTS = ("position", "velocity", "angular_velocity", "acceleration", "angular_acceleration")


def mapping(body):
    """The table of a body that an FMU exported by us moves."""
    lines = [f'body = "{body}"', f"attitude = {[f'bodies.{body}.quaternion.{axis}' for axis in 'wxyz']}"]
    lines += [f"{part} = {[f'bodies.{body}.{part}.{axis}' for axis in 'xyz']}" for part in PARTS]
    lines += [
        f"{load} = {[f'wrench.{body}.{load}.{axis}' for axis in 'xyz']}" for load in ("force", "moment")
    ]
    return "\n".join(["[[fmus.bodies]]", *lines, ""])


@pytest.mark.parametrize("version", [2, 3])
def test_our_mechanism_as_a_foreign_machine_gives_the_bits_of_our_own_run(tmp_path, version):
    """A box on a guide and a spring under a ball: as part of the run, and as an FMU that the run moves."""
    (tmp_path / "own.toml").write_text(BOX + OWN + BALL, encoding="utf-8")
    own = load_case(tmp_path / "own.toml")
    machine = own.machine
    step = machine.model_copy(update={"run": machine.run.model_copy(update={"step": 50e-6})})
    export_machine(step, tmp_path / "own.fmu", version=version)
    foreign = '\n[[fmus]]\nname = "machine"\nfile = "own.fmu"\n\n' + mapping("box")
    (tmp_path / "foreign.toml").write_text(BOX + foreign + BALL, encoding="utf-8")
    one, two = (rows_of(load_case(tmp_path / f"{name}.toml"), 0.03) for name in ("own", "foreign"))
    assert np.count_nonzero(one["box_charge_force_z"]) > 2
    for name in ("box_position_z", "charge_mass_centre_z", "box_charge_force_z", "wall_normal_loss"):
        assert np.array_equal(one[name], two[name]), name
