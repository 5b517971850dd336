"""Statistics of a charge, summed while it runs: work and load on the walls, density and velocity fields,
touching neighbours.

A *sample* is taken at the rows of the record: contacts with walls as the next substep will meet them,
everything else as it is.  The sum of samples times their interval is the integral over time by the rectangle
rule.  Its error is that of counting samples: contacts begin and end within an interval, so that a total that
comes from n seen contacts is uncertain by about 1/sqrt(n) of itself.

All sums are whole numbers of a small unit.  They add up to the same sum in any order: every thread keeps its
own, and the total has the same bits for any number of threads.

Fields are taken in a cylindrical grid that moves with a body and turns about its z axis by an angle handed
in, in a mill the crank angle, so that the crescent of a nutating charge stands still in it.  Velocities are
those relative to the body.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.chunks import slots_of_chunk
from nutamill.charge.kernels.clumps import CLUMP
from nutamill.charge.kernels.columns import wall_batch
from nutamill.charge.kernels.dynamics import move_bodies
from nutamill.charge.kernels.pair_contacts import filter_pairs
from nutamill.charge.kernels.publish import fixed_point
from nutamill.charge.kernels.rows import ACT, HELD, A
from nutamill.charge.kernels.team import thread_share
from nutamill.charge.kernels.wall_contacts import OVERLAP, find_walls, load_walls
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.model import (
    ChargeModel,
    ChargeScratch,
    ChargeState,
    Clock,
    ImpactBook,
    stamp_of,
    without_law,
)
from nutamill.charge.walls.patches import part_of, patch_of, sector_of, whole
from nutamill.charge.walls.surfaces import place_surfaces

STEP, PUBLISHED, LIST = int(Clock.STEP), int(Clock.PUBLISHED), int(Clock.LIST)

WALL_SUMS = ("normal_work", "shear_work", "rolling_work", "load", "contacts")
"""Sums of a patch: work taken out by the three parts of the law [J], normal load [N s], contacts [s]."""
FIELD_SUMS = (
    "solid_volume",
    "mass",
    "momentum_r",
    "momentum_a",
    "momentum_z",
    "square_speed",
    "particles",
    "neighbours",
)
"""Sums of a cell: solid volume [m^3 s], mass [kg s], momentum relative to the body, radial, azimuthal, axial
[kg m], mass times squared speed [J s], particles [s], touching neighbours of its particles [s].  The first
goes by volume, the others by particle centres.
"""
MOST_NEIGHBOURS = 16
"""Places of the histogram of touching neighbours [1]; the last counts all that have as many or more."""
FINE = 2.0**30
"""Small units in the quantity that one mean particle at 1 m/s stands for [1]."""
POINTS = 1024
"""Places within a particle at which its volume is put, one after the other [1]."""


class StatisticsPlan(NamedTuple):
    """What is summed, and where: constants."""

    on: int
    """1: take samples, 0: none [1]."""
    body: int
    """Body whose axes the grid has, and in whose motion velocities are measured [1]."""
    origin: np.ndarray
    """Origin of the grid [m] (3,), body axes, from the body's mass centre."""
    cells: np.ndarray
    """Cells along radius, azimuth and height [1], int64 (3,)."""
    extent: np.ndarray
    """Largest radius, lowest and highest height [m] (3,), grid axes; points beyond count in the outermost
    cell.
    """
    within: np.ndarray
    """Places within a ball of radius 1, evenly spread [1] (POINTS, 3)."""
    mass_of: np.ndarray
    """Mass of each sphere by id, of a pebble its share of the clump's by volume [kg] (n,)."""
    volume_of: np.ndarray
    """Solid volume of each sphere by id, of a pebble its share of the clump's [m^3] (n,)."""
    per_wall: np.ndarray
    """Small units in 1 of each of `WALL_SUMS` [1/unit], (5,)."""
    per_field: np.ndarray
    """Small units in 1 of each of `FIELD_SUMS` [1/unit], (8,)."""


class ChargeStatistics(NamedTuple):
    """Sums over all samples since the start, by thread; the sum over threads is what counts."""

    samples: np.ndarray
    """Samples taken [1], int64 (1,)."""
    walls: np.ndarray
    """`WALL_SUMS` of each patch in small units, int64 (T, P, 5)."""
    fields: np.ndarray
    """`FIELD_SUMS` of each cell in small units, int64 (T, cells, 8); radius outermost, height innermost."""
    neighbours: np.ndarray
    """Particles with 0, 1, 2 ... touching neighbours, int64 (T, MOST_NEIGHBOURS)."""


def points_within() -> np.ndarray:
    """Return evenly spread points in a ball of radius 1 (POINTS, 3), whose mean is the centre.

    Source: M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018 (R3 sequence); each
    place is used with its opposite.
    """
    root = 1.2207440846057596  # of x^4 = x + 1
    u = np.mod(0.5 + np.outer(np.arange(1, POINTS // 2 + 1), root ** -np.arange(1.0, 4.0)), 1.0)
    height, azimuth = 2.0 * u[:, 1] - 1.0, math.tau * u[:, 2]
    flat = np.sqrt(1.0 - height**2)
    half = np.cbrt(u[:, :1]) * np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), height], axis=1)
    return np.stack([half, -half], axis=1).reshape(POINTS, 3)


def statistics_plan(
    model: ChargeModel,
    state: ChargeState,
    dt: float,
    body: int = 0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    cells: tuple[int, int, int] = (1, 1, 1),
    extent: tuple[float, float, float] = (1.0, 0.0, 1.0),
    on: bool = True,
    volumes: np.ndarray | None = None,
) -> StatisticsPlan:
    """Return what is summed for a charge, and where.

    Parameters
    ----------
    dt : substep [s]
    body, origin, cells, extent, on : as in `StatisticsPlan`
    volumes : `StatisticsPlan.volume_of` where particles are clumps, whose pebbles overlap; that of spheres if
        None
    """
    n, ids = model.n_particles, state.ids[: model.n_particles]
    mass_of, volume_of = np.empty(n), np.empty(n)
    volume_of[ids] = 4.0 / 3.0 * math.pi * state.mass_props[0, :n] ** 3
    volume_of = volume_of if volumes is None else np.array(volumes, float)
    mass_of[ids] = state.mass_props[1, :n]
    if len(state.clumps):
        clump = state.mass_props[CLUMP, :n].astype(int)
        mass_of[ids] *= volume_of[ids] / np.bincount(clump, volume_of[ids])[clump]
    mass, volume = float(mass_of.mean()), float(volume_of.mean())
    power, force = mass / dt, mass / dt
    return StatisticsPlan(
        on=int(on),
        body=body,
        origin=np.array(origin, float),
        cells=np.array(cells, np.int64),
        extent=np.array(extent, float),
        within=points_within(),
        mass_of=mass_of,
        volume_of=volume_of,
        per_wall=FINE / np.array([power, power, power, force, FINE]),  # contacts are counted, one unit each
        per_field=FINE / np.array([volume, mass, mass, mass, mass, mass, FINE, FINE]),  # and so are particles
    )


def charge_statistics(plan: StatisticsPlan, state: ChargeState) -> ChargeStatistics:
    """Return empty sums for a charge, without room for samples where the plan is off."""
    threads, patches = state.impacts.cut.shape
    cells = int(plan.cells.prod())
    if not plan.on:
        threads, patches, cells = 1, 0, 0
    return ChargeStatistics(
        np.zeros(1, np.int64),
        np.zeros((threads, patches, len(WALL_SUMS)), np.int64),
        np.zeros((threads, cells, len(FIELD_SUMS)), np.int64),
        np.zeros((threads, MOST_NEIGHBOURS), np.int64),
    )


def _by_thread(sums: ChargeStatistics, impacts: ImpactBook) -> dict[str, np.ndarray]:
    """Return all arrays with a first axis of threads, by their names in a checkpoint."""
    return {
        "walls": sums.walls,
        "fields": sums.fields,
        "neighbours": sums.neighbours,
        "spectra": impacts.spectra,
        "cut": impacts.cut,
    }


def gathered(sums: ChargeStatistics, impacts: ImpactBook) -> dict[str, np.ndarray]:
    """Return the sums over all threads by name, as a checkpoint holds them: the same for any number of
    threads.
    """
    return {
        "samples": sums.samples.copy(),
        **{name: array.sum(axis=0) for name, array in _by_thread(sums, impacts).items()},
    }


def put_back(sums: ChargeStatistics, impacts: ImpactBook, saved: dict[str, np.ndarray]) -> None:
    """Set the sums to those that `gathered` returned."""
    clear(sums, impacts)
    for name, array in _by_thread(sums, impacts).items():
        array[0] = saved[name]
    sums.samples[...] = saved["samples"]


def clear(sums: ChargeStatistics, impacts: ImpactBook) -> None:
    """Set the sums to zero, of the charge on all threads."""
    for array in _by_thread(sums, impacts).values():
        array[...] = 0


def add_to_first(
    sums: ChargeStatistics,
    impacts: ImpactBook,
    total: Callable[[np.ndarray], np.ndarray],
    first: bool,
) -> None:
    """Add the sums of all processes up on the first, and set those of the others to zero.

    Parameters
    ----------
    total : sums an array over all processes, which all call it
    first : whether this process is the first; it counts the samples
    """
    wholes = {name: total(array.sum(axis=0)) for name, array in _by_thread(sums, impacts).items()}
    clear(sums, impacts)
    if first:
        for name, array in _by_thread(sums, impacts).items():
            array[0] = wholes[name]


@kernel(fast=True)
def sample_walls(model, state, scratch, plan, c, dt, tid, sums_out):
    """Add work and load of chunk `c` on the walls, as the next substep will meet them."""
    lo, hi = slots_of_chunk(state, c)
    buffer = state.clock[PUBLISHED]
    rows = state.published_rows[buffer]
    lanes, measured, columns = scratch.lanes[tid], scratch.measured[tid], scratch.columns[tid, 1]
    motion, surface_poses = scratch.motion[tid], scratch.surface_poses[tid]
    real = rows[0, 0]
    now, last = like(stamp_of(state.clock[STEP]), real), like(stamp_of(state.clock[STEP] - 1), real)
    walls, per, patches = sums_out.walls[tid], plan.per_wall, model.patches
    n_walls = find_walls(
        model.law.film,
        without_law(model),
        scratch.near,
        state.x,
        state.mass_props[0],
        0.0,
        scratch.local[tid],
        motion,
        surface_poses,
        lo,
        hi - lo,
        tid,
        lanes,
        measured,
        scratch.test[tid],
    )
    for q in range(n_walls, n_walls + BATCH):
        lanes[0, q], lanes[1, q], lanes[3, q], lanes[4, q] = (
            model.chunk,
            0,
            state.wall_memory.shape[0] - 1,
            model.n_bodies,
        )
    for first in range(0, n_walls, BATCH):
        m = min(BATCH, n_walls - first)
        load_walls(
            model,
            rows,
            state.wall_memory,
            state.material,
            scratch.twists[tid],
            lanes,
            measured,
            first,
            m,
            columns,
        )
        wall_batch(model.law, columns, last, now, like(dt, real))
        for b in range(m):
            slot, s = lanes[1, first + b], lanes[2, first + b]
            n0, n1, n2 = (
                float(measured[0, first + b]),
                float(measured[1, first + b]),
                float(measured[2, first + b]),
            )
            arm = state.mass_props[0, slot] - 0.5 * float(measured[OVERLAP, first + b])
            p = patch_of(
                patches,
                surface_poses[s],
                model.surface_size[s],
                s,
                state.x[0, slot] + arm * n0,
                state.x[1, slot] + arm * n1,
                state.x[2, slot] + arm * n2,
            )
            for k in range(3):
                walls[p, k] -= whole(columns[(ACT + k) * BATCH + b], per[k])
            load = -(
                columns[A * BATCH + b] * n0
                + columns[(A + 1) * BATCH + b] * n1
                + columns[(A + 2) * BATCH + b] * n2
            )
            walls[p, 3] += whole(load, per[3])
            walls[p, 4] += 1


@kernel
def sample_neighbours(model, state, scratch, c, tid, sums_out):
    """Count the touching neighbours of each particle of chunk `c`, to ``scratch.lists.cell``, and put them in
    the histogram.
    """
    lo, hi = slots_of_chunk(state, c)
    points, lst = state.published_points[state.clock[PUBLISHED]], state.clock[LIST]
    local, lanes, counts = scratch.local[tid], scratch.lanes[tid], scratch.lists.cell
    reach = fixed_point(model.film_reach, model.scale)
    for l in range(hi - lo):
        i = lo + l
        counts[i] = 0
        local[l, 0], local[l, 1], local[l, 2], local[l, 3] = (
            points[i, 0],
            points[i, 1],
            points[i, 2],
            reach - points[i, 3],
        )
    n_pairs = filter_pairs(
        points,
        state.pairs.partners[lst, c],
        state.pairs.owners[lst, c],
        local,
        state.pairs.counts[lst, c],
        lo,
        hi,
        lanes,
    )
    for q in range(n_pairs):
        counts[lanes[4, q]] += 1
        # a pair within the chunk is listed once
        if lanes[3, q] != local.shape[0] - 1:
            counts[lanes[1, q]] += 1
    for i in range(lo, hi):
        sums_out.neighbours[tid, min(counts[i], MOST_NEIGHBOURS - 1)] += 1


@kernel(inline="always")
def cell_of(plan, a, b, c, angle):
    """Return cell, distance from the axis [m] and azimuth [rad] in the body's axes of the point (a, b, c) [m]
    from the grid's origin.
    """
    radius = math.sqrt(a * a + b * b)
    azimuth = math.atan2(b, a)
    across, around, up = plan.cells[0], plan.cells[1], plan.cells[2]
    r = part_of(radius, 0.0, plan.extent[0], across)
    z = part_of(c, plan.extent[1], plan.extent[2], up)
    return (r * around + sector_of(azimuth - angle, around)) * up + z, radius


@kernel
def sample_fields(model, state, scratch, plan, c, angle, tid, sums_out):
    """Add the particles of chunk `c` to the fields. ``scratch.motion[tid]`` is the pose of the body."""
    lo, hi = slots_of_chunk(state, c)
    x, v, fields, per = state.x, state.v, sums_out.fields[tid], plan.per_field
    motion = scratch.motion[tid, plan.body]
    m0, m1, m2 = motion[0], motion[1], motion[2]
    R00, R01, R02, R10, R11, R12, R20, R21, R22 = (
        motion[3], motion[4], motion[5], motion[6], motion[7], motion[8], motion[9], motion[10], motion[11],
    )  # fmt: skip
    V0, V1, V2, W0, W1, W2 = motion[12], motion[13], motion[14], motion[15], motion[16], motion[17]
    back = 0.5 * state.last_dt[0]
    sample = sums_out.samples[0]
    for i in range(lo, hi):
        radius, mass = state.mass_props[0, i], plan.mass_of[state.ids[i]]
        v0, v1, v2 = v[0, i], v[1, i], v[2, i]
        d0, d1, d2 = x[0, i] - back * v0 - m0, x[1, i] - back * v1 - m1, x[2, i] - back * v2 - m2
        u0, u1, u2 = (
            v0 - V0 - (W1 * d2 - W2 * d1),
            v1 - V1 - (W2 * d0 - W0 * d2),
            v2 - V2 - (W0 * d1 - W1 * d0),
        )
        a = R00 * d0 + R10 * d1 + R20 * d2 - plan.origin[0]
        b = R01 * d0 + R11 * d1 + R21 * d2 - plan.origin[1]
        z = R02 * d0 + R12 * d1 + R22 * d2 - plan.origin[2]
        va, vb, vz = (
            R00 * u0 + R10 * u1 + R20 * u2,
            R01 * u0 + R11 * u1 + R21 * u2,
            R02 * u0 + R12 * u1 + R22 * u2,
        )
        k, r = cell_of(plan, a, b, z, angle)
        per_r = 1.0 / (r + 1e-300)
        fields[k, 1] += whole(mass, per[1])
        fields[k, 2] += whole(mass * (va * a + vb * b) * per_r, per[2])
        fields[k, 3] += whole(mass * (vb * a - va * b) * per_r, per[3])
        fields[k, 4] += whole(mass * vz, per[4])
        fields[k, 5] += whole(mass * (u0 * u0 + u1 * u1 + u2 * u2), per[5])
        fields[k, 6] += 1
        fields[k, 7] += scratch.lists.cell[i]
        q = (sample + 7919 * state.ids[i]) & (POINTS - 1)
        k, _ = cell_of(
            plan,
            a + radius * plan.within[q, 0],
            b + radius * plan.within[q, 1],
            z + radius * plan.within[q, 2],
            angle,
        )
        fields[k, 0] += whole(plan.volume_of[state.ids[i]], per[0])


@kernel
def sample(
    model: ChargeModel,
    state: ChargeState,
    scratch: ChargeScratch,
    plan: StatisticsPlan,
    motions,
    angle: float,
    sums_out: ChargeStatistics,
    tid: int,
    n_threads: int,
):
    """Take one sample between two windows. Called by all threads of a team, each for its share of the chunks.

    Nobody may change the state meanwhile, and the next sample may begin only after all threads have left this
    one; ``sums_out.samples`` is for the caller to count.

    Parameters
    ----------
    motions : (n_bodies, 19) motion of each body from now on, as `frames.MOTION_SIZE`, world axes
    angle : by which the grid is turned about the z axis of the body [rad]
    plan, sums_out : what is summed, and the sums
    """
    first, end = thread_share(scratch.alarms.shape[0], tid, n_threads)
    move_bodies(motions, 0.0, scratch.motion[tid], scratch.twists[tid])
    for c in range(first, end):
        sample_neighbours(without_law(model), state, scratch, c, tid, sums_out)
        sample_fields(without_law(model), state, scratch, plan, c, angle, tid, sums_out)
    sample_chunks_at_walls(model, state, scratch, plan, motions, first, end, tid, sums_out)


@kernel
def sample_chunks_at_walls(model, state, scratch, plan, motions, first, end, tid, sums_out):
    """Add work and load of the chunks `first` to `end` on the walls. The other arguments are those of
    `sample`.
    """
    dt = state.last_dt[0]
    move_bodies(motions, 0.5 * dt, scratch.motion[tid], scratch.twists[tid])
    place_surfaces(without_law(model), scratch.motion[tid], scratch.surface_poses[tid])
    points = state.published_points[state.clock[PUBLISHED]]
    local, columns = scratch.local[tid], scratch.columns[tid, 1]
    for k in range(columns.shape[0]):
        columns[k] = 1.0
    for b in range(BATCH):
        columns[HELD * BATCH + b] = -1.0  # no law is loaded yet
    for c in range(first, end):
        lo, hi = slots_of_chunk(state, c)
        for l in range(hi - lo):
            for k in range(4):
                local[l, k] = points[lo + l, k]
        sample_walls(model, state, scratch, plan, c, dt, tid, sums_out)
