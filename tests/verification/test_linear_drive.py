"""Drives along the axis of a prismatic joint, prescribed and by a motor, against closed forms."""

import math

import numpy as np
import pytest

from nutamill import CaseError, System
from nutamill.mechanism.parts import GROUND, Body, Drive, Joint, JointKind, Motor, Spring

O, X, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
MASS, DAMPING = 4.0, 25.0


def slider(drive, damping=DAMPING, axis=X, gravity=(0.0, 0.0, -9.81)):
    """A body on a guide with a damper along it, driven by `drive`."""
    body = Body("slide", MASS, 0.1 * np.eye(3), O)
    guide = Joint("guide", JointKind.PRISMATIC, GROUND, "slide", (0.1, 0.2, -0.3), axis)
    far = tuple(-2.0 * np.asarray(axis))
    drag = Spring("drag", GROUND, "slide", far, O, 0.0, damping, 0.0)
    return System([body], [guide], [drag], [drive], gravity=gravity)


def ledger(system):
    """Energy stored and lost less the work of the drives [J]."""
    return system.energy().total + system.state.loss.sum() - system.state.drive_work.sum()


def test_force_of_a_prescribed_travel_is_mass_times_acceleration_plus_friction():
    system = slider(Drive("ram", "guide", (0.0, 0.5, 0.8), (0.0, 2.0, -1.0)))
    system.march(0.25, 1e-3)
    # halfway up the first ramp, 4 m/s^2: travel and speed are prescribed exactly
    assert system.position("slide")[0] == pytest.approx(0.5 * 4.0 * 0.25**2, abs=1e-14)
    assert system.velocity("slide")[0] == pytest.approx(1.0, abs=1e-13)
    assert system.torque("ram") == pytest.approx(MASS * 4.0 + DAMPING * 1.0, rel=1e-12)
    # the guide carries the weight, and its moment about the joint's point; the drive pushes at that point
    assert system.reaction("guide").force == pytest.approx((0.0, 0.0, MASS * 9.81), abs=1e-9)
    system.march(0.4, 1e-3)
    # halfway down the second ramp, -10 m/s^2
    assert system.torque("ram") == pytest.approx(MASS * -10.0 + DAMPING * 0.5, rel=1e-9)


def test_work_of_a_prescribed_travel_closes_the_ledger_with_second_order():
    residuals = []
    for dt in (2e-3, 1e-3):
        system = slider(Drive("ram", "guide", (0.0, 0.5), (0.0, 2.0)), axis=(0.6, 0.0, 0.8))
        begin = ledger(system)
        system.march(0.7, dt)
        residuals.append(ledger(system) - begin)
    # kinetic energy, weight lifted and drag: all of it is work of the drive
    lifted = MASS * 9.81 * 0.8 * (0.5 + 0.4)
    drag = DAMPING * (4.0 * 0.5 / 3.0 + 4.0 * 0.2)
    assert system.state.drive_work[0] == pytest.approx(0.5 * MASS * 4.0 + lifted + drag, rel=1e-5)
    assert abs(residuals[1]) < max(abs(residuals[0]) / 3.5, 1e-11)


def test_a_motor_with_a_force_limit_accelerates_against_drag_as_the_closed_form():
    # far from its speed the force is the limit: v = F / c (1 - exp(-c t / m))
    force, misses = 60.0, []
    for dt in (1e-3, 5e-4):
        system = slider(Drive("ram", "guide", (0.0,), (100.0,), Motor(50.0, 0.0, torque_limit=force)))
        system.march(0.2, dt)
        misses.append(system.velocity("slide")[0] - force / DAMPING * (1 - math.exp(-DAMPING / MASS * 0.2)))
        assert system.torque("ram") == force
        assert ledger(system) == pytest.approx(0.0, abs=force * 0.4 * (DAMPING / MASS * dt) ** 2)
    assert 3.5 < misses[0] / misses[1] < 4.5
    state = system.state
    assert state.drive_motion[0, :2] == pytest.approx(
        (system.position("slide")[0], system.velocity("slide")[0]), abs=1e-14
    )
    assert state.drive_motion[0, 2] == pytest.approx(
        (force - DAMPING * system.velocity("slide")[0]) / MASS, rel=(DAMPING / MASS * dt) ** 2
    )


def test_a_travel_on_a_turning_arm_feels_coriolis_and_centrifugal_forces():
    # a bead pushed out along an arm that turns at w: force m (s'' - w^2 s), torque 2 m w s s' with s'' = 0
    spin, speed = 3.0, 0.5
    bodies = [
        Body("arm", 1.0, np.eye(3), O, angular_velocity=(0.0, 0.0, spin)),
        Body("bead", MASS, 0.1 * np.eye(3), (1.0, 0.0, 0.0)),
    ]
    joints = [
        Joint("pivot", JointKind.REVOLUTE, GROUND, "arm", O, Z),
        Joint("guide", JointKind.PRISMATIC, "arm", "bead", (1.0, 0.0, 0.0), X),
    ]
    drives = [Drive("turn", "pivot", (0.0,), (spin,)), Drive("push", "guide", (0.0,), (speed,))]
    system = System(bodies, joints, drives=drives, gravity=O)
    system.march(0.5, 1e-3)
    out = 1.0 + speed * 0.5
    assert np.hypot(*system.position("bead")[:2]) == pytest.approx(out, abs=1e-13)
    second_order = 4.0 * (spin * 1e-3) ** 2
    assert system.torque("push") == pytest.approx(-MASS * spin**2 * out, rel=second_order)
    assert system.torque("turn") == pytest.approx(2.0 * MASS * spin * out * speed, rel=second_order)


def test_a_motor_along_a_turning_arm_reports_the_second_derivative_of_its_travel():
    # without force, in the turning frame: s'' = w^2 s
    bodies = [
        Body("arm", 1.0, np.eye(3), O),
        Body("bead", MASS, 0.1 * np.eye(3), (1.0, 0.0, 0.0)),
    ]
    joints = [
        Joint("pivot", JointKind.REVOLUTE, GROUND, "arm", O, Z),
        Joint("guide", JointKind.PRISMATIC, "arm", "bead", (1.0, 0.0, 0.0), X),
    ]
    drives = [
        Drive("turn", "pivot", (0.0,), (3.0,)),
        Drive("push", "guide", (0.0,), (0.0,), Motor(0.0, 0.0)),
    ]
    system = System(bodies, joints, drives=drives, gravity=O)
    system.march(0.3, 1e-3)
    travel, _speed, acceleration = system.state.drive_motion[1]
    assert acceleration == pytest.approx(9.0 * (1.0 + travel), rel=1e-9)
    assert 1.0 + travel == pytest.approx(math.cosh(3.0 * 0.3), rel=1e-5)


def test_rest_holds_the_travel_of_a_motor():
    system = slider(Drive("ram", "guide", (0.0,), (0.0,), Motor(10.0, 0.0)), axis=Z)
    system.rest()
    assert system.position("slide") == pytest.approx(O, abs=1e-12)


def test_a_joint_that_neither_turns_nor_slides_takes_no_drive():
    with pytest.raises(CaseError, match="neither turns about an axis nor only slides"):
        System(
            [Body("slide", MASS, np.eye(3), O)],
            [Joint("ball", JointKind.SPHERICAL, GROUND, "slide", O)],
            drives=[Drive("ram", "ball", (0.0,), (1.0,))],
        )


def test_tension_of_a_spring_and_its_damper():
    body = Body("block", MASS, np.eye(3), O, velocity=(0.0, 0.0, -0.3))
    system = System([body], loads=[Spring("coil", GROUND, "block", Z, O, 200.0, 5.0, 0.9)])
    assert system.tension("coil") == pytest.approx(200.0 * 0.1 + 5.0 * 0.3)
