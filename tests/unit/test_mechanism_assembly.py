"""What `assemble` refuses, and that it names the part."""

from typing import get_args

import numpy as np
import pytest

from nutamill.base.errors import CaseError
from nutamill.case.machine import JointEntry
from nutamill.case.machine_checks import TURNING, WITHOUT_AXIS
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.dynamics import OK, start
from nutamill.mechanism.parts import (
    GROUND,
    JOINTS,
    Body,
    Bushing,
    Drive,
    Joint,
    JointFriction,
    JointKind,
    Motor,
    Spring,
    Torque,
)
from nutamill.mechanism.probes import joint_reaction

O, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def box(name, place=O, mass=1.0, inertia=(1.0, 1.0, 1.0)):
    """A body of 1 kg."""
    return Body(name, mass, np.diag(inertia), place)


def refusal(*parts, **options) -> str:
    """What `assemble` says when it refuses."""
    with pytest.raises(CaseError) as caught:
        assemble(*parts, **options)
    return str(caught.value)


def test_all_faults_are_reported_at_once():
    message = refusal(
        [
            box("a", mass=-1.0),
            box("a"),
            box("flat", inertia=(1.0, 1.0, 3.0)),
            box("thin", inertia=(1.0, 1.0, 0.0)),
        ],
        [
            Joint("hinge", JointKind.REVOLUTE, "a", "nowhere", O),
            Joint("weld", JointKind.FIXED, "a", "flat", O, friction=JointFriction(0.1, 0.1)),
        ],
        [Bushing("mount", GROUND, "flat", O, Z, (1.0, 1.0, -1.0, 0.0))],
        [Spring("spring", GROUND, "flat", O, O, 1.0, 0.0, 0.0)],
        drives=[Drive("motor", "weld", (0.0, 0.0), (1.0, 2.0)), Drive("other", "nothing", (0.0,), (1.0,))],
    )
    for words in (
        "body 'a': mass is not positive, got -1 kg",
        "body 'a': the name is taken, got it twice. Rename one of them",
        "body 'flat': the largest principal inertia exceeds the sum of the others, "
        "got principal values 1, 1, 3 kg m^2. No mass distribution has this inertia",
        "body 'thin': inertia is not positive definite, got principal values 0, 1, 1 kg m^2",
        "joint 'hinge': unknown body, got 'nowhere'. Known bodies are a, flat, ground, thin",
        "joint 'hinge': a REVOLUTE joint needs an axis of non-zero length, got None",
        "joint 'weld': a FIXED joint does not move and has no friction",
        "bushing 'mount': stiffness or damping is negative, got (1.0, 1.0, -1.0, 0.0)",
        "spring 'spring': the two ends are one point",
        "drive 'motor': joint 'weld' neither turns about an axis nor only slides along it, got a FIXED "
        "joint. Drive a REVOLUTE, CYLINDRICAL or PRISMATIC joint",
        "drive 'motor': times do not begin at 0 and increase, got (0.0, 0.0)",
        "drive 'other': unknown joint, got 'nothing'. Known joints are hinge, weld",
    ):
        assert words in message


def test_gap_in_a_joint_is_refused_with_its_size_and_the_point_that_closes_it():
    message = refusal(
        [box("a")],
        [Joint("pin", JointKind.SPHERICAL, GROUND, "a", (0.1, 0.0, 0.0), point_b=(0.1, 0.0, 0.002))],
    )
    assert "joint 'pin'" in message and "gap of 2 mm" in message and "(100, 0, 0) mm" in message


def test_gap_along_the_axis_a_joint_slides_on_is_no_gap():
    joint = Joint("pin", JointKind.POINT_ON_LINE, GROUND, "a", O, Z, point_b=(0.0, 0.0, 0.3))
    assert start(*assemble([box("a")], [joint])) == OK


def test_redundant_constraints_are_refused_by_name():
    joints = [
        Joint("left", JointKind.REVOLUTE, GROUND, "a", O, Z),
        Joint("right", JointKind.REVOLUTE, GROUND, "a", (0.0, 0.0, 1.0), Z),
    ]
    message = refusal([box("a")], joints)
    assert (
        "joint 'right'" in message
        and "already locked by joint 'left'" in message
        and 'redundant = "allow"' in message
    )


def test_allowed_redundancy_marks_the_reactions_it_leaves_open():
    joints = [
        Joint("left", JointKind.REVOLUTE, GROUND, "a", O, Z),
        Joint("right", JointKind.REVOLUTE, GROUND, "a", (0.0, 0.0, 1.0), Z),
        Joint("last", JointKind.REVOLUTE, "a", "b", (0.0, 1.0, 1.0), Z),
    ]
    mechanism, state, scratch = assemble([box("a"), box("b", (0.0, 1.0, 1.0))], joints, redundant="allow")
    assert list(mechanism.joints.reaction_unique) == [0, 0, 1]
    assert start(mechanism, state, scratch) == OK
    left, right = np.zeros(6), np.zeros(6)
    joint_reaction(mechanism, state, 0, left)
    joint_reaction(mechanism, state, 1, right)
    assert abs(left[2] + right[2] - 2.0 * 9.81) < 1e-12  # together they carry both bodies


def test_contradicting_drives_are_refused_even_where_redundancy_is_allowed():
    joints = [Joint("hinge", JointKind.REVOLUTE, GROUND, "a", O, Z)]
    drives = [Drive("one", "hinge", (0.0,), (1.0,)), Drive("two", "hinge", (0.0,), (3.0,))]
    for redundant in ("refuse", "allow"):
        message = refusal([box("a")], joints, drives=drives, redundant=redundant)
        assert "drive 'two'" in message and "drive 'one'" in message and "differ by 2 rad/s" in message


def test_axes_of_a_universal_joint_must_be_square():
    message = refusal([box("a")], [Joint("hooke", JointKind.UNIVERSAL, GROUND, "a", O, Z, (0.0, 1.0, 1.0))])
    assert "joint 'hooke': the two axes are not square" in message and "45 deg" in message


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        (
            [Body("a", 1.0, np.eye(3), (0.0, 0.0))],
            "body 'a': position is not 3 finite numbers, got (0.0, 0.0)",
        ),
        ([Body("a", float("nan"), np.eye(3), O)], "body 'a': mass is not a finite number, got nan"),
        ([Body("a", 1.0, np.eye(2), O)], "body 'a': inertia is not 3 x 3 finite numbers"),
        ([Body("a", 1.0, "round", O)], "body 'a': inertia is not 3 x 3 finite numbers, got 'round'"),
        ([Body("a", 1.0, np.eye(3), O, (2.0, 0.0, 0.0, 0.0))], "the quaternion has not length 1, got 2"),
        ([Body("a", 1.0, np.eye(3) + np.eye(3, k=1) / 2, O)], "body 'a': inertia is not symmetric"),
        ([Body("", 1.0, np.eye(3), O)], "body '': a name has 1 to 64 characters, got 0"),
        ([Body(7, 1.0, np.eye(3), O)], "body number 0: the name is no text, got 7"),
        (["a"], "body number 0: not a Body, got str. Give nutamill.mechanism.parts.Body(...)"),
    ],
)
def test_a_body_that_cannot_be_is_refused_in_words(parts, message):
    assert message in refusal(parts, [])


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        (
            Joint("j", "hinge", GROUND, "a", O),
            "joint 'j': unknown kind, got 'hinge'. Give one of JointKind.FIXED",
        ),
        (Joint("j", JointKind.FIXED, "a", "a", O), "joint 'j': joins a body to itself, got 'a' twice"),
        (
            Joint("j", JointKind.UNIVERSAL, GROUND, "a", O, Z),
            "needs a second_axis of non-zero length, got None",
        ),
        (
            Joint("j", JointKind.SPHERICAL, GROUND, "a", O, friction=JointFriction(-1.0, 0.1)),
            "joint 'j': friction values are negative",
        ),
        (
            Joint("j", JointKind.SPHERICAL, GROUND, "a", O, friction=JointFriction(float("inf"), 0.1)),
            "joint 'j': coefficient is not a finite number, got inf",
        ),
    ],
)
def test_a_joint_that_cannot_be_is_refused_in_words(joint, message):
    assert message in refusal([box("a")], [joint])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"redundant": "maybe"}, 'redundant: no such choice, got \'maybe\'. Give "refuse" or "allow"'),
        ({"gravity": (0.0, 9.81)}, "gravity: it is not 3 finite numbers, got (0.0, 9.81)"),
        ({"torques": [Torque("t", GROUND, Z)]}, "torque 't': unknown moving body, got 'ground'"),
        ({"torques": [Torque("t", "a", (1.0,))]}, "torque 't': moment is not 3 finite numbers, got (1.0,)"),
        ({"springs": [Spring("s", GROUND, "a", O, Z, -1.0, 0.0, 0.1)]}, "free_length is negative"),
        ({"bushings": [Bushing("b", GROUND, "a", O, O, (1.0,) * 4)]}, "bushing 'b': the axis has no length"),
        ({"bushings": [Bushing("b", GROUND, "a", O, Z, (1.0,) * 3)]}, "stiffness is not 4 finite numbers"),
        (
            {"drives": [Drive("d", "j", (0.0,), (1.0, 2.0))]},
            "two lists of one length, got shapes (1,) and (2,)",
        ),
        ({"drives": [Drive("d", "j", "now", (1.0,))]}, "times and speeds are not lists of numbers, got now"),
        ({"drives": [Drive("d", "j", (0.0,), (float("nan"),))]}, "times or speeds are not finite"),
        (
            {"drives": [Drive("d", "j", (0.0,), (1.0,), Motor(-1.0, 0.0))]},
            "drive 'd': gains or limits of the motor are negative",
        ),
    ],
)
def test_loads_and_drives_that_cannot_be_are_refused_in_words(options, message):
    hinge = Joint("j", JointKind.REVOLUTE, GROUND, "a", O, Z)
    assert message in refusal([box("a")], [hinge], **options)


def test_joints_lock_as_many_directions_as_they_take_freedoms():
    # three translations and three rotations, less the motions that the kind is named for
    free = {"FIXED": 0, "REVOLUTE": 1, "SPHERICAL": 3, "UNIVERSAL": 2, "CYLINDRICAL": 2, "PRISMATIC": 1}
    free["POINT_ON_LINE"] = 4
    assert {kind.name: 6 - rows.points - rows.axes for kind, rows in JOINTS.items()} == free


def test_kinds_of_joints_in_case_files_are_those_of_the_engine():
    assert set(get_args(JointEntry.model_fields["kind"].annotation)) == {kind.name.lower() for kind in JOINTS}
    assert set(TURNING) == {kind.name.lower() for kind, rows in JOINTS.items() if rows.turns}
    assert set(WITHOUT_AXIS) == {kind.name.lower() for kind, rows in JOINTS.items() if not rows.needs_axis}
