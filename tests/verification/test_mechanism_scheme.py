"""The step itself, on a small mill: order, drift off the constraints, ledger, repeatability."""

import math

import numpy as np
import pytest

from nutamill.base.frames import pose_in_window
from nutamill.base.kernel import copy_arrays
from nutamill.mechanism.assembly import assemble, new_scratch
from nutamill.mechanism.dynamics import (
    OK,
    body_motion,
    drift,
    finish,
    march,
    solve_again,
    start,
)
from nutamill.mechanism.energy import energies
from nutamill.mechanism.equations import row_residuals, update_kinematics
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointFriction, JointKind
from nutamill.mechanism.probes import joint_reaction
from nutamill.mechanism.rows import matrix_of
from nutamill.mechanism.sensors import (
    Sensor,
    SensorKind,
    column_names,
    march_recording,
    read_sensors,
    sensor_table,
)

X, Y, Z = np.eye(3)
THROW, DEPTH = 0.04, 0.36


def small_mill(friction=0.03):
    """A nutating body on a sprung frame, driven by a crank that runs up to 70 rad/s in 0.05 s and then holds
    its speed.
    """
    alpha = math.atan2(THROW, DEPTH)
    q = (math.cos(alpha / 2), 0.0, -math.sin(alpha / 2), 0.0)
    tilted = matrix_of(q)
    pin, low = np.array([THROW, 0.0, -DEPTH]), np.array([0.0, 0.0, -DEPTH])
    rub = JointFriction(friction, 0.024)
    bodies = [
        Body("frame", 60.0, np.diag([5.0, 5.0, 3.0]), -0.4 * Z),
        Body("chamber", 5.0, np.diag([0.07, 0.07, 0.025]), -0.24 * tilted[:, 2], q),
        Body("cross", 0.5, 5e-4 * np.eye(3), 0 * Z, q),
        Body("shaft", 6.0, 0.02 * np.eye(3), low),
    ]
    joints = [
        Joint("yoke", JointKind.REVOLUTE, "frame", "cross", 0 * Z, Y),
        Joint("pivot", JointKind.REVOLUTE, "cross", "chamber", 0 * Z, tilted[:, 0]),
        Joint("bearing", JointKind.REVOLUTE, "frame", "shaft", low, Z, friction=rub),
        Joint("pin", JointKind.POINT_ON_LINE, "shaft", "chamber", pin, Z, friction=rub),
    ]
    rates = (72e3, 540e3, 50.0, 0.0), (300.0, 300.0, 3.0, 0.0)
    mounts = [
        Bushing(f"mount {k}", GROUND, "frame", (x, y, -0.7), Z, *rates)
        for k, (x, y) in enumerate([(0.15, 0), (-0.1, 0.13), (-0.1, -0.13)])
    ]
    engine = assemble(bodies, joints, mounts, drives=[Drive("motor", "bearing", (0.0, 0.05), (0.0, 70.0))])
    static_equilibrium(*engine)
    return engine


def energy_residual(mechanism, state, scratch):
    """Kinetic + potential + elastic + losses - works [J]."""
    now = np.zeros(3)
    energies(mechanism, state, scratch, now)
    return now.sum() + state.loss.sum() - state.drive_work.sum() - state.wrench_work.sum()


def test_step_is_of_second_order_in_motion_and_reaction():
    end, paths = 0.1, []
    for n in (
        1000,
        2000,
        4000,
    ):  # friction takes the reaction of the step before, a share of first order: left out here
        mechanism, state, scratch = small_mill(friction=0.0)
        march(mechanism, state, scratch, end / n, n)
        force = np.zeros(6)
        joint_reaction(mechanism, state, 3, force)
        paths.append((state.position[0].copy(), state.velocity[1].copy(), force[:3].copy()))
    for quantity in range(3):
        one, two = (np.linalg.norm(paths[k][quantity] - paths[k + 1][quantity]) for k in range(2))
        # differences of successive halvings fall by four (first order: two, third: eight)
        assert 1.8 < math.log2(one / two) < 2.2


def test_constraints_hold_to_round_off_over_ten_thousand_steps():
    mechanism, state, scratch = small_mill()
    assert march(mechanism, state, scratch, 1e-4, 10_000) == OK
    update_kinematics(mechanism, state, scratch)
    rate, twist = np.zeros(len(mechanism.rows)), np.hstack([state.velocity, state.angular_velocity])
    row_residuals(mechanism.rows, mechanism.gears, scratch.jacobian, twist, -scratch.gap_rate, rate)
    # gaps: the square of one step's error (w dt)^3 x 0.36 m ~ 1e-7 m; rates: that error times the speeds of
    # the joints, twice
    assert np.abs(scratch.gap).max() < 1e-13
    assert np.abs(rate).max() < 1e-9


def test_energy_ledger_closes_with_second_order():
    residuals, scale = [], 0.0
    for n in (1000, 2000):
        mechanism, state, scratch = small_mill()
        begin = energy_residual(mechanism, state, scratch)
        march(mechanism, state, scratch, 0.1 / n, n)
        residuals.append(energy_residual(mechanism, state, scratch) - begin)
        scale = state.drive_work[0]
    assert abs(residuals[1]) < 1e-4 * scale
    assert 3.3 < residuals[0] / residuals[1] < 4.7


def test_energy_ledger_counts_a_wrench_that_jumps_at_every_step():
    closed = []
    for n in (1000, 2000):
        mechanism, state, scratch = small_mill()
        begin = energy_residual(mechanism, state, scratch)
        for k in range(n):
            drift(mechanism, state, scratch, 0.1 / n)
            state.wrench[1, :3] = 200.0 * math.sin(300.0 * 0.1 * k / n), 100.0 * (-1) ** k, 0.0
            finish(mechanism, state, scratch, 0.1 / n)
        closed.append(abs(energy_residual(mechanism, state, scratch) - begin))
        assert abs(state.wrench_work[1]) > 100 * closed[-1]
    # works are impulse times mean velocity, so jumps do no harm: second order
    assert closed[1] < closed[0] / 3.3


def test_copied_state_repeats_the_same_bits_with_fresh_scratch():
    mechanism, state, scratch = small_mill()
    march(mechanism, state, scratch, 1e-4, 100)
    copied = type(state)(*(array.copy() for array in state))
    march(mechanism, state, scratch, 1e-4, 100)
    march(mechanism, copied, new_scratch(mechanism), 1e-4, 100)
    for name, one, other in zip(state._fields, state, copied, strict=True):
        assert np.array_equal(one, other), name


def test_every_array_of_the_state_is_copied():
    mechanism, state, scratch = small_mill()
    march(mechanism, state, scratch, 1e-4, 10)
    other = type(state)(*(np.full_like(array, -1.0) for array in state))
    copy_arrays(state, other)
    for name, one, two in zip(state._fields, state, other, strict=True):
        assert np.array_equal(one, two), name


def test_drift_moves_bodies_exactly_as_the_window_says():
    mechanism, state, scratch = small_mill()
    march(mechanism, state, scratch, 1e-4, 700)
    motion, p, q = np.zeros(19), np.zeros(3), np.zeros(4)
    body_motion(state, 1, motion)
    drift(mechanism, state, scratch, 1e-4)
    pose_in_window(motion, 1e-4, p, q)
    # the same formula; sums may be contracted differently
    assert np.abs(state.position[1] - p).max() < 1e-15
    assert np.abs(state.quaternion[1] - q).max() < 1e-15


def test_solving_again_with_the_same_wrench_finds_the_same_accelerations():
    mechanism, state, scratch = small_mill(friction=0.0)
    march(mechanism, state, scratch, 1e-4, 300)
    before = state.acceleration.copy()
    solve_again(mechanism, state, scratch)
    # the step solved at the pose and predicted speeds before the projection: they differ by order dt^2
    assert np.abs(state.acceleration - before).max() < 1e-2 * np.abs(before).max()
    again = state.acceleration.copy()
    state.wrench[0, 0] = 100.0
    solve_again(mechanism, state, scratch)
    assert state.acceleration[0, 0] - again[0, 0] == pytest.approx(
        100.0 / 66.0, rel=0.3
    )  # frame and what hangs on it


def test_sensors_read_what_they_are_named_for():
    mechanism, state, scratch = small_mill()
    sensors = [
        Sensor("pin", SensorKind.JOINT_REACTION, "pin", axes_body="shaft"),
        Sensor("motor", SensorKind.DRIVE, "motor"),
        Sensor("corner", SensorKind.POINT_POSITION, "frame", point=(0.2, 0.15, -0.7)),
        Sensor("corner", SensorKind.POINT_VELOCITY, "frame", point=(0.2, 0.15, -0.7)),
        Sensor("chamber", SensorKind.BODY_ATTITUDE, "chamber"),
        Sensor("mount", SensorKind.BUSHING_TRAVEL, "mount 0"),
    ]
    table = sensor_table(mechanism, state, sensors)
    start(mechanism, state, scratch)
    names = column_names(table)
    rows = np.zeros((5, 1 + len(names)))
    assert march_recording(mechanism, state, scratch, table, 1e-4, 200, rows) == OK
    assert np.allclose(rows[:, 0], np.arange(5) * 0.02, rtol=0, atol=1e-12)
    read = dict(zip(names, rows[-1, 1:], strict=True))
    # angle of the ramp: 70 t^2/0.1 up to 0.05 s, then 70 t
    assert read["motor_angle"] == pytest.approx(70 * 0.05 / 2 + 70 * 0.03, abs=1e-12)
    force = np.zeros(6)
    joint_reaction(mechanism, state, 3, force)
    in_shaft = matrix_of(state.quaternion[3]).T @ force[:3]
    assert np.allclose(
        [read["pin_force_x"], read["pin_force_y"], read["pin_force_z"]], in_shaft, rtol=1e-12, atol=1e-12
    )
    assert np.allclose([read[f"chamber_q{k}"] for k in "wxyz"], state.quaternion[1], rtol=0, atol=0)
    h, before, after = 1e-5, np.zeros(len(names)), np.zeros(len(names))
    read_sensors(mechanism, state, scratch, table, before)
    march(mechanism, state, scratch, h, 2)
    read_sensors(mechanism, state, scratch, table, after)
    at, rate = names.index("corner_x"), names.index("corner_vx")
    assert (after[at] - before[at]) / (2 * h) == pytest.approx((after[rate] + before[rate]) / 2, rel=1e-4)
