"""Unbalance motors: the amplitude of a sprung mass, the bearing force, the power of the drive."""

import math
from dataclasses import replace

import numpy as np
import pytest

from nutamill import CaseError, System
from nutamill.mechanism.parts import GROUND, Body, Bushing, Joint, JointKind, Motor
from nutamill.mechanism.unbalance import UnbalanceMotor

O, X, Y, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
FRAME, ROTOR, ECCENTRICITY, STIFFNESS = 18.0, 2.0, 0.03, 32e3
SPEED = 60.0
"""Speed of the motor [rad/s]; the frequency of the sprung mass is 40 rad/s."""


def screen(motor, damping=0.0, speed=0.0):
    """A frame that moves up and down on a spring, thrown up at `speed`, with an unbalance motor about y."""
    body = Body("frame", FRAME, np.eye(3), O, velocity=(0.0, 0.0, speed))
    guide = Joint("guide", JointKind.PRISMATIC, GROUND, "frame", O, Z)
    spring = Bushing("spring", GROUND, "frame", O, Z, (0.0, STIFFNESS, 0.0, 0.0), (0.0, damping, 0.0, 0.0))
    rotor, bearing, drive = motor.parts()
    if speed:  # the rotor runs already, and moves with the frame
        spin = motor.speeds[0]
        velocity = (0.0, 0.0, speed - spin * ECCENTRICITY)
        rotor = replace(rotor, velocity=velocity, angular_velocity=(0.0, spin, 0.0))
    return System([body, rotor], [guide, bearing], [spring], [drive], gravity=O)


def unbalance(**other):
    """The motor, its mass ahead of the x axis: z = -e sin(w t)."""
    numbers = {"times": (0.0,), "speeds": (SPEED,)} | other
    return UnbalanceMotor("shaker", "frame", O, Y, X, ROTOR, ECCENTRICITY, **numbers)


def amplitude(speed):
    """m_e e w^2 / (k - m w^2), m the whole mass [m]."""
    return ROTOR * ECCENTRICITY * speed**2 / (STIFFNESS - (FRAME + ROTOR) * speed**2)


@pytest.mark.parametrize("speed", [20.0, 60.0, 200.0])
def test_a_sprung_frame_swings_as_the_closed_form(speed):
    # started with the speed of its steady motion, an undamped frame has no other: z = -A sin(w t)
    a, dt = amplitude(speed), 0.02 / speed
    system = screen(unbalance(speeds=(speed,)), speed=-a * speed)
    n = round(math.pi / speed / dt)
    for _ in range(4):
        system.march(0.5 * n * dt, dt)
        exact = -a * math.sin(speed * system.time)
        # of second order in both frequencies of the motion
        faster = max(speed, 40.0)
        assert system.position("frame")[2] == pytest.approx(exact, abs=3.0 * abs(a) * (faster * dt) ** 2)


def test_the_bearing_carries_the_force_of_the_eccentric_mass():
    system = screen(unbalance(), speed=-amplitude(SPEED) * SPEED)
    dt = 1e-4
    system.march(0.25 * 2.0 * math.pi / SPEED, dt)
    # a quarter of a turn: the mass is at the lowest point, e + A below the frame's rest, and accelerates up
    force = ROTOR * SPEED**2 * (ECCENTRICITY + amplitude(SPEED))
    assert system.reaction("shaker").force[2] == pytest.approx(force, rel=5.0 * (SPEED * dt) ** 2)


def test_the_drive_pays_for_what_the_damper_loses():
    # steady: mean power = c A^2 w^2 / 2 with A of the damped oscillator
    damping = 300.0
    system = screen(unbalance(), damping)
    turn = 2.0 * math.pi / SPEED
    system.march(20.0 * turn, turn / 200)
    before = system.state.drive_work[0], system.state.loss[0]
    system.march(10.0 * turn, turn / 200)
    work, loss = system.state.drive_work[0] - before[0], system.state.loss[0] - before[1]
    size = (
        ROTOR
        * ECCENTRICITY
        * SPEED**2
        / abs(complex(STIFFNESS - (FRAME + ROTOR) * SPEED**2, damping * SPEED))
    )
    # 20 turns leave exp(-c t / 2 m) = exp(-15.7) of the transient; (w dt)^2 of a step is 1e-3
    assert loss == pytest.approx(10.0 * turn * 0.5 * damping * (size * SPEED) ** 2, rel=2e-3)
    assert work == pytest.approx(loss, rel=2e-3)


def test_a_weak_motor_stays_below_the_resonance_it_cannot_pass():
    # all power goes into the damper near the resonance (Sommerfeld): a strong motor passes, a weak one stays
    speeds = []
    for power in (1000.0, 8.0):
        motor = Motor(5.0, 0.0, torque_limit=20.0, power_limit=power)
        system = screen(unbalance(motor=motor), damping=100.0)
        system.march(3.0, 5e-4)
        speeds.append(system.state.drive_motion[0, 1])
    assert speeds[0] == pytest.approx(SPEED, rel=0.05)
    assert speeds[1] < 40.0


def test_numbers_that_no_rotor_has_are_refused_all_at_once():
    with pytest.raises(CaseError) as error:
        UnbalanceMotor("a", "frame", O, Y, (1.0, 1.0, 0.0), 0.0, -1.0, (0.0,), (1.0,), inertia=0.0).parts()
    message = str(error.value)
    for words in ("mass is not positive", "eccentricity is not positive", "inertia is not", "not square"):
        assert words in message
