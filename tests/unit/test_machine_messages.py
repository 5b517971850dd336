"""Texts of messages about machines: their set-up, their sheet before a run, and their vibrations."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from nutamill.analysis.mounts import floor_series
from nutamill.base.errors import CaseError, StepError
from nutamill.case import load_case
from nutamill.case.toml.layers import Layer
from nutamill.case.toml.locate import key_parts
from nutamill.charge.laws.capillary import separation_work
from nutamill.cli import app
from nutamill.design import campbell as campbell_room
from nutamill.design import machine_sheet as sheet_room
from nutamill.design import modes as modes_room
from nutamill.design.campbell import campbell
from nutamill.design.charge_facts import charge_facts
from nutamill.design.modes import machine_modes
from nutamill.design.runup import run_up
from nutamill.design.weights import with_charge_mass
from nutamill.mechanism import modes as rest_room
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.parts import Body, Force, Spring, Stop
from nutamill.mechanism.running_modes import solve
from nutamill.mechanism.sensors import Sensor, SensorKind, sensor_table
from nutamill.mechanism.system import System
from nutamill.mechanism.unbalance import UnbalanceMotor
from nutamill.simulation.coupling_model import Outcome
from nutamill.simulation.entry import failure
from nutamill.simulation.setup import model as model_room
from nutamill.simulation.setup.charge import pair_law
from nutamill.simulation.setup.clock import run_clock
from nutamill.simulation.setup.walls import mesh_facts

ARM = """
[[bodies]]
name = "arm"
mass = "2 kg"
inertia = ["0.1 kg m^2", "0.1 kg m^2", "0.05 kg m^2"]
position = ["0 m", "0 m", "0.5 m"]
[run]
until = "1 s"
"""
PIN = """
[[joints]]
name = "{}"
kind = "{}"
between = ["ground", "arm"]
point = ["0 m", "{} m", "0 m"]
"""
HINGE = PIN.format("pin", "revolute", 0) + "axis = [0, 1, 0]\n"
EMPTY = "charge.kind=none"


@pytest.fixture
def invoke(tmp_path, monkeypatch):
    """Write a file and run a command on it."""
    monkeypatch.chdir(tmp_path)

    def run(command, text, *words):
        (tmp_path / "arm.toml").write_text(text)
        return CliRunner().invoke(app, [command, "arm.toml", *words]).output

    return run


# before a run -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        (
            ARM + HINGE,
            ["modes     none that swing about rest, drives held", "          this equilibrium is unstable"],
        ),
        (
            ARM + PIN.format("weld", "fixed", 0),
            ["modes     none: nothing is free to vibrate with the drives held"],
        ),
        (ARM, ["modes     none: nothing holds arm"]),
        (
            'redundant = "allow"\n'
            + ARM
            + HINGE
            + HINGE.replace('"pin"', '"top"').replace("0 m", "0.1 m", 2),
            ["          reactions not unique: pin, top"],
        ),
    ],
    ids=["unstable", "nothing moves", "nothing holds", "held twice"],
)
def test_the_sheet_says_why_there_are_no_modes_and_which_reactions_are_not_unique(
    invoke, monkeypatch, text, lines
):
    monkeypatch.setattr(rest_room, "NEWTON_ROUNDS", 3)  # what falls would fall in 300 rounds as well
    sheet = invoke("check", text).splitlines()
    assert set(lines) <= set(sheet), sheet


def test_modes_about_an_unstable_equilibrium_are_refused(invoke):
    message = invoke("modes", ARM + HINGE)
    assert "modes: the equilibrium is unstable. Assemble the mechanism near a stable one" in message


def test_a_frame_that_no_body_can_be_is_refused():
    with pytest.raises(CaseError) as caught:
        machine_modes(load_case("numill", [EMPTY, "frame.gyration_yaw=1 mm"]))
    assert re.fullmatch(
        r"frame: the radii of gyration of the whole machine leave the frame moments of inertia of "
        r"\[.*\] kg m\^2, which no body has. Give larger frame.gyration_rocking or frame.gyration_yaw",
        str(caught.value),
    )


def test_cohesion_that_exceeds_the_spring_is_refused_with_the_pressure_that_would_do():
    changes = ["contact.cohesion=area"]
    changes += [f"contact.pairs.{pair}.cohesive_pressure=1 GPa" for pair in ("steel-steel", "steel-acrylic")]
    with pytest.raises(CaseError, match=r"particles would collapse. Give a cohesive_pressure well below"):
        run_clock(load_case("numill", changes).machine)


def wet_mill(**numbers):
    """The published mill with a film of oil."""
    numbers = {"liquid_viscosity": "50 mPa s", "film_thickness": "0.1 mm", "film_roughness": "1 um"} | numbers
    changes = ["contact.film=viscous"]
    for pair in ("steel-steel", "steel-acrylic"):
        changes += [f"contact.pairs.{pair}.{name}={value}" for name, value in numbers.items()]
    return load_case("numill", changes).machine


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        (
            {"film_thickness": "0.6 mm"},
            "contact.pairs steel-steel: film_thickness must be at most 0.1 of the smallest diameter, 500 um, "
            "got 600 um. The film law holds for thin layers; it does not model a bath",
        ),
        (
            {"film_roughness": "0.2 mm"},
            "contact.pairs steel-steel: film_thickness must exceed film_roughness 0.0002 m, got 0.0001 m. A "
            "film within the roughness has no effect: leave liquid_viscosity out",
        ),
    ],
)
def test_films_beyond_what_the_law_holds_for_are_refused(numbers, message):
    with pytest.raises(CaseError) as caught:
        run_clock(wet_mill(**numbers))
    assert str(caught.value).splitlines()[0] == message


def bridged_mill(**numbers):
    """The published mill with a drop of water in each contact."""
    numbers = {"bridge_volume": "10 nL", "surface_tension": "72 mN/m", "contact_angle": "20 deg"} | numbers
    changes = ["contact.film=capillary"]
    for pair in ("steel-steel", "steel-acrylic"):
        changes += [f"contact.pairs.{pair}.{name}={value}" for name, value in numbers.items()]
    return load_case("numill", changes).machine


@pytest.mark.parametrize(
    ("numbers", "messages"),
    [
        (
            {"bridge_volume": "20 nL"},  # R is the radius 2.5 mm, at a wall 5 mm
            [
                "contact.pairs steel-steel: bridge_volume must be at most 0.001 of R^3 of the smallest "
                "particles, 15.6 nL, got 20 nL. The closed form of the bridge holds for small drops; R is "
                "the diameter at a wall, else the radius"
            ],
        ),
        (
            {"contact_angle": "41 deg"},
            [
                f"contact.pairs steel-{other}: contact_angle must be from 0 to 40 deg, got 41 deg. The "
                "closed form of the bridge holds for liquids that wet"
                for other in ("steel", "acrylic")
            ],
        ),
    ],
)
def test_bridges_beyond_what_the_closed_form_holds_for_are_refused(numbers, messages):
    with pytest.raises(CaseError) as caught:
        run_clock(bridged_mill(**numbers))
    assert str(caught.value).splitlines() == messages


def test_check_prints_what_the_bridges_do():
    # pull 2 pi R gamma cos(theta), rupture R (1 + theta/2)(V*^(1/3) + V*^(2/3)/10)
    machine = bridged_mill()
    lines = charge_facts(machine).lines(machine)
    work = [
        separation_work(pair_law(machine, "steel", other), r)
        for other, r in (("steel", 1.25e-3), ("acrylic", 2.5e-3))
    ]
    assert lines[-3:] == [
        "bridges   of the quickest particles",
        f"          steel-steel          pull 1.06 mN, breaks at 255 um, parting takes {work[0]:.2e} J",
        f"          steel-acrylic wall   pull 2.13 mN, breaks at 254 um, parting takes {work[1]:.2e} J",
    ]


def test_a_thick_liquid_shortens_the_substep():
    # its braking time m R^-2 roughness/(6 pi mu) at the roughness, of two pellets
    thick, plain = run_clock(wet_mill(liquid_viscosity="500 Pa s")), run_clock(wet_mill())
    assert thick.substep < 0.1 * plain.substep


def test_the_mass_of_a_charge_needs_a_ring_to_be_put_on():
    case = load_case("numill")
    bare = case.model_copy(update={"chamber": case.chamber.model_copy(update={"bars": None})})
    with pytest.raises(CaseError) as caught:
        with_charge_mass(bare)
    assert str(caught.value) == (
        "chamber.bars: is missing, so that the mass of the charge has no position. Leave the mass of the "
        "charge out, or give the drawing of a mill radius and depth of a ring"
    )


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        (
            "vessel.stl",
            "solid x\nendsolid x\n",
            "vessel.stl: has no triangles. Is it a mesh file, and whole?",
        ),
        ("vessel.obj", "v a b c\nf 1 2 3\n", "vessel.obj: cannot be read as a mesh: "),
    ],
)
def test_a_mesh_file_without_triangles_is_refused(tmp_path, name, content, message):
    (tmp_path / name).write_text(content)
    file = tmp_path / "mill.toml"
    file.write_text(f'base = "numill"\n[chamber.mesh]\nfile = "{name}"\nunit = "mm"\n')
    with pytest.raises(CaseError) as caught:
        mesh_facts(load_case(file).machine)
    assert str(caught.value).startswith(message)


def test_a_force_on_the_floor_that_is_not_recorded_is_refused():
    machine = load_case("numill", [EMPTY]).machine
    with pytest.raises(CaseError) as caught:
        floor_series({"time": np.zeros(3)}, machine)
    assert str(caught.value) == (
        "run.series: leaves out joint_intermediate_shaft_bearing_force_x, which this answer needs. Add it"
    )


# vibrations -------------------------------------------------------------------------------------------------


CRANK_ON_A_SPRING = """
schema = 1
gravity = ["0 m/s^2", "0 m/s^2", "0 m/s^2"]
drives = [{ name = "motor", joint = "pin", speed = "100 rpm", ramp = "100 rpm/s" }]

[[bodies]]
name     = "crank"
mass     = "1 kg"
inertia  = ["1 kg m^2", "1 kg m^2", "1 kg m^2"]
position = ["0 m", "0 m", "0 m"]

[[bodies]]
name     = "bob"
mass     = "1 kg"
inertia  = ["1 kg m^2", "1 kg m^2", "1 kg m^2"]
position = ["2 m", "0 m", "0 m"]

[[joints]]
name    = "pin"
kind    = "revolute"
between = ["ground", "crank"]
point   = ["0 m", "0 m", "0 m"]
axis    = [0, 0, 1]

[[springs]]
name        = "spring"
between     = ["ground", "crank"]
point_a     = ["1 m", "1 m", "0 m"]
point_b     = ["1 m", "0 m", "0 m"]
stiffness   = "1 N/mm"
free_length = "1 m"

[[bushings]]
name              = "foot"
between           = ["ground", "bob"]
point             = ["2 m", "0 m", "0 m"]
axis              = [0, 0, 1]
shear_stiffness   = "1 N/mm"
axial_stiffness   = "1 N/mm"
bending_stiffness = "1 N m/rad"
torsion_stiffness = "1 N m/rad"

[run]
until = "1 s"
"""


def test_a_drive_that_strains_a_spring_leaves_no_steady_motion_to_vibrate_about(tmp_path):
    (tmp_path / "crank.toml").write_text(CRANK_ON_A_SPRING)
    with pytest.raises(StepError) as caught:
        machine_modes(load_case(tmp_path / "crank.toml"), 10.0)
    assert str(caught.value) == (
        "running modes: the drives strain bushings or springs, so that there is no steady motion to vibrate "
        "about. Take the modes at rest."
    )


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (
            lambda: machine_modes(load_case("numill", [EMPTY]), -1.0),
            "speed: must be zero or more, got -1 rad/s",
        ),
        (
            lambda: machine_modes(
                load_case("numill", [EMPTY, "shaft_coupling.torsion_stiffness=1e-5 N m/rad"])
            ),
            "modes: a motion of the machine has no stiffness. Give mounts and shaft_coupling stiffness in "
            "that direction",
        ),
    ],
)
def test_a_mill_that_cannot_vibrate_is_refused(act, message):
    with pytest.raises(CaseError) as caught:
        act()
    assert str(caught.value) == message


def test_a_number_of_modes_that_changes_with_the_speed_is_refused(monkeypatch):
    def modes_at(case, speed=0.0, charge=False):
        n = 7 if speed == 0.0 else 6
        shapes = np.ones((1, 6, n), complex)
        return modes_room.MachineModes(speed, np.ones(n), np.zeros(n), shapes, np.ones((1, 2, n)), ("frame",))

    monkeypatch.setattr(campbell_room, "machine_modes", modes_at)
    with pytest.raises(CaseError) as caught:
        campbell(load_case("numill", [EMPTY]), np.pi * 20.0, 2)
    assert str(caught.value) == (
        "campbell: the number of modes changes with the speed: 7 at rest, 6 at 600 rpm. Choose a lower speed"
    )


def test_free_coordinates_that_do_not_determine_the_others_are_refused():
    with pytest.raises(
        StepError, match=r"running modes: 2 constraints do not determine 2 coordinates. Check"
    ):
        solve(np.zeros((2, 2)), np.zeros(2))


def test_a_run_up_sets_the_ramp_itself(tmp_path):
    profile = tmp_path / "speed.csv"
    profile.write_text("time [s], speed [rpm]\n0, 0\n1, 60\n")
    with pytest.raises(
        CaseError, match=r"drive.profile: has no use in a run-up, which sets the ramp itself."
    ):
        run_up(load_case("numill", [EMPTY, f"drive.profile={profile}"]), [1.0])


# a start that is not finite ---------------------------------------------------------------------------------


def test_a_body_that_turns_beyond_all_bounds_has_no_finite_acceleration():
    body = Body("top", 1.0, np.diag([1.0, 1.5, 2.0]), (0, 0, 0), angular_velocity=(1e200, 1e200, 1e200))
    with np.errstate(all="ignore"), pytest.raises(StepError, match="first accelerations: they are not fini"):
        System([body])


@pytest.mark.parametrize(
    ("room", "act", "message"),
    [
        (
            sheet_room,
            sheet_room.machine_sheet,
            "arm: the accelerations at the start are not finite. Check the masses and inertias.",
        ),
        (
            model_room,
            lambda case: model_room.build(case, None),
            "arm: the first accelerations are not finite. Look at the masses and inertias of the bodies.",
        ),
        (
            rest_room,
            lambda case: rest_room.static_equilibrium(*model_room.assemble_machine(case)),
            "static equilibrium: the accelerations are not finite. Check that every body is supported.",
        ),
    ],
)
def test_a_start_that_fails_is_named(tmp_path, monkeypatch, room, act, message):
    file = tmp_path / "arm.toml"
    file.write_text(ARM + HINGE)
    case = load_case(file)
    monkeypatch.setattr(room, "start", lambda *parts: 1)
    with pytest.raises(StepError) as caught:
        act(case)
    assert str(caught.value) == message


def test_the_first_recorded_series_is_the_time(tmp_path):
    file = tmp_path / "arm.toml"
    file.write_text(ARM + HINGE)
    case = load_case(file)
    other = model_room.build(case, None)[0].readout.names[1]
    with pytest.raises(CaseError) as caught:
        model_room.build(case.with_("run.series", [other]), None)
    assert str(caught.value) == 'run.series: the first must be "time"'


def test_a_sensor_in_the_axes_of_no_body_is_refused():
    mechanism, state, _ = assemble([Body("arm", 1.0, np.eye(3), (0, 0, 0))], [])
    with pytest.raises(CaseError, match=r"sensor 'tip': unknown axes_body, got 'amr'. Known are "):
        sensor_table(mechanism, state, [Sensor("tip", SensorKind.POINT_VELOCITY, "arm", axes_body="amr")])


# a run ------------------------------------------------------------------------------------------------------


def test_passes_that_do_not_converge_are_named_with_their_time():
    state = SimpleNamespace(
        charge=None,
        coupling=SimpleNamespace(outcome=[Outcome.NOT_CONVERGED]),
        mechanism=SimpleNamespace(time=[0.25]),
    )
    assert failure(None, state) == (
        "t = 0.25 s: the passes over a window did not converge. Shorten the window (run.window), or use "
        'run.coupling = "staggered".'
    )


# files ------------------------------------------------------------------------------------------------------


def test_a_file_nested_beyond_the_reader_is_refused():
    with pytest.raises(CaseError, match=r"deep.toml(:1:\d+)?: is nested too deeply"):
        Layer.of_text("a = " + "[" * 100_000, "deep.toml")


def test_two_keys_are_not_one():
    with pytest.raises(ValueError, match="more than one key in 'a = 1"):
        key_parts("a = 1\nb")


def test_a_drive_has_a_ramp_or_a_profile(tmp_path):
    file = tmp_path / "arm.toml"
    file.write_text(ARM + HINGE + '[[drives]]\nname = "motor"\njoint = "pin"\nspeed = "1 rpm"\n')
    with pytest.raises(CaseError, match=r"drives.motor: needs either a ramp or a profile, not both or none"):
        load_case(file)


def test_of_many_wrong_cells_ten_are_listed_and_the_rest_counted(tmp_path):
    profile = tmp_path / "speed.csv"
    profile.write_text("time [s], speed [rpm]\n" + "x, y\n" * 8)
    with pytest.raises(CaseError, match="6 more cells are wrong, of 16"):
        load_case("numill", [f"drive.profile={profile}"])


# parts of the engine ----------------------------------------------------------------------------------------

ORIGIN, UP = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        (
            {"springs": [Spring("coil", "ground", "arm", ORIGIN, UP, 0.0, 0.0, preload=1.0)]},
            "spring 'coil': a preload needs a stiffness, got 0. Use a Force for a constant force",
        ),
        (
            {"forces": [Force("push", "arm", (1.0, 2.0))]},
            "force 'push': forces is ",
        ),
        (
            {"forces": [Force("push", "arm", ((np.inf, 0.0, 0.0),), times=(0.0,))]},
            "force 'push': times or forces are not finite, got ",
        ),
        (
            {"stops": [Stop("floor", "ground", "arm", ORIGIN, UP, 1e3, 0.5, normal=ORIGIN)]},
            "stop 'floor': the normal has no length, got (0.0, 0.0, 0.0)",
        ),
        (
            {"stops": [Stop("ball", "ground", "arm", UP, UP, 1e3, 0.5, radius_a=0.1)]},
            "stop 'ball': both spheres have one centre, got (0.0, 0.0, 1.0)",
        ),
        (
            {"stops": [Stop("floor", "ground", "arm", ORIGIN, UP, 1e3, 1.5, normal=UP)]},
            "stop 'floor': restitution is not between 0.05 and 1, got 1.5",
        ),
    ],
)
def test_a_load_that_makes_no_sense_is_refused_by_its_name(loads, message):
    with pytest.raises(CaseError) as caught:
        assemble([Body("arm", 1.0, np.eye(3), ORIGIN)], [], **loads)
    assert str(caught.value).startswith(message)


def test_an_unbalance_motor_needs_an_axis():
    motor = UnbalanceMotor(
        "shaker", "arm", ORIGIN, ORIGIN, (1.0, 0.0, 0.0), 1.0, 0.01, (0.0, 1.0), (0.0, 1.0)
    )
    with pytest.raises(CaseError) as caught:
        motor.parts()
    assert "unbalance motor 'shaker': axis has no length, got (0.0, 0.0, 0.0)" in str(caught.value)


def test_check_prints_what_the_films_do_to_an_impact():
    # St = m* v/(6 pi mu R*^2), and (1 + e)/e ln(thickness/roughness) below which two stick
    machine = wet_mill(film_thickness="50 um")
    lines = charge_facts(machine).lines(machine)
    assert lines[-3:] == [
        "liquid    films, and Stokes numbers at the same speed",
        "          steel-steel          film 50 um to 1 um, St 500, sticks below 11.7",
        "          steel-acrylic wall   film 50 um to 1 um, St 250, sticks below 13.7",
    ]
