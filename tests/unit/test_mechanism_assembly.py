"""What `assemble` refuses, and that it names the part."""

import numpy as np
import pytest

from nutamill.base.errors import CaseError
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.dynamics import OK, start
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointFriction, JointKind, Spring
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


def test_all_faults_are_told_at_once():
    said = refusal(
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
        "mass must be positive, got -1 kg",
        "body 'a': names must be unique",
        "body 'flat': the largest principal inertia",
        "body 'thin': inertia must be positive definite",
        "got 'nowhere'",
        "joint 'hinge': a REVOLUTE joint needs an axis",
        "joint 'weld': a FIXED joint does not turn",
        "bushing 'mount': stiffness and damping must not be negative",
        "spring 'spring': the two ends must be apart",
        "drive 'motor': must turn a REVOLUTE",
        "drive 'motor': times must begin at 0",
        "drive 'other': must turn a known joint",
    ):
        assert words in said


def test_gap_in_a_joint_is_refused_with_its_size_and_the_point_that_closes_it():
    said = refusal(
        [box("a")],
        [Joint("pin", JointKind.SPHERICAL, GROUND, "a", (0.1, 0.0, 0.0), point_b=(0.1, 0.0, 0.002))],
    )
    assert "joint 'pin'" in said and "gap of 2 mm" in said and "(100, 0, 0) mm" in said


def test_gap_along_the_axis_a_joint_slides_on_is_no_gap():
    joint = Joint("pin", JointKind.POINT_ON_LINE, GROUND, "a", O, Z, point_b=(0.0, 0.0, 0.3))
    assert start(*assemble([box("a")], [joint])) == OK


def test_redundant_constraints_are_refused_by_name():
    joints = [
        Joint("left", JointKind.REVOLUTE, GROUND, "a", O, Z),
        Joint("right", JointKind.REVOLUTE, GROUND, "a", (0.0, 0.0, 1.0), Z),
    ]
    said = refusal([box("a")], joints)
    assert (
        "joint 'right'" in said and "already held by joint 'left'" in said and 'redundant = "allow"' in said
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
    joint_reaction(mechanism, state, scratch, 0, left)
    joint_reaction(mechanism, state, scratch, 1, right)
    assert abs(left[2] + right[2] - 2.0 * 9.81) < 1e-12  # together they carry both bodies


def test_contradicting_drives_are_refused_even_where_redundancy_is_allowed():
    joints = [Joint("hinge", JointKind.REVOLUTE, GROUND, "a", O, Z)]
    drives = [Drive("one", "hinge", (0.0,), (1.0,)), Drive("two", "hinge", (0.0,), (3.0,))]
    for redundant in ("refuse", "allow"):
        said = refusal([box("a")], joints, drives=drives, redundant=redundant)
        assert "drive 'two'" in said and "drive 'one'" in said and "differ by 2 rad/s" in said


def test_axes_of_a_universal_joint_must_be_square():
    said = refusal([box("a")], [Joint("hooke", JointKind.UNIVERSAL, GROUND, "a", O, Z, (0.0, 1.0, 1.0))])
    assert "joint 'hooke': the two axes must be square" in said and "45 deg" in said
