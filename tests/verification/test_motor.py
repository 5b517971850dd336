"""Motors with limits: a shaft of one inertia, of which everything is known, and the mill."""

import math

import numpy as np
import pytest
from mill_bench import march_mill, mill

from nutamill.base.errors import CaseError
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.dynamics import march, start
from nutamill.mechanism.energy import energies
from nutamill.mechanism.modes import modes, static_equilibrium
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointFriction, JointKind, Motor
from nutamill.simulation.runs import resume
from nutamill.simulation.runs import run as march_run

O, Z, INERTIA, DT = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.02, 1e-4
FAST = ((0.0,), (100.0,))
"""Asked for 100 rad/s at once."""


def shaft(motor, knots=FAST, viscous=0.0, speed=0.0):
    """A shaft in a bearing, driven by `motor`."""
    body = Body("shaft", 1.0, np.diag([0.02, 0.02, INERTIA]), O, angular_velocity=(0.0, 0.0, speed))
    friction = JointFriction(0.0, 0.01, viscous=viscous) if viscous else None
    built = assemble(
        [body],
        [Joint("bearing", JointKind.REVOLUTE, GROUND, "shaft", O, Z, friction=friction)],
        drives=[Drive("motor", "bearing", *knots, motor)],
    )
    start(*built)
    return built


def speed_after(built, time):
    march(*built, DT, round(time / DT))
    return built[1].drive_motion[0, 1]


def test_torque_limit_gives_a_steady_acceleration():
    # far from the speed asked for, the torque is the limit: w = T t / I. The scheme is exact for a constant
    # torque
    built = shaft(Motor(5.0, 50.0, torque_limit=3.0))
    assert speed_after(built, 0.2) == pytest.approx(3.0 * 0.2 / INERTIA, rel=1e-9)
    assert built[1].drive_torque[0] == 3.0
    assert built[1].drive_motion[0, 0] == pytest.approx(
        0.5 * 3.0 / INERTIA * 0.2**2, rel=1e-6
    )  # turns counted


def test_power_limit_gives_kinetic_energy_at_a_steady_rate():
    # I w^2 / 2 = P t; where the torque is limited as well it begins with w = T t / I up to w = P / T
    torque, power, t = 3.0, 60.0, 0.4
    begin = power / torque
    t0 = INERTIA * begin / torque
    w = math.sqrt(begin**2 + 2.0 * power / INERTIA * (t - t0))
    # second order: the error of a step is of the order (dt w'/w)^2 of it
    assert speed_after(shaft(Motor(5.0, 50.0, torque_limit=torque, power_limit=power)), t) == pytest.approx(
        w, rel=1e-5
    )


def test_shaft_whose_supply_is_cut_coasts_down_by_its_friction():
    c = 0.01
    built = shaft(Motor(5.0, 50.0, cut=0.0), viscous=c, speed=80.0)
    assert speed_after(built, 1.0) == pytest.approx(80.0 * math.exp(-c / INERTIA), rel=1e-6)
    assert built[1].drive_work[0] == 0.0


def test_supply_that_comes_back_brings_the_shaft_back_to_its_speed():
    built = shaft(Motor(2.0, 10.0, torque_limit=20.0, cut=0.3, restored=0.4), viscous=0.05)
    before, during = speed_after(built, 0.3), speed_after(built, 0.1)
    assert during == pytest.approx(before * math.exp(-0.05 / INERTIA * 0.1), rel=1e-3)
    assert speed_after(built, 2.0) == pytest.approx(100.0, rel=1e-3)


def test_controlled_shaft_rings_as_two_poles():
    # I w' = g e + integral: I s^2 + g s + k = 0; the step answer of e is the sum of its two exponentials,
    # e(0) = 1, e'(0) = -g / I
    g, k = 1.0, 50.0
    built = shaft(Motor(g, k), knots=((0.0,), (1.0,)))
    error = []
    for _ in range(20):
        march(*built, DT, 50)
        error.append(1.0 - built[1].drive_motion[0, 1])
    s = np.roots([INERTIA, g, k])
    a = np.linalg.solve(np.vstack([np.ones(2), s]), [1.0, -g / INERTIA])
    exact = (a[None, :] * np.exp(np.outer(5e-3 * np.arange(1, 21), s))).sum(axis=1).real
    # the integral part is advanced once a step: first order, g dt / I = 5e-3 of the answer
    assert np.abs(np.array(error) - exact).max() < 5e-3


def test_energy_of_a_motor_is_what_the_shaft_gains_and_loses():
    built = shaft(Motor(1.0, 20.0, torque_limit=3.0, power_limit=100.0), viscous=0.01)
    march(*built, DT, 5000)
    energy = np.zeros(3)
    energies(*built, energy)
    work = built[1].drive_work[0]
    # trapezoid rule of powers that change within some 10 ms: (dt/10 ms)^2 / 12
    assert energy[0] + built[1].loss[0] == pytest.approx(work, rel=1e-5)


def test_pendulum_held_by_a_resting_motor_is_at_rest_and_shakes_on_its_seat():
    # the motor's joint is locked for statics and modes, as a prescribed one is held
    frame, arm = Body("frame", 2.0, 0.1 * np.eye(3), O), Body("arm", 1.0, 0.01 * np.eye(3), (0.3, 0.0, 0.0))
    joints = [
        Joint("slide", JointKind.PRISMATIC, GROUND, "frame", O, Z),
        Joint("hinge", JointKind.REVOLUTE, "frame", "arm", O, (0.0, 1.0, 0.0)),
    ]
    seat = Bushing("seat", GROUND, "frame", O, Z, (0.0, 3000.0, 0.0, 0.0))
    built = assemble(
        [frame, arm],
        joints,
        [seat],
        drives=[Drive("motor", "hinge", (0.0, 1.0), (0.0, 0.0), Motor(1.0, 1.0))],
    )
    static_equilibrium(*built)
    assert built[1].position[1, 2] == pytest.approx(-3.0 * 9.81 / 3000.0, rel=1e-6)
    assert 2 * np.pi * modes(*built).frequency == pytest.approx([math.sqrt(3000.0 / 3.0)], rel=1e-6)


def test_mill_stops_speeding_up_where_its_friction_takes_the_power():
    # 20 W and a viscous loss alone at two joints: the driveshaft bearing turns with w, the pin with w (its
    # two parts turn against
    # each other once per turn, within the cosine of 6.08 deg)
    case = mill(
        "charge.kind=none",
        "mechanism.mounting=rigid",
        "mechanism.joint_friction=0",
        "mechanism.joint_friction_viscous=0.01 N m s/rad",
        "drive.ramp=20000 rpm/s",
        "drive.motor.power=20 W",
        "drive.motor.gain=5 N m s/rad",
        "shaft_coupling.torsion_damping=0.5 N m s/rad",
    )
    series = march_mill(case, 4.0)
    last = series["time"] > 3.5
    assert series["driveshaft_power"].max() < 20.0 * (1 + 1e-3)
    assert series["driveshaft_power"][last].mean() == pytest.approx(20.0, rel=1e-3)
    assert series["driveshaft_speed"][last].mean() == pytest.approx(math.sqrt(20.0 / 0.02), rel=0.01)
    assert np.abs(series["ledger_residual"]).max() < 1e-3 * series["motor_work"][-1]


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (["drive.motor.restored=2 s"], "restored must come after cut"),
        (["drive.motor.cut=3 s", "drive.motor.restored=2 s"], "restored must come after cut"),
        (["drive.motor.power=0 W"], "must be positive"),
        (["drive.motor.power=5 N m"], "is a torque"),
    ],
)
def test_motor_that_makes_no_sense_is_refused(keys, message):
    with pytest.raises(CaseError, match=message):
        mill(*keys)


def test_case_with_a_motor_is_read_back_as_it_was_written():
    case = mill("drive.motor.power=370 W", "drive.motor.cut=8 s")
    again = type(case).from_toml(case.to_toml())
    assert again == case and again.drive.motor.power == 370.0


def test_run_with_a_motor_that_is_resumed_is_the_run_that_never_stopped(tmp_path):
    keys = [
        "charge.kind=none",
        "mechanism.mounting=rigid",
        "drive.ramp=20000 rpm/s",
        "drive.motor.power=200 W",
        "run.checkpoint=10 ms",
    ]
    case = mill(*keys, "run.until=40 ms")
    with march_run(case, tmp_path / "whole.h5") as whole:
        march_run(case.with_(run__until=0.02), tmp_path / "parts.h5").close()
        with resume(tmp_path / "parts.h5", until=0.04) as parts:
            assert parts.series.equals(whole.series)
            assert 0.0 < whole.series["driveshaft_speed"][-1] < case.drive.speed
