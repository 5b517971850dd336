"""The two loops over contacts of one chunk: particle with particle, and particle with surface."""

import numpy as np

from nutamill.charge.columns import ARM, BODY_V, BODY_W, HELD, LAW, MEMORY, WEIGHT, A, B, pair_batch, wall_batch
from nutamill.charge.impacts import note_pair_impacts, note_wall_impacts
from nutamill.charge.mesh_contact import touch_mesh
from nutamill.charge.model import BATCH, LAW_NUMBERS, SurfaceKind
from nutamill.charge.simd import WIDTH, add_rows, gather_differences, gather_rows, set_rows, touching
from nutamill.charge.surfaces import touch_cap, touch_cone
from nutamill.charge.walls import wall_near, wall_overlap
from nutamill.kernel import kernel, like

PLANE = int(SurfaceKind.PLANE)
CYLINDER = int(SurfaceKind.CYLINDER)
BOX = int(SurfaceKind.BOX)
CONE = int(SurfaceKind.CONE)
MESH_PATCH = int(SurfaceKind.MESH_PATCH)


PLACES = np.array([([e for e in range(WIDTH) if mask >> e & 1] + [0] * WIDTH)[:WIDTH] for mask in range(1 << WIDTH)], np.uint32)
"""Places of the bits that are set in each mask of eight, then zeros [1]."""

BITS = np.array([bin(mask).count("1") for mask in range(1 << WIDTH)], np.uint64)
"""Number of bits set in each mask of eight [1]."""


@kernel(fast=True, inline="always")
def filter_pairs(points, partners, owners, local, n_listed, lo, hi, lanes):
    """Find the touching pairs among the candidates of a chunk.

    Rows of `lanes`: place of the first particle in the chunk, slot of the second, place in the list, place of the second in the chunk
    (or behind its end), slot of the first.  Behind the last pair come empty lanes up to a full batch.  Returns the number of pairs.
    """
    chunk = local.shape[0] - 1
    n = np.uint64(0)
    first, second, found, place_second, slot_first = lanes[0], lanes[1], lanes[2], lanes[3], lanes[4]
    for k in range(0, n_listed, WIDTH):
        mask = touching(points, partners, local, owners, k)
        if k + WIDTH > n_listed:
            mask &= (1 << (n_listed - k)) - 1
        bits = np.uint64(mask)
        for e in range(np.uint64(WIDTH)):
            found[n + e] = np.uint32(k) + PLACES[bits, e]
        n += BITS[bits]
    for q in range(n):
        k = found[q]
        i, j = owners[k], partners[k]
        place = np.uint32(j - np.uint32(lo))  # slots before the chunk wrap to large numbers
        first[q] = i
        second[q] = j
        place_second[q] = place if place < np.uint32(hi - lo) else np.uint32(chunk)
        slot_first[q] = i + np.uint32(lo)
    for q in range(n, n + np.uint64(BATCH + WIDTH)):
        first[q] = chunk
        second[q] = lo
        found[q] = partners.shape[0] - 1
        place_second[q] = chunk
        slot_first[q] = lo
    return np.int64(n)


@kernel(inline="always")
def hold_law(columns, b, laws, law):
    """Lay the numbers of pair law `law` into lane `b`, unless they are there."""
    number = like(law, columns[0])
    if columns[HELD * BATCH + b] != number:
        columns[HELD * BATCH + b] = number
        for k in range(LAW_NUMBERS):
            columns[(LAW + k) * BATCH + b] = laws[law, k]


@kernel(fast=True, inline="always")
def pair_contacts(model, points, rows, memory, material, n, lanes, local, columns, last, now, dt, forces, book, tid):
    """Forces of all touching pairs of a chunk, added to `forces`; memory is brought up to date, contacts that begin are booked.

    Returns
    -------
    powers of normal, tangential and rolling part [W] (3), 1 if an overlap is beyond its limit
    """
    real = columns[0]
    unit = like(1.0 / model.scale, real)
    zero, half, one = like(0.0, real), like(0.5, real), like(1.0, real)
    across = np.uint32(forces.shape[0] - 1)
    several = model.laws.shape[0] > 1
    first_place, second, found, second_place, first_slot = lanes[0], lanes[1], lanes[2], lanes[3], lanes[4]
    sum_n, sum_t, sum_r = 0.0, 0.0, 0.0
    beyond = 0
    for first in range(0, n, BATCH):
        m = min(BATCH, n - first)
        for g in range(0, m, WIDTH):
            q = first + g
            gather_differences(points, second, local, first_place, q, columns, g)
            gather_rows(rows, first_slot, q, columns, g, A)
            gather_rows(rows, second, q, columns, g, B)
            gather_rows(memory, found, q, columns, g, MEMORY)
        for b in range(BATCH):
            weight = half if second_place[first + b] == across else one
            columns[WEIGHT * BATCH + b] = weight if b < m else zero
        if several:
            for b in range(m):
                hold_law(columns, b, model.laws, model.law_of[material[first_slot[first + b]], material[second[first + b]]])
        power_n, power_t, power_r, over, begun = pair_batch(model.law, columns, unit, last, now, dt)
        if begun != 0:
            note_pair_impacts(columns, begun, first, lanes, across, material, model.law_of.shape[0], book, tid)
        sum_n += power_n
        sum_t += power_t
        sum_r += power_r
        beyond |= over
        for g in range(0, m, WIDTH):
            q = first + g
            add_rows(forces, first_place, q, columns, g, A)
            add_rows(forces, second_place, q, columns, g, B)
            set_rows(memory, found, q, columns, g, MEMORY)
    return sum_n, sum_t, sum_r, beyond


@kernel(fast=True)
def touch_plane(x, radius, lo, n, place, out):
    """Write a positive number to ``out[l]`` where particle ``lo + l`` touches the plane `place` (12,)."""
    a, b, c = place[5], place[8], place[11]
    x0, x1, x2, r = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n], radius[lo : lo + n]
    at = a * place[0] + b * place[1] + c * place[2]
    for i in range(n):
        out[i] = r[i] + at - (a * x0[i] + b * x1[i] + c * x2[i])


@kernel(fast=True)
def touch_cylinder(x, radius, lo, n, place, bore, out):
    """As `touch_plane`, for the inside of a cylinder of radius `bore` [m]."""
    o0, o1, o2 = place[0], place[1], place[2]
    a, b, c = place[5], place[8], place[11]
    x0, x1, x2, r = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n], radius[lo : lo + n]
    for i in range(n):
        d0, d1, d2 = x0[i] - o0, x1[i] - o1, x2[i] - o2
        along = a * d0 + b * d1 + c * d2
        free = bore - r[i]
        out[i] = d0 * d0 + d1 * d1 + d2 * d2 - along * along - free * free


@kernel(fast=True)
def touch_box(x, radius, lo, n, place, size, out):
    """As `touch_plane`, for the outside of a box of half sizes `size` (3,) [m]."""
    o0, o1, o2 = place[0], place[1], place[2]
    a0, a1, a2, b0, b1, b2, c0, c1, c2 = place[3], place[6], place[9], place[4], place[7], place[10], place[5], place[8], place[11]
    h0, h1, h2 = size[0], size[1], size[2]
    x0, x1, x2, r = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n], radius[lo : lo + n]
    for i in range(n):
        d0, d1, d2 = x0[i] - o0, x1[i] - o1, x2[i] - o2
        g0 = abs(a0 * d0 + a1 * d1 + a2 * d2) - h0
        g1 = abs(b0 * d0 + b1 * d1 + b2 * d2) - h1
        g2 = abs(c0 * d0 + c1 * d1 + c2 * d2) - h2
        g0 = g0 if g0 > 0.0 else 0.0
        g1 = g1 if g1 > 0.0 else 0.0
        g2 = g2 if g2 > 0.0 else 0.0
        out[i] = r[i] * r[i] - (g0 * g0 + g1 * g1 + g2 * g2)


@kernel
def touch_surface(model, x, radius, lo, n, s, place, out):
    """Choose the test for surface `s`, at `place` (12,): positive ``out[l]`` where particle ``lo + l`` touches, or may touch a mesh."""
    kind, size = model.surface_kind[s], model.surface_size[s]
    if kind == PLANE:
        touch_plane(x, radius, lo, n, place, out)
    elif kind == CYLINDER:
        touch_cylinder(x, radius, lo, n, place, size[0], out)
    elif kind == BOX:
        touch_box(x, radius, lo, n, place, size, out)
    elif kind == CONE:
        touch_cone(x, radius, lo, n, place, size, out)
    elif kind == MESH_PATCH:
        touch_mesh(model.mesh, x, lo, n, s, place, out)
    else:
        touch_cap(x, radius, lo, n, place, size, out)


@kernel(inline="always")
def chunk_sphere(model, local, n):
    """Centre [m] (3), world, and radius [m] of a sphere about the particle centres of a chunk (fixed point, n of them)."""
    l0, l1, l2 = local[0, 0], local[0, 1], local[0, 2]
    h0, h1, h2 = l0, l1, l2
    for i in range(n):
        a, b, c = local[i, 0], local[i, 1], local[i, 2]
        l0, l1, l2 = min(l0, a), min(l1, b), min(l2, c)
        h0, h1, h2 = max(h0, a), max(h1, b), max(h2, c)
    half = 0.5 / model.scale
    r0, r1, r2 = half * (float(h0) - float(l0)), half * (float(h1) - float(l1)), half * (float(h2) - float(l2))
    return (
        model.centre[0] + half * (float(l0) + float(h0)),
        model.centre[1] + half * (float(l1) + float(h1)),
        model.centre[2] + half * (float(l2) + float(h2)),
        (r0 * r0 + r1 * r1 + r2 * r2) ** 0.5,
    )


@kernel(inline="always")
def find_walls(model, x, radius, local, placed, lo, n, lanes, normals, test):
    """Find all contacts of a chunk's `n` particles with surfaces.

    Rows 0 to 2 of `lanes`: place in the chunk, slot, surface; row 3: row of the wall memory.  `normals`: normal and overlap.
    Returns their number.
    """
    n_surfaces = model.surface_kind.shape[0]
    c0, c1, c2, around = chunk_sphere(model, local, n)
    found = 0
    places, slots, surfaces, memories = lanes[0], lanes[1], lanes[2], lanes[3]
    for s in range(n_surfaces):
        if wall_near(model, placed, s, c0, c1, c2, around + model.largest_radius) > 0.0:
            touch_surface(model, x, radius, lo, n, s, placed[s], test)
            start = found
            end = np.uint64(found)
            for i in range(np.uint32(n)):
                places[end] = i
                end += np.uint64(test[i] > 0.0)
            found = np.int64(end)
            kept = start
            for q in range(start, found):
                i = places[q]
                slot = i + np.uint32(lo)
                overlap, n0, n1, n2 = wall_overlap(model, placed, s, x[0, slot], x[1, slot], x[2, slot], radius[slot])
                if overlap > 0.0:
                    places[kept], slots[kept], surfaces[kept], memories[kept] = i, slot, s, slot * n_surfaces + s
                    normals[0, kept], normals[1, kept], normals[2, kept], normals[3, kept] = n0, n1, n2, overlap
                    kept += 1
            found = kept
    return found


@kernel(inline="always")
def lay_walls(model, x, rows, wall_memory, material, motion, first, m, slots, surfaces, memories, normals, columns):
    """Lay `m` contacts with walls, from entry `first` of the lists on, into the lanes of a batch."""
    one, zero = like(1.0, columns[0]), like(0.0, columns[0])
    body_of, material_of, law_of, laws = model.surface_body, model.surface_material, model.law_of, model.laws
    for g in range(0, m, WIDTH):
        gather_rows(rows, slots, first + g, columns, g, A)
        gather_rows(wall_memory, memories, first + g, columns, g, MEMORY)
    for b in range(BATCH):
        columns[WEIGHT * BATCH + b] = one if b < m else zero
    for b in range(m):
        q = first + b
        slot, s = slots[q], surfaces[q]
        body = body_of[s]
        for k in range(4):
            columns[k * BATCH + b] = normals[k, q]
        for k in range(3):
            columns[(ARM + k) * BATCH + b] = x[k, slot] - motion[body, k]
            columns[(BODY_V + k) * BATCH + b] = motion[body, 12 + k]
            columns[(BODY_W + k) * BATCH + b] = motion[body, 15 + k]
        hold_law(columns, b, laws, law_of[material[slot], material_of[s]])


@kernel(fast=True, inline="always")
def wall_contacts(
    model, x, radius, rows, wall_memory, material, motion, placed, found, lanes, normals, columns, last, now, dt, forces, sums, book, tid
):
    """Forces of all touching walls of a chunk, added to `forces`, and their reaction on the bodies, added to `sums` (B, 6).

    Contacts that begin are booked.

    Returns
    -------
    powers of normal, tangential and rolling part and of the surfaces' motion [W] (4), 1 if an overlap is beyond its limit
    """
    places, slots, surfaces, memories = lanes[0], lanes[1], lanes[2], lanes[3]
    body_of = model.surface_body
    for q in range(found, found + BATCH):
        places[q], slots[q], memories[q] = forces.shape[0] - 1, 0, wall_memory.shape[0] - 1
    sum_n, sum_t, sum_r, sum_i = 0.0, 0.0, 0.0, 0.0
    beyond = 0
    for first in range(0, found, BATCH):
        m = min(BATCH, found - first)
        lay_walls(model, x, rows, wall_memory, material, motion, first, m, slots, surfaces, memories, normals, columns)
        power_n, power_t, power_r, power_i, over, begun = wall_batch(model.law, columns, last, now, dt)
        if begun != 0:
            note_wall_impacts(columns, begun, first, lanes, normals, model, x, radius, material, placed, book, tid)
        sum_n += power_n
        sum_t += power_t
        sum_r += power_r
        sum_i += power_i
        beyond |= over
        for b in range(m):
            body = body_of[surfaces[first + b]]
            for k in range(3):
                sums[body, k] -= columns[(A + k) * BATCH + b]
                sums[body, 3 + k] -= columns[(ARM + k) * BATCH + b]
        for g in range(0, m, WIDTH):
            add_rows(forces, places, first + g, columns, g, A)
            set_rows(wall_memory, memories, first + g, columns, g, MEMORY)
    return sum_n, sum_t, sum_r, sum_i, beyond
