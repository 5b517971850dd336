"""Given forces and preloaded springs against closed forms."""

import numpy as np
import pytest

from nutamill import CaseError, System
from nutamill.mechanism.parts import GROUND, Body, Force, Joint, JointKind, Spring

O, X, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def block(mass=2.0, position=O):
    return Body("block", mass, np.diag([0.01, 0.02, 0.03]), position)


def test_a_force_table_gives_its_area_as_impulse():
    # rise, plateau, fall and a change of direction: the area of each piece is its mean times its length
    times = (0.0, 0.02, 0.05, 0.06, 0.10)
    forces = ((0.0, 0.0, 0.0), (50.0, 0.0, 0.0), (50.0, 20.0, 0.0), (0.0, 0.0, -10.0), (0.0, 0.0, 0.0))
    area = sum(
        0.5 * (t1 - t0) * np.add(f0, f1)
        for t0, t1, f0, f1 in zip(times[:-1], times[1:], forces[:-1], forces[1:], strict=True)
    )
    system = System([block()], loads=[Force("push", "block", forces, times)], gravity=O)
    system.march(0.12, 1e-3)  # every knot is the end of a step: the trapezoid rule is exact
    assert 2.0 * system.velocity("block") == pytest.approx(area, abs=1e-13)
    assert system.state.force_work[0] == pytest.approx(system.energy().kinetic, rel=1e-12)


def test_a_force_beside_the_mass_centre_turns_the_body_and_its_work_closes_the_ledger():
    # the arm turns with the body, the force does not: angle'' = F r cos(angle) / I_zz, a pendulum
    force, arm, inertia, residuals = 3.0, 0.2, 0.03, []
    for dt in (2e-3, 1e-3):
        push = Force("push", "block", (0.0, force, 0.0), point=(arm, 0.0, 0.0))
        system = System([block()], loads=[push], gravity=O)
        system.march(0.4, dt)
        residuals.append(system.energy().kinetic - system.state.force_work[0])
        turn = 2.0 * np.arctan2(system.attitude("block")[3], system.attitude("block")[0])
        # energy of the rotation: I w^2 / 2 = F r sin(angle)
        spin = system.angular_velocity("block")[2]
        work = force * arm * np.sin(turn)
        # of second order: (w dt)^2 with w^2 = F r / I
        assert 0.5 * inertia * spin**2 == pytest.approx(work, abs=force * arm * force * arm / inertia * dt**2)
        assert system.velocity("block")[1] == pytest.approx(force * 0.4 / 2.0, rel=1e-12)
    assert system.state.force_work[0] > 0.5
    assert abs(residuals[1]) < max(abs(residuals[0]) / 3.5, 1e-12)


def test_a_preloaded_spring_balances_the_weight_it_is_preloaded_for():
    weight = 2.0 * 9.81
    spring = Spring("spring", GROUND, "block", (0.0, 0.0, 1.0), O, 500.0, 0.0, preload=weight)
    guide = Joint("guide", JointKind.PRISMATIC, GROUND, "block", O, Z)
    system = System([block()], [guide], [spring])
    system.march(0.5, 1e-3)
    assert system.position("block") == pytest.approx(O, abs=1e-12)
    # twice the weight stretches it by weight / stiffness more
    system.apply("block", (0.0, 0.0, -weight))
    system.rest()
    assert system.position("block")[2] == pytest.approx(-weight / 500.0, abs=1e-10)
    # stored: tension^2 / (2 k), whatever the free length
    assert system.energy().elastic == pytest.approx((2.0 * weight) ** 2 / (2.0 * 500.0))


def test_free_length_and_preload_say_the_same():
    by_length = Spring("spring", GROUND, "block", (0.0, 0.0, 0.5), O, 800.0, 1.0, 0.45)
    by_preload = Spring("spring", GROUND, "block", (0.0, 0.0, 0.5), O, 800.0, 1.0, preload=800.0 * 0.05)
    ends = []
    for spring in (by_length, by_preload):
        system = System([block()], loads=[spring])
        system.march(0.1, 1e-3)
        ends.append(system.position("block"))
    assert ends[0] == pytest.approx(ends[1], abs=1e-14)


def test_faults_of_forces_and_springs_come_all_at_once():
    with pytest.raises(CaseError) as error:
        System(
            [block()],
            loads=[
                Force("a", "blok", (1.0, 0.0, 0.0)),
                Force("b", "block", (1.0, 0.0)),
                Force("c", "block", ((1.0, 0.0, 0.0),), (0.5,)),
                Force("d", "block", ((1.0, 0.0, 0.0),), (0.0, 1.0)),
                Force("e", "block", (1.0, 0.0, np.nan)),
                Spring("f", GROUND, "block", X, O, 1.0, 0.0),
                Spring("g", GROUND, "block", X, O, 1.0, 0.0, 0.5, 3.0),
                Spring("h", GROUND, "block", X, O, 0.0, 1.0, preload=3.0),
            ],
        )
    faults = {fault.where: fault.what for fault in error.value.faults}
    assert faults.keys() == {f"force '{name}'" for name in "abcde"} | {f"spring '{name}'" for name in "fgh"}
    assert "unknown moving body" in faults["force 'a'"]
    assert "begin at 0" in faults["force 'c'"]
    assert "one length" in faults["force 'd'"]
