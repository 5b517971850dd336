"""Solid walls that the drives move into each other through chains of joints and gears, before a step is run.

Bodies whose motion the drives prescribe are moved through the positions of the machine, without forces.  What
stands on springs, swings or is pushed by the charge has no motion that is known beforehand: its walls are
looked at during the run.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.linalg import null_space

from nutamill.base.errors import CaseError, Fault
from nutamill.base.frames import rotation_matrix_of
from nutamill.base.units import shown
from nutamill.case.machine import Machine
from nutamill.case.machine_checks import GROUND
from nutamill.mechanism.constraints import dense_jacobian
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.modes import displace
from nutamill.mechanism.parts import Drive
from nutamill.simulation.setup.mechanism import assemble_machine, mechanism_parts
from nutamill.simulation.setup.solid_walls import Poses, SolidWall, meeting

STEP = math.radians(1.0)
"""Largest rotation [rad] of a drive between two positions."""

FINEST = 1.0 / 1024.0
"""Smallest share of that rotation to which a step is halved [1]."""

MOST = 2000
"""Positions that are looked at, at most [1]."""

PRESCRIBED = 1e-9
"""Share of the free directions in the motion of a body below which the drives prescribe it [1]."""

ROUNDS, CLOSED = 12, 1e-9
"""Rounds in which a position is put together [1], and the largest gap [m or rad] that counts as none."""


def swept_faults(machine: Machine, pairs: Sequence[tuple[SolidWall, SolidWall]]) -> list[Fault]:
    """Return the pairs of solid walls that the drives move into each other before the end of the run, each
    pair once.
    """
    moved = moved_bodies(machine)
    waiting = [
        pair for pair in pairs if any(wall.carrier.name in moved for wall in pair) and _known(pair, moved)
    ]
    faults: list[Fault] = []
    if not waiting:
        return faults
    thin = min(float(wall.half.min()) for pair in waiting for wall in pair)
    for time, poses in _positions(machine, [wall for pair in waiting for wall in pair], thin):
        for one, two in tuple(waiting):
            if meeting(one, two, poses):
                waiting.remove((one, two))
                what = f"moves into {one.label} at t = {shown(time, 's', '.3g')}, moved by the drives"
                hint = "Move one of the two, or end the run earlier"
                faults.append(Fault(f"walls.{two.name}", what, hint))
        if not waiting:
            break
    return faults


def moved_bodies(machine: Machine) -> list[str]:
    """Return the bodies whose motion the drives prescribe, through any chain of joints and gears. A machine
    that cannot be assembled has none: its faults are reported by its assembly.
    """
    try:
        mechanism, state, scratch = assemble_machine(machine, _prescribed(machine))
    except CaseError:
        return []
    free = null_space(dense_jacobian(mechanism, state, scratch))
    names = [body.name for body in mechanism_parts(machine).bodies]
    size = np.abs(free.reshape(len(names), -1)).max(axis=1, initial=0.0)
    return [name for name, share in zip(names, size, strict=True) if share <= PRESCRIBED]


def _known(pair: tuple[SolidWall, SolidWall], moved: Sequence[str]) -> bool:
    """Return whether the motion of both bodies of a pair is known beforehand."""
    return all(wall.carrier.name in (GROUND, *moved) for wall in pair)


def _prescribed(machine: Machine) -> list[Drive]:
    """Return the drives of a machine as if each motor reached the speed it is asked for."""
    drives = mechanism_parts(machine).drives
    return [Drive(drive.name, drive.joint, drive.times, drive.speeds) for drive in drives]


def _positions(machine: Machine, walls: Sequence[SolidWall], thin: float) -> Iterator[tuple[float, Poses]]:
    """Yield times [s] and poses of the bodies while the drives move them, so near to each other that no wall
    moves by more than `thin` [m] and no drive by more than `STEP` between two of them.
    """
    drives = _prescribed(machine)
    mechanism, state, scratch = assemble_machine(machine, drives)
    carriers = {wall.carrier.name: wall.carrier for wall in walls}
    time, before = 0.0, _corners(walls, _poses(state, carriers.values()))
    for _ in range(MOST):
        fastest = max(max(abs(speed) for speed in drive.speeds) for drive in drives)
        dt = min(STEP / fastest, machine.run.end - time) if fastest > 0.0 else 0.0
        if dt <= 0.0:
            return
        start = state.position.copy(), state.quaternion.copy()
        while True:
            if not _assembled_at(mechanism, state, scratch, time + dt):
                return  # a dead centre: the run decides where it goes
            poses = _poses(state, carriers.values())
            corners = _corners(walls, poses)
            if np.abs(corners - before).max() <= thin or dt < FINEST * STEP / fastest:
                break
            state.position[:], state.quaternion[:] = start
            dt *= 0.5
        time, before = time + dt, corners
        yield time, poses


def _assembled_at(
    mechanism: Mechanism, state: MechanismState, scratch: MechanismScratch, time: float
) -> bool:
    """Move the bodies to where the drives have them at a time [s]. Return whether all joints close."""
    state.time[0] = time
    for _ in range(ROUNDS):
        jacobian = dense_jacobian(mechanism, state, scratch)
        gap = scratch.gap[: len(jacobian)]
        if np.abs(gap).max(initial=0.0) < CLOSED:
            return True
        displace(state, np.linalg.lstsq(jacobian, -gap, rcond=None)[0])
    return False


def _poses(state: MechanismState, carriers) -> Poses:
    """Return mass centre and rotation of each carrier by name."""
    return {
        carrier.name: (
            state.position[carrier.body].copy(),
            rotation_matrix_of(state.quaternion[carrier.body]),
        )
        for carrier in carriers
    }


def _corners(walls: Sequence[SolidWall], poses: Poses) -> np.ndarray:
    """Return the corners of solid walls [m] (n, 3), world."""
    return np.concatenate([wall.placed(poses).reshape(-1, 3) for wall in walls])
