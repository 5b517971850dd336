"""Gears against closed forms: reflected inertia, torques on the housing, a jar on a planetary disc."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nutamill import CaseError, System
from nutamill.mechanism.parts import GROUND, Body, Drive, Gear, Joint, JointFriction, JointKind, Motor, Torque

O, X, Y, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def wheel(name, inertia, position, mass=1.0, **motion):
    """A wheel about z."""
    return Body(name, mass, np.diag([inertia, inertia, inertia]), position, **motion)


def hinge(name, a, b, point, axis=Z, friction=None):
    return Joint(name, JointKind.REVOLUTE, a, b, point, axis, friction=friction)


def gear_pair(ratio, drives=(), loads=(), axis=Z, friction=None):
    """A motor's wheel and a load's, one metre apart, in bearings of the ground."""
    bodies = [wheel("motor", 0.02, O), wheel("load", 0.5, X)]
    joints = [hinge("in", GROUND, "motor", O), hinge("out", GROUND, "load", X, axis, friction)]
    return System(bodies, joints, loads, drives, gravity=O, gears=[Gear("pair", "in", "out", ratio)])


def test_the_motor_feels_the_inertia_of_the_load_times_the_ratio_squared():
    ratio, torque, t = -0.25, 3.0, 0.4
    system = gear_pair(ratio, loads=[Torque("push", "motor", (0.0, 0.0, torque))])
    system.march(t, 1e-3)
    acceleration = torque / (0.02 + ratio**2 * 0.5)
    assert system.angular_velocity("motor")[2] == pytest.approx(acceleration * t, rel=1e-12)
    assert system.angular_velocity("load")[2] == pytest.approx(ratio * acceleration * t, rel=1e-12)
    # the gear turns the load with its inertia times its acceleration
    assert system.gear_torque("pair") == pytest.approx(0.5 * ratio * acceleration, rel=1e-12)
    assert system.energy().kinetic == pytest.approx(system.state.torque_work[0], rel=1e-12)


def test_both_sides_keep_the_ratio_over_many_turns():
    ratio = -math.pi / 7.0  # no whole number of turns is one
    system = gear_pair(ratio, [Drive("motor", "in", (0.0, 0.5), (0.0, 200.0))])
    system.march(3.0, 1e-3)
    angles = system.state.gear_angle
    assert angles[0] == pytest.approx(0.5 * 0.5 * 200.0 + 2.5 * 200.0, abs=1e-9)
    assert angles[1] - ratio * angles[0] == pytest.approx(0.0, abs=1e-9)
    q = system.attitude("load")
    turned = 2.0 * math.atan2(q[3], q[0])
    assert math.remainder(turned - ratio * angles[0], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_the_housing_carries_the_difference_of_the_torques():
    # a brake on the output, at steady speed: T_in = -ratio T_out, and the ground holds the rest
    ratio, viscous, speed = 0.2, 0.4, 50.0
    brake = JointFriction(0.0, 0.0, viscous=viscous)
    system = gear_pair(ratio, [Drive("motor", "in", (0.0,), (speed,))], friction=brake)
    system.march(0.01, 1e-3)
    out = viscous * ratio * speed
    assert system.gear_torque("pair") == pytest.approx(out, rel=1e-12)
    assert system.torque("motor") == pytest.approx(ratio * out, rel=1e-12)
    # power in is power out
    assert system.torque("motor") * speed == pytest.approx(out * ratio * speed, rel=1e-12)


def test_bevel_gears_pass_torque_between_axes_that_cross():
    system = gear_pair(-2.0, loads=[Torque("push", "motor", (0.0, 0.0, 1.0))], axis=Y)
    system.march(0.2, 1e-3)
    spin = 1.0 / (0.02 + 4.0 * 0.5) * 0.2
    assert system.angular_velocity("load") == pytest.approx((0.0, -2.0 * spin, 0.0), abs=1e-12)


def planetary_mill(drive, speed=0.0):
    """A disc on a heavy housing that is free to turn about z, with two jars geared to the disc's rotation."""
    bodies = [
        wheel("housing", 40.0, O, 100.0),
        wheel("disc", 2.0, O, 20.0),
        wheel("jar_1", 0.03, (0.2, 0.0, 0.0), 3.0),
        wheel("jar_2", 0.03, (-0.2, 0.0, 0.0), 3.0),
    ]
    joints = [
        hinge("floor", GROUND, "housing", O),
        hinge("bearing", "housing", "disc", O),
        hinge("pivot_1", "disc", "jar_1", (0.2, 0.0, 0.0)),
        hinge("pivot_2", "disc", "jar_2", (-0.2, 0.0, 0.0)),
    ]
    gears = [Gear(f"belt_{k}", "bearing", f"pivot_{k}", -2.0) for k in (1, 2)]
    return System(bodies, joints, drives=[drive], gravity=O, gears=gears)


def test_jars_of_a_planetary_mill_turn_relative_to_their_disc():
    torque = 5.0
    constant = Motor(1e9, 0.0, torque_limit=torque)
    system = planetary_mill(Drive("motor", "bearing", (0.0,), (1e9,), constant))
    system.march(0.5, 5e-4)
    # with W of the housing, w of the disc relative to it: the jars spin at W + w - 2 w. Angular momentum
    # about z is zero, and torque times w is the growth of the kinetic energy
    carried = 2.0 + 2.0 * 3.0 * 0.2**2
    jars = 2.0 * 0.03
    a = np.array([[40.0 + carried + jars, carried - jars], [carried - jars, carried + jars]])
    housing, disc = np.linalg.solve(a, [0.0, torque]) * 0.5
    assert system.angular_velocity("housing")[2] == pytest.approx(housing, rel=1e-6)
    assert system.angular_velocity("disc")[2] == pytest.approx(housing + disc, rel=1e-6)
    assert system.angular_velocity("jar_1")[2] == pytest.approx(housing - disc, rel=1e-6)
    assert system.energy().kinetic == pytest.approx(system.state.drive_work[0], rel=1e-6)


def test_bevel_gears_in_a_free_housing_turn_it_the_other_way_about_both_axes():
    # all mass centres in one point, all inertias those of balls, everything at rest: angular momentum stays
    # zero, so that in axes of the housing W = -(I1 w z + I2 r w y)/I, whatever attitude it has come to
    ratio, torque, inertias = -0.5, 0.4, {"housing": 2.0, "motor": 0.1, "load": 0.6}
    bodies = [wheel(name, inertia, O) for name, inertia in inertias.items()]
    joints = [hinge("in", "housing", "motor", O, Z), hinge("out", "housing", "load", O, Y)]
    constant = Motor(1e9, 0.0, torque_limit=torque)
    whole, own = sum(inertias.values()), 0.1 + 0.6 * ratio**2
    turned = (0.1**2 + (0.6 * ratio) ** 2) / whole
    misses = []
    for dt in (2e-3, 1e-3):
        system = System(
            bodies,
            joints,
            drives=[Drive("drive", "in", (0.0,), (1e9,), constant)],
            gravity=O,
            gears=[Gear("bevel", "in", "out", ratio)],
        )
        system.march(2.0, dt)
        speed = torque * 2.0 / (own - turned)
        q = system.attitude("housing")
        w = Rotation.from_quat(np.roll(q, -1)).inv().apply(system.angular_velocity("housing"))
        closed = -speed / whole * np.array([0.0, 0.6 * ratio, 0.1])
        misses.append(np.abs(w - closed).max())
        assert w == pytest.approx(closed, abs=(speed * dt) ** 2 * speed)
    assert misses[1] < max(misses[0] / 3.5, 1e-10)


def test_bearings_of_a_driven_planetary_mill_carry_the_jars_centrifugal_force():
    spin = 30.0
    system = planetary_mill(Drive("motor", "bearing", (0.0,), (spin,)))
    dt = 5e-4
    system.march(0.1, dt)
    whole = system.angular_velocity("disc")[2]
    assert np.linalg.norm(system.reaction("pivot_1").force) == pytest.approx(
        3.0 * 0.2 * whole**2, rel=(spin * dt) ** 2
    )
    # nothing accelerates: no torque in the belts
    assert system.gear_torque("belt_1") == pytest.approx(0.0, abs=1e-6)


def test_a_drive_on_both_sides_must_agree_with_the_ratio():
    drives = [Drive("one", "in", (0.0,), (10.0,)), Drive("two", "out", (0.0,), (30.0,))]
    with pytest.raises(CaseError, match="contradicts"):
        gear_pair(2.0, drives)
    with pytest.raises(CaseError, match=r"already locked by .*gear 'pair'"):
        gear_pair(3.0, drives)


def test_gears_that_join_nothing_are_refused_all_at_once():
    with pytest.raises(CaseError) as error:
        System(
            [wheel("a", 1.0, O)],
            [hinge("pin", GROUND, "a", O), Joint("ball", JointKind.SPHERICAL, GROUND, "a", O)],
            gears=[Gear("g", "pin", "ball", 1.0), Gear("h", "pin", "pin", 0.0), Gear("i", "no", "pin", 1.0)],
        )
    message = str(error.value)
    for words in (
        "gear 'g': joint 'ball' does not turn about an axis, got a SPHERICAL joint",
        "gear 'h': input and output are one joint",
        "gear 'h': the ratio is zero",
        "gear 'i': unknown joint, got 'no'",
    ):
        assert words in message
