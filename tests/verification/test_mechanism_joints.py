"""Joints, drives and reactions against closed forms."""

import math

import numpy as np

from nutamill import System
from nutamill.mechanism.parts import GROUND, Body, Drive, Joint, JointFriction, JointKind, Spring, Torque
from nutamill.mechanism.rows import matrix_of

O = (0.0, 0.0, 0.0)
X, Y, Z = np.eye(3)
SMALL = 1e-3 * np.eye(3)


def test_universal_joint_turns_its_shaft_unevenly():
    # w_out/w_in = cos(beta) / (1 - sin(beta)^2 sin(theta)^2), theta from where the driving fork is square to
    # the plane of the shafts
    beta, speed, n = 0.3, 10.0, 2000
    out = np.array([math.cos(beta), 0.0, math.sin(beta)])
    bodies = [Body("in", 1.0, SMALL, -0.1 * X), Body("out", 1.0, SMALL, 0.1 * out)]
    joints = [
        Joint("bearing", JointKind.REVOLUTE, GROUND, "in", -0.1 * X, X),
        Joint("hooke", JointKind.UNIVERSAL, "in", "out", O, Y, np.cross(out, Y)),
        Joint("guide", JointKind.POINT_ON_LINE, GROUND, "out", 0.2 * out, out),
    ]
    system = System(bodies, joints, drives=[Drive("motor", "bearing", (0.0,), (speed,))])
    for eighth in range(9):
        theta = eighth * math.pi / 4
        ratio = math.cos(beta) / (1 - (math.sin(beta) * math.sin(theta)) ** 2)
        # velocities are projected at every step: exact to round-off wherever the pose is
        assert abs(system.angular_velocity("out") @ out / speed - ratio) < 1e-9
        system.march(math.pi / 4 / speed, math.pi / 4 / speed / n)


def test_slider_crank_moves_and_loads_its_drive_as_its_geometry_says():
    crank, rod, speed, rod_mass, slider_mass, t = 0.1, 0.3, 10.0, 0.7, 1.3, 0.05
    thin = rod_mass * rod**2 / 12
    bodies = [
        Body("crank", 1.0, SMALL, O),
        Body("rod", rod_mass, np.diag([1e-6, thin, thin]), (crank + rod / 2) * X),
        Body("slider", slider_mass, SMALL, (crank + rod) * X),
    ]
    joints = [
        Joint("bearing", JointKind.REVOLUTE, GROUND, "crank", O, Z),
        Joint("crank end", JointKind.SPHERICAL, "crank", "rod", crank * X),
        Joint("slider end", JointKind.SPHERICAL, "rod", "slider", (crank + rod) * X),
        Joint("guide", JointKind.PRISMATIC, GROUND, "slider", (crank + rod) * X, X),
    ]
    system = System(bodies, joints, drives=[Drive("motor", "bearing", (0.0,), (speed,))], gravity=O)
    system.march(t, t / 5000)

    def slider(angle):
        return crank * np.cos(angle) + np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)

    def kinetic(angle, h=1e-4):
        pin = lambda a: crank * np.array([np.cos(a), np.sin(a)])  # noqa: E731
        middle = lambda a: (pin(a) + np.array([slider(a), 0.0])) / 2  # noqa: E731
        tilt = lambda a: np.arcsin(crank * np.sin(a) / rod)  # noqa: E731
        rate = lambda f: speed * (f(angle + h) - f(angle - h)) / (2 * h)  # noqa: E731
        return (
            rod_mass * rate(middle) @ rate(middle) + thin * rate(tilt) ** 2 + slider_mass * rate(slider) ** 2
        ) / 2

    angle, h = speed * t, 1e-3
    assert abs(system.position("slider")[0] - slider(angle)) < 1e-9
    assert (
        abs(system.velocity("slider")[0] - speed * (slider(angle + 1e-5) - slider(angle - 1e-5)) / 2e-5)
        < 1e-7
    )
    # no loss, no gravity: torque x speed = d(kinetic energy)/dt; differences of h^2 = 1e-6, scheme (w dt)^2 =
    # 1e-8
    torque = (kinetic(angle + h) - kinetic(angle - h)) / (2 * h)
    assert abs(system.torque("motor") / torque - 1.0) < 2e-6


def nutating_pin_force(speed, phi, throw, depth, mass, arm, inertia, g):
    """Force on a rigid body nutating on a Hooke joint (axes: y fixed, x of the body), from a vertical pin
    that circles below it.

    R = Ry(a) Rx(b) with b = asin(sin(alpha) sin(phi)), a = -atan2(sin(alpha) cos(phi), cos(alpha)), alpha =
    atan(throw/depth). The moment about the joint is balanced by a horizontal pin force and a moment along the
    cross's normal; derivatives of R by central differences of sixth order.
    """
    alpha = math.atan2(throw, depth)

    def attitude(p):
        b, a = (
            math.asin(math.sin(alpha) * math.sin(p)),
            -math.atan2(math.sin(alpha) * math.cos(p), math.cos(alpha)),
        )
        ca, sa, cb, sb = math.cos(a), math.sin(a), math.cos(b), math.sin(b)
        return np.array([[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]]) @ np.array(
            [[1, 0, 0], [0, cb, -sb], [0, sb, cb]]
        )

    h = 2e-3
    at = [attitude(phi + k * h) for k in range(-3, 4)]
    first = (
        speed
        * sum(c * R for c, R in zip((-1 / 60, 3 / 20, -3 / 4, 0, 3 / 4, -3 / 20, 1 / 60), at, strict=True))
        / h
    )
    second = (
        speed**2
        * sum(
            c * R for c, R in zip((1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90), at, strict=True)
        )
        / h**2
    )
    R = at[3]
    turn, change = first @ R.T, second @ R.T + first @ first.T
    axial = lambda A: np.array([A[2, 1], A[0, 2], A[1, 0]])  # noqa: E731
    w, dw, centre, world_inertia = axial(turn), axial(change), R @ arm, R @ inertia @ R.T
    need = (
        world_inertia @ dw
        + np.cross(w, world_inertia @ w)
        + np.cross(centre, mass * (second @ arm + np.array([0, 0, g])))
    )
    pin = R @ np.array([0.0, 0.0, -math.hypot(throw, depth)])
    x, y, _ = np.linalg.solve(np.column_stack([np.cross(pin, X), np.cross(pin, Y), np.cross(Y, R @ X)]), need)
    return np.array([x, y])


def nutating_body(speed, throw, depth, mass, arm, inertia, g):
    """The same body on UNIVERSAL and POINT_ON_LINE joints, driven by a crank."""
    alpha = math.atan2(throw, depth)
    q = (math.cos(alpha / 2), 0.0, -math.sin(alpha / 2), 0.0)
    R = matrix_of(q)
    bodies = [Body("body", mass, inertia, R @ arm, q), Body("crank", 1.0, SMALL, (0.0, 0.0, -depth))]
    pin = (throw, 0.0, -depth)
    joints = [
        Joint("bearing", JointKind.REVOLUTE, GROUND, "crank", (0.0, 0.0, -depth), Z),
        Joint("hooke", JointKind.UNIVERSAL, GROUND, "body", O, Y, R @ X),
        Joint("pin", JointKind.POINT_ON_LINE, "crank", "body", pin, Z),
    ]
    return System(
        bodies, joints, drives=[Drive("motor", "bearing", (0.0,), (speed,))], gravity=(0.0, 0.0, -g)
    )


def test_nutating_body_loads_its_crank_pin_as_the_closed_form():
    throw, depth, mass, arm, inertia = (
        0.039,
        0.366,
        5.29,
        np.array([0.0, 0.0, -0.21]),
        np.diag([0.055, 0.055, 0.021]),
    )
    speed, n = 700 * math.pi / 30, 3600
    system = nutating_body(speed, throw, depth, mass, arm, inertia, 9.81)
    torques, errors, radial = [], [], []
    for k in range(36):
        phi = 2 * math.pi * k / 36
        exact = nutating_pin_force(speed, phi, throw, depth, mass, arm, inertia, 9.81)
        force = system.reaction("pin").force
        errors.append(np.linalg.norm(force[:2] - exact) / np.linalg.norm(exact))
        radial.append(-force[0] * math.cos(phi) - force[1] * math.sin(phi))
        torques.append(system.torque("motor"))
        assert abs(force[2]) < 1e-12 * np.linalg.norm(exact)
        system.march(2 * math.pi / speed / 36, 2 * math.pi / speed / n)
    # second order of the turn in a step, for the ripple twice in a turn: (4 pi / 3600)^2 = 1.2e-5
    assert max(errors) < 1.2e-5
    # ripple: twice in a turn, small against the mean; no loss, so no mean torque
    ripple = np.abs(np.fft.rfft(radial - np.mean(radial)))
    assert np.argmax(ripple) == 2
    assert abs(np.mean(torques)) < 1e-5 * np.max(np.abs(torques))


def test_pin_force_of_the_nutating_body_grows_with_speed_squared():
    # without gravity F = A w^2 at a given crank angle
    means = []
    for rpm in (100, 400):
        speed = rpm * math.pi / 30
        system = nutating_body(
            speed, 0.039, 0.366, 5.29, np.array([0.0, 0.0, -0.21]), np.diag([0.055, 0.055, 0.021]), 0.0
        )
        system.march(0.7 / speed, 0.7 / speed / 500)
        means.append(np.linalg.norm(system.reaction("pin").force[:2]) / speed**2)
    # the same angles per step: only round-off differs
    assert abs(means[1] / means[0] - 1.0) < 1e-9


def test_joint_friction_slows_a_disc_by_coefficient_times_radius_times_weight():
    mass, axial, coefficient, radius, constant, start_speed, t = 2.0, 0.01, 0.05, 0.02, 0.003, 50.0, 1.0
    disc = Body("disc", mass, np.diag([axial, axial, axial]), O, angular_velocity=(0.0, 0.0, start_speed))
    friction = JointFriction(coefficient, radius, constant)
    system = System([disc], [Joint("axle", JointKind.REVOLUTE, GROUND, "disc", O, Z, friction=friction)])
    system.march(t, 1e-3)
    speed = system.angular_velocity("disc")[2]
    moment = coefficient * radius * mass * 9.81 + constant
    # a constant moment far above the speed at which friction is regularised: exact but for round-off
    assert abs(speed - (start_speed - moment / axial * t)) < 1e-9
    assert abs(system.reaction("axle").moment[2] + moment) < 1e-12
    # its loss is the kinetic energy that went
    assert abs(system.state.loss[0] - axial * (start_speed**2 - speed**2) / 2) < 1e-9


def test_viscous_joint_friction_lets_the_speed_decay_exponentially():
    axial, rate, t = 0.01, 0.02, 0.5
    disc = Body("disc", 1.0, axial * np.eye(3), O, angular_velocity=(0.0, 0.0, 50.0))
    friction = JointFriction(0.0, 0.0, viscous=rate)
    system = System([disc], [Joint("axle", JointKind.REVOLUTE, GROUND, "disc", O, Z, friction=friction)])
    system.march(t, 1e-4)
    # second order: (rate dt / axial)^2 t rate / axial = 4e-8
    assert abs(system.angular_velocity("disc")[2] / (50.0 * math.exp(-rate / axial * t)) - 1.0) < 4e-8


SQUEEZER_END = {
    "beta": 15.81077119629904,
    "gamma": 0.04082224013073101,
    "delta": 0.5244099658805304,
    "epsilon": 1.048080741042263,
}
"""Angles at 0.03 s: Mazzia and Magherini, Test Set for Initial Value Problem Solvers, 2008, problem 3
(Andrews' squeezer).
"""


def squeezer_parts():
    """Andrews' squeezer after Hairer and Wanner, Solving Ordinary Differential Equations II, 1996, section
    VII.7 (SI).
    """
    beta, theta, gamma, phi = -0.0617138900142764, 0.0, 0.455279819163070, 0.222668390165886
    delta, omega, epsilon = 0.487364979543843, -0.222668390165886, 1.23054744454982
    turn = lambda a: np.array([math.cos(a), math.sin(a), 0.0])  # noqa: E731
    down = lambda a: np.array([math.sin(a), -math.cos(a), 0.0])  # noqa: E731
    A, B, C = (
        np.array([-0.06934, -0.00227, 0.0]),
        np.array([-0.03635, 0.03273, 0.0]),
        np.array([0.014, 0.072, 0.0]),
    )
    crank_end = 7e-3 * turn(beta)
    P = crank_end - 28e-3 * turn(beta + theta)
    G, H = A + 4e-2 * turn(delta), A + 4e-2 * down(epsilon)
    D = B + 2e-2 * turn(gamma) + 18e-3 * down(gamma)
    centres = [
        92e-5 * turn(beta),
        crank_end - 115e-4 * turn(beta + theta),
        B + 1874e-5 * down(gamma) + 1043e-5 * turn(gamma),
        G + (2e-2 - 1421e-5) * down(phi + delta),
        A + 2308e-5 * turn(delta) - 916e-5 * down(delta),
        H + (2e-2 - 1421e-5) * turn(omega + epsilon),
        A + 1228e-5 * down(epsilon) - 449e-5 * turn(epsilon),
    ]
    masses = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)
    inertias = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)
    bodies = [Body(f"K{k + 1}", masses[k], inertias[k] * np.eye(3), centres[k]) for k in range(7)]
    pairs = [
        (GROUND, "K1", O),
        ("K1", "K2", crank_end),
        (GROUND, "K3", B),
        ("K2", "K3", P),
        (GROUND, "K5", A),
        ("K5", "K4", G),
        ("K2", "K4", P),
        (GROUND, "K7", A),
        ("K7", "K6", H),
        ("K2", "K6", P),
    ]
    joints = [Joint(f"pin {k}", JointKind.REVOLUTE, a, b, point, Z) for k, (a, b, point) in enumerate(pairs)]
    spring = Spring("spring", GROUND, "K3", C, D, 4530.0, 0.0, 7785e-5)
    starts = {
        "beta": ("K1", beta),
        "gamma": ("K3", gamma),
        "delta": ("K5", delta),
        "epsilon": ("K7", epsilon),
    }
    return bodies, joints, [spring, Torque("motor", "K1", (0.0, 0.0, 0.033))], starts


def test_andrews_squeezer_is_where_the_test_set_says():
    bodies, joints, loads, starts = squeezer_parts()
    system = System(bodies, joints, loads, gravity=O, redundant="allow")
    system.march(0.03, 2e-6)
    for name, (body, begin) in starts.items():
        q = system.attitude(body)
        angle = begin + 2 * math.atan2(q[3], q[0])
        miss = (angle - SQUEEZER_END[name] + math.pi) % (2 * math.pi) - math.pi
        assert abs(miss) < 1e-4, name
