"""Bushings, springs and external wrenches: action equals reaction, decay, resonance, modes."""

import itertools
import math

import numpy as np

from nutamill import System
from nutamill.mechanism.dynamics import start
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointKind
from nutamill.mechanism.rows import matrix_of

O, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def total_momentum(system, bodies):
    """Momentum and angular momentum about the world's origin of all bodies, (6,)."""
    total = np.zeros(6)
    for body in bodies:
        R, v = matrix_of(system.attitude(body.name)), system.velocity(body.name)
        spin = R @ body.inertia @ R.T @ system.angular_velocity(body.name)
        total[:3] += body.mass * v
        total[3:] += spin + np.cross(system.position(body.name), body.mass * v)
    return total


def linked_pair():
    """Two free bodies joined by one strong bushing, tumbling through large angles."""
    bodies = [
        Body(
            "a",
            2.0,
            np.diag([0.02, 0.03, 0.04]),
            O,
            velocity=(0.3, 0.0, 0.1),
            angular_velocity=(3.0, -2.0, 5.0),
        ),
        Body(
            "b",
            1.0,
            np.diag([0.01, 0.015, 0.02]),
            (0.3, 0.1, 0.2),
            velocity=(0.0, -0.4, 0.0),
            angular_velocity=(-4.0, 1.0, 2.0),
        ),
    ]
    return (
        bodies,
        [],
        [
            Bushing(
                "link",
                "a",
                "b",
                (0.15, 0.1, 0.0),
                (0.0, 0.6, 0.8),
                (300.0, 500.0, 2.0, 1.0),
                (0.5, 0.3, 0.002, 0.001),
            )
        ],
    )


def test_bushing_passes_momentum_and_angular_momentum_on_without_loss():
    parts = linked_pair()
    system = System(*parts, gravity=O)
    before, n = total_momentum(system, parts[0]), 2000
    system.march(1e-3 * n, 1e-3)
    assert np.linalg.norm(system.velocity("b") - np.array([0.0, -0.4, 0.0])) > 0.1  # it did exchange
    # n additions of impulses of order 1
    assert np.abs(total_momentum(system, parts[0]) - before).max() < 1e-15 * n


def test_energy_of_a_bushing_and_two_bodies_closes_with_second_order():
    drifts = []
    for dt in (2e-3, 1e-3):
        system = System(*linked_pair(), gravity=O)
        begin = system.energy().total
        system.march(0.5, dt)
        loss = system.state.loss[0]
        assert loss > 0.1 * begin
        drifts.append(system.energy().total + loss - begin)
    # second order leaves a quarter (first order: a half)
    assert abs(drifts[1]) < abs(drifts[0]) / 3.0


def test_body_on_a_bushing_decays_as_a_damped_oscillator():
    mass, stiffness, damping, push, t = 2.0, 800.0, 4.0, 0.5, 0.9
    body = Body("body", mass, 0.1 * np.eye(3), O, velocity=(0.0, 0.0, push))
    mount = Bushing("mount", GROUND, "body", O, Z, (1.0, stiffness, 0.0, 0.0), (0.0, damping, 0.0, 0.0))
    natural, ratio, misses = math.sqrt(stiffness / mass), damping / (2 * math.sqrt(stiffness * mass)), []
    damped = natural * math.sqrt(1 - ratio**2)
    exact = push / damped * math.exp(-ratio * natural * t) * math.sin(damped * t)
    for dt in (1e-3, 5e-4):
        system = System([body], loads=[mount], gravity=O)
        system.march(t, dt)
        misses.append(system.position("body")[2] - exact)
    # second order over the whole phase: push / natural x (natural dt)^2 x natural t / 24
    assert abs(misses[1]) < push / natural * (natural * 5e-4) ** 2 * natural * t / 12
    assert 3.5 < misses[0] / misses[1] < 4.5


def test_external_wrench_gives_exactly_its_impulse():
    random = np.random.default_rng(7)
    body = Body("body", 3.0, np.diag([0.02, 0.03, 0.04]), (0.1, 0.2, 0.3), angular_velocity=(5.0, -3.0, 2.0))
    system = System([body], gravity=O)

    def momenta():
        R = matrix_of(system.attitude("body"))
        spin = R @ np.diag([0.02, 0.03, 0.04]) @ R.T @ system.angular_velocity("body")
        return np.concatenate([3.0 * system.velocity("body"), spin])

    before, impulse, dt = momenta(), np.zeros(6), 1e-3
    for _ in range(200):  # a wrench that jumps at every step, as that of a charge does
        wrench = random.normal(size=6)
        impulse += dt * wrench
        system.apply("body", wrench[:3], wrench[3:])
        system.step(dt)
    # the last half kick is complete: no half step of the wrench is owed
    assert np.abs(momenta() - before - impulse).max() < 1e-13


def rotor_on_mounts(speed):
    """A frame with an unbalanced rotor on an isotropic bushing, placed on its steady orbit; and the orbit's
    complex amplitude.
    """
    mass, stiffness, damping, unbalance = 85.0, 2.2e5, 300.0, 0.05
    orbit = unbalance * speed**2 / (stiffness - mass * speed**2 + 1j * speed * damping)
    rotor_mass, stiff = 5.0, 1e7
    bodies = [
        Body("frame", mass - rotor_mass, 5.0 * np.eye(3), O),
        Body("rotor", rotor_mass, 0.05 * np.eye(3), (unbalance / rotor_mass, 0.0, 0.0)),
    ]
    mount = Bushing(
        "mount", GROUND, "frame", O, Z, (stiffness, stiff, stiff, stiff), (damping, 0.0, 0.0, 0.0)
    )
    joints = [Joint("bearing", JointKind.REVOLUTE, "frame", "rotor", O, Z)]
    system = System(bodies, joints, [mount], [Drive("motor", "bearing", (0.0,), (speed,))], gravity=O)
    state = system.state
    state.position[:2, :2] += (orbit.real, orbit.imag)
    state.velocity[:2, :2] = speed * np.array([-orbit.imag, orbit.real])
    state.velocity[1, 1] += speed * unbalance / rotor_mass
    state.angular_velocity[:2] = O, (0.0, 0.0, speed)
    start(system.mechanism, state, system.scratch)
    return system, orbit


def test_unbalanced_rotor_keeps_the_orbit_phase_force_and_torque_of_den_hartog():
    stiffness, damping = 2.2e5, 300.0
    for speed in (46.0, 73.3):  # below and above resonance at 50.9 rad/s
        system, orbit = rotor_on_mounts(speed)
        n, period, torques, forces = 1500, 2 * math.pi / speed, [], []
        for _ in range(20):
            system.march(period / 20, period / n)
            torques.append(system.torque("motor"))
            forces.append(np.linalg.norm(system.load("mount").force[:2]))
        amplification = abs(stiffness / (stiffness - 85.0 * speed**2 + 1j * speed * damping)) + 1
        allowed = amplification * 2 * math.pi * (2 * math.pi / n) ** 2  # second order, over one turn
        ratio = complex(*system.position("frame")[:2]) / orbit
        assert abs(abs(ratio) - 1.0) < allowed
        assert abs(math.atan2(ratio.imag, ratio.real)) < allowed
        assert abs(np.mean(forces) / (abs(orbit) * abs(stiffness + 1j * speed * damping)) - 1.0) < allowed
        # power of the dampers: c (w X)^2 = T w
        assert abs(np.mean(torques) / (damping * speed * abs(orbit) ** 2) - 1.0) < 20 * allowed


def frame_on_mounts():
    """A frame of 85 kg on four bushings, and its six frequencies [Hz] from the 6 x 6 problem."""
    shear, axial, mass, inertia = 5e4, 1.2e5, 85.0, np.diag([6.0, 7.0, 4.0])
    places = [(x, y, -0.45) for x, y in itertools.product((-0.3, 0.3), (-0.25, 0.25))]
    K = np.zeros((6, 6))
    for x, y, z in places:  # displacement of a mount: u + theta x p
        B = np.hstack([np.eye(3), [[0, z, -y], [-z, 0, x], [y, -x, 0]]])
        K += B.T @ np.diag([shear, shear, axial]) @ B
    M = np.diag([mass] * 3 + list(np.diag(inertia)))
    exact = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)) / (2 * math.pi)
    mounts = [
        Bushing(f"mount {n}", GROUND, "frame", place, Z, (shear, axial, 0.0, 0.0))
        for n, place in enumerate(places)
    ]
    return System([Body("frame", mass, inertia, O)], loads=mounts, gravity=O), exact


def test_modes_of_a_frame_on_four_mounts_are_those_of_the_six_by_six_problem():
    system, exact = frame_on_mounts()
    modes = system.modes()
    assert len(modes.frequency) == 6
    # central differences of 1e-6: relative error of a stiffness 1e-9
    assert np.abs(modes.frequency / exact - 1.0).max() < 1e-8
    assert np.abs(modes.damping_ratio).max() < 1e-8


def test_frame_released_in_a_mode_swings_at_its_frequency():
    system, exact = frame_on_mounts()
    shape = system.modes().shape[0, :, 0].real
    shape = 1e-5 * shape / np.abs(shape).max()
    system.state.position[0] += shape[:3]
    system.state.quaternion[0, 1:] = shape[3:] / 2
    start(system.mechanism, system.state, system.scratch)
    quarter = 0.25 / exact[0]
    system.march(quarter, quarter / 2000)  # it then passes through its position at rest
    # phase error of the scheme (pi/2/n)^2 x pi/2 / 24 = 4e-8; of the quaternion's and travel's squares 1e-5
    assert np.abs(system.position("frame")).max() < 2e-5 * np.abs(shape).max()


def test_rest_place_on_mounts_carries_the_weight():
    stiffness, mass = 2e4, 12.0
    mount = Bushing("mount", GROUND, "body", O, Z, (1e3, stiffness, 50.0, 10.0))
    system = System([Body("body", mass, np.eye(3), O)], loads=[mount])
    system.rest()
    assert abs(system.position("body")[2] + mass * 9.81 / stiffness) < 1e-11
    assert np.abs(system.state.acceleration).max() < 1e-9


def test_rest_with_free_drives_lets_a_crank_hang_down():
    joint = Joint("bearing", JointKind.REVOLUTE, GROUND, "arm", O, (0.0, 1.0, 0.0))
    arm = Body("arm", 1.0, 0.01 * np.eye(3), (0.3, 0.0, -0.1))
    system = System([arm], [joint])
    system.rest(hold_drives=False)
    assert np.abs(system.position("arm") - np.array([0.0, 0.0, -math.hypot(0.3, 0.1)])).max() < 1e-10
