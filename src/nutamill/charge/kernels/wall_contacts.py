"""The loop over contacts of one chunk with surfaces: who touches what, then the law for all that do.

Contacts are found surface after surface, so that those with one surface lie side by side.
"""

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.columns import ARM, BODY, BODY_V, MEMORY, WEIGHT, A, wall_batch
from nutamill.charge.kernels.impacts import note_wall_impacts
from nutamill.charge.kernels.pair_contacts import hold_law
from nutamill.charge.kernels.simd import WIDTH, add_rows, copy_lanes, gather_rows, set_rows
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.walls.surface import SurfaceKind
from nutamill.charge.walls.touching import touch_surface
from nutamill.charge.walls.walls import wall_near, wall_overlap

PLANE = int(SurfaceKind.PLANE)
CYLINDER = int(SurfaceKind.CYLINDER)

OVERLAP, FROM_BODY = 3, 4
"""Rows of what `find_walls` measures, behind the normal (3): overlap; particle's centre from the body's mass
centre (3).
"""


@kernel(inline="always")
def chunk_sphere(model, local, n):
    """Centre [m] (3), world, and radius [m] of a sphere about the particle centres of a chunk (fixed point, n
    of them).
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
def measure(kind, model, placed, s, centre, x, radius, slots, start, end, measured):
    """Normal, overlap and place of the particles ``slots[start:end]`` at surface `s` of `kind`, to the rows
    of `measured`.

    Called with a constant kind, it becomes a vector loop.  Returns the smallest overlap [m].
    """
    c0, c1, c2 = centre[0], centre[1], centre[2]
    least = 1.0
    for q in range(np.uint64(start), np.uint64(end)):
        slot = slots[q]
        x0, x1, x2 = x[0, slot], x[1, slot], x[2, slot]
        overlap, n0, n1, n2 = wall_overlap(kind, model, placed, s, x0, x1, x2, radius[slot])
        measured[0, q], measured[1, q], measured[2, q], measured[3, q] = n0, n1, n2, overlap
        measured[4, q], measured[5, q], measured[6, q] = x0 - c0, x1 - c1, x2 - c2
        least = min(least, overlap)
    return least


@kernel(fast=True)
def measure_walls(model, placed, s, centre, x, radius, slots, start, end, measured):
    """As `measure`, for a surface of any kind."""
    kind = model.surface_kind[s]
    if kind == PLANE:
        return measure(PLANE, model, placed, s, centre, x, radius, slots, start, end, measured)
    if kind == CYLINDER:
        return measure(CYLINDER, model, placed, s, centre, x, radius, slots, start, end, measured)
    return measure(kind, model, placed, s, centre, x, radius, slots, start, end, measured)


@kernel
def keep_touching(start, end, lanes, measured):
    """Strike those without overlap from the contacts `start` to `end`; returns the new end."""
    kept = start
    for q in range(start, end):
        if measured[OVERLAP, q] > 0.0:
            for k in range(5):
                lanes[k, kept] = lanes[k, q]
            for k in range(measured.shape[0]):
                measured[k, kept] = measured[k, q]
            kept += 1
    return kept


@kernel(inline="always")
def find_walls(model, x, radius, local, motion, placed, lo, n, lanes, measured, test):
    """Find all contacts of a chunk's `n` particles with surfaces.

    Rows of `lanes`: place in the chunk, slot, surface, row of the wall memory, body.  `measured`: normal,
    overlap, and place from the mass centre of the body, which `motion` (B, 18) holds.  Returns their number.
    """
    n_surfaces = model.surface_kind.shape[0]
    c0, c1, c2, around = chunk_sphere(model, local, n)
    found = 0
    places, slots, surfaces, memories, bodies = lanes[0], lanes[1], lanes[2], lanes[3], lanes[4]
    for s in range(n_surfaces):
        body = model.surface_body[s]
        if wall_near(model, placed, s, c0, c1, c2, around + model.largest_radius) > 0.0:
            touch_surface(model, x, radius, lo, n, s, placed[s], test)
            start = found
            end = np.uint64(found)
            for i in range(np.uint32(n)):
                places[end] = i
                end += np.uint64(test[i] > 0.0)
            found = np.int64(end)
            for q in range(np.uint64(start), end):
                slot = places[q] + np.uint32(lo)
                slots[q] = slot
                surfaces[q] = s
                bodies[q] = body
                memories[q] = slot * n_surfaces + s
            if measure_walls(model, placed, s, motion[body], x, radius, slots, start, found, measured) <= 0.0:
                found = keep_touching(start, found, lanes, measured)
    return found


@kernel(fast=True, inline="always")
def lay_walls(model, rows, wall_memory, material, twists, first, m, lanes, measured, columns):
    """Lay `m` contacts with walls, from entry `first` of the lists on, into the lanes of a batch."""
    one, zero = like(1.0, columns[0]), like(0.0, columns[0])
    slots, surfaces, memories, bodies = lanes[1], lanes[2], lanes[3], lanes[4]
    material_of, law_of = model.surface_material, model.law_of
    for g in range(0, m, WIDTH):
        gather_rows(rows, slots, first + g, columns, g, A)
        gather_rows(wall_memory, memories, first + g, columns, g, MEMORY)
    for g in range(0, BATCH, WIDTH):
        gather_rows(
            twists, bodies, first + g, columns, g, BODY_V
        )  # of empty lanes too: they belong to no body
    flat, width = measured.reshape(measured.size), measured.shape[1]
    for k in range(FROM_BODY):
        copy_lanes(flat, k * width + first, columns, k * BATCH)
    for k in range(3):
        copy_lanes(flat, (FROM_BODY + k) * width + first, columns, (ARM + k) * BATCH)
    for b in range(BATCH):
        columns[WEIGHT * BATCH + b] = one
    for b in range(m, BATCH):
        columns[WEIGHT * BATCH + b] = zero
    for b in range(m):
        q = np.uint32(first) + np.uint32(b)
        hold_law(columns, b, model.laws, law_of[material[slots[q]], material_of[surfaces[q]]])


@kernel(fast=True, inline="always")
def add_reactions(columns, body, sums):
    """Take the forces and angular impulse rates of the batch's contacts with `body` from its row of `sums`
    (B, 6).
    """
    number = like(body, columns[0])
    for k in range(3):
        force, moment = 0.0, 0.0
        for b in range(BATCH):
            here = columns[BODY * BATCH + b] == number
            force += float(columns[(A + k) * BATCH + b]) if here else 0.0
            moment += float(columns[(ARM + k) * BATCH + b]) if here else 0.0
        sums[body, k] -= force
        sums[body, 3 + k] -= moment


@kernel(fast=True, inline="always")
def wall_contacts(
    model,
    x,
    radius,
    rows,
    wall_memory,
    material,
    twists,
    placed,
    found,
    lanes,
    measured,
    columns,
    last,
    now,
    dt,
    forces,
    sums,
    book,
    tid,
):
    """Forces of all touching walls of a chunk, added to `forces`, and their reaction on the bodies, added to
    `sums` (B, 6).

    Contacts that begin are booked.

    Returns
    -------
    powers of normal, tangential and rolling part and of the surfaces' motion [W] (4), number of overlaps
    beyond their limit
    """
    places, slots, memories, bodies = lanes[0], lanes[1], lanes[3], lanes[4]
    for q in range(found, found + BATCH):
        places[q], slots[q], memories[q], bodies[q] = (
            forces.shape[0] - 1,
            0,
            wall_memory.shape[0] - 1,
            model.n_bodies,
        )
    sum_n, sum_t, sum_r, sum_i = 0.0, 0.0, 0.0, 0.0
    beyond = 0.0
    for first in range(0, found, BATCH):
        m = min(BATCH, found - first)
        lay_walls(model, rows, wall_memory, material, twists, first, m, lanes, measured, columns)
        power_n, power_t, power_r, power_i, over, begun = wall_batch(model.law, columns, last, now, dt)
        if begun > 0.0:
            note_wall_impacts(columns, first, lanes, measured, model, x, radius, material, placed, book, tid)
        sum_n += power_n
        sum_t += power_t
        sum_r += power_r
        sum_i += power_i
        beyond += over
        for body in range(model.n_bodies):
            add_reactions(columns, body, sums)
        for g in range(0, m, WIDTH):
            add_rows(forces, places, first + g, columns, g, A)
            set_rows(wall_memory, memories, first + g, columns, g, MEMORY)
    return sum_n, sum_t, sum_r, sum_i, beyond
