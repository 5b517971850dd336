"""Any mechanism as data: the parts of a file are those of the model, a fault has its line, and a resumed run
has the same bits.
"""

import math

import numpy as np
import pytest

import nutamill as nm
from nutamill.analysis.mechanism import ledger_share, mechanism_summary_lines, part_loads
from nutamill.analysis.source import drawing_of
from nutamill.base.errors import CaseError, MillError
from nutamill.case import Machine, case_of_text, load_case
from nutamill.design.machine_sheet import machine_sheet
from nutamill.mechanism.modes import modes, static_equilibrium
from nutamill.result import open_result
from nutamill.simulation.setup.mechanism import assemble_machine, mechanism_parts
from nutamill.simulation.setup.model import build
from nutamill.view.figures.mechanism import draw_reactions
from nutamill.view.figures.named import figure_of
from nutamill.view.report import write_report
from nutamill.view.webview import view_page

HEAD = 'schema = 1\ntitle = "pendulum on a spring"\n'
ARM = """
[[bodies]]
name     = "arm"
mass     = "2 kg"
inertia  = ["0.1 kg m^2", "0.1 kg m^2", "0.05 kg m^2", "0 kg m^2", "0.01 kg m^2", "0 kg m^2"]
position = ["0 mm", "0 mm", "-500 mm"]
turn     = { axis = [0, 0, 2], angle = "90 deg" }
"""
PIN = """
[[joints]]
name     = "pin"
kind     = "revolute"
between  = ["ground", "arm"]
point    = ["0 mm", "0 mm", "0 mm"]
axis     = [0, 1, 0]
friction = { viscous = "0.2 N m s/rad" }
"""
REST = """
[[springs]]
name        = "coil"
between     = ["ground", "arm"]
point_a     = ["1 m", "0 mm", "-500 mm"]
point_b     = ["0 mm", "0 mm", "-500 mm"]
stiffness   = "50 N/m"
damping     = "3 N s/m"
free_length = "900 mm"

[[sensors]]
name = "tip"
kind = "velocity"
of   = "arm"
at   = ["0 mm", "0 mm", "-1 m"]
axes = "arm"

[run]
until       = "0.3 s"
step        = "300 us"
checkpoint  = "0.1 s"
"""


@pytest.fixture
def file(tmp_path):
    """A pendulum with a spring, friction and a sensor, as a file."""
    path = tmp_path / "pendulum.toml"
    path.write_text(HEAD + ARM + PIN + REST)
    return path


def refusal(tmp_path, text) -> str:
    """What `load_case` says of a file."""
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(CaseError) as caught:
        load_case(path)
    return str(caught.value)


def test_a_file_with_bodies_is_a_mechanism_and_survives_toml(file):
    case = load_case(file)
    assert isinstance(case, Machine)
    assert case_of_text(case.to_toml()) == case
    assert isinstance(load_case("numill"), nm.Case)


def test_the_file_is_what_is_built(file):
    parts = mechanism_parts(load_case(file))
    arm, spring = parts.bodies[0], parts.springs[0]
    # 90 deg about z: q = (cos 45, 0, 0, sin 45); six inertias are xx, yy, zz, xy, xz, yz
    assert np.allclose(arm.quaternion, (math.sqrt(0.5), 0, 0, math.sqrt(0.5)))
    assert np.allclose(arm.inertia, [[0.1, 0, 0.01], [0, 0.1, 0], [0.01, 0, 0.05]])
    assert (spring.stiffness, spring.damping, spring.free_length) == (50.0, 3.0, 0.9)
    assert parts.joints[0].friction.viscous == 0.2


def test_a_part_is_changed_by_its_name(file):
    assert load_case(file, ["bodies.arm.mass=5 kg"]).bodies[0].mass == 5.0
    assert load_case(file).with_("springs.coil.stiffness", 70.0).springs[0].stiffness == 70.0


def test_a_machine_without_a_crank_has_every_picture_that_its_series_allow(file, tmp_path):
    nm.run(load_case(file), to=tmp_path / "a.h5").close()
    with open_result(tmp_path / "a.h5") as result:
        with pytest.raises(MillError, match=r"must hold a charge"):
            figure_of(result, "flow")
        assert len(figure_of(result, "run").axes) == 1  # the forces of its joint
        page = write_report([result.path], tmp_path / "a.html").read_text(encoding="utf-8")
        assert "joint pin" in page or "pin force" in page
        assert len(figure_of(result, "history:tip_velocity_x").axes) == 1
        # a machine without a drawing is shown by its walls and the rods to its joints
        assert '"home":"ground"' in view_page(result)


def test_steps_divide_the_rows(file):
    model, _, _ = build(load_case(file), None)
    # 1 ms between rows, steps of 300 us at most: four steps of 250 us
    assert model.clock.windows_per_row == 4
    assert model.clock.window == pytest.approx(250e-6, rel=1e-12)


def test_a_run_records_every_part_and_its_ledger_closes(file, tmp_path):
    with nm.run(load_case(file), to=tmp_path / "a.h5") as result:
        assert drawing_of(result) is None
        names = set(map(str, result.series.data_vars))
        assert {
            "joint_pin_force_z",
            "tip_velocity_x",
            "spring_coil_loss",
            "joint_pin_loss",
            "ledger_residual",
        } <= names
        # at rest: the spring, 0.1 m long of its 0.9 m, pulls with 50 x 0.1 N = 5 N at half the arm; gravity
        # has no moment
        inertia = 0.1 + 2.0 * 0.5**2
        acceleration = result.series["tip_velocity_y"].values[1] / 1e-3
        # arm axes are turned by 90 deg: world x is the arm's -y; after 1 ms the speed has grown by the first
        # acceleration
        assert acceleration == pytest.approx(
            -5.0 * 0.5 / inertia, rel=2e-2
        )  # damping 0.2 + 3 x 0.25 over the inertia: 1.6 /s x 1 ms
        assert ledger_share(result) < 1e-5  # second order: (6 rad/s x 250 us)^2
        assert [load.part for load in part_loads(result)] == ["joint_pin"]
        assert any("joint_pin" in line for line in mechanism_summary_lines(result))
        assert len(draw_reactions(result).axes) == 1


def test_a_resumed_mechanism_is_the_one_that_never_stopped(file, tmp_path):
    case = load_case(file)
    with nm.run(case, to=tmp_path / "whole.h5") as whole:
        expected = whole.series["joint_pin_force_x"].values
    nm.run(case.with_("run.until", 0.2), to=tmp_path / "part.h5").close()
    with nm.resume(tmp_path / "part.h5", until=0.3) as result:
        assert np.array_equal(result.series["joint_pin_force_x"].values, expected)


def test_check_prints_masses_freedom_and_modes(file):
    sheet = machine_sheet(load_case(file).with_("run.start", "rest"))
    text = "\n".join(sheet.lines())
    assert "arm 2" in text
    assert sheet.freedoms == 1 and sheet.driven == 0
    # about rest near straight down: (m g l + k l^2 to first order) / (I + m l^2), the spring pulling along
    # its own axis
    frequency = math.sqrt((2.0 * 9.81 * 0.5 + 50.0 * 0.25) / (0.1 + 2.0 * 0.25)) / (2 * math.pi)
    # at rest the spring has turned the arm by 0.11 rad, which changes both terms by some per cent
    assert sheet.modes[0][0] == pytest.approx(frequency, rel=0.05)


def test_check_names_what_is_held_twice(tmp_path):
    path = tmp_path / "two.toml"
    second = PIN.replace('"pin"', '"second"').replace(
        'point    = ["0 mm", "0 mm"', 'point    = ["0 mm", "100 mm"'
    )
    path.write_text(HEAD + 'redundant = "allow"\n' + ARM + PIN + second + REST)
    sheet = machine_sheet(load_case(path))
    assert len(sheet.redundant) == 5 and sheet.freedoms == 1
    assert all(line.startswith("joint 'second'") and "joint 'pin'" in line for line in sheet.redundant)
    assert sheet.not_unique == ["pin", "second"]


def test_a_body_that_nothing_holds_is_named_by_the_search_for_modes(file):
    case = load_case(file)
    engine = assemble_machine(
        Machine.model_validate(
            {**case.model_dump(by_alias=True), "joints": (), "springs": (), "gravity": (0, 0, 0)}
        )
    )
    static_equilibrium(*engine)
    with pytest.raises(CaseError, match=r"no restoring force, got (translation|rotation) of body 'arm'"):
        modes(*engine)
    assert machine_sheet(load_case(file)).modes


def test_all_faults_of_a_file_are_reported_at_once_with_their_lines(tmp_path):
    message = refusal(
        tmp_path,
        HEAD
        + ARM.replace('mass     = "2 kg"', 'mass     = "0 kg"')
        + PIN.replace('"arm"', '"amr"').replace("axis     = [0, 1, 0]\n", "")
        + '[[bushings]]\nname = "mount"\nbetween = ["ground", "arm"]\npoint = ["0 mm", "0 mm", "0 '
        'mm"]\naxis = [0, 0, 0]\n'
        + '[[drives]]\nname = "motor"\njoint = "pim"\nspeed = "10 rpm"\nramp = "10 rpm/s"\n'
        + REST.replace('point_b     = ["0 mm",', 'point_b     = ["1 m",'),
    )
    for words in (
        "bad.toml:6: bodies.arm.mass: must be positive, got 0 kg",
        'joints.pin.between[1]: no body is called "amr". Did you mean "arm"?',
        "joints.pin.axis: is missing for a revolute joint",
        "bushings.mount.axis: must have a length",
        "bushings.mount: must have some stiffness or damping",
        'drives.motor.joint: no joint is called "pim". Did you mean "pin"?',
        "springs.coil.point_b: is the same point as point_a",
    ):
        assert words in message, words


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ARM, 'bodies[1].name: is the name of two parts, got "arm". Rename one of the two'),
        (
            PIN.replace("pin", "ball").replace("revolute", "spherical").replace("axis     = [0, 1, 0]\n", "")
            + '[[drives]]\nname = "motor"\njoint = "ball"\nspeed = "1 rpm"\nramp = "1 rpm/s"\n',
            'drives.motor.joint: must be a revolute or cylindrical joint, got "ball", a spherical joint',
        ),
        (
            '[[sensors]]\nname = "joint_a"\nkind = "position"\nof = "arm"\n',
            'sensors.joint_a.name: begins like the series of a part, got "joint_a". Choose a name that does '
            "not begin with joint_, bushing_, drive_, spring_, torque_",
        ),
    ],
)
def test_parts_that_contradict_each_other_are_refused(tmp_path, text, message):
    assert message in refusal(tmp_path, HEAD + ARM + PIN + text + REST)


def test_faults_of_units_and_unknown_keys_of_a_part_name_their_lines(tmp_path):
    message = refusal(
        tmp_path, HEAD + ARM.replace('"2 kg"', "2").replace("position", "positoin") + PIN + REST
    )
    assert 'bad.toml:6: bodies.arm.mass: needs a unit: write "2 kg"' in message
    assert 'bodies.arm.positoin: unknown key. Did you mean "position"?' in message
    assert "bodies.arm.position: is missing" in message and "numill" not in message


def test_a_loop_that_does_not_close_is_refused_before_a_step(file):
    case = load_case(file).with_("joints.pin.point_b", ("0 mm", "0 mm", "2 mm"))
    with pytest.raises(CaseError, match=r"joint 'pin'.*gap of 2 mm"):
        build(case, None)


def test_forces_preloads_and_motors_of_a_file_are_built_and_recorded(tmp_path):
    path = tmp_path / "pushed.toml"
    loads = (
        REST.replace('free_length = "900 mm"', 'preload = "5 N"')
        + """
[[forces]]
name  = "push"
body  = "arm"
at    = ["0 mm", "0 mm", "-1 m"]
table = [["0 s", ["0 N", "0 N", "0 N"]], ["0.1 s", ["4 N", "0 N", "-2 N"]]]

[[forces]]
name  = "load"
body  = "arm"
force = ["0 N", "1 N", "0 N"]

[[drives]]
name  = "motor"
joint = "pin"
speed = "10 rpm"
ramp  = "60 rpm/s"
motor = { torque = "2 N m", gain = "3 N m s/rad", integral_time = "0.5 s" }
"""
    )
    path.write_text(HEAD + ARM + PIN + loads)
    case = load_case(path)
    assert case_of_text(case.to_toml()) == case
    parts = mechanism_parts(case)
    push, load = parts.forces
    assert (push.times, push.forces[1], push.point) == ((0.0, 0.1), (4.0, 0.0, -2.0), (0.0, 0.0, -1.0))
    assert (load.times, load.forces, load.point) == (None, (0.0, 1.0, 0.0), None)
    assert (parts.springs[0].free_length, parts.springs[0].preload) == (None, 5.0)
    motor = parts.drives[0].motor
    assert (motor.gain, motor.integral_gain, motor.torque_limit) == (3.0, 6.0, 2.0)
    with nm.run(case, to=tmp_path / "a.h5") as result:
        assert "force_push_work" in result.series
        assert ledger_share(result) < 1e-4  # of second order: (w dt)^2 with the controller's 3/0.6 per second


def test_forces_and_springs_that_say_too_little_or_too_much_are_refused(tmp_path):
    text = refusal(
        tmp_path,
        HEAD + ARM + PIN + REST.replace('free_length = "900 mm"', "")
        + """
[[forces]]
name = "a"
body = "leg"

[[forces]]
name  = "b"
body  = "arm"
table = [["0.5 s", ["0 N", "0 N", "0 N"]], ["0.1 s", ["4 N", "0 N", "-2 N"]]]
""",
    )  # fmt: skip
    for line in (
        'no body that moves is called "leg"',
        "must have either a free_length or a preload",
        "must have either a force or a table",
        "must begin at 0 s",
    ):
        assert line in text


SLIDE = """
[[bodies]]
name     = "slide"
mass     = "2 kg"
inertia  = ["0.1 kg m^2", "0.1 kg m^2", "0.1 kg m^2"]
position = ["0 mm", "0 mm", "0 mm"]

[[joints]]
name    = "guide"
kind    = "prismatic"
between = ["ground", "slide"]
point   = ["0 mm", "0 mm", "0 mm"]
axis    = [1, 0, 0]

[[springs]]
name      = "coil"
between   = ["ground", "slide"]
point_a   = ["1 m", "0 mm", "0 mm"]
point_b   = ["0 mm", "0 mm", "0 mm"]
stiffness = "50 N/m"
preload   = "4 N"

[[linear_drives]]
name   = "ram"
joint  = "guide"
speeds = [["0 s", "0 m/s"], ["0.1 s", "0.2 m/s"]]

[[sensors]]
name = "coil"
kind = "spring"
of   = "coil"

[run]
until = "0.2 s"
step  = "500 us"
"""


def test_a_linear_drive_and_a_spring_are_recorded(tmp_path):
    path = tmp_path / "slide.toml"
    path.write_text(HEAD + SLIDE)
    case = load_case(path)
    assert case_of_text(case.to_toml()) == case
    assert case.drive.ramp_end == 0.1
    with nm.run(case, to=tmp_path / "a.h5") as result:
        series = {name: float(values.values[-1]) for name, values in result.series.data_vars.items()}
        assert ledger_share(result) < 1e-9  # loads that are linear in the travel: works are exact
    travel = 0.5 * 0.1 * 0.2 + 0.1 * 0.2
    assert series["linear_drive_ram_travel"] == pytest.approx(travel, abs=1e-12)
    assert series["linear_drive_ram_speed"] == pytest.approx(0.2, abs=1e-12)
    assert series["coil_spring_length"] == pytest.approx(1.0 - travel, abs=1e-12)
    assert series["coil_spring_force"] == pytest.approx(4.0 - 50.0 * travel, abs=1e-9)
    assert series["linear_drive_ram_force"] == pytest.approx(-4.0 + 50.0 * travel, abs=1e-9)


def test_linear_drives_that_no_joint_takes_are_refused(tmp_path):
    text = refusal(
        tmp_path,
        HEAD
        + ARM
        + PIN
        + REST
        + """
[[linear_drives]]
name   = "ram"
joint  = "pin"
speeds = [["0.1 s", "0 m/s"], ["0.1 s", "0.2 m/s"]]
""",
    )
    assert 'must be a prismatic joint, got "pin", a revolute joint' in text
    assert "must begin at 0 s" in text


DISC = """
[[bodies]]
name     = "disc"
mass     = "2 kg"
inertia  = ["0.1 kg m^2", "0.1 kg m^2", "0.1 kg m^2"]
position = ["0 mm", "0 mm", "0 mm"]

[[bodies]]
name     = "jar"
mass     = "1 kg"
inertia  = ["0.01 kg m^2", "0.01 kg m^2", "0.01 kg m^2"]
position = ["200 mm", "0 mm", "0 mm"]

[[joints]]
name    = "bearing"
kind    = "revolute"
between = ["ground", "disc"]
point   = ["0 mm", "0 mm", "0 mm"]
axis    = [0, 0, 1]

[[joints]]
name    = "pivot"
kind    = "revolute"
between = ["disc", "jar"]
point   = ["200 mm", "0 mm", "0 mm"]
axis    = [0, 0, 1]

[[gears]]
name   = "belt"
input  = "bearing"
output = "pivot"
ratio  = -3

[[drives]]
name  = "motor"
joint = "bearing"
speed = "10 rad/s"
ramp  = "100 rad/s^2"

[run]
until = "0.05 s"
step  = "500 us"
"""


def test_a_gear_of_a_file_turns_the_jar_and_its_torque_is_recorded(tmp_path):
    path = tmp_path / "planetary.toml"
    path.write_text(HEAD + DISC)
    case = load_case(path)
    assert case_of_text(case.to_toml()) == case
    with nm.run(case, to=tmp_path / "a.h5") as result:
        # relative to the disc the jar turns back three times as fast: 0.01 (1 - 3) 100
        assert result.series["gear_belt_torque"].values[-1] == pytest.approx(-2.0, rel=1e-6)
        assert ledger_share(result) < 2.5e-5  # of second order: (10 rad/s x 500 us)^2


def test_gears_of_joints_that_do_not_turn_are_refused(tmp_path):
    text = refusal(
        tmp_path,
        HEAD + DISC.replace('output = "pivot"', 'output = "bearing"').replace("ratio  = -3", "ratio = 0"),
    )
    assert 'must be another joint than the input, got "bearing"' in text
    assert "must not be zero" in text
    text = refusal(tmp_path, HEAD + DISC.replace('output = "pivot"', 'output = "pivt"'))
    assert 'no joint is called "pivt"' in text


DROP = """
[[bodies]]
name     = "vessel"
mass     = "2 kg"
inertia  = ["0.1 kg m^2", "0.1 kg m^2", "0.1 kg m^2"]
position = ["0 mm", "0 mm", "60 mm"]

[[stops]]
name        = "floor"
between     = ["ground", "vessel"]
point_a     = ["0 mm", "0 mm", "0 mm"]
normal      = [0, 0, 1]
point_b     = ["0 mm", "0 mm", "60 mm"]
radius_b    = "50 mm"
stiffness   = "20 N/mm"
restitution = 0.5

[run]
until = "0.08 s"
step  = "200 us"
"""


def test_a_dropped_vessel_meets_the_stop_of_its_file(tmp_path):
    path = tmp_path / "drop.toml"
    path.write_text(HEAD + DROP)
    case = load_case(path)
    assert case_of_text(case.to_toml()) == case
    with nm.run(case, to=tmp_path / "a.h5") as result:
        series = {name: values.values for name, values in result.series.data_vars.items()}
        assert ledger_share(result) < (100.0 * 200e-6) ** 2  # second order: w = sqrt(k / m) = 100 rad/s
    assert series["stop_floor_gap"][0] == pytest.approx(0.01)
    assert series["stop_floor_force"].max() > 2.0 * 9.81
    impact = 0.5 * 2.0 * 2.0 * 9.81 * 0.01  # half m v^2 with v^2 = 2 g h
    assert 0.5 * impact < series["stop_floor_loss"][-1] < impact


def test_stops_that_say_too_little_and_steps_that_are_too_long_are_refused(tmp_path):
    bad = DROP.replace("normal      = [0, 0, 1]\n", "").replace("restitution = 0.5", "restitution = 0.01")
    text = refusal(tmp_path, HEAD + bad)
    assert "must have either a normal or a radius_a" in text
    assert "must be at least 0.05, got 0.01" in text
    path = tmp_path / "long.toml"
    path.write_text(HEAD + DROP.replace("200 us", "1 ms").replace("20 N/mm", "2 kN/mm"))
    with pytest.raises(CaseError, match=r"run.step: too long for the contact of stop 'floor', got 1000 us"):
        build(load_case(path), None)


SHAKER = """
[[bodies]]
name     = "frame"
mass     = "18 kg"
inertia  = ["1 kg m^2", "1 kg m^2", "1 kg m^2"]
position = ["0 mm", "0 mm", "0 mm"]

[[joints]]
name    = "guide"
kind    = "prismatic"
between = ["ground", "frame"]
point   = ["0 mm", "0 mm", "0 mm"]
axis    = [0, 0, 1]

[[springs]]
name      = "mount"
between   = ["ground", "frame"]
point_a   = ["0 mm", "0 mm", "-500 mm"]
point_b   = ["0 mm", "0 mm", "0 mm"]
stiffness = "32 N/mm"
damping   = "300 N s/m"
preload   = "-200 N"

[[unbalance_motors]]
name         = "shaker"
body         = "frame"
point        = ["0 mm", "0 mm", "0 mm"]
axis         = [0, 1, 0]
towards      = [1, 0, 0]
mass         = "2 kg"
eccentricity = "30 mm"
speed        = "60 rad/s"
ramp         = "600 rad/s^2"

[run]
until = "0.3 s"
step  = "200 us"
"""


def test_an_unbalance_motor_of_a_file_is_a_rotor_a_bearing_and_a_drive(tmp_path):
    path = tmp_path / "shaker.toml"
    path.write_text(HEAD + SHAKER)
    case = load_case(path)
    assert case_of_text(case.to_toml()) == case
    assert case.drive.ramp_end == 0.1
    parts = mechanism_parts(case)
    assert [body.name for body in parts.bodies] == ["frame", "shaker"]
    assert parts.bodies[1].position == pytest.approx((0.03, 0.0, 0.0))
    with nm.run(case, to=tmp_path / "a.h5") as result:
        assert {"joint_shaker_force_z", "drive_shaker_torque", "drive_shaker_work"} <= set(result.series)
        assert result.series["drive_shaker_speed"].values[-1] == pytest.approx(60.0)
        assert ledger_share(result) < (60.0 * 200e-6) ** 2


def test_unbalance_motors_with_a_taken_name_or_a_slanting_mass_are_refused(tmp_path):
    text = refusal(
        tmp_path,
        HEAD
        + SHAKER.replace('name         = "shaker"', 'name         = "guide"')
        .replace("towards      = [1, 0, 0]", "towards      = [1, 1, 0]")
        .replace('body         = "frame"', 'body         = "frane"'),
    )
    assert 'is the name of a body, a joint or a drive, got "guide"' in text
    assert "must be square to the axis" in text
    assert 'no body that moves is called "frane"' in text
