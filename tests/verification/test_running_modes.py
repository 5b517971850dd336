"""Modes of turning machines against closed forms."""

import numpy as np
import pytest

from nutamill.base.errors import CaseError
from nutamill.case import load_case
from nutamill.design.campbell import campbell
from nutamill.design.modes import machine_modes
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointKind
from nutamill.mechanism.running_modes import running_modes

O, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def gyroscope(speed):
    """A disc on a frame that can only tilt: its whirls at `speed`, in rad/s."""
    k, axial, transverse = 400.0, 0.02, 0.03  # the frame has half of the transverse inertia
    frame = Body("frame", 1.0, np.diag([0.015, 0.015, 0.02]), O)
    disc = Body("disc", 1.0, np.diag([0.015, 0.015, axial]), O)
    joints = [
        Joint("pivot", JointKind.UNIVERSAL, GROUND, "frame", O, (1, 0, 0), (0, 1, 0)),
        Joint("shaft", JointKind.REVOLUTE, "frame", "disc", O, Z),
    ]
    seat = Bushing("seat", GROUND, "frame", O, Z, (0, 0, k, k))
    built = assemble(
        [frame, disc], joints, [seat], drives=[Drive("motor", "shaft", (0.0, 1.0), (speed, speed))], gravity=O
    )
    static_equilibrium(*built)
    vibrations, _ = running_modes(*built, np.array([3, 4]), np.zeros(2), np.arange(6) / 6 * 2 * np.pi / speed)
    return 2 * np.pi * vibrations.frequency, k, axial, transverse


def test_whirls_of_a_gyroscope_are_split_by_its_speed():
    # It phi'' - i Ip speed phi' + k phi = 0 for phi = tilt x + i tilt y; with exp(i w t): It w^2 - Ip speed w
    # - k = 0
    speed = 150.0
    frequencies, k, axial, transverse = gyroscope(speed)
    half = axial * speed / (2 * transverse)
    root = np.sqrt(half**2 + k / transverse)
    # central differences of 1e-5: error of order (1e-5)^2, round-off 1e-16 / 1e-5 of accelerations of some
    # 1e4
    assert frequencies == pytest.approx([root - half, root + half], rel=1e-6)


def test_slowly_turning_mill_has_the_modes_of_the_mill_at_rest():
    # two ways to the same frequencies: energies about rest, and accelerations about a running drive. At rest
    # the crank points to x,
    # which splits the swaying pair by a part in 10^4; the average over a turn does not
    case = load_case("numill", ["charge.kind=none"])
    rest, slow = machine_modes(case), machine_modes(case, 0.01)
    assert slow.frequency == pytest.approx(rest.frequency, rel=5e-4)
    assert slow.damping_ratio == pytest.approx(rest.damping_ratio, rel=2e-2)


def test_torsion_of_the_drive_train_is_one_inertia_on_the_coupling():
    case = load_case("numill", ["charge.kind=none", "mechanism.mounting=rigid"])
    vibrations = machine_modes(case, 50.0)
    assert vibrations.label(0) == "torsion of the drive train"
    assert 2 * np.pi * vibrations.frequency[0] == pytest.approx(np.sqrt(287.0 / 0.002), rel=1e-5)
    assert vibrations.damping_ratio[0] == pytest.approx(0.05 / (2 * np.sqrt(287.0 * 0.002)), rel=1e-5)


def test_charge_makes_the_swaying_slower_by_its_share_of_the_mass():
    # 1.347 kg of 84.5 kg, near the chamber's foot: less than half its share of the mass, as sqrt(k/m)
    case = load_case("numill")
    ratio = machine_modes(case, charge=True).frequency[0] / machine_modes(case).frequency[0]
    assert 1 - 1.347 / 84.54 < ratio < 1.0


def test_speeds_to_avoid_lie_where_the_order_meets_the_frequency():
    diagram = campbell(load_case("numill", ["charge.kind=none"]), count=3)
    assert {at.order for at in diagram.avoid} == {1.0, 2.0}
    for at in diagram.avoid:
        assert at.order * at.speed / (2 * np.pi) == pytest.approx(at.frequency, rel=1e-9)


def test_mode_search_of_a_machine_that_is_not_held_is_refused():
    case = load_case("numill", ["charge.kind=none", "shaft_coupling.torsion_stiffness=0 N m/rad"])
    with pytest.raises(
        CaseError, match=r"no restoring force, got rotation of body .intermediate_shaft. about z"
    ):
        machine_modes(case)
