"""Foreign FMUs in a run: a motor on a shaft and a body under a ball against closed forms and our own parts,
and a sentence for everything that can be wrong with an FMU.
"""

import shutil
import signal
import stat
import zipfile

import numpy as np
import pytest
from box_and_ball import BALL, BOX, FOREIGN, OWN, rows_of
from fmu_bench import compiled, description, write_fmu
from motor_on_shaft import MOTOR, SHAFT

import nutamill as nm
from nutamill.base.errors import CaseError, ResultError, StepError
from nutamill.case import load_case
from nutamill.simulation.fmus.mapping import fmu_plans
from nutamill.simulation.fmus.trust import fmu_lines
from nutamill.simulation.runs import resume, run
from nutamill.simulation.setup.model import build

pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]
pytest.importorskip("fmpy", reason="needs the extra fmu")

UNITLESS = '<UnitDefinitions><Unit name="m/m"><BaseUnit/></Unit>'


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("bench"))


@pytest.fixture
def case(tmp_path, library):
    def made(content, **how):
        write_fmu(tmp_path / "bench.fmu", library, **how)
        (tmp_path / "case.toml").write_text(content.replace("motor.fmu", "bench.fmu"), encoding="utf-8")
        return load_case(tmp_path / "case.toml")

    return made


def test_a_foreign_motor_runs_a_shaft_up_as_its_equations_say(case, tmp_path):
    """L di/dt = U - R i - k w, J dw/dt = k i - d w: the exact solution of the linear pair at the end."""
    with run(case(SHAFT + MOTOR), to=tmp_path / "a.h5", trust_fmu=True) as result:
        time, speed = (result.series[name].values for name in ("time", "drive_shaft_speed"))
        work, residual = (result.series[name].values for name in ("drive_shaft_work", "ledger_residual"))
        assert result.provenance["fmus.motor"] == "bench 1.2, FMI 2, made by cc"
        assert len(result.provenance["fmus.motor.sha256"]) == 64
    matrix = np.array([[-2.0 / 0.01, -0.5 / 0.01], [0.5 / 0.02, -0.02 / 0.02]])
    values, vectors = np.linalg.eig(matrix)
    steady = -np.linalg.solve(matrix, [24.0 / 0.01, 0.0])
    moving = vectors @ np.diag(np.exp(values * time[-1])) @ np.linalg.solve(vectors, -steady)
    # the FMU's own 20 explicit steps per window of 50 us: at most 1/2 * 2.5 us * R/L of the current
    assert abs(speed[-1] / (steady + moving)[1] - 1.0) < 0.5 * 2.5e-6 * 200.0 * 2.0
    assert abs(residual).max() < 1e-5 * work[-1]


def test_a_run_that_was_stopped_goes_on_with_the_fmus_state_bit_for_bit(case, tmp_path):
    whole = case(SHAFT.replace("20 ms", "30 ms") + MOTOR)
    with run(whole, to=tmp_path / "whole.h5", trust_fmu=True) as result:
        wanted = result.series.drive_shaft_torque.values
    run(whole.with_("run.until", "10 ms"), to=tmp_path / "part.h5", trust_fmu=True).close()
    with resume(tmp_path / "part.h5", until="30 ms", trust_fmu=True) as result:
        assert np.array_equal(result.series.drive_shaft_torque.values, wanted)


def test_an_fmu_that_cannot_store_its_state_is_not_resumed(case, tmp_path):
    run(case(SHAFT + MOTOR, text=description(states=False)), to=tmp_path / "a.h5", trust_fmu=True).close()
    with pytest.raises(ResultError, match='fmus: "motor" cannot store the state of the model'):
        resume(tmp_path / "a.h5", until="30 ms", trust_fmu=True)


def test_a_ball_on_a_foreign_body_moves_as_on_our_own(case):
    """The FMU makes the same Verlet step of the same mass and spring: what differs is rounding, which two
    bounces magnify.
    """
    own = rows_of(case(BOX + OWN + BALL), 0.04)
    foreign = rows_of(case(BOX + FOREIGN + BALL), 0.04)
    for name in ("box_position_z", "charge_mass_centre_z", "box_charge_force_z"):
        size = np.abs(own[name]).max()
        assert size > 0.0
        assert np.abs(own[name] - foreign[name]).max() < 1e-8 * size
    assert np.count_nonzero(own["box_charge_force_z"]) > 2
    single = np.finfo(np.float32).eps  # of the memory of the contacts
    assert np.abs(foreign["ledger_residual"]).max() < single * foreign["kinetic_energy_charge"].max()
    assert np.array_equal(foreign["fmu_mass_work"], foreign["interface_work"])


def test_passes_over_a_window_bring_walls_to_where_an_fmu_moves_them_at_once(case):
    """An FMU whose body answers the force of a window within it: extrapolated walls miss its end by half of
    the change of acceleration times the window squared, passes do not.
    """
    at_once = BOX + FOREIGN.replace("mass = 2.0", "mass = 2.0, at_once = 1.0") + BALL
    passes = at_once.replace("[run]", '[run]\ncoupling = "iterated"')
    fine = rows_of(case(passes).with_("run.window", 2), 0.02)["charge_mass_centre_z"]
    for window in (40, 20):
        one, several = (
            np.abs(rows_of(case(text).with_("run.window", window), 0.02)["charge_mass_centre_z"] - fine).max()
            for text in (at_once, passes)
        )
        assert several < one / 2.0


def test_rates_that_an_fmu_does_not_give_are_taken_from_its_positions(case):
    """What the ball misses when the FMU gives positions only falls with the window."""
    only = FOREIGN.replace('velocity     = ["vx", "vy", "vz"]\n', "").replace(
        'acceleration = ["ax", "ay", "az"]\n', ""
    )
    assert "vx" not in only
    errors = []
    for window in (40, 20, 10):
        full, part = (
            rows_of(case(BOX + fmu + BALL).with_("run.window", window), 0.01) for fmu in (FOREIGN, only)
        )
        errors.append(np.abs(full["charge_mass_centre_z"] - part["charge_mass_centre_z"]).max())
    assert errors[0] > 1.5 * errors[1] > 2.25 * errors[2]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('force        = ["fx"', 'force        = ["-fx"'), "a unit force x moves the body the other way"),
        (('["fx", "fy", "fz"]', '["fy", "fx", "fz"]'), "are those of no machine, look at force"),
        (("pz = -0.01", "pz = -0.02"), "the FMU starts it at (0, 0, -0.02) m, 0.01 m from its place"),
        (("mass = 2.0", "mass = 2.0, gain = 0.0"), "no unit force or moment moves the body"),
        (('body         = "box"', 'body = "box"\nattitude = ["pz", "px", "py", "pz"]'), "turned by 1.57"),
        (('body         = "box"', 'body = "box"\nattitude = ["", "", "", ""]'), "without a finite pose"),
    ],
)
def test_a_wrong_frame_is_refused_before_the_start(case, change, message):
    with pytest.raises(CaseError) as error:
        rows_of(case(BOX + FOREIGN.replace(*change) + BALL), 0.001)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('"M"', '"N"'), 'fmus.motor.drives.shaft.torque: the FMU has no variable "N"'),
        (('"M"', '"w"'), '"w" is no output of the FMU but: input'),
        (('speed  = "w"', 'speed  = "R"'), "A run cannot change it: give it under start"),
        (('torque = "M"', 'torque = "I"'), '"I" has the unit A, which is no unit of torque like N m'),
        (("U = 24.0", "V = 24.0"), 'the FMU has no variable "V"'),
        (("U = 24.0", 'U = "24 V"'), '"U" is of type Real, got "24 V"'),
        (('speed  = "w"', 'speed  = "fault"'), "is no input of the FMU but: parameter"),
        (("start = {", 'units = { M = "kN m" }\nstart = {'), '"M" has the unit N.m, the case says kN m'),
        (('speed  = "w"', 'speed  = "w"\nset_speed = "w"'), '"w" is set twice'),
    ],
)
def test_a_wrong_mapping_is_refused_with_its_key(case, change, message):
    with pytest.raises(CaseError) as error:
        fmu_plans(case(SHAFT + MOTOR.replace(*change)))
    assert message in str(error.value)


def test_all_faults_of_a_mapping_come_at_once(case):
    text = MOTOR.replace('"M"', '"N"').replace('speed  = "w"', 'speed  = "R"').replace("U = 24.0", "V = 1.0")
    with pytest.raises(CaseError) as error:
        fmu_plans(case(SHAFT + text))
    assert len(error.value.faults) == 3


def test_units_of_the_fmu_are_converted(case):
    """A motor whose torque is declared in kN m drives like one in N m with a thousandth of the constant."""
    thousand = description(units={"M": "kN.m", "w": "rpm"})
    plan = fmu_plans(case(SHAFT + MOTOR, text=thousand))[0]
    assert (plan.outputs[0].factor, plan.inputs[0].factor) == (1000.0, 2.0 * np.pi / 60.0)


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"text": description(version="1.0")}, "is an FMU of FMI 1.0; FMI 2 and 3 are taken"),
        ({"text": description(kind="ModelExchange")}, "is for model exchange only: it brings no solver"),
        ({"platform": "win64"}, "has no library for linux64, it has win64"),
        ({"text": "<no xml"}, "the description of bench.fmu cannot be read"),
        ({"members": {"../outside": b""}}, "which leads out of the archive"),
        ({"members": {"/outside": b""}}, "which leads out of the archive"),
        ({"members": {"..\\outside": b""}}, "which leads out of the archive"),
        ({"members": {"resources/../../outside": b""}}, "which leads out of the archive"),
        ({"members": {"C:/outside": b""}}, "which leads out of the archive"),
    ],
)
def test_an_fmu_that_cannot_be_taken_is_refused(case, how, message):
    with pytest.raises(CaseError) as error:
        fmu_plans(case(SHAFT + MOTOR, **how))
    assert message in str(error.value)


def test_a_link_in_an_archive_is_refused(case, tmp_path):
    loaded = case(SHAFT + MOTOR)
    with zipfile.ZipFile(tmp_path / "bench.fmu", "a") as archive:
        link = zipfile.ZipInfo("resources/link")
        link.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(link, "/etc/passwd")
    with pytest.raises(CaseError, match="which is a link or a device"):
        fmu_plans(load_case(tmp_path / "case.toml"))
    with pytest.raises(CaseError, match="has changed: SHA-256"):
        fmu_plans(loaded)


def test_a_corrupt_archive_is_refused(case, tmp_path):
    case(SHAFT + MOTOR)
    whole = (tmp_path / "bench.fmu").read_bytes()
    (tmp_path / "bench.fmu").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(CaseError, match="cannot be read as an FMU"):
        fmu_plans(load_case(tmp_path / "case.toml"))
    with zipfile.ZipFile(tmp_path / "bench.fmu", "w") as archive:
        archive.writestr("readme.txt", "no model")
    with pytest.raises(CaseError, match="holds no modelDescription"):
        fmu_plans(load_case(tmp_path / "case.toml"))


def test_a_library_that_is_damaged_in_its_archive_is_not_run(case, tmp_path, library):
    case(SHAFT + MOTOR)
    path = tmp_path / "bench.fmu"
    damaged = bytearray(path.read_bytes())
    damaged[damaged.index(library) + len(library) // 2] ^= 1  # the archive stores without compression
    path.write_bytes(damaged)
    with pytest.raises(CaseError, match=r"bench.fmu cannot be read as an FMU: Bad CRC-32"):
        run(load_case(tmp_path / "case.toml"), to=tmp_path / "a.h5", trust_fmu=True)
    assert not (tmp_path / "a.h5").exists()


CONTROLLER = """
[[fmus]]
name  = "controller"
file  = "bench.fmu"
start = { U = 24.0 }

[[fmus.drives]]
drive     = "shaft"
speed     = "w"
"""


def test_an_fmu_that_gives_no_torque_gets_the_motion_and_feeds_the_next(case, tmp_path):
    """Its torque is the voltage of the motor below it."""
    chain = CONTROLLER + MOTOR.replace("start = { U = 24.0 }", 'links = { U = "controller.M" }')
    with pytest.raises(CaseError, match=r'fmus.motor.links.U: "U" has the unit V, "M" has N.m'):
        fmu_plans(case(SHAFT + chain))
    plain = description(units={"M": "1"})
    with run(case(SHAFT + chain, text=plain), to=tmp_path / "a.h5", trust_fmu=True) as result:
        torque = result.series.drive_shaft_torque.values
    with run(case(SHAFT + MOTOR), to=tmp_path / "b.h5", trust_fmu=True) as result:
        alone = result.series.drive_shaft_torque.values
    # 24 V on 2 Ohm and 0.5 N m/A are at most 6 N m: as volts a quarter of 24
    assert 0.0 < torque.max() < 6.0 / 24.0 * alone.max()


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (1, 'the output "M" of the FMU is not a finite number at t = 0.01'),
        (2, "fmus.motor: the FMU refused at t = 0.01"),
        (4, 'fmus.motor.start: the FMU changed its parameter "R" from 2 to 3 at t = 0.01'),
        (3, f"the process of the FMU ended at t = 0.01 s, by signal {signal.Signals(signal.SIGSEGV).name}"),
    ],
)
def test_a_fault_of_the_fmu_ends_the_run_with_a_sentence_and_what_was_recorded_stays(
    case, tmp_path, fault, message
):
    text = MOTOR.replace("U = 24.0", f"U = 24.0, R = 2.0, late = 0.00999, fault = {fault}")
    with pytest.raises(StepError) as error:
        run(case(SHAFT + text), to=tmp_path / "a.h5", trust_fmu=True)
    assert message in str(error.value)
    with nm.open_result(tmp_path / "a.h5") as result:
        assert result.state.startswith("failed")
        assert result.series.time.values[-1] > 0.009


def test_native_code_is_run_only_where_it_is_trusted(case, tmp_path):
    loaded = case(SHAFT + MOTOR)
    with pytest.raises(CaseError) as error:
        run(loaded, to=tmp_path / "a.h5")
    assert "are run only where they are trusted" in str(error.value)
    assert f"is native code of bench 1.2, FMI 2, made by cc, SHA-256 {loaded.fmus[0].sha256}" in str(
        error.value
    )
    assert not (tmp_path / "a.h5").exists()


def test_an_answer_that_is_no_run_refuses_an_fmu(case):
    with pytest.raises(CaseError, match="are run by run and resume only"):
        build(case(SHAFT + MOTOR), None)


@pytest.mark.parametrize("name", ["dimensionless", "1", "m/m"])
def test_a_unit_that_is_a_plain_number_says_nothing_of_the_quantity(case, name):
    """Some programs give it to every variable: the case says what the variable is, or it is SI."""
    text = description(units={"M": name}).replace("<UnitDefinitions>", UNITLESS)
    given = MOTOR.replace("start = {", 'units = { M = "kN m" }\nstart = {')
    assert fmu_plans(case(SHAFT + given, text=text))[0].outputs[0].factor == 1000.0
    assert fmu_plans(case(SHAFT + MOTOR, text=text))[0].outputs[0].factor == 1.0
    assert "without a declared unit, taken as SI: M" in "".join(fmu_lines(case(SHAFT + MOTOR, text=text)))


def test_check_reads_the_description_only(case):
    lines = fmu_lines(case(SHAFT + MOTOR))
    assert "gets w; gives M" in lines[1]
    assert "its state can be rolled back and stored" in lines[0]
