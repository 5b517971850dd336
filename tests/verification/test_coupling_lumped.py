"""Particles that never lose contact: the box rings, sags and weighs with them."""

import math

import numpy as np
import pytest
from coupled_bench import FLOOR, CoupledBench, G, Scheme, inside_of_a_box, law, sphere_mass
from scipy.linalg import eigh

R = 0.0025
BALL = sphere_mass(R)
BOX, SPRING = 0.05, 2e4
"""Mass of the box [kg] and stiffness below it [N/m]."""


def ringing(stiffness, mass, start, times):
    """Displacements (n_times, n) of an undamped chain with the velocities `start` (n,) at rest place, by its
    modes.
    """
    squares, shapes = eigh(stiffness, mass)
    w = np.sqrt(squares)
    amount = shapes.T @ mass @ start
    return (np.sin(np.outer(times, w)) / w * amount) @ shapes.T, w / (2 * math.pi)


# ---- one ball held between two walls: two degrees of freedom

CONTACT, SQUEEZE, KICK = 1e6, 5e-5, 1.0
"""Stiffness of each of the two contacts [N/m], overlap of each at rest [m], speed of the ball at the start
[m/s].
"""


def held_ball(window, scheme=Scheme.STAGGERED, end=0.002):
    """A ball between two walls that squeeze it, in a box on a spring; the ball starts with `KICK` along z,
    the box at rest.
    """
    half = R - SQUEEZE
    surfaces = [surface for surface in inside_of_a_box((1.0, 1.0, half)) if surface.name in ("bottom", "top")]
    bench = CoupledBench(
        [0.0, 0.0, 0.0],
        surfaces,
        law(CONTACT),
        window,
        BOX,
        stiffness=SPRING,
        velocities=[0.0, 0.0, KICK],
        scheme=scheme,
    )
    return bench.until(end)


def held_ball_exactly(times):
    """Box on SPRING, ball on the two contacts in parallel: places (n_times, 2) of box and ball, and both
    frequencies [Hz].
    """
    k = 2 * CONTACT
    return ringing(np.array([[SPRING + k, -k], [-k, k]]), np.diag([BOX, BALL]), np.array([0.0, KICK]), times)


def worst_error(bench):
    """Largest errors of the box's and of the ball's travel, in parts of the largest of each, (2,)."""
    exact, _ = held_ball_exactly(bench.read("time", "time"))
    seen = np.column_stack([bench.read("sensors", "box_z"), bench.read("mass_centre", "z")])
    return np.abs(seen - exact).max(axis=0) / np.abs(exact).max(axis=0)


SCHEMES = pytest.mark.parametrize("scheme", [Scheme.STAGGERED, Scheme.ITERATED])


@SCHEMES
def test_box_and_held_ball_ring_with_both_of_their_frequencies(scheme):
    # Second order in the window dt: as in any Verlet scheme the phase w2 t of the fast mode is wrong by a
    # share (w2 dt)^2/24, for
    # the part of the swing that the box takes in steps of a window (the ball's own substeps are ten times
    # finer). Bound: all of it.
    window, end = 1e-6, 0.002
    bench = held_ball(window, scheme, end)
    w2 = 2 * math.pi * held_ball_exactly(np.zeros(1))[1][1]
    assert np.all(worst_error(bench) < w2 * end * (w2 * window) ** 2 / 24)


@SCHEMES
def test_error_falls_with_the_square_of_the_window_while_contact_lasts(scheme):
    errors = np.array([worst_error(held_ball(window, scheme)) for window in (4e-6, 2e-6, 1e-6)])
    assert np.all(np.log2(errors[:-1] / errors[1:]) > 1.8), errors


@SCHEMES
def test_energy_of_box_and_held_ball_is_conserved_to_second_order_in_the_window(scheme):
    # no loss anywhere: box, spring, ball and contacts keep their energy; the ledger's residual is their
    # change
    worst, kinetic = [], 0.5 * BALL * KICK**2
    for window in (4e-6, 2e-6, 1e-6):
        energy = held_ball(window, scheme).energy()
        worst.append(np.abs(energy - energy[0]).max() / kinetic)
    assert worst[-1] < 1e-3
    assert np.all(np.log2(np.array(worst[:-1]) / worst[1:]) > 1.8), worst


# ---- a box packed with particles


def packed_box(scheme=Scheme.STAGGERED):
    """27 balls in 3 x 3 x 3, all squeezed by walls and neighbours alike, in a box on a spring; all start with
    0.05 m/s along z.
    """
    spacing = 2 * R - SQUEEZE
    grid = spacing * np.array([-1.0, 0.0, 1.0])
    places = np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3)
    half = spacing + R - SQUEEZE
    return CoupledBench(
        places,
        inside_of_a_box((half, half, half)),
        law(CONTACT),
        5e-6,
        BOX,
        stiffness=SPRING,
        box_velocity=(0.0, 0.0, 0.05),
        velocities=[0.0, 0.0, 0.05],
        scheme=scheme,
        substeps=5,
    )


def test_packed_box_rings_with_the_mass_of_box_and_particles():
    # Rayleigh with all moving alike bounds the frequency from above, Dunkerley from below: 1/w^2 = (M + m)/K
    # + 1/wi^2, where the
    # layers between resting walls ring with wi^2 = (2 - sqrt 2) k/m. The other modes shift a crossing by
    # about w/wi of the
    # share (w/wi)^2 they take: less than the distance of the two bounds.
    bench = packed_box().until(0.06)
    times, z = bench.read("time", "time"), bench.read("sensors", "box_z")
    at = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    crossings = times[at] - z[at] * (times[at + 1] - times[at]) / (z[at + 1] - z[at])
    w2 = (2 * math.pi / np.diff(crossings).mean()) ** 2
    together = BOX + 27 * BALL
    highest = SPRING / together
    lowest = 1.0 / (together / SPRING + BALL / ((2 - math.sqrt(2)) * CONTACT))
    assert len(crossings) == 5
    assert lowest < w2 < highest
    assert w2 < 0.9 * SPRING / BOX  # what the box would do without its particles


def test_spring_sags_under_the_weight_of_box_and_settled_particles():
    # critically damped: what is left of the start after 40 time constants is e^-40 (1 + 40), round-off of the
    # positions apart
    weight = (BOX + 9 * BALL) * G
    spacing = 3 * R * np.array([-1.0, 0.0, 1.0])
    places = [(x, y, R) for x in spacing for y in spacing]
    constant = math.sqrt((BOX + 9 * BALL) / SPRING)
    bench = CoupledBench(
        places,
        [FLOOR],
        law(CONTACT, 0.3),
        1e-5,
        BOX,
        stiffness=SPRING,
        damping=2 * SPRING * constant,
        gravity=(0.0, 0.0, -G),
        substeps=5,
    ).until(40 * constant)
    assert bench.z == pytest.approx(-weight / SPRING, rel=1e-9)
    # and each particle sinks into the floor by its own weight
    assert bench.x[:, 2] - bench.z - R == pytest.approx(np.full(9, -BALL * G / CONTACT), abs=1e-13)
