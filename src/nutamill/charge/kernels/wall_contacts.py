"""The loop over contacts of one chunk with surfaces: detect them, then apply the law to all of them.

Contacts are detected surface after surface, so that those with one surface are neighbours in the lists.
Exact shapes are tested for a whole chunk at once, meshes for each particle by its wall list
(`nutamill.charge.kernels.near_meshes`).
"""

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.columns import wall_batch
from nutamill.charge.kernels.film_lanes import film_power, true_overlap
from nutamill.charge.kernels.impacts import note_wall_impacts
from nutamill.charge.kernels.loading import count_turned, note_wall_loading
from nutamill.charge.kernels.near_meshes import find_mesh_contacts
from nutamill.charge.kernels.pair_contacts import set_law
from nutamill.charge.kernels.rows import ARM, BODY, BODY_V, MEMORY, WEIGHT, A
from nutamill.charge.kernels.simd import WIDTH, add_rows, copy_lanes, gather_rows, set_rows
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.model import without_law
from nutamill.charge.walls.surface import SurfaceKind
from nutamill.charge.walls.surfaces import surface_near, surface_overlap
from nutamill.charge.walls.touching import touch_surface

MESH_PATCH = int(SurfaceKind.MESH_PATCH)
PLANE = int(SurfaceKind.PLANE)
CYLINDER = int(SurfaceKind.CYLINDER)

OVERLAP, FROM_BODY = 3, 4
"""Rows of what `find_walls` measures, behind the normal (3): overlap; particle's centre from the body's mass
centre (3).
"""


@kernel(inline="always")
def chunk_sphere(model, local, n):
    """Return centre [m] (3), world, and radius [m] of a sphere about the centres of the `n` particles of a
    chunk.
    """
    flat = local.reshape(
        local.size
    )  # rows of four: with a stride that it knows, the compiler makes vector code
    l0, l1, l2 = flat[0], flat[1], flat[2]
    h0, h1, h2 = l0, l1, l2
    for i in range(0, 4 * n, 4):
        a, b, c = flat[i], flat[i + 1], flat[i + 2]
        l0, l1, l2 = min(l0, a), min(l1, b), min(l2, c)
        h0, h1, h2 = max(h0, a), max(h1, b), max(h2, c)
    half = 0.5 / model.scale
    r0, r1, r2 = (
        half * (float(h0) - float(l0)),
        half * (float(h1) - float(l1)),
        half * (float(h2) - float(l2)),
    )
    return (
        model.centre[0] + half * (float(l0) + float(h0)),
        model.centre[1] + half * (float(l1) + float(h1)),
        model.centre[2] + half * (float(l2) + float(h2)),
        (r0 * r0 + r1 * r1 + r2 * r2) ** 0.5,
    )


@kernel(inline="always")
def measure(kind, film, model, surface_poses, s, centre, x, radius, reach, slots, start, end, measured_out):
    """Compute normal, overlap and position of the particles ``slots[start:end]`` at surface `s` of `kind`,
    under the `film` of the law.

    `radius` [m] (M,) may exceed that of the particles by `reach` [m]: then gaps up to that are measured as
    negative overlaps.  Called with a constant kind, it becomes a vector loop.  Rows of `measured_out`: normal
    [1] (3), overlap [m], position from the mass centre of the surface's body [m] (3).

    Returns
    -------
    smallest overlap [m]
    """
    c0, c1, c2 = centre[0], centre[1], centre[2]
    least = 1.0
    for q in range(np.uint64(start), np.uint64(end)):
        slot = slots[q]
        x0, x1, x2 = x[0, slot], x[1, slot], x[2, slot]
        overlap, n0, n1, n2 = surface_overlap(
            kind, model.surface_size, surface_poses, s, x0, x1, x2, radius[slot]
        )
        overlap = true_overlap(film, overlap, reach)
        measured_out[0, q], measured_out[1, q], measured_out[2, q], measured_out[3, q] = n0, n1, n2, overlap
        measured_out[4, q], measured_out[5, q], measured_out[6, q] = x0 - c0, x1 - c1, x2 - c2
        least = min(least, overlap)
    return least


@kernel(fast=True)
def measure_walls(film, model, surface_poses, s, centre, x, radius, reach, slots, start, end, measured_out):
    """Measure the contacts with a surface of any kind but a mesh, as `measure`."""
    kind = model.surface_kind[s]
    if kind == PLANE:
        return measure(
            PLANE, film, model, surface_poses, s, centre, x, radius, reach, slots, start, end, measured_out
        )
    if kind == CYLINDER:
        return measure(
            CYLINDER, film, model, surface_poses, s, centre, x, radius, reach, slots, start, end, measured_out
        )
    return measure(
        kind, film, model, surface_poses, s, centre, x, radius, reach, slots, start, end, measured_out
    )


@kernel
def remove_apart(start, end, reach, lanes_out, measured_out):
    """Remove the contacts `start` to `end` with a gap of `reach` [m] or more from the lists, and return the
    new end.
    """
    left = start
    for q in range(start, end):
        if measured_out[OVERLAP, q] > -reach:
            for k in range(5):
                lanes_out[k, left] = lanes_out[k, q]
            for k in range(measured_out.shape[0]):
                measured_out[k, left] = measured_out[k, q]
            left += 1
    return left


@kernel
def take_mesh_contacts(
    film, model, near_scratch, x, s, n_surfaces, body, centre, lo, reach, tid, count, lanes_out, measured_out
):
    """Append the contacts with surface `s`, a patch of a mesh, to the lists, and return the new end.

    The surface has none in `near_scratch` afterwards. Arguments are those of `find_walls`; `n_surfaces` is
    their number, `body` that of the surface, `centre` its mass centre [m] (3,).
    """
    q = near_scratch.head[tid, s]
    near_scratch.head[tid, s] = -1
    while q >= 0:
        slot = lo + near_scratch.link[tid, 1, q]
        lanes_out[0, count], lanes_out[1, count], lanes_out[2, count] = near_scratch.link[tid, 1, q], slot, s
        lanes_out[3, count], lanes_out[4, count] = slot * n_surfaces + s, body
        for k in range(3):
            measured_out[k, count] = near_scratch.contact[tid, q, k]
        overlap = near_scratch.contact[tid, q, 3]
        measured_out[OVERLAP, count] = true_overlap(film, overlap, reach)
        for k in range(3):
            measured_out[FROM_BODY + k, count] = x[k, slot] - centre[k]
        q = near_scratch.link[tid, 0, q]
        count += 1
    return count


@kernel(inline="always")
def find_walls(
    film,
    model,
    near_scratch,
    x,
    radius,
    reach,
    local,
    motion,
    surface_poses,
    lo,
    n,
    tid,
    lanes_out,
    measured_out,
    test_out,
):
    """Detect all contacts of a chunk's `n` particles with surfaces.

    Parameters
    ----------
    film : the film of the law
    near_scratch : the wall list, brought up to date
    x : of all slots [m]
    radius, reach : as `measure`
    local : published positions of the chunk, fixed point
    motion : pose and twist of each body, as `ChargeScratch.motion` (B, 18)
    surface_poses : place of each surface, as from `place_surfaces` (S, 12)
    lo : first slot of the chunk
    tid : number of this thread
    lanes_out : rows are position in the chunk, slot, surface, row of the wall memory, body
    measured_out : as `measure`
    test_out : work space, one number per particle

    Returns
    -------
    number of contacts
    """
    n_surfaces = model.surface_kind.shape[0]
    c0, c1, c2, around = chunk_sphere(model, local, n)
    find_mesh_contacts(model, near_scratch, x, radius, motion, surface_poses, lo, n, tid)
    count = 0
    places, slots, surfaces, memories, bodies = (
        lanes_out[0],
        lanes_out[1],
        lanes_out[2],
        lanes_out[3],
        lanes_out[4],
    )
    for s in range(n_surfaces):
        body = model.surface_body[s]
        if model.surface_kind[s] == MESH_PATCH:
            if near_scratch.head[tid, s] >= 0:
                count = take_mesh_contacts(
                    film,
                    model,
                    near_scratch,
                    x,
                    s,
                    n_surfaces,
                    body,
                    motion[body],
                    lo,
                    reach,
                    tid,
                    count,
                    lanes_out,
                    measured_out,
                )
        elif (
            surface_near(
                model.surface_kind,
                model.surface_size,
                surface_poses,
                s,
                c0,
                c1,
                c2,
                around + model.largest_radius + reach,
            )
            > 0.0
        ):
            touch_surface(model, x, radius, lo, n, s, surface_poses[s], test_out)
            start = count
            end = np.uint64(count)
            for i in range(np.uint32(n)):
                places[end] = i
                end += np.uint64(test_out[i] > 0.0)
            count = np.int64(end)
            for q in range(np.uint64(start), end):
                slot = places[q] + np.uint32(lo)
                slots[q] = slot
                surfaces[q] = s
                bodies[q] = body
                memories[q] = slot * n_surfaces + s
            if (
                measure_walls(
                    film,
                    model,
                    surface_poses,
                    s,
                    motion[body],
                    x,
                    radius,
                    reach,
                    slots,
                    start,
                    count,
                    measured_out,
                )
                <= -reach
            ):
                count = remove_apart(start, count, reach, lanes_out, measured_out)
    return count


@kernel(fast=True, inline="always")
def load_walls(model, rows, wall_memory, material, twists, lanes, measured, first, m, columns_out):
    """Load `m` wall contacts, from entry `first` of the lists on, into the lanes of a batch."""
    one, zero = like(1.0, columns_out[0]), like(0.0, columns_out[0])
    slots, surfaces, memories, bodies = lanes[1], lanes[2], lanes[3], lanes[4]
    material_of, law_of = model.surface_material, model.law_of
    for g in range(0, m, WIDTH):
        gather_rows(rows, slots, first + g, g, A, columns_out)
        gather_rows(wall_memory, memories, first + g, g, MEMORY, columns_out)
    for g in range(0, BATCH, WIDTH):
        gather_rows(
            twists, bodies, first + g, g, BODY_V, columns_out
        )  # of empty lanes too: they belong to no body
    flat, width = measured.reshape(measured.size), measured.shape[1]
    for k in range(FROM_BODY):
        copy_lanes(flat, k * width + first, k * BATCH, columns_out)
    for k in range(3):
        copy_lanes(flat, (FROM_BODY + k) * width + first, (ARM + k) * BATCH, columns_out)
    for b in range(BATCH):
        columns_out[WEIGHT * BATCH + b] = one
    for b in range(m, BATCH):
        columns_out[WEIGHT * BATCH + b] = zero
    for b in range(m):
        q = np.uint32(first) + np.uint32(b)
        set_law(model, law_of[material[slots[q]], material_of[surfaces[q]]], b, columns_out)


@kernel(fast=True, inline="always")
def add_reactions(columns, body, sums_out):
    """Subtract the forces and angular impulse rates of the batch's contacts with `body` from its row of
    `sums_out` (B, 6).
    """
    number = like(body, columns[0])
    for k in range(3):
        force, moment = 0.0, 0.0
        for b in range(BATCH):
            here = columns[BODY * BATCH + b] == number
            force += float(columns[(A + k) * BATCH + b]) if here else 0.0
            moment += float(columns[(ARM + k) * BATCH + b]) if here else 0.0
        sums_out[body, k] -= force
        sums_out[body, 3 + k] -= moment


@kernel(fast=True, inline="always")
def wall_contacts(
    model,
    x,
    radius,
    rows,
    material,
    twists,
    surface_poses,
    measured,
    n,
    last,
    now,
    dt,
    tid,
    lanes_out,
    wall_memory_out,
    columns_out,
    forces_out,
    sums_out,
    book_out,
):
    """Add the forces of all touching walls of a chunk to `forces_out` and their reactions to `sums_out`, and
    book the contacts that begin and those that turn.

    Parameters
    ----------
    x, radius, rows, material : of all slots
    twists : velocity and spin of each body, as `ChargeScratch.twists`
    surface_poses : place of each surface
    measured : as from `find_walls`
    n : number of contacts
    last, now : stamps of the last and of this substep [1]
    dt : substep [s]
    tid : number of this thread, whose page of `book_out` is used
    lanes_out : as from `find_walls`; empty lanes are appended up to a full batch
    wall_memory_out : as `ChargeState.wall_memory`
    columns_out : work space of `wall_batch`
    forces_out : force [N] (3), spare, moment [N m] (3), spare, on each particle of the chunk, world axes
    sums_out : force [N] and moment [N m] on each body (B, 6), about its mass centre, world axes

    Returns
    -------
    powers of normal, tangential and rolling part, of the surfaces' motion and of the film [W] (5), number of
    overlaps beyond their limit
    """
    places, slots, memories, bodies = lanes_out[0], lanes_out[1], lanes_out[3], lanes_out[4]
    for q in range(n, n + BATCH):
        places[q], slots[q], memories[q], bodies[q] = (
            forces_out.shape[0] - 1,
            0,
            wall_memory_out.shape[0] - 1,
            model.n_bodies,
        )
    books = book_out.on[0] > 0
    sum_n, sum_t, sum_r, sum_i, sum_f = 0.0, 0.0, 0.0, 0.0, 0.0
    beyond = 0.0
    for first in range(0, n, BATCH):
        m = min(BATCH, n - first)
        load_walls(model, rows, wall_memory_out, material, twists, lanes_out, measured, first, m, columns_out)
        power_n, power_t, power_r, power_i, over, begun = wall_batch(model.law, columns_out, last, now, dt)
        if books and begun > 0.0:
            note_wall_impacts(
                without_law(model),
                columns_out,
                lanes_out,
                measured,
                x,
                radius,
                material,
                surface_poses,
                first,
                tid,
                book_out,
            )
        if books and count_turned(model.law.normal, columns_out) > 0.0:
            note_wall_loading(
                model.law.normal,
                without_law(model),
                lanes_out,
                rows,
                material,
                wall_memory_out,
                first,
                dt,
                tid,
                columns_out,
                book_out,
            )
        sum_n += power_n
        sum_t += power_t
        sum_r += power_r
        sum_i += power_i
        sum_f += film_power(model.law.film, columns_out)
        beyond += over
        for body in range(model.n_bodies):
            add_reactions(columns_out, body, sums_out)
        for g in range(0, m, WIDTH):
            add_rows(places, first + g, columns_out, g, A, forces_out)
            set_rows(memories, first + g, columns_out, g, MEMORY, wall_memory_out)
    return sum_n, sum_t, sum_r, sum_i, sum_f, beyond
