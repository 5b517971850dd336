"""Reactions and torques that answer an external wrench are of second order in the window.

The wrench is known as its mean over the window alone, as that of a charge is.
"""

import itertools
import math

import numpy as np
import pytest

from nutamill import System
from nutamill.mechanism.dynamics import drift, finish, solve_again
from nutamill.mechanism.parts import GROUND, Body, Drive, Joint, JointKind

O, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
SPEED, RADIUS, FORCE, LEAD = 73.3, 0.05, 400.0, 0.9
"""Speed of the crank [rad/s], its radius [m], force on its pin [N] and its angle ahead of the crank [rad]."""
WINDOWS = (125e-6, 62.5e-6, 31.25e-6)
"""Windows [s]."""


def crank():
    """A driven crank with its mass centre at its pin, without gravity: the drive alone balances a force."""
    body = Body("crank", 2.0, np.diag([0.01, 0.01, 0.02]), (RADIUS, 0.0, 0.0))
    bearing = Joint("bearing", JointKind.REVOLUTE, GROUND, "crank", O, Z)
    return System([body], [bearing], drives=[Drive("motor", "bearing", (0.0,), (SPEED,))], gravity=O)


def rotating_mean(start, end):
    """Mean over a window of a force that rotates with the crank (3,) [N]."""
    angles = SPEED * np.array([start, end]) + LEAD
    sine, cosine = np.diff(np.sin(angles))[0], -np.diff(np.cos(angles))[0]
    return FORCE / (SPEED * (end - start)) * np.array([sine, cosine, 0.0])


def march(system, dt, time, mean_force):
    """March under the mean of a force over every window; torque and radial bearing force after each."""
    rows = []
    for n in range(round(time / dt)):
        drift(system.mechanism, system.state, system.scratch, dt)
        system.state.wrench[0, :3] = mean_force(n * dt, (n + 1) * dt)
        finish(system.mechanism, system.state, system.scratch, dt)
        angle, force = SPEED * system.time, system.reaction("bearing").force
        radial = force[0] * math.cos(angle) + force[1] * math.sin(angle)
        rows.append((system.torque("motor"), radial))
    return np.array(rows[1:])  # the first window has none before it


def test_torque_and_force_that_answer_a_rotating_force_are_of_second_order():
    exact = np.array([-FORCE * RADIUS * math.sin(LEAD), -FORCE * math.cos(LEAD) - 2.0 * RADIUS * SPEED**2])
    errors = []
    for dt in WINDOWS:
        readings = march(crank(), dt, 0.05, rotating_mean)
        errors.append(
            (np.abs(readings.mean(axis=0) / exact - 1.0), np.abs(readings / exact - 1.0).max(axis=0))
        )
    # the mean wrench of the window alone would lag by half a window: w dt/2 / tan(LEAD) = 0.36 % of the
    # torque at 125 us
    assert max(errors[0][1]) < 2.0 * (SPEED * WINDOWS[0]) ** 2
    for one, two in itertools.pairwise(errors):
        for k in range(2):  # of the mean, and of the worst window
            assert np.all((one[k] / two[k] > 3.5) & (one[k] / two[k] < 4.5))


def test_a_wrench_that_is_constant_leaves_the_reaction_of_the_solve():
    for force in (0.0, 50.0):
        system = crank()
        system.apply("crank", (force, 0.0, 0.0))
        system.march(0.01, 1e-4)
        assert np.abs(system.state.multiplier).max() > 1.0
        assert np.array_equal(system.state.reaction, system.state.multiplier)


def test_work_of_a_drive_is_that_of_the_impulse_and_not_of_the_reported_torque():
    # a force that jumps at every window: the body feels its mean, and so does the ledger
    system, dt, work = crank(), 1e-4, 0.0
    random = np.random.default_rng(5)
    for _ in range(200):
        drift(system.mechanism, system.state, system.scratch, dt)
        angle = SPEED * (system.time + 0.5 * dt)
        push = FORCE * random.normal()
        system.state.wrench[0, :2] = -push * math.sin(angle), push * math.cos(angle)
        finish(system.mechanism, system.state, system.scratch, dt)
        work -= push * RADIUS * SPEED * dt
    assert system.state.drive_work[0] == pytest.approx(work, rel=(SPEED * dt) ** 2 * 20)


def test_a_repeated_step_reports_as_one_that_converged_at_once():
    # the iterated coupling goes back to the start of a window with the wrench it produced, until both agree
    dt, system = 1e-4, crank()
    march(system, dt, 0.01, rotating_mean)
    force = rotating_mean(system.time, system.time + dt)
    system.state.wrench[0, :3] = force
    solve_again(system.mechanism, system.state, system.scratch)
    drift(system.mechanism, system.state, system.scratch, dt)
    finish(system.mechanism, system.state, system.scratch, dt)
    assert system.torque("motor") == pytest.approx(
        -FORCE * RADIUS * math.sin(LEAD), rel=2.0 * (SPEED * dt) ** 2
    )
