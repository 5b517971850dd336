"""Where the time of a substep goes, and how far it is from what the machine could do:
``python benchmarks/stages.py``.

A developed flow of the pellets at 700 rpm is held still, and a substep is run again and again up to its
first, second ... stage on one thread; differences are the stages.  Contacts count as lasting.  Beside it the
two limits: the law alone, on lanes that lie in the nearest cache, and the bytes that a substep reads and
writes, at the rate at which this machine copies a block of that size.
"""

import statistics
import time

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.base.provenance import processor
from nutamill.charge.kernels.chunks import slots_of_chunk
from nutamill.charge.kernels.columns import pair_batch
from nutamill.charge.kernels.dynamics import open_window
from nutamill.charge.kernels.integration import integrate_spheres
from nutamill.charge.kernels.neighbours import rebuild, rotation_about
from nutamill.charge.kernels.pair_contacts import filter_pairs, pair_contacts
from nutamill.charge.kernels.rows import ROWS
from nutamill.charge.kernels.simd import WIDTH, negated_radii
from nutamill.charge.kernels.wall_contacts import find_walls, wall_contacts
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.model import Clock, stamp_of, without_law
from nutamill.simulation.coupling import start_window
from nutamill.simulation.speed import developed_case, developed_flow
from nutamill.simulation.warm_up import warm_up

STAGES = (
    "clear",
    "filter candidates",
    "pair contacts",
    "find walls",
    "wall contacts",
    "integrate and publish",
)
REPEATS, PIECES = 25, 40
STEP, PUBLISHED, LIST = int(Clock.STEP), int(Clock.PUBLISHED), int(Clock.LIST)


@kernel(fast=True)
def substeps(model, state, scratch, reference, dt, last_stage, n, counts):
    """`n` times a substep of all chunks up to `last_stage`, on one thread, without turning the clock; as
    `charge.dynamics` has it.

    ``counts``: pair contacts and wall contacts found last.
    """
    for _ in range(n):
        counts[0] = counts[1] = 0
        for c in range(scratch.alarms.shape[0]):
            lo, hi = slots_of_chunk(state, c)
            clock = state.clock
            buffer, lst = clock[PUBLISHED], clock[LIST]
            points, rows, partners, memory = (
                state.published_points[buffer],
                state.published_rows[buffer],
                state.pairs.partners[lst, c],
                state.pairs.memory[lst, c],
            )
            local, lanes, forces, work = (
                scratch.local[0],
                scratch.lanes[0],
                scratch.forces[0],
                scratch.work[c],
            )
            real = rows[0, 0]
            now, step = like(stamp_of(clock[STEP]), real), like(dt, real)
            empty = forces.reshape(forces.size)
            for k in range(empty.size):
                empty[k] = like(0.0, real)
            for l in range(0, hi - lo, WIDTH):
                negated_radii(points, scratch.slots, lo + l, l, local)
            if last_stage < 1:
                continue
            n_pairs = filter_pairs(
                points, partners, state.pairs.owners[lst, c], local, state.pairs.counts[lst, c], lo, hi, lanes
            )
            counts[0] += n_pairs
            if last_stage < 2:
                continue
            pair_contacts(
                model,
                points,
                rows,
                state.material,
                lanes,
                local,
                n_pairs,
                now,
                now,
                step,
                0,
                memory,
                scratch.columns[0, 0],
                forces,
                state.impacts,
            )
            if last_stage < 3:
                continue
            surface_poses, measured = scratch.surface_poses[0], scratch.measured[0]
            n_walls = find_walls(
                model.law.film,
                without_law(model),
                scratch.near,
                state.x,
                state.mass_props[0],
                0.0,
                local,
                scratch.motion[0],
                surface_poses,
                lo,
                hi - lo,
                0,
                lanes,
                measured,
                scratch.test[0],
            )
            counts[1] += n_walls
            if last_stage < 4:
                continue
            wall_contacts(
                model,
                state.x,
                state.mass_props[0],
                rows,
                state.material,
                scratch.twists[0],
                surface_poses,
                measured,
                n_walls,
                now,
                now,
                step,
                0,
                lanes,
                state.wall_memory,
                scratch.columns[0, 1],
                forces,
                scratch.sums[c],
                state.impacts,
            )
            if last_stage < 5:
                continue
            integrate_spheres(without_law(model), state, scratch, forces, reference, lo, hi, dt, 0, work)


@kernel(fast=True)
def law_alone(model, columns, unit, dt, n, times):
    """`n` times: lay the lanes of a batch anew from a copy, and put the pair law to them `times` times, once
    or not at all.
    """
    sums = like(0.0, dt)
    for _ in range(n):
        for k in range(columns.shape[1]):
            columns[0, k] = columns[1, k]
        for _ in range(times):
            sums += pair_batch(model.law, columns[0], unit, like(0.0, dt), dt, dt, dt)[0]
    return sums


def fastest(act, *arguments) -> float:
    """Least wall time of one call [s], of many."""
    times = []
    for _ in range(PIECES):
        begun = time.perf_counter()
        act(*arguments)
        times.append(time.perf_counter() - begun)
    return min(times)


def bytes_of(state, pairs: float, walls: float, candidates: float) -> float:
    """Bytes read and written per particle and substep: every array once, however often a cache gives it
    again.
    """
    listed, memory = candidates * 2 * 4, 2 * (pairs + walls) * 8 * state.published_rows.itemsize
    seen = 2 * (8 * state.published_rows.itemsize + 4 * state.published_points.itemsize)
    moving = 2 * (3 * 3) * 8 + (3 + state.mass_props.shape[0]) * 8
    return listed + memory + seen + moving


def main() -> None:
    warm_up(print)
    print(f"$ python benchmarks/stages.py      # {processor()}, {time.strftime('%Y-%m-%d')}")
    model, flow, work = developed_flow(developed_case())
    charge, state, scratch = model.charge, flow.charge, work.charge
    n = charge.n_particles
    start_window(model.coupled(), flow.coupled(), work.coupled(model, flow))
    reference = flow.coupling.reference
    open_window(charge, state, scratch, 0)
    rotation_about(reference, 0.0, scratch.rotation[0])
    dt, counts = model.clock.substep, np.zeros(2, np.int64)
    total, before, rows = 0.0, 0.0, []
    for stage, name in enumerate(STAGES):
        # integration runs without time, so that nothing moves
        step = 0.0 if stage == len(STAGES) - 1 else dt
        substeps(charge, state, scratch, reference, step, stage, 1, counts)
        total = (
            1e9
            * fastest(substeps, charge, state, scratch, reference, step, stage, REPEATS, counts)
            / REPEATS
            / n
        )
        rows.append((name, total - before))
        before = total
    every = statistics.median(rebuild_times(charge, state, scratch, reference)) / n * 1e9
    per_list = int(state.clock[STEP]) / max(int(state.clock[Clock.REBUILDS]), 1)
    rows.append((f"neighbour list, every {per_list:.0f} substeps", every / per_list))
    whole = sum(taken for _, taken in rows)
    for name, taken in rows:
        print(f"{name:42} {taken:6.2f} ns per particle and substep  {100 * taken / whole:3.0f} %")
    pairs, walls = counts / n
    candidates = state.pairs.counts[state.clock[LIST]].sum() / n
    print(
        f"{'all':42} {whole:6.2f}, with {pairs:.2f} pair and {walls:.2f} wall contacts and "
        f"{candidates:.2f} candidates per particle"
    )
    real = state.published_rows.dtype.type
    columns = np.ones((2, ROWS * BATCH), real)
    columns[1] = scratch.columns[0, 0]
    unit, dt = real(1 / charge.scale), real(dt)
    law_alone(charge, columns, unit, dt, 1, 1)
    laid, done = (fastest(law_alone, charge, columns, unit, dt, 1000, times) for times in (0, 1))
    alone = 1e9 * (done - laid) / 1000 / BATCH * pairs
    print(f"arithmetic: the pair law alone takes {alone:.1f} of the {rows[2][1]:.1f} ns of the pair contacts")
    moved = bytes_of(state, pairs, walls, candidates)
    block = np.zeros(round(moved * n / 2), np.uint8)
    rate = 2 * block.size / fastest(np.copyto, block.copy(), block)
    print(
        f"memory: {moved:.0f} bytes per particle and substep; copied at {rate / 1e9:.0f} GB/s they "
        f"would take {moved / rate * 1e9:.1f} ns"
    )


def rebuild_times(charge, state, scratch, reference) -> list[float]:
    """Wall times of new neighbour lists of the same state [s]."""
    times = []
    for _ in range(PIECES):
        begun = time.perf_counter()
        rebuild(charge._replace(law=None), state, scratch, reference, 0.0, 0, 1)
        times.append(time.perf_counter() - begun)
    return times


if __name__ == "__main__":
    main()
