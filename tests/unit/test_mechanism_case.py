"""Any mechanism as data: what a file says is what is built, what is wrong is told with its line, a run goes
on bit for bit.
"""

import math

import numpy as np
import pytest

import nutamill as nm
from nutamill.analysis.mechanism import ledger_share, mechanism_summary_lines, part_loads
from nutamill.analysis.source import drawing_of
from nutamill.base.errors import CaseError, MillError
from nutamill.case import Machine, case_of_text, load_case, load_mill
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


def test_what_shows_mills_says_that_a_mechanism_is_none(file, tmp_path):
    nm.run(load_case(file), to=tmp_path / "a.h5").close()
    with open_result(tmp_path / "a.h5") as result:
        for ask in (
            lambda: figure_of(result, "run"),
            lambda: write_report([result.path], tmp_path / "a.html"),
        ):
            with pytest.raises(MillError, match=r"is the run of a mechanism|no run of a mill"):
                ask()
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


def test_check_tells_masses_freedom_and_modes(file):
    sheet = machine_sheet(load_case(file).with_("run.start", "rest"))
    said = "\n".join(sheet.lines())
    assert "arm 2" in said
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


def test_all_faults_of_a_file_are_told_at_once_with_their_lines(tmp_path):
    said = refusal(
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
        assert words in said, words


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


def test_units_and_unknown_keys_of_a_part_are_told_with_their_lines(tmp_path):
    said = refusal(tmp_path, HEAD + ARM.replace('"2 kg"', "2").replace("position", "positoin") + PIN + REST)
    assert 'bad.toml:6: bodies.arm.mass: needs a unit: write "2 kg"' in said
    assert 'bodies.arm.positoin: unknown key. Did you mean "position"?' in said
    assert "bodies.arm.position: is missing" in said and "numill" not in said


def test_a_loop_that_does_not_close_is_refused_before_a_step(file):
    case = load_case(file).with_("joints.pin.point_b", ("0 mm", "0 mm", "2 mm"))
    with pytest.raises(CaseError, match=r"joint 'pin'.*gap of 2 mm"):
        build(case, None)


def test_what_only_a_mill_can_do_refuses_a_mechanism(file):
    with pytest.raises(CaseError, match=r"describes a mechanism part by part \(\[\[bodies\]\]\), not a mill"):
        load_mill(file)
