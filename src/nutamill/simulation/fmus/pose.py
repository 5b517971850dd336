"""Poses, twists and wrenches between the axes and the reference point of an FMU and those of a body."""

import numpy as np

from nutamill.base.frames import quaternion_product, rotation_matrix, turn_quaternion
from nutamill.simulation.fmus.mapping import BodyPlan

MOTION = {
    "position": slice(0, 3),
    "quaternion": slice(3, 7),
    "velocity": slice(7, 10),
    "angular_velocity": slice(10, 13),
    "acceleration": slice(13, 16),
    "angular_acceleration": slice(16, 19),
}
"""Where each part of a motion is (`nutamill.base.frames.MOTION_SIZE`)."""


def matrix(quaternion: np.ndarray) -> np.ndarray:
    """Return the rotation matrix (3, 3) of a unit quaternion (4,)."""
    out = np.empty((3, 3))
    rotation_matrix(quaternion, out)
    return out


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the product of two quaternions (4,)."""
    return np.array(quaternion_product(a, b))


def attitude(numbers: np.ndarray, kind: str) -> np.ndarray:
    """Return the unit quaternion (4,) of an attitude as an FMU gives it
    (`nutamill.case.fmus.FmuBody.attitude_as`).
    """
    if kind == "quaternion":
        size = float(np.sqrt(numbers @ numbers))
        if size == 0.0:
            return np.full(4, np.nan)
        return numbers / size if abs(size - 1.0) > 1e-12 else numbers.copy()
    quaternion = np.array([1.0, 0.0, 0.0, 0.0])
    if kind == "rotation_vector":
        turn_quaternion(quaternion, *numbers, quaternion)
        return quaternion
    for axis in (2, 1, 0):  # about world axes in reverse order: about the body's axes in this one
        turn_quaternion(quaternion, *(numbers * (np.arange(3) == axis)), quaternion)
    return quaternion


def motion_of(plan: BodyPlan, outputs: np.ndarray, former: np.ndarray, step: float) -> np.ndarray:
    """Return the motion (19,) of a body's mass centre, world, from the outputs of an FMU.

    Parameters
    ----------
    outputs : SI, with a zero at the end for what the FMU does not have
    former : motion of the body a `step` [s] ago, from which rates that the FMU does not give are taken as
        mean rates; at the start the step is zero and they are zero
    """
    motion = np.zeros(19)
    turn = None if plan.turn is None else matrix(plan.turn)

    def world(places: list[int]) -> np.ndarray:
        return outputs[places] if turn is None else turn @ outputs[places]

    quaternion = plan.start[3:]
    if plan.attitude:
        quaternion = attitude(outputs[plan.attitude], plan.attitude_as)
        if plan.turn is not None:
            quaternion = product(plan.turn, quaternion)
    motion[MOTION["quaternion"]] = quaternion
    for name, places in plan.rates.items():
        motion[MOTION[name]] = world(places)
    arm = None if plan.arm is None else -(matrix(quaternion) @ plan.arm)
    position = plan.origin + world(plan.position)
    motion[MOTION["position"]] = position if arm is None else position + arm
    _add_rotational_rates(plan, motion, former, step)
    w, alpha = motion[MOTION["angular_velocity"]], motion[MOTION["angular_acceleration"]]
    if arm is not None:
        motion[MOTION["velocity"]] += np.cross(w, arm)
        motion[MOTION["acceleration"]] += np.cross(alpha, arm) + np.cross(w, np.cross(w, arm))
    for rate, of in (("velocity", "position"), ("acceleration", "velocity")):
        if rate not in plan.rates:
            change = motion[MOTION[of]] - former[MOTION[of]]
            motion[MOTION[rate]] = change / step if step > 0.0 else 0.0
    return motion


def _add_rotational_rates(plan: BodyPlan, motion: np.ndarray, former: np.ndarray, step: float) -> None:
    """Put the angular velocity and acceleration that the FMU does not give into a motion, as mean rates."""
    if not plan.attitude or not step > 0.0:
        return
    if "angular_velocity" not in plan.rates:
        back = former[MOTION["quaternion"]] * (1.0, -1.0, -1.0, -1.0)
        turn = product(motion[MOTION["quaternion"]], back)
        motion[MOTION["angular_velocity"]] = 2.0 * np.copysign(1.0, turn[0]) * turn[1:] / step
    if "angular_acceleration" not in plan.rates:
        change = motion[MOTION["angular_velocity"]] - former[MOTION["angular_velocity"]]
        motion[MOTION["angular_acceleration"]] = change / step


def put_wrench(plan: BodyPlan, wrench: np.ndarray, quaternion: np.ndarray, inputs_out: np.ndarray) -> None:
    """Write a wrench (6,), world axes, about the mass centre of a body of this attitude, to the inputs of an
    FMU.
    """
    force, moment = wrench[:3], wrench[3:]
    if plan.arm is not None:
        moment = moment - np.cross(matrix(quaternion) @ plan.arm, force)
    if plan.turn is not None:
        back = matrix(plan.turn).T
        force, moment = back @ force, back @ moment
    if plan.force:
        inputs_out[plan.force] = force
    if plan.moment:
        inputs_out[plan.moment] = moment
