"""Coulomb friction in prismatic joints against closed forms: a block on a rail, a block on a slope, a sled on
a rail that is free itself.
"""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nutamill import CaseError, System
from nutamill.case import case_of_text
from nutamill.mechanism.loads import FRICTION_ANGLE
from nutamill.mechanism.parts import GROUND, Body, Drive, Joint, JointFriction, JointKind
from nutamill.simulation import runs

O, X, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
MASS, INERTIA, G, MU = 3.0, 0.02, 9.81, 0.25
LENGTH = math.sqrt(3.0 * INERTIA / (2.0 * MASS))
"""Radius of gyration of the block [m]."""


def block(speed, friction, axis=X, gravity=(0.0, 0.0, -G), drives=()):
    """A block that slides along a rail of the ground."""
    axis = np.asarray(axis)
    body = Body("block", MASS, INERTIA * np.eye(3), O, velocity=tuple(speed * axis))
    rail = Joint("rail", JointKind.PRISMATIC, GROUND, "block", (0.0, 0.0, -0.1), axis, friction=friction)
    return System([body], [rail], drives=drives, gravity=gravity)


def test_a_block_on_a_rail_decelerates_and_its_energy_becomes_the_work_of_friction():
    # v' = -a tanh(v/rest): sinh(v/rest) = sinh(v0/rest) exp(-a t/rest), for sliding and for the last creeping
    start, a = 1.5, MU * G
    rest = math.sqrt(2.0 * FRICTION_ANGLE * LENGTH * a)
    misses = []
    for dt in (4e-4, 2e-4):
        system = block(start, JointFriction(MU))
        system.march(0.4, dt)
        assert system.velocity("block")[0] == pytest.approx(start - a * 0.4, rel=1e-12)
        assert system.reaction("rail").force == pytest.approx((-MU * MASS * G, 0.0, MASS * G), rel=1e-12)
        assert system.state.loss[0] == pytest.approx(
            0.5 * MASS * (start**2 - (start - a * 0.4) ** 2), rel=1e-12
        )
        system.march(start / a - 0.4, dt)
        log = start / rest - math.log(2.0) - a * float(system.time) / rest
        misses.append(abs(system.velocity("block")[0] / (rest * math.asinh(math.exp(log))) - 1.0))
        system.march(0.1, dt)
        # of the energy at the start, what is left of the creeping is below round-off
        assert system.state.loss[0] == pytest.approx(0.5 * MASS * start**2, rel=(dt * a / rest) ** 2)
    assert misses[1] < max(misses[0] / 3.5, 1e-9)
    stopped = start**2 / (2.0 * a)
    # tanh brakes less than its limit over the last few `rest`, each of which takes rest^2/a
    assert system.position("block")[0] == pytest.approx(stopped, abs=rest**2 / a)


def test_constant_and_viscous_parts_brake_as_the_closed_form():
    # m v' = -(F + c v) while it slides: v + F/c falls by exp(-c t/m)
    force, viscous, start, t = 2.0, 4.0, 3.0, 0.5
    friction = JointFriction(0.0, constant_force=force, viscous_force=viscous)
    misses = []
    for dt in (1e-3, 5e-4):
        system = block(start, friction)
        system.march(t, dt)
        exact = (start + force / viscous) * math.exp(-viscous * t / MASS) - force / viscous
        misses.append(abs(system.velocity("block")[0] - exact))
        lost = 0.5 * MASS * (start**2 - system.velocity("block")[0] ** 2)
        assert system.state.loss[0] == pytest.approx(lost, rel=(viscous * dt / MASS) ** 2)
    assert 3.9 < misses[0] / misses[1] < 4.1


@pytest.mark.parametrize("slope", [0.2, 0.4])
def test_a_block_on_a_slope_stays_below_the_angle_of_friction_and_slides_above(slope):
    # below: it creeps at rest artanh(tan(slope)/mu); above: a = g (sin(slope) - mu cos(slope))
    down = (math.cos(slope), 0.0, -math.sin(slope))
    system = block(0.0, JointFriction(MU), down)
    system.march(0.5, 2e-4)
    along = float(np.dot(system.velocity("block"), down))
    rest = math.sqrt(2.0 * FRICTION_ANGLE * LENGTH * MU * G * math.cos(slope))
    if math.tan(slope) < MU:
        assert along == pytest.approx(rest * math.atanh(math.tan(slope) / MU), rel=1e-9)
    else:
        free = G * (math.sin(slope) - MU * math.cos(slope)) * 0.5
        # until it is at a few `rest`, friction is below its limit: at most rest log(2) of speed more
        assert free < along < free + G * 0.5 * rest


def test_friction_between_two_free_bodies_conserves_momentum_and_stops_their_relative_motion():
    # a sled on a long rail in space, beside the rail's mass centre: both move, both turn, as one in the end
    bodies = [
        Body("rail", 5.0, np.diag([0.4, 0.5, 0.6]), O, velocity=(0.0, 0.3, 0.0)),
        Body("sled", 2.0, np.diag([0.02, 0.03, 0.04]), (0.1, 0.0, 0.3), velocity=(1.0, 0.3, 0.0)),
    ]
    joint = Joint(
        "rail", JointKind.PRISMATIC, "rail", "sled", (0.1, 0.0, 0.2), X,
        friction=JointFriction(0.1, constant_force=4.0),
    )  # fmt: skip
    turned = []
    for dt in (1e-3, 5e-4):
        system = System(bodies, [joint], gravity=O)
        before, energy = momenta(system, bodies), system.energy().kinetic
        system.march(1.0, dt)
        change = momenta(system, bodies) - before
        assert change[0] == pytest.approx(O, abs=1e-13)
        turned.append(np.abs(change[1]).max())
        assert energy - system.energy().kinetic == pytest.approx(system.state.loss[0], rel=1e-5)
    assert turned[1] < turned[0] / 3.5  # of the second order of the step, as without friction
    arm = system.position("sled") - system.position("rail")
    relative = system.velocity("sled") - system.velocity("rail")
    # they turn on: against the centrifugal force friction holds by creeping, far below its limit of 4 N
    length, mass = math.sqrt(0.09 / (2.0 * 2.0)), 2.0 * 5.0 / 7.0
    rest = math.sqrt(2.0 * FRICTION_ANGLE * length * 4.0 / mass)
    creep = np.linalg.norm(relative - np.cross(system.angular_velocity("rail"), arm))
    assert creep < 0.1 * rest
    assert system.state.loss[0] > 0.3


def momenta(system, bodies):
    """Return momentum [kg m/s] and angular momentum about the origin [kg m^2/s] of all bodies, (2, 3)."""
    linear, angular = np.zeros(3), np.zeros(3)
    for body in bodies:
        rotation = Rotation.from_quat(np.roll(system.attitude(body.name), -1)).as_matrix()
        push = body.mass * system.velocity(body.name)
        linear += push
        angular += rotation @ body.inertia @ rotation.T @ system.angular_velocity(body.name)
        angular += np.cross(system.position(body.name), push)
    return np.array([linear, angular])


def test_a_drive_along_the_rail_feels_the_friction():
    drive = Drive("ram", "rail", (0.0,), (0.5,))
    system = block(0.5, JointFriction(MU, constant_force=1.5, viscous_force=4.0), drives=[drive])
    system.march(0.1, 1e-3)
    assert system.torque("ram") == pytest.approx(MU * MASS * G + 1.5 + 4.0 * 0.5, rel=1e-12)
    assert system.state.drive_work[0] == pytest.approx(system.state.loss[0], rel=1e-12)


def test_friction_of_the_other_kind_of_joint_is_refused():
    with pytest.raises(CaseError, match=r"force along the axis.*Give coefficient, constant_force and"):
        block(0.0, JointFriction(0.1, 0.01))
    pushed = JointFriction(0.0, constant_force=1.0)
    bearing = Joint("pin", JointKind.REVOLUTE, GROUND, "wheel", O, Z, friction=pushed)
    with pytest.raises(CaseError, match=r"its friction is a moment, got a part in N\. Give coefficient and"):
        System([Body("wheel", 1.0, np.eye(3), O)], [bearing])


SLED = """
schema = 1
[[bodies]]
name     = "sled"
mass     = "2 kg"
inertia  = ["0.01 kg m^2", "0.01 kg m^2", "0.01 kg m^2"]
position = ["0 m", "0 m", "0 m"]
velocity = ["1 m/s", "0 m/s", "0 m/s"]
[[joints]]
name     = "rail"
kind     = "prismatic"
between  = ["ground", "sled"]
point    = ["0 m", "0 m", "0 m"]
axis     = [1, 0, 0]
friction = { coefficient = 0.2, constant_force = "1 N", viscous_force = "0.5 N s/m" }
[run]
until = "0.2 s"
"""


def test_the_loss_of_a_sled_in_a_file_closes_its_ledger(tmp_path):
    with runs.run(case_of_text(SLED), tmp_path / "sled.h5") as result:
        loss = result.series["joint_rail_loss"].values
        residual = result.series["ledger_residual"].values
        across = result.series["joint_rail_force_z"].values
        along = result.series["joint_rail_force_x"].values
    # at least the load-dependent part over at least the way at the speed at the end, and never all
    assert 0.2 * (0.2 * 2.0 * G + 1.0) * 0.2 < loss[-1] < 0.5 * 2.0 * 1.0**2
    assert abs(residual).max() < 1e-6 * loss[-1]
    assert across == pytest.approx(2.0 * G, rel=1e-9)
    assert along[0] == pytest.approx(-(0.2 * 2.0 * G + 1.0 + 0.5), rel=1e-9)


@pytest.mark.parametrize(
    ("kind", "key", "value", "message"),
    [
        (
            "prismatic",
            "radius",
            "8 mm",
            "no meaning for a prismatic joint. It has coefficient, constant_force, ",
        ),
        (
            "revolute",
            "viscous_force",
            "1 N s/m",
            "no meaning for a revolute joint. It has coefficient, radius, ",
        ),
    ],
)
def test_friction_in_a_file_has_the_keys_of_its_joint(kind, key, value, message):
    keys = f'friction = {{ coefficient = 0.2, {key} = "{value}" }}'
    lines = [keys if line.startswith("friction") else line for line in SLED.splitlines()]
    text = "\n".join(lines).replace("prismatic", kind)
    with pytest.raises(CaseError) as caught:
        case_of_text(text)
    assert f"joints.rail.friction.{key}: has {message}" in str(caught.value)
    welded = SLED.replace("prismatic", "fixed").replace("axis     = [1, 0, 0]\n", "")
    with pytest.raises(CaseError, match=r"joints.rail.friction: has no meaning for a fixed joint\. Leave it"):
        case_of_text(welded)
