"""Rolling, sliding, resting and colliding against closed forms."""

import math

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law, sphere_mass

from nutamill.charge.face import at_rest
from nutamill.charge.laws.composition import ContactLaw
from nutamill.charge.laws.type_a import RollingTypeA
from nutamill.charge.walls.surface import Surface, SurfaceKind

R, G = 0.0025, 9.81
M = sphere_mass(R)
DOWN = (0.0, 0.0, -G)
K = 1e4
DT = 2e-6
SAG = M * G / K
"""Static overlap of one ball on a plane."""


def test_sliding_ball_rolls_at_five_sevenths_of_its_speed():
    # friction mu m g until v = R w: v = 5/7 v0 after 2 v0/(7 mu g), over 12 v0^2/(49 mu g); arm R less half
    # the sag: 2e-7 of R
    mu, v0 = 0.3, 0.05
    t = 2 * v0 / (7 * mu * G)
    bench = Bench([0, 0, R - SAG], law(K, 0.1, friction=mu), DT, [FLOOR], gravity=DOWN, velocities=[v0, 0, 0])
    bench.step(round(t / DT))
    # the spring first stretches by mu m g/k: the start is late by about that length over the speed
    late = mu * SAG / v0 + DT
    assert bench.positions[0, 0] == pytest.approx(12 * v0**2 / (49 * mu * G), abs=2 * late * v0)
    bench.step(round(0.3 * t / DT))
    # the spring keeps swinging with at most the speed it was released with, sqrt(7/2 kt/m) mu m g/kt
    swing = mu * G * math.sqrt(M / K)
    assert bench.velocities[0, 0] == pytest.approx(5 / 7 * v0, abs=swing)
    assert R * bench.spins[0, 1] == pytest.approx(5 / 7 * v0, abs=2.5 * swing)


def test_ball_rolls_to_and_fro_in_a_cylinder_at_the_frequency_of_rolling():
    # small swings: w^2 = 5 g/(7 (bore - R)); quarter period from the release at rest to the lowest point
    bore, angle = 0.05, 0.05
    arm = bore - R + SAG
    bench = Bench(
        [arm * math.sin(angle), 0, -arm * math.cos(angle)],
        law(K, 0.1, friction=0.5),
        1e-5,
        [
            Surface(
                "bore",
                SurfaceKind.CYLINDER,
                0,
                0,
                size=(bore, 0, 0),
                rotation=((1, 0, 0), (0, 0, -1), (0, 1, 0)),
            )
        ],
        gravity=DOWN,
    )
    quarter = 0.5 * math.pi / math.sqrt(5 * G / (7 * (bore - R)))
    n = round(quarter / 1e-5)
    bench.step(n)
    # amplitude: quarter period longer by angle^2/16 = 1.6e-4; the swing of the springs adds less than mu
    # SAG/2R = 1e-4 of the amplitude
    assert abs(bench.positions[0, 0]) < 1e-3 * arm * angle + bench.velocities[0, 0] ** 2
    assert bench.velocities[0, 0] == pytest.approx(
        -arm * angle * math.sqrt(5 * G / (7 * (bore - R))), rel=2e-3
    )


@pytest.mark.parametrize(("slope", "rolls"), [(0.08, False), (0.12, True)])
def test_rolling_spring_holds_a_ball_on_an_incline_up_to_its_limit(slope, rolls):
    # M_r = mu_r R m g cos(slope) against R m g sin(slope): holds below atan(mu_r) = 0.0997
    gravity = (G * math.sin(slope), 0, -G * math.cos(slope))
    bench = Bench([0, 0, R - SAG], law(K, 0.3, friction=0.8, rolling=0.1), 4e-6, [FLOOR], gravity=gravity)
    bench.step(25000)
    t = 0.1
    # rolling freely with the limit moment: a = 5/7 g (sin - mu_r cos); holding: the spring gives by some g
    # sin/w^2 and swings undamped
    free = 5 / 7 * G * (math.sin(slope) - 0.1 * math.cos(slope)) * t * t / 2
    give = 10 * G * math.sin(slope) * M / K
    # until the spring reaches its limit the ball gains the speed sqrt(10/7 mu_r g x mu_r m g/k)
    lead = 0.1 * G * math.sqrt(10 / 7 * M / K) * t
    assert bench.positions[0, 0] == pytest.approx(
        free if rolls else 0.0, abs=lead + 0.002 * free if rolls else give
    )


def test_type_a_stops_a_rolling_ball_in_the_distance_of_its_moment_and_keeps_it_at_rest():
    # rolling ball, moment mu_r R m g: deceleration 5/7 mu_r g; it stops after 7 v^2/(10 mu_r g) and stays
    mu_r, v0 = 0.05, 0.03
    stop = v0 / (5 / 7 * mu_r * G)
    bench = Bench(
        [0, 0, R - SAG], law(K, 0.3, friction=0.8, rolling=mu_r), 1e-5, [FLOOR], gravity=DOWN,
        velocities=[v0, 0, 0], spins=[0, v0 / R, 0], law=ContactLaw(rolling=RollingTypeA()),
    )  # fmt: skip
    bench.step(round(0.5 * stop / 1e-5))
    assert bench.velocities[0, 0] == pytest.approx(0.5 * v0, rel=0.02)
    bench.step(round(stop / 1e-5))
    # the tangential spring has no loss of its own; what swings is below mu_r g sqrt(m/k)
    assert abs(bench.velocities[0, 0]) < 2 * mu_r * G * math.sqrt(M / K)
    assert bench.positions[0, 0] == pytest.approx(0.7 * v0**2 / (mu_r * G), rel=0.02)


def test_two_stacked_balls_rest_at_their_static_overlaps():
    # floor carries two weights, the pair one: overlaps 2 m g/k and m g/k
    bench = Bench([[0, 0, R], [0, 0, 3 * R]], law(K, 0.3), 1e-5, [FLOOR], gravity=DOWN)
    bench.step(8000)
    x = bench.positions
    assert R - x[0, 2] == pytest.approx(2 * SAG, rel=1e-3)
    assert 2 * R - (x[1, 2] - x[0, 2]) == pytest.approx(SAG, rel=1e-3)


def test_two_squeezed_balls_move_as_the_two_mass_chain():
    # MFiX DEM03: floor, ball, ball, ceiling, all springs compressed: m x1'' = k(R - x1) - k(2R - (x2 - x1)) -
    # m g, and so on
    gap, k = 3.6 * R, 1e4
    ceiling = Surface(
        "ceiling", SurfaceKind.PLANE, 0, 0, origin=(0, 0, gap), rotation=((1, 0, 0), (0, -1, 0), (0, 0, -1))
    )
    x1, x2, v1, v2 = 0.25 * gap, 0.75 * gap, 0.0, 0.0
    bench = Bench([[0, 0, x1], [0, 0, x2]], law(k), 2e-6, [FLOOR, ceiling], gravity=DOWN)
    n, h = 300, 2e-7
    for _ in range(10 * n):
        x1, x2 = x1 + 0.5 * h * v1, x2 + 0.5 * h * v2
        middle = k * max(2 * R - (x2 - x1), 0.0)
        v1 += h * ((k * max(R - x1, 0.0) - middle) / M - G)
        v2 += h * ((middle - k * max(x2 + R - gap, 0.0)) / M - G)
        x1, x2 = x1 + 0.5 * h * v1, x2 + 0.5 * h * v2
    bench.step(n)
    # phase error (w h)^2/24 per radian, w^2 = 3k/m, w t = 4.6: 2e-4 of an amplitude below 0.2 R
    assert bench.positions[:, 2] == pytest.approx([x1, x2], abs=1e-4 * R)


@pytest.mark.parametrize("k", [1e5, 1e6])
def test_ball_that_falls_on_an_edge_leaves_along_the_line_to_it(k):
    # head-on at 45 degrees to the edge of a box: the normal is the line from the edge to the centre, the
    # speed is turned round
    box = Surface("rib", SurfaceKind.BOX, 0, 0, origin=(-0.01, 0, -0.01), size=(0.01, 0.02, 0.01))
    d = (R + 1e-5) / math.sqrt(2)
    dt = math.pi * math.sqrt(M / k) / 100
    bench = Bench([d, 0, d], law(k, 0.0), dt, [box], velocities=[-1 / math.sqrt(2), 0, -1 / math.sqrt(2)])
    bench.step(110 + int(2e-5 / dt))
    assert bench.velocities[0] == pytest.approx([1 / math.sqrt(2), 0, 1 / math.sqrt(2)], abs=2e-3)


def test_ball_rolls_from_a_tube_onto_the_next_as_in_an_endless_cylinder():
    # along the bottom of a bore about x, across the seam of two tubes at x = 20 mm
    bore, v, along = 0.05, 0.5, ((0, 0, 1), (0, 1, 0), (-1, 0, 0))
    tubes = [
        Surface(f"tube at {x}", SurfaceKind.TUBE, 0, 0, (x, 0, 0), along, (bore, 0.02, 0)) for x in (0, 0.02)
    ]
    endless = [Surface("bore", SurfaceKind.CYLINDER, 0, 0, (0, 0, 0), along, (bore, 0, 0))]
    start = {
        "positions": [0.019, 0, -(bore - R + SAG)],
        "gravity": DOWN,
        "velocities": [v, 0, 0],
        "spins": [0, v / (R - 0.5 * SAG), 0],
    }
    benches = [
        Bench(pair_laws=law(K, 0.1, friction=0.5), dt=1e-5, surfaces=s, **start) for s in (tubes, endless)
    ]
    for bench in benches:
        bench.step(400)
        assert bench.contacts == (0, 1)
    assert benches[0].positions[0, 0] == pytest.approx(0.019 + 400e-5 * v, abs=1e-9)
    # the spring of friction starts anew on the second tube, from the nothing that rolling has left in it
    assert benches[0].positions == pytest.approx(benches[1].positions, abs=1e-12)
    assert benches[0].velocities == pytest.approx(benches[1].velocities, abs=1e-9)


def test_a_ball_in_each_of_two_tubes_side_by_side_touches_its_own_alone():
    # two jars, 60 mm apart: each ball flies to and fro across its jar, and never feels the other jar's wall
    jars = [
        Surface(f"jar {k}", SurfaceKind.TUBE, 0, 0, (x, 0, 0), size=(0.02, 0.05, 0))
        for k, x in enumerate((-0.03, 0.03))
    ]
    wall, dt = 0.02 - R, math.pi * math.sqrt(M / K) / 100
    bench = Bench(
        [[-0.03 + wall - 1e-5, 0, 0.02], [0.03, wall - 1e-5, 0.03]],
        law(K),
        dt,
        jars,
        velocities=[[1.0, 0, 0], [0, 1.0, 0]],
    )
    assert bench.contacts == (0, 0)
    # the contact takes pi sqrt(m/k): one hundred steps
    bench.step(110 + int(2e-5 / dt))
    assert bench.velocities == pytest.approx(np.array([[-1.0, 0, 0], [0, -1.0, 0]]), abs=2e-3)


def test_ball_that_bounces_on_the_rim_of_a_rod_gives_it_the_momentum_it_lost():
    # head-on at 45 degrees to the rim, at an azimuth of 0.6 rad: the speed is turned round
    k, turn, side, half = 1e5, 0.6, 0.01, 0.015
    way = np.array([math.cos(turn), math.sin(turn), 1.0]) / math.sqrt(2)
    rim = np.array([side * math.cos(turn), side * math.sin(turn), half])
    rod = Surface("rod", SurfaceKind.ROD, 0, 0, size=(side, half, 0))
    dt = math.pi * math.sqrt(M / k) / 100
    bench = Bench(rim + (R + 1e-5) * way, law(k), dt, [rod], velocities=-way)
    bench.step(110 + int(2e-5 / dt))
    assert bench.velocities[0] == pytest.approx(way, abs=2e-3)
    lost = M * (-way - bench.velocities[0])
    assert bench.state.impulse[0, :3] == pytest.approx(lost, abs=1e-12)
    # it acts between rim and centre on one line, so its moment about the rod's middle is that at the rim
    assert bench.state.impulse[0, 3:] == pytest.approx(np.cross(rim, lost), abs=1e-12)


def test_belt_takes_a_ball_along_at_two_sevenths_of_its_speed():
    # plane that moves in itself at V: the ball slides until V - v = R w (w backwards): v = 2/7 V
    speed = 0.05
    bench = Bench([0, 0, R - SAG], law(K, 0.1, friction=0.3), DT, [FLOOR], gravity=DOWN)
    bench.motion[0, 7] = speed
    bench.step(4000)
    assert bench.velocities[0, 0] == pytest.approx(2 / 7 * speed, abs=0.3 * G * math.sqrt(M / K))


def test_impulse_on_a_body_is_the_momentum_a_ball_lost_about_the_moving_mass_centre():
    # floor carried by a body whose mass centre is at (0.1, 0, 0): impulse J, moment (r - c) x J at the
    # contact
    floor = Surface("floor", SurfaceKind.PLANE, 0, 0, origin=(-0.1, 0.0, 0.0))
    carrier = at_rest()
    carrier[0, 0] = 0.1
    bench = Bench(
        [0, 0.02, R + 1e-6],
        law(5e5, 0.0),
        1e-6,
        [floor],
        velocities=[0, 0, -1.0],
        motion=carrier,
    )
    bench.step(150)
    lost = M * (-1.0 - bench.velocities[0, 2])
    assert bench.state.impulse[0, :3] == pytest.approx([0, 0, lost], abs=1e-12)
    assert bench.state.impulse[0, 3:] == pytest.approx([0.02 * lost, 0.1 * lost, 0], abs=1e-12)


def test_a_carrier_goes_on_where_the_last_march_left_it():
    # a floor that rises with a given acceleration and turns: marched in two pieces it ends as in one
    def ball():
        motion = at_rest()
        motion[0, 7:] = [0.1, 0, 0.02, 0, 0.5, 3.0, 0, 0, 9.0, 0, 0, 2.0]
        return Bench([0, 0, R - SAG], law(K, 0.1, friction=0.3), DT, [FLOOR], gravity=DOWN, motion=motion)

    one, two = ball().step(400), ball().step(150).step(250)
    # rounding of some 400 sums, and the turn about a mean axis: |spin x acceleration| t^3/24 of each march
    turns = 0.5 * 2.0 * DT**3 * (400**3 - 150**3 - 250**3) / 24
    assert two.motion == pytest.approx(one.motion, abs=1e-13 + 1.01 * turns)
    assert two.positions == pytest.approx(one.positions, abs=1e-13)
    assert two.velocities == pytest.approx(one.velocities, abs=1e-10)
    # the floor has risen by v t + a t^2/2
    t = 400 * DT
    assert one.motion[0, 2] == pytest.approx(0.02 * t + 4.5 * t * t, rel=1e-12)
    assert one.contacts == (0, 1)
