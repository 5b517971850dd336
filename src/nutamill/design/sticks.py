"""A mill or a mechanism as a stick drawing: lines fixed to its bodies, to show how it moves."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from nutamill.case import Case, Machine
from nutamill.case.drawing import CHAMBER, DRIVESHAFT, FRAME, SHAFT
from nutamill.case.drawn_bodies import chamber_rotation
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.parts import Vector
from nutamill.simulation.setup.mechanism import assemble_machine, mechanism_parts


class Stick(NamedTuple):
    """A line fixed to a body."""

    body: str
    """Name of the body."""
    points: np.ndarray
    """Corners of the line at rest [m], (n, 3), world axes."""
    centre: np.ndarray
    """Mass centre of the body at rest [m], (3,), world axes."""

    def moved(self, displacement: np.ndarray) -> np.ndarray:
        """Return the complex or real displacement (n, 3) [m] of the corners when the body moves by
        `displacement` (6,) [m, rad].
        """
        return displacement[:3] + np.cross(displacement[3:], self.points - self.centre)


def sticks(case: Case | Machine) -> list[Stick]:
    """Return the lines of a mill as assembled at crank angle 0, or of a mechanism at its rest: from each mass
    centre to the parts that hold the body.
    """
    mill = case.drawing
    return _mechanism_sticks(case.machine) if mill is None else _mill_sticks(mill)


def _mechanism_sticks(case: Machine) -> list[Stick]:
    """Return the lines from the mass centre of each body to its joints, bushings and springs, with the drives
    held.
    """
    parts = mechanism_parts(case)
    mechanism, state, scratch = assemble_machine(case)
    before = Rotation.from_quat(state.quaternion[:, [1, 2, 3, 0]])
    static_equilibrium(mechanism, state, scratch)
    turn = (Rotation.from_quat(state.quaternion[:, [1, 2, 3, 0]]) * before.inv()).as_matrix()
    held: list[tuple[str, Vector]] = []
    for joint in parts.joints:
        held += [(joint.body_a, joint.point), (joint.body_b, joint.point)]
    for bushing in parts.bushings:
        held += [(bushing.body_a, bushing.point), (bushing.body_b, bushing.point)]
    for spring in parts.springs:
        held += [(spring.body_a, spring.point_a), (spring.body_b, spring.point_b)]
    lines = []
    for number, body in enumerate(parts.bodies):
        centre = state.position[number]
        for side, point in held:
            if side == body.name:
                lines.append(
                    Stick(
                        body.name,
                        np.array([centre, centre + turn[number] @ (np.array(point) - body.position)]),
                        centre,
                    )
                )
    return lines


def _mill_sticks(case: Case) -> list[Stick]:
    """Return the lines of frame, driveshaft with crank, and chamber."""
    centre = {body.name: np.array(body.position) for body in case.machine.bodies}
    depth, coupling = case.mounts.depth, case.shaft_coupling.depth
    pin = np.array([case.mechanism.crank_radius, 0.0, -case.mechanism.nutation_point_to_crank])
    feet = np.array([(x, y, -depth) for x, y in case.mounts.points])
    top = feet * [1.0, 1.0, 0.0]
    lines = [(FRAME, np.vstack([feet, feet[:1]])), (FRAME, np.vstack([top, top[:1]]))]
    lines += [(FRAME, np.array([foot, head, (0.0, 0.0, 0.0)])) for foot, head in zip(feet, top, strict=True)]
    lines.append((DRIVESHAFT, np.array([(0.0, 0.0, -coupling), (0.0, 0.0, pin[2]), pin])))
    lines.append((SHAFT, np.array([(0.0, 0.0, -coupling), (0.0, 0.0, -coupling - 0.1)])))
    chamber, turn = case.chamber, chamber_rotation(case)
    around = np.linspace(0.0, 2.0 * np.pi, 25)
    ring = (
        0.5
        * chamber.inner_diameter
        * np.column_stack([np.cos(around), np.sin(around), np.zeros_like(around)])
    )
    rings = [ring + np.array([0.0, 0.0, -at]) for at in (chamber.floor_depth, chamber.ceiling_depth)]
    walls = [np.array([low, high]) for low, high in zip(rings[0][::6], rings[1][::6], strict=True)]
    lines += [
        (CHAMBER, line @ turn.T) for line in (*rings, *walls, np.array([(0.0, 0.0, 0.0), turn.T @ pin]))
    ]
    return [Stick(body, points, centre[body]) for body, points in lines]
