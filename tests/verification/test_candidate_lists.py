"""Lists of candidate pairs: all pairs within reach whatever the sizes, the memory of contacts, one sort for
any team.
"""

import numpy as np
import pytest
from charge_bench import Bench, law

from nutamill.charge.assembly import chunk_size
from nutamill.charge.face import FIXED_FRAME
from nutamill.charge.kernels.chunks import share_groups
from nutamill.charge.kernels.neighbours import rebuild
from nutamill.charge.kernels.sorting import sort_by_cell
from nutamill.charge.kernels.team import run_team
from nutamill.charge.model import Clock, stamp_of


def apart(radii, size, rng):
    """Positions of spheres in a box of `size` [m], at random and without overlaps, the largest first."""
    x = np.empty((len(radii), 3))
    order = np.argsort(-radii)
    for k, i in enumerate(order):
        while True:
            x[i] = rng.uniform(-0.5, 0.5, 3) * size
            gaps = np.linalg.norm(x[order[:k]] - x[i], axis=1) - radii[order[:k]] - radii[i]
            if (gaps > 0.0).all():
                break
    return x


def many_sizes(ratio, n=500, seed=4, **options):
    """Spheres whose radii reach from 1 mm to `ratio` mm, as many of each octave of sizes as fit in a box."""
    rng = np.random.default_rng(seed)
    radii = 1e-3 * ratio ** (rng.uniform(size=n) ** 4)
    radii[0] = 1e-3 * ratio
    size = np.cbrt((4.0 / 3.0 * np.pi * radii**3).sum() / 0.25)
    options = {"precision": "single", "skin": 2e-3} | options
    return Bench(apart(radii, size, rng), law(1e4), 1e-6, radius=radii, **options)


def listed(bench):
    """Pairs of ids in the lists, and the chunk of each particle by id."""
    state, pairs = bench.state, bench.state.pairs
    lst = state.clock[Clock.LIST]
    candidates, chunk_of = [], np.empty(bench.model.n_particles, int)
    for c in range(pairs.counts.shape[1] - 1):
        lo, hi = pairs.counts[2, c : c + 2]
        chunk_of[state.ids[lo:hi]] = c
        count = pairs.counts[lst, c]
        owners = state.ids[lo + pairs.owners[lst, c, :count].astype(int)]
        candidates += zip(owners, state.ids[pairs.partners[lst, c, :count]], strict=True)
    return candidates, chunk_of


@pytest.mark.parametrize("ratio", [1.0, 12.0])
def test_lists_hold_every_pair_within_the_skin_once_in_each_chunk(ratio):
    bench = many_sizes(ratio).step(1)
    n, x = bench.model.n_particles, np.empty((bench.model.n_particles, 3))
    x[bench.state.ids[:n]] = bench.state.listed_x[:, :n].T
    r = np.empty(n)
    r[bench.state.ids[:n]] = bench.state.mass_props[0, :n]
    gap = np.linalg.norm(x[:, None] - x[None], axis=2) - r[:, None] - r[None]
    candidates, chunk_of = listed(bench)
    assert len(bench.model.class_radius) == (1 if ratio == 1.0 else 4)
    near = np.argwhere(np.triu(gap < bench.model.skin, 1))
    assert len(near) > 200
    wanted = []
    for a, b in near:
        wanted += [(a, b), (b, a)] if chunk_of[a] != chunk_of[b] else [(min(a, b), max(a, b))]
    got = [(a, b) if chunk_of[a] != chunk_of[b] else (min(a, b), max(a, b)) for a, b in candidates]
    # a pair at the very end of the skin may be on either side by rounding in single precision
    sure = [pair for pair in wanted if abs(gap[pair] - bench.model.skin) > 1e-4 * bench.model.skin]
    assert sorted(set(got)) == sorted(got)
    assert set(sure) <= set(got) <= set(map(tuple, np.argwhere(gap < bench.model.skin * 1.001)))


def memory_of(bench):
    """Memory of every contact alive by the ids of its pair, as the first of them sees it."""
    state, pairs = bench.state, bench.state.pairs
    lst, last = state.clock[Clock.LIST], stamp_of(int(state.clock[Clock.STEP]) - 1)
    out = {}
    for c in range(pairs.counts.shape[1] - 1):
        lo = pairs.counts[2, c]
        for k in range(pairs.counts[lst, c]):
            memory = pairs.memory[lst, c, k]
            if abs(memory[6]) == last:
                a, b = int(state.ids[lo + pairs.owners[lst, c, k]]), int(state.ids[pairs.partners[lst, c, k]])
                sign = np.where(np.arange(8) < 6, 1.0 if a < b else -1.0, 1.0)
                out.setdefault((min(a, b), max(a, b)), []).append(tuple(memory * sign))
    return {pair: sorted(memories)[0] for pair, memories in out.items()}


def test_a_new_list_inherits_every_contact_of_a_boulder_among_grains():
    # a ball of 50 mm radius under 900 grains of 0.5 mm pressed into its top, more contacts than any grain has
    rng = np.random.default_rng(1)
    turns = np.arange(900) * 2.399963
    height = 1.0 - (np.arange(900) + 0.5) / 900 * 0.4
    flat = np.sqrt(1.0 - height**2)
    outward = np.stack([flat * np.cos(turns), flat * np.sin(turns), height], axis=1)
    radii = np.r_[0.05, np.full(900, 0.0005)]
    x = np.r_[[[0.0, 0.0, 0.0]], outward * (0.0505 - 2e-6)]
    spins = np.r_[[[0.0, 0.0, 0.0]], rng.normal(size=(900, 3)) * 20.0]
    bench = Bench(x, law(1e3, friction=0.5), 1e-6, radius=radii, precision="single", spins=spins).step(20)
    before, rebuilds = memory_of(bench), int(bench.state.clock[Clock.REBUILDS])
    assert sum(0 in pair for pair in before) > 800
    model, state, scratch = bench.parts
    rebuild(model._replace(law=None), state, scratch, FIXED_FRAME, 0.0, 0, 1)
    assert int(bench.state.clock[Clock.REBUILDS]) == rebuilds + 1
    after = memory_of(bench)
    assert after.keys() == before.keys()
    assert all(after[pair] == pytest.approx(before[pair], rel=1e-5, abs=1e-12) for pair in before)
    assert max(abs(memory[0]) for memory in before.values()) > 0.0


@pytest.mark.parametrize("threads", [1, 3, 4])
def test_a_team_sorts_slots_by_cell_as_one_stable_sort(threads):
    bench = many_sizes(1.0)
    lists, n, cells = bench.scratch.lists, bench.model.n_particles, 1000
    lists.cell[:n] = np.random.default_rng(2).integers(0, cells, n)
    run_team(_sort, (bench.scratch, n, cells, lists.order), threads)
    assert lists.order[:n].tolist() == np.argsort(lists.cell[:n], kind="stable").tolist()
    assert (
        lists.counts[: cells + 1].tolist()
        == np.searchsorted(np.sort(lists.cell[:n]), np.arange(cells + 1)).tolist()
    )


def _sort(scratch, n, cells, order, tid, n_threads):
    """Sort with the arguments in the order of a team's function."""
    sort_by_cell(scratch, n, cells, tid, n_threads, order)


@pytest.mark.parametrize(("threads", "most"), [(2, 1.1), (8, 1.25), (16, 1.4)])
def test_threads_share_the_work_of_2618_pellets_evenly(threads, most):
    # a bed as deep as it is wide, of as many pellets as the published charge has
    bed = np.argwhere(np.ones((14, 14, 14)))[:2618] * 2.02 * 0.0025
    bench = Bench(bed, law(1e4), 1e-6, precision="single").step(1)
    work = bench.scratch.group_work
    shares = np.zeros(threads)
    for tid in range(threads):
        first, end = share_groups(work, tid, threads)
        shares[tid] = work[first:end].sum()
    assert shares.sum() == work.sum()
    assert shares.min() > 0.0
    assert shares.max() <= most * shares.mean()


def test_a_chunk_has_room_for_two_clumps_of_any_length():
    assert [chunk_size(n, 1) for n in (1, 1000, 2618, 10752, 10**6)] == [64, 64, 160, 672, 672]
    assert [chunk_size(n, 200) for n in (200, 2600, 10**6)] == [416, 416, 672]
