"""Bushings, springs and external wrenches: action equals reaction, decay, resonance, modes."""

import itertools
import math

import numpy as np

from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.dynamics import OK, drift, finish, march, start
from nutamill.mechanism.energy import energies
from nutamill.mechanism.modes import modes, static_equilibrium
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointKind
from nutamill.mechanism.probes import bushing_wrench, drive_torque
from nutamill.mechanism.rows import matrix_of

O, Z = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def started(*parts, **options):
    """Assembled and started mechanism, state and scratch."""
    engine = assemble(*parts, **options)
    assert start(*engine) == OK
    return engine


def total_momentum(mechanism, state):
    """Momentum and angular momentum about the world's origin of all bodies, (6,)."""
    total = np.zeros(6)
    for b, body in enumerate(mechanism.bodies[:-1]):
        R, p, v, w = (
            matrix_of(state.quaternion[b]),
            state.position[b],
            state.velocity[b],
            state.angular_velocity[b],
        )
        total[:3] += body.mass * v
        total[3:] += R @ body.inertia @ R.T @ w + np.cross(p, body.mass * v)
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
    mechanism, state, scratch = started(*linked_pair(), gravity=O)
    before, n = total_momentum(mechanism, state), 2000
    march(mechanism, state, scratch, 1e-3, n)
    assert np.linalg.norm(state.velocity[1] - np.array([0.0, -0.4, 0.0])) > 0.1  # it did exchange
    # n additions of impulses of order 1
    assert np.abs(total_momentum(mechanism, state) - before).max() < 1e-15 * n


def test_energy_of_a_bushing_and_two_bodies_closes_with_second_order():
    drifts = []
    for dt in (2e-3, 1e-3):
        mechanism, state, scratch = started(*linked_pair(), gravity=O)
        energy = np.zeros(3)
        energies(mechanism, state, scratch, energy)
        begin = energy.sum()
        march(mechanism, state, scratch, dt, round(0.5 / dt))
        energies(mechanism, state, scratch, energy)
        assert state.bushing_loss[0] > 0.1 * begin
        drifts.append(energy.sum() + state.bushing_loss[0] - begin)
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
        engine = started([body], [], [mount], gravity=O)
        march(*engine, dt, round(t / dt))
        misses.append(engine[1].position[0, 2] - exact)
    # second order over the whole phase: push / natural x (natural dt)^2 x natural t / 24
    assert abs(misses[1]) < push / natural * (natural * 5e-4) ** 2 * natural * t / 12
    assert 3.5 < misses[0] / misses[1] < 4.5


def test_external_wrench_gives_exactly_its_impulse():
    random = np.random.default_rng(7)
    body = Body("body", 3.0, np.diag([0.02, 0.03, 0.04]), (0.1, 0.2, 0.3), angular_velocity=(5.0, -3.0, 2.0))
    mechanism, state, scratch = started([body], [], gravity=O)

    def spin():
        return (lambda R: R @ np.diag([0.02, 0.03, 0.04]) @ R.T @ state.angular_velocity[0])(
            matrix_of(state.quaternion[0])
        )

    momentum, angular, given, dt = 3.0 * state.velocity[0], spin(), np.zeros(6), 1e-3
    for _ in range(200):  # a wrench that jumps at every step, as that of a charge does
        state.wrench[0] = random.normal(size=6)
        given += dt * state.wrench[0]
        drift(mechanism, state, scratch, dt)
        finish(mechanism, state, scratch, dt)
    # the last half kick is complete: no half step of the wrench is owed
    assert np.abs(3.0 * state.velocity[0] - momentum - given[:3]).max() < 1e-13
    assert np.abs(spin() - angular - given[3:]).max() < 1e-13


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
    mechanism, state, scratch = assemble(
        bodies, joints, [mount], drives=[Drive("motor", "bearing", (0.0,), (speed,))], gravity=O
    )
    state.position[:2, :2] += (orbit.real, orbit.imag)
    state.velocity[:2, :2] += speed * np.array([-orbit.imag, orbit.real])
    state.velocity[1, 1] += speed * unbalance / rotor_mass
    state.angular_velocity[1, 2] = speed
    start(mechanism, state, scratch)
    return mechanism, state, scratch, orbit


def test_unbalanced_rotor_keeps_the_orbit_phase_force_and_torque_of_den_hartog():
    stiffness, damping = 2.2e5, 300.0
    for speed in (46.0, 73.3):  # below and above resonance at 50.9 rad/s
        mechanism, state, scratch, orbit = rotor_on_mounts(speed)
        n, force, torques, forces = 1500, np.zeros(6), [], []
        for _ in range(20):
            march(mechanism, state, scratch, 2 * math.pi / speed / n, n // 20)
            bushing_wrench(mechanism, state, scratch, 0, force)
            torques.append(drive_torque(mechanism, state, 0))
            forces.append(math.hypot(force[0], force[1]))
        amplification = abs(stiffness / (stiffness - 85.0 * speed**2 + 1j * speed * damping)) + 1
        allowed = amplification * 2 * math.pi * (2 * math.pi / n) ** 2  # second order, over one turn
        turned = complex(state.position[0, 0], state.position[0, 1]) / orbit
        assert abs(abs(turned) - 1.0) < allowed
        assert abs(math.atan2(turned.imag, turned.real)) < allowed
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
    return assemble([Body("frame", mass, inertia, O)], [], mounts, gravity=O), exact


def test_modes_of_a_frame_on_four_mounts_are_those_of_the_six_by_six_problem():
    engine, exact = frame_on_mounts()
    start(*engine)
    found = modes(*engine)
    assert len(found.frequency) == 6
    # central differences of 1e-6: relative error of a stiffness 1e-9
    assert np.abs(found.frequency / exact - 1.0).max() < 1e-8
    assert np.abs(found.damping_ratio).max() < 1e-8


def test_frame_released_in_a_mode_swings_at_its_frequency():
    engine, exact = frame_on_mounts()
    start(*engine)
    shape = modes(*engine).shape[0, :, 0].real
    shape = 1e-5 * shape / np.abs(shape).max()
    engine[1].position[0] += shape[:3]
    engine[1].quaternion[0, 1:] = shape[3:] / 2
    start(*engine)
    n = 2000
    march(*engine, 0.25 / exact[0] / n, n)  # a quarter of a period later it passes through its rest place
    # phase error of the scheme (pi/2/n)^2 x pi/2 / 24 = 4e-8; of the quaternion's and travel's squares 1e-5
    assert np.abs(engine[1].position[0]).max() < 2e-5 * np.abs(shape).max()


def test_rest_place_on_mounts_carries_the_weight():
    stiffness, mass = 2e4, 12.0
    mount = Bushing("mount", GROUND, "body", O, Z, (1e3, stiffness, 50.0, 10.0))
    engine = assemble([Body("body", mass, np.eye(3), O)], [], [mount])
    static_equilibrium(*engine)
    assert abs(engine[1].position[0, 2] + mass * 9.81 / stiffness) < 1e-11
    assert np.abs(engine[1].acceleration).max() < 1e-9


def test_rest_with_free_drives_lets_a_crank_hang_down():
    joint = Joint("bearing", JointKind.REVOLUTE, GROUND, "arm", O, (0.0, 1.0, 0.0))
    arm = Body("arm", 1.0, 0.01 * np.eye(3), (0.3, 0.0, -0.1))
    mechanism, state, scratch = assemble([arm], [joint])
    static_equilibrium(mechanism, state, scratch, hold_drives=False)
    assert np.abs(state.position[0] - np.array([0.0, 0.0, -math.hypot(0.3, 0.1)])).max() < 1e-10
