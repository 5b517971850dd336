"""Stops as records: the damping that gives a restitution, the frequency of a contact, the step that it asks
for.
"""

import math
from collections.abc import Sequence

import numpy as np

from nutamill.base.errors import Fault
from nutamill.base.required import required
from nutamill.base.units import shown
from nutamill.mechanism.effective_mass import IMMOVABLE, free_motion
from nutamill.mechanism.equations import update_kinematics
from nutamill.mechanism.model import STOP
from nutamill.mechanism.parts import Stop
from nutamill.mechanism.rows import Placement, records, unit

LEAST_RESTITUTION = 0.05
"""Smallest coefficient of restitution [1]: below, the damping would ask for needlessly short steps."""

RESOLVED = 0.2
"""Largest product of the frequency of a contact and the step [1]: sixteen steps from touch to rebound, and an
error of the rebound below one per cent.
"""


def damping_number(restitution: float) -> float:
    """Return the number c of `nutamill.mechanism.stops` that gives a coefficient of restitution e.

    Energy of approach and rebound at the deepest point: ``c (1 + e) = ln((1 + c) / (1 - e c))``, solved by
    bisection between zero and 1/e.
    """
    if restitution >= 1.0:
        return 0.0
    low, high = 0.5 * (1.0 - restitution), (1.0 - 1e-15) / restitution
    for _ in range(200):
        c = 0.5 * (low + high)
        if math.log((1.0 + c) / (1.0 - restitution * c)) < c * (1.0 + restitution):
            low = c
        else:
            high = c
    return 0.5 * (low + high)


def stop_table(placement: Placement, stops: Sequence[Stop]) -> np.recarray:
    """Return the records of stops in body axes. `set_frequencies` sets their frequencies."""
    return records(STOP, [stop_record(placement, stop) for stop in stops])


def stop_record(placement: Placement, stop: Stop) -> tuple:
    """Return the record of a stop, its frequency zero."""
    a, b, plane = stop.body_a, stop.body_b, stop.normal is not None
    return (
        placement.index[a],
        placement.index[b],
        placement.local_point(a, stop.point_a),
        placement.local_point(b, stop.point_b),
        int(plane),
        placement.local_axis(a, unit(stop.normal)) if plane else np.zeros(3),
        stop.radius_b + (0.0 if plane else required(stop.radius_a)),
        stop.stiffness,
        damping_number(stop.restitution),
        0.0,
    )


def set_frequencies(mechanism, state, scratch) -> None:
    """Set the frequency ``sqrt(k / m)`` [rad/s] of every stop. m is the mass that the bodies, held by joints
    and prescribed drives, put behind it as assembled.
    """
    if not len(mechanism.stops):
        return
    n = len(mechanism.bodies) - 1
    update_kinematics(mechanism, state, scratch)
    for stop in mechanism.stops:
        push = generalised_push(stop, state, scratch.rotation, n)
        free, loose = free_motion(mechanism, state, scratch, push[None, :])
        compliance = (free * free).sum()
        if compliance > IMMOVABLE * (loose * loose).sum():
            stop.frequency = math.sqrt(stop.stiffness * compliance)


def generalised_push(stop, state, rotation, n) -> np.ndarray:
    """Return the load (6 n,) of a unit force that pushes the bodies of a stop apart, as assembled."""
    a, b = stop.body_a, stop.body_b
    x = state.position[b] + rotation[b] @ stop.point_b
    normal = rotation[a] @ stop.normal
    if not stop.plane:
        normal = unit(x - state.position[a] - rotation[a] @ stop.point_a)
    push = np.zeros((n + 1, 6))
    for body, sign in ((a, -1.0), (b, 1.0)):
        push[body, :3] += sign * normal
        push[body, 3:] += sign * np.cross(x - state.position[body], normal)
    return push[:n].ravel()


def longest_step(stop) -> float:
    """Return the longest step [s] that resolves the contact of a `STOP` record."""
    if stop.frequency == 0.0:
        return math.inf
    return RESOLVED / (stop.frequency * math.sqrt(1.0 + stop.damping))


def step_faults(mechanism, where: str, dt: float) -> list[Fault]:
    """Return a fault at the key `where` for every stop whose contact a step of `dt` [s] does not resolve."""
    names = mechanism.names[len(mechanism.names) - len(mechanism.stops) :]
    return [
        Fault(
            where,
            f"too long for the contact of stop {str(name)!r}, got {shown(dt, 'us')}",
            f"Take at most {shown(longest_step(stop), 'us', '.3g')}, or a softer stop",
        )
        for name, stop in zip(names, mechanism.stops, strict=True)
        if dt > longest_step(stop) * (1.0 + 1e-9)
    ]
