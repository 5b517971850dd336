"""Given forces: a constant or tabulated force at a point of a body, and the work it does."""

from nutamill.base.frames import cross, turn_vector
from nutamill.base.kernel import kernel
from nutamill.mechanism.drives import last_knot_before


@kernel
def given_force(force, knots, t):
    """Return the force [N] of a `FORCE` record at time `t` [s], world axes, as a 3-tuple: linear between
    knots, constant after the last.
    """
    k = last_knot_before(knots, force.first_knot, force.end_knot, t)
    f = knots[k].force
    if k + 1 == force.end_knot:
        return f[0], f[1], f[2]
    g = knots[k + 1].force
    share = (t - knots[k].time) / (knots[k + 1].time - knots[k].time)
    return f[0] + share * (g[0] - f[0]), f[1] + share * (g[1] - f[1]), f[2] + share * (g[2] - f[2])


@kernel
def apply_forces(forces, knots, quaternion, t, load_out, wrench_out):
    """Add every given force at time `t` [s] to `load_out` (n_bodies + 1, 6).

    Write its force [N] and moment about the body's mass centre [N m] into `wrench_out` (n_forces, 6), world
    axes.
    """
    for i in range(forces.shape[0]):
        body, point, wrench = forces[i].body, forces[i].point, wrench_out[i]
        f0, f1, f2 = given_force(forces[i], knots, t)
        r0, r1, r2 = turn_vector(quaternion[body], point[0], point[1], point[2])
        wrench[0], wrench[1], wrench[2] = f0, f1, f2
        wrench[3], wrench[4], wrench[5] = cross(r0, r1, r2, f0, f1, f2)
        for k in range(6):
            load_out[body, k] += wrench[k]


@kernel
def add_force_works(forces, before, after, start_twist, twist, dt, work_out):
    """Add the works of the given forces over a step of `dt` [s] to `work_out` (n_forces,) [J]: impulse times
    mean velocity.

    Parameters
    ----------
    before, after : wrenches of the forces at the start and at the end of the step, (n_forces, 6)
    start_twist, twist : of the bodies at the start and at the end, (n_bodies + 1, 6)
    """
    for i in range(forces.shape[0]):
        v, w = start_twist[forces[i].body], twist[forces[i].body]
        for k in range(6):
            work_out[i] += 0.5 * dt * (before[i, k] + after[i, k]) * 0.5 * (v[k] + w[k])
