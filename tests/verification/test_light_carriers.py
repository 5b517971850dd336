"""Carriers that are light, or coupled in windows that are long for them: mass, warnings, refusals."""

import math
import warnings

import numpy as np
import pytest
from charge_bench import FLOOR, law, sphere_mass

import nutamill as nm
from nutamill.base.light_carriers import (
    DIVERGING_WINDOW,
    LONG_WINDOW,
    UNSTABLE_WINDOW,
    PushedCarrier,
    carrier_faults,
    carrier_warnings,
)
from nutamill.mechanism.parts import GROUND, Body, Drive, Joint, JointKind
from nutamill.mechanism.system import System

O, X, Z = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
ROD = Body("rod", 3.0, np.diag([1e-4, 0.25, 0.25]), (0.5, 0.0, 0.0))
"""A slender rod of a metre along x, with its left end at the origin."""


def test_free_rod_answers_at_its_end_with_a_quarter_of_its_mass():
    system = System([ROD], gravity=O)
    assert system.effective_mass("rod", (0.5, 0.0, 0.0), Z) == pytest.approx(3.0)
    # 1/m + (L/2)^2/(m L^2/12) = 4/m
    assert system.effective_mass("rod", (1.0, 0.0, 0.0), Z) == pytest.approx(0.75)
    assert system.effective_mass("rod", (1.0, 0.0, 0.0), X) == pytest.approx(3.0)
    assert system.effective_mass("rod", (1.0, 0.0, 0.0)) == pytest.approx(0.75)


def test_hinged_rod_answers_with_its_inertia_about_the_hinge():
    hinge = Joint("hinge", JointKind.REVOLUTE, GROUND, "rod", O, (0.0, 1.0, 0.0))
    system = System([ROD], [hinge], gravity=O)
    # I/a^2 = (m L^2/3)/a^2 square to the rod; held along it and along the axis
    assert system.effective_mass("rod", (0.5, 0.0, 0.0), Z) == pytest.approx(1.0 / 0.25)
    assert system.effective_mass("rod", (1.0, 0.0, 0.0)) == pytest.approx(1.0)
    assert system.effective_mass("rod", (1.0, 0.0, 0.0), X) == math.inf
    assert system.effective_mass("rod", O) == math.inf
    driven = System([ROD], [hinge], drives=[Drive("motor", "hinge", (0.0,), (1.0,))], gravity=O)
    assert driven.effective_mass("rod", (1.0, 0.0, 0.0)) == math.inf


def test_body_on_a_slide_carries_the_body_that_hangs_on_it():
    # a rod on a cart: pushed along the slide at its hinge, the cart takes m/(1 + 3 cos^2) along: here m/4
    cart = Body("cart", 2.0, 0.1 * np.eye(3), O)
    rod = Body("rod", 3.0, np.diag([0.25, 0.25, 1e-4]), (0.0, 0.0, -0.5))
    joints = [
        Joint("slide", JointKind.PRISMATIC, GROUND, "cart", O, X),
        Joint("hinge", JointKind.REVOLUTE, "cart", "rod", O, (0.0, 1.0, 0.0)),
    ]
    system = System([cart, rod], joints, gravity=O)
    assert system.effective_mass("cart", O, X) == pytest.approx(2.0 + 3.0 / 4.0)


def gain(phase: float) -> float:
    """Return the factor by which the energy of a body on an undamped contact spring grows in half a swing,
    staggered with windows of this phase [rad].

    The push of a window is the mean of ``-k x`` over the motion held through it.
    """
    k, mass = 100.0, 1.0
    dt = phase / math.sqrt(k / mass)
    body = Body("box", mass, np.eye(3), (1e-3, 0.0, 0.0))
    system = System(
        [body], [Joint("slide", JointKind.PRISMATIC, GROUND, "box", (1e-3, 0.0, 0.0), X)], gravity=O
    )

    def energy():
        return 0.5 * k * system.position("box")[0] ** 2 + 0.5 * mass * system.velocity("box")[0] ** 2

    windows, energies = round(40 * math.pi / phase), []
    for _ in range(windows):
        x, v, a = (
            system.state.position[0, 0],
            system.state.velocity[0, 0],
            system.state.acceleration[0, 0],
        )
        system.apply("box", (-k * (x + v * dt / 2 + a * dt * dt / 6), 0.0, 0.0))
        system.step(dt)
        energies.append(energy())
    # from the second half swing on, the start is forgotten; means over whole swings
    swing = round(math.pi / phase)
    first, last = np.mean(energies[swing : 3 * swing]), np.mean(energies[-2 * swing :])
    return (last / first) ** (math.pi / (phase * (windows - 3 * swing)))


def test_limits_of_the_window_are_those_of_the_scheme():
    # gain per half swing of about phase^3; the means of the energy err by the number of windows in a swing
    assert 1.007 < gain(LONG_WINDOW) < 1.01
    assert gain(UNSTABLE_WINDOW) == pytest.approx(2.0, rel=0.05)


def heavy(mass=1.0, contacts=1):
    return PushedCarrier("box", mass, 1e-3, 1e4, contacts)


def test_heavy_carrier_in_a_short_window_passes():
    window = 0.99 * LONG_WINDOW / 100.0
    assert carrier_warnings(heavy(), window) == carrier_faults(heavy(), window) == []
    assert carrier_warnings(heavy(math.inf), 1.0) == carrier_faults(heavy(math.inf), 1.0) == []


def test_light_carrier_and_long_window_are_warned_of_with_the_window_to_take():
    window = 1.5 * LONG_WINDOW / 100.0
    (long,) = carrier_warnings(heavy(), window)
    assert str(long) == (
        "box: moves on its contacts by 0.3 rad in a window of 3000 us: its contacts gain energy. "
        'Take a window of at most 2000 us, or coupling = "iterated"'
    )
    # four contacts at once are four springs: twice the frequency
    assert "at most 1000 us" in str(carrier_warnings(heavy(contacts=4), window)[0])
    assert carrier_warnings(heavy(), window, iterated=True) == []
    (light,) = carrier_warnings(heavy(0.049), 1e-9)
    assert str(light).startswith("box: weighs 49 particles where they touch it, less than 50")
    assert carrier_faults(heavy(), window) == []


def test_window_beyond_stability_is_refused():
    (fault,) = carrier_faults(heavy(), 1.01 * UNSTABLE_WINDOW / 100.0)
    assert "unstable" in str(fault) and 'at most 2000 us, or coupling = "iterated"' in str(fault)
    assert carrier_faults(heavy(), 1.01 * UNSTABLE_WINDOW / 100.0, iterated=True) == []
    (fault,) = carrier_faults(heavy(), 1.01 * DIVERGING_WINDOW / 100.0, iterated=True)
    assert "diverge" in str(fault)


def ball_on_a_carrier(mass):
    """A ball above the floor of a carrier of this mass in balls; stiffness 1e5 N/m."""
    ball = nm.spheres([0.01]).placed([[0.0, 0.0, 0.0051]])
    return nm.Charge(
        ball, [7850.0], law(1e5), [FLOOR], dt=1e-6, carrier_masses=[mass * sphere_mass(0.005, 7850.0)]
    )


def test_charge_warns_and_refuses_at_its_own_face():
    one = sphere_mass(0.005, 7850.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ball_on_a_carrier(100.0).march(1e-5)
    with pytest.warns(UserWarning, match="carrier 0: weighs 10 particles"):
        ball_on_a_carrier(10.0).march(1e-5)
    with pytest.raises(nm.CaseError, match=r"carrier 0: .* unstable"):
        ball_on_a_carrier(100.0).march(1.1 * UNSTABLE_WINDOW * math.sqrt(100.0 * one / 1e5))
    with pytest.raises(nm.CaseError, match="carrier_masses: must be a positive mass for each carrier"):
        ball_on_a_carrier(-1.0)
