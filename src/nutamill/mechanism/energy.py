"""Kinetic, potential and elastic energy of a mechanism."""

from nutamill.base.frames import turn_vector_back
from nutamill.base.kernel import kernel
from nutamill.mechanism.dynamics import gather_twists
from nutamill.mechanism.loads import bushing_travel_of, spring_pull
from nutamill.mechanism.stops import stop_contact


@kernel
def kinetic_energy(mechanism, state):
    """Return the kinetic energy of all bodies [J]."""
    total = 0.0
    for b in range(mechanism.bodies.shape[0] - 1):
        v, w, I = state.velocity[b], state.angular_velocity[b], mechanism.bodies[b].inertia
        w0, w1, w2 = turn_vector_back(state.quaternion[b], w[0], w[1], w[2])
        total += 0.5 * mechanism.bodies[b].mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        total += 0.5 * (w0 * w0 * I[0, 0] + w1 * w1 * I[1, 1] + w2 * w2 * I[2, 2])
        total += w0 * w1 * I[0, 1] + w0 * w2 * I[0, 2] + w1 * w2 * I[1, 2]
    return total


@kernel
def potential_energy(mechanism, state):
    """Return the potential energy of gravity of all bodies [J], zero with the mass centres at the world's
    origin.
    """
    total = 0.0
    for b in range(mechanism.bodies.shape[0] - 1):
        for k in range(3):
            total -= mechanism.bodies[b].mass * mechanism.gravity[k] * state.position[b, k]
    return total


@kernel
def bushing_energy(mechanism, state, bushing):
    """Return the elastic energy [J] of bushing number `bushing`: half of stiffness times travel squared."""
    k = mechanism.bushings[bushing].stiffness
    d0, d1, d2, t0, t1, t2 = bushing_travel_of(mechanism.bushings[bushing], state.position, state.quaternion)
    return 0.5 * (
        k[0] * d0 * d0 + k[1] * d1 * d1 + k[2] * d2 * d2 + k[3] * t0 * t0 + k[4] * t1 * t1 + k[5] * t2 * t2
    )


@kernel
def energies(mechanism, state, scratch, out):
    """Write kinetic, potential and elastic energy [J] (bushings, springs, stops) into `out` (3,).

    The call overwrites `scratch.twist`.
    """
    out[0], out[1], out[2] = kinetic_energy(mechanism, state), potential_energy(mechanism, state), 0.0
    for i in range(mechanism.bushings.shape[0]):
        out[2] += bushing_energy(mechanism, state, i)
    gather_twists(state, scratch.twist)
    for i in range(mechanism.springs.shape[0]):
        spring = mechanism.springs[i]
        length, _pull, _power, _n0, _n1, _n2 = spring_pull(
            spring, state.position, state.quaternion, scratch.twist
        )
        out[2] += 0.5 * spring.stiffness * (length - spring.free_length) ** 2
    for i in range(mechanism.stops.shape[0]):
        stop = mechanism.stops[i]
        gap, _closing, _n0, _n1, _n2, _x0, _x1, _x2 = stop_contact(
            stop, state.position, state.quaternion, scratch.twist
        )
        out[2] += 0.5 * stop.stiffness * min(gap, 0.0) ** 2
