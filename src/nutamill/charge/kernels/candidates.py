"""Candidates of a particle: a grid of cells for each class of sizes, so that a grain looks at few cells and a
boulder beside it does not make the cells of the grains large.

The sizes of a class differ by less than a factor of two.  A particle looks in the grids of all classes, at
the cells within reach of the largest of that class.

Source: K. Iwai, C.-W. Hong and P. Greil, "Fast particle pair detection algorithms for particle simulations",
Int. J. Mod. Phys. C 10 (1999) (hierarchical grids for spheres of many sizes).
"""

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.sorting import GRID_MARGIN, find_bounds, sort_by_cell
from nutamill.charge.kernels.team import barrier, thread_share

WIDER = 1.0001
"""Factor on the reach in which cells are searched [1], beyond the rounding of positions in the precision of
the law.
"""


@kernel
def fit_grids(model, scratch):
    """Cut the box of ``scratch.lists.grid`` into cells of each class, as large as the longest distance of two
    candidates of the class, or larger where there would be too many. Called by one thread.
    """
    lists = scratch.lists
    classes = model.class_radius.shape[0]
    most = (lists.counts.shape[0] - 2) // classes
    for q in range(classes):
        size = 2.0 * model.class_radius[q] + model.skin
        while True:
            total = 1
            for k in range(3):
                lists.cells[q, k] = int(lists.grid[3 + k] / size) + 1
                total *= lists.cells[q, k]
            if total <= most:
                break
            size *= 1.26
        lists.sizes[q] = size
        lists.cells[q + 1, 3] = lists.cells[q, 3] + total


@kernel
def fill_cells(model, state, scratch, tid, n_threads):
    """Sort the slots into the cells of their classes. Called by all threads of the team."""
    n, x, lists = model.n_particles, state.listed_x, scratch.lists
    find_bounds(scratch, x, n, GRID_MARGIN * model.largest_radius, tid, n_threads)
    if tid == 0:
        fit_grids(model, scratch)
    barrier(scratch.barrier, n_threads)
    lo, hi = thread_share(n, tid, n_threads)
    for i in range(lo, hi):
        q = 0
        while state.mass_props[0, i] > model.class_radius[q]:
            q += 1
        h = 1.0 / lists.sizes[q]
        a = int((x[0, i] - lists.grid[0]) * h)
        b = int((x[1, i] - lists.grid[1]) * h)
        c = int((x[2, i] - lists.grid[2]) * h)
        lists.cell[i] = lists.cells[q, 3] + (c * lists.cells[q, 1] + b) * lists.cells[q, 0] + a
    total = lists.cells[model.class_radius.shape[0], 3]
    sort_by_cell(scratch, n, total, tid, n_threads, lists.order)
    real = state.published_rows[0, 0, 0]
    for d in range(lo, hi):
        i = lists.order[d]
        for k in range(3):
            lists.sorted[k, d] = like(x[k, i] - lists.grid[k], real)
        lists.sorted[3, d] = like(state.mass_props[0, i], real)
    barrier(scratch.barrier, n_threads)


@kernel(inline="always")
def cells_within(x, reach, h, n):
    """Return the first and the last of `n` cells of size ``1/h`` that lie within `reach` of `x` along one
    axis.
    """
    return max(0, int((x - reach) * h)), min(n - 1, int((x + reach) * h))


@kernel(inline="always")
def gap_to_cell(x, size, cell):
    """Return how far `x` is outside the cell of number `cell` along one axis, 0 within."""
    below = like(cell, x) * size - x
    above = -below - size
    return max(max(below, above), like(0.0, x))


@kernel(fast=True)
def candidates_of(scratch, i, lo, x, y, z, reach, q, radius, k, room, partners_out):
    """Append the candidates of slot `i` among the particles of class `q` to `partners_out` from index `k` on.

    Parameters
    ----------
    i : slot
    lo : first slot of the chunk; slots before it are in other chunks
    x, y, z : centre from the corner of the cells [m]
    reach : radius + skin [m]
    radius : largest radius of the class [m]
    room : size of the list

    Returns
    -------
    new end of the list, -1 where there is no room
    """
    lists = scratch.lists
    n0, n1, n2, before = lists.cells[q, 0], lists.cells[q, 1], lists.cells[q, 2], lists.cells[q, 3]
    px, py, pz, pr = lists.sorted[0], lists.sorted[1], lists.sorted[2], lists.sorted[3]
    size = like(lists.sizes[q], x)
    h = like(1.0, x) / size
    within = (reach + radius) * like(WIDER, x)
    a0, a1 = cells_within(x, within, h, n0)
    b0, b1 = cells_within(y, within, h, n1)
    c0, c1 = cells_within(z, within, h, n2)
    for c in range(c0, c1 + 1):
        gap_z = gap_to_cell(z, size, c)
        for b in range(b0, b1 + 1):
            gap_y = gap_to_cell(y, size, b)
            if gap_y * gap_y + gap_z * gap_z > within * within:
                continue
            row = before + (c * n1 + b) * n0
            begin, end = lists.counts[row + a0], lists.counts[row + a1 + 1]
            if k + end - begin > room:
                return -1
            for d in range(begin, end):
                j = lists.order[d]
                dx = px[d] - x
                dy = py[d] - y
                dz = pz[d] - z
                far = reach + pr[d]
                partners_out[k] = j
                k += int((dx * dx + dy * dy + dz * dz < far * far) & ((j > i) | (j < lo)))
    return k
