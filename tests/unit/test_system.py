"""`nutamill.System`: what it reads by name, and what it refuses."""

import math

import numpy as np
import pytest

from nutamill import CaseError, StepError, System
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointKind, Spring

O, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@pytest.fixture
def wheel():
    """A wheel of 2 kg whose mass centre is 0.1 m off its axle, the axle 0.3 m above the origin."""
    body = Body("wheel", 2.0, np.diag([0.01, 0.01, 0.02]), (0.1, 0.0, 0.3))
    axle = Joint("axle", JointKind.REVOLUTE, GROUND, "wheel", (0.0, 0.0, 0.3), Z)
    return System([body], [axle], drives=[Drive("motor", "axle", (0.0,), (5.0,))])


def test_a_driven_wheel_loads_its_axle_by_its_weight_and_centrifugal_force(wheel):
    wheel.march(math.pi / 10, 1e-4)  # a quarter of a revolution at 5 rad/s
    assert wheel.time == pytest.approx(math.pi / 10)
    # the drive prescribes the angle, so that the pose is exact
    assert wheel.position("wheel") == pytest.approx((0.0, 0.1, 0.3), abs=1e-12)
    assert wheel.velocity("wheel") == pytest.approx((-0.5, 0.0, 0.0), abs=1e-12)
    assert wheel.angular_velocity("wheel") == pytest.approx((0.0, 0.0, 5.0), abs=1e-12)
    assert wheel.attitude("wheel") == pytest.approx((math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)), abs=1e-12)
    reaction = wheel.reaction("axle")
    assert reaction.point == pytest.approx((0.0, 0.0, 0.3), abs=1e-12)
    # m r w^2 = 2 x 0.1 x 25 towards the axle, weight, and the moment of the weight about the axle's point
    assert reaction.force == pytest.approx((0.0, -5.0, 2.0 * 9.81), abs=1e-9)
    assert reaction.moment == pytest.approx((0.1 * 2.0 * 9.81, 0.0, 0.0), abs=1e-9)
    assert wheel.torque("motor") == pytest.approx(0.0, abs=1e-9)
    kinetic, potential, elastic = wheel.energy()
    assert kinetic == pytest.approx((0.02 + 2.0 * 0.01) * 25.0 / 2)
    assert (potential, elastic) == pytest.approx((2.0 * 9.81 * 0.3, 0.0))
    assert wheel.energy().total == pytest.approx(kinetic + potential)


def test_an_applied_force_at_rest_moves_a_bushing_by_its_compliance():
    system = System(
        [Body("block", 1.0, np.eye(3), O)],
        loads=[Bushing("mount", GROUND, "block", O, Z, (100.0, 200.0, 5.0, 5.0))],
        gravity=O,
    )
    system.apply("block", (1.0, 0.0, 4.0))
    system.rest()
    # force over stiffness; Newton's method ends at steps of 1e-11 m
    assert system.position("block") == pytest.approx((0.01, 0.0, 0.02), abs=1e-10)
    assert system.load("mount").force == pytest.approx((-1.0, 0.0, -4.0), abs=1e-8)
    assert system.energy().elastic == pytest.approx(0.5 * (100.0 * 0.01**2 + 200.0 * 0.02**2))


def test_a_step_is_a_march_of_one_step(wheel):
    wheel.step(1e-3)
    assert wheel.time == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda wheel: wheel.position("whel"), "body 'whel': unknown body. Known are wheel, ground"),
        (lambda wheel: wheel.reaction("pin"), "joint 'pin': unknown joint. Known are axle"),
        (lambda wheel: wheel.load("mount"), "bushing 'mount': unknown bushing. Known are none"),
        (lambda wheel: wheel.torque("crank"), "drive 'crank': unknown drive. Known are motor"),
        (lambda wheel: wheel.step(0.0), "dt: not a positive number, got 0.0. Give seconds"),
        (lambda wheel: wheel.march(-1.0, 1e-3), "duration: not a positive number, got -1.0"),
        (lambda wheel: wheel.march("long", 1e-3), "duration: not a positive number, got 'long'"),
        (lambda wheel: wheel.apply("wheel", (1.0, 2.0)), "force: it is not 3 finite numbers, got (1.0, 2.0)"),
        (lambda wheel: System(["wheel"]), "body number 0: not a Body, got str"),
        (
            lambda wheel: System([], loads=[7]),
            "loads: not a load, got int. Give Bushing, Spring, Torque, Force or Stop",
        ),
    ],
)
def test_bad_input_is_refused_in_words(wheel, act, message):
    with pytest.raises(CaseError) as caught:
        act(wheel)
    assert message in str(caught.value)


def test_motions_without_a_restoring_force_are_named():
    system = System([Body("block", 1.0, np.eye(3), O)], gravity=O)
    with pytest.raises(CaseError, match="modes: no restoring force, got translation of body 'block' along x"):
        system.modes()


def test_a_march_that_blows_up_says_when_and_what_to_do():
    # a step of 1 s on a spring of period 0.2 ms
    system = System(
        [Body("block", 1e-3, 1e-6 * np.eye(3), (0.0, 0.0, 1.0))],
        loads=[Spring("spring", GROUND, "block", O, (0.0, 0.0, 1.0), 1e6, 0.0, 0.9)],
    )
    with pytest.raises(StepError, match=r"t = \d+ s: the motion is not finite. Take a shorter step"):
        system.march(1000.0, 1.0)


def test_rest_where_nothing_supports_a_body_says_so():
    system = System([Body("block", 1.0, np.eye(3), O)])
    with pytest.raises(
        StepError, match="static equilibrium: none after 300 rounds, nothing balances all loads"
    ):
        system.rest()
