"""The wall list: which patches of meshes are near each particle, so that few of them are tested.

Everything is measured in the axes of the body that carries the mesh: a particle that rides with a wall does
not move.  Of each particle the list holds the patches within reach of it, and of each of these the place of
the last test, a distance the patch had there at least, and the triangle nearest there.  As long as the
particle has not moved from there by that distance less the largest radius, the patch is not tested; where it
is, the search begins at that triangle.  (The largest one, for a centre behind a mesh is pushed out from as
deep as that, however small its particle.)

Most particles at a wall touch one patch, far from any edge, and slide a thousandth of a triangle in a
substep.  What their triangle needs to decide again stands beside the list, in one line of the cache: a walk
through the arrays of a fine mesh costs several times its arithmetic.

The list decides what is computed and never the result: each entry is a statement about the mesh that is true
wherever the particle is and whichever it is.  So it is work space that no checkpoint needs, and each chunk
brings it up to date for its own particles.
"""

import math

from nutamill.base.kernel import kernel
from nutamill.charge.walls.mesh_contact import (
    NEAR_MARGIN,
    cell_of,
    contact_from,
    contact_over,
    from_edge,
    height_over,
    margin_left,
    patch_in_cell,
    to_surface,
    to_world,
)
from nutamill.charge.walls.wall_list import MOST_NEAR

AWAY = 3
"""Column of `NearMeshes.tested` behind the place of the test (3): the distance there."""

SAFE = 1.0 - 1e-9
"""Factor by which distances are taken smaller, against rounding [1]."""

PLACE, ROOM = 4, 7
"""Columns of `NearMeshes.held` behind the plane: place of the particle (3), square of what it may move."""


@kernel(fast=True)
def find_due(x, largest, at, clear, lo, n, pose, place_out, due_out):
    """Write a positive number to ``due_out[l]`` where particle ``lo + l`` may touch a mesh.

    Parameters
    ----------
    x : places of all slots [m] (3, M)
    largest : distance at which a patch may touch a particle [m]
    at, clear : of all slots, as `NearMeshes` of one body
    pose : mass centre [m] (3) and rotation [1] (9) of the body
    place_out : places of the chunk's particles [m] (3, chunk), body axes
    """
    o0, o1, o2 = pose[0], pose[1], pose[2]
    a0, a1, a2 = pose[3], pose[4], pose[5]
    b0, b1, b2 = pose[6], pose[7], pose[8]
    c0, c1, c2 = pose[9], pose[10], pose[11]
    x0, x1, x2 = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n]
    at0, at1, at2, free = at[0, lo : lo + n], at[1, lo : lo + n], at[2, lo : lo + n], clear[lo : lo + n]
    p0, p1, p2 = place_out[0], place_out[1], place_out[2]
    for i in range(n):
        d0, d1, d2 = x0[i] - o0, x1[i] - o1, x2[i] - o2
        u0 = a0 * d0 + b0 * d1 + c0 * d2
        u1 = a1 * d0 + b1 * d1 + c1 * d2
        u2 = a2 * d0 + b2 * d1 + c2 * d2
        p0[i], p1[i], p2[i] = u0, u1, u2
        d0, d1, d2 = u0 - at0[i], u1 - at1[i], u2 - at2[i]
        room = max(free[i] - largest, 0.0)
        # a particle with no room at all is due where it stands, too
        due_out[i] = d0 * d0 + d1 * d1 + d2 * d2 - room * room + (1.0 if room == 0.0 else 0.0)


@kernel
def list_patches(model, instance, u0, u1, u2, n, surface_out, face_out, tested_out):
    """Append the patches of a mesh at one place that are near (u0, u1, u2) [m], axes of its body, to a list
    of `n`.  A patch that is there already, last tested near this place, keeps the triangle its next search
    begins at.

    Returns
    -------
    number of patches listed, more than there is room for where there are too many; a distance that all others
    have at least [m]
    """
    mesh = model.mesh
    grid, places = mesh.grid, mesh.places
    g, first = places.mesh[instance], places.first[instance]
    # all patches of a mesh are at one place: any that is a surface shows it
    k = first
    while places.surface[k] < 0:
        k += 1
    s = places.surface[k]
    origin, rotation = model.surface_origin[s], model.surface_rotation[s]
    d0, d1, d2 = u0 - origin[0], u1 - origin[1], u2 - origin[2]
    outside = 0.0
    y0, y1, y2 = 0.0, 0.0, 0.0
    for k in range(3):
        y = rotation[0, k] * d0 + rotation[1, k] * d1 + rotation[2, k] * d2
        low = grid.corner[g, k]
        gap = max(0.0, max(low - y, y - (low + grid.size[g] * grid.cells[g, k])))
        outside += gap * gap
        if k == 0:
            y0 = y
        elif k == 1:
            y1 = y
        else:
            y2 = y
    cell = cell_of(grid, g, y0, y1, y2)
    if cell < 0:
        # the grid ends its reach from the mesh
        return n, grid.reach + math.sqrt(outside)
    for q in range(grid.begin[cell], grid.begin[cell + 1]):
        s = places.surface[first + grid.patch[q] - mesh.first_patch[g]]
        if s >= 0:
            if n < MOST_NEAR:
                moved = distance(u0, u1, u2, tested_out[n, 0], tested_out[n, 1], tested_out[n, 2])
                if surface_out[n] != s or moved > grid.reach:
                    surface_out[n], face_out[n] = s, grid.face[q]
                tested_out[n, 0], tested_out[n, 1], tested_out[n, 2] = u0, u1, u2
                tested_out[n, AWAY] = 0.0
            n += 1
    return n, max(grid.reach, float(grid.apart[cell]))


@kernel(inline="always")
def note_contact(near_scratch, tid, l, s, count, overlap, n0, n1, n2):
    """Put a contact of particle `l` of the chunk with surface `s` first in the list of that surface, and
    return the number of contacts.
    """
    near_scratch.link[tid, 0, count] = near_scratch.head[tid, s]
    near_scratch.link[tid, 1, count] = l
    near_scratch.head[tid, s] = count
    contact = near_scratch.contact[tid, count]
    contact[0], contact[1], contact[2], contact[3] = n0, n1, n2, overlap
    return count + 1


@kernel
def test_all(model, near_scratch, body, surface_poses, x0, x1, x2, r, tid, l, count):
    """Test particle `l` of the chunk against all patches of the meshes of a body, and return the number of
    contacts.
    """
    mesh = model.mesh
    grid, places = mesh.grid, mesh.places
    for instance in range(places.body.shape[0]):
        if places.body[instance] == body:
            for k in range(places.first[instance], places.first[instance + 1]):
                s = places.surface[k]
                if s >= 0:
                    a, b, c = to_surface(surface_poses, s, x0, x1, x2)
                    g = places.mesh[instance]
                    cell = cell_of(grid, g, a, b, c)
                    patch = mesh.patch_of[s]
                    q = patch_in_cell(grid, cell, patch)
                    if q >= 0:
                        overlap, n0, n1, n2, _, _ = contact_from(mesh, patch, grid.face[q], a, b, c, r)
                        if overlap > 0.0:
                            w0, w1, w2 = to_world(surface_poses, s, n0, n1, n2)
                            count = note_contact(near_scratch, tid, l, s, count, overlap, w0, w1, w2)
    return count


@kernel
def keep_decider(model, near_scratch, d, slot, s, face, u0, u1, u2, a, b, c, room):
    """Keep that triangle `face`, of surface `s`, decides for the particle of a slot.

    Parameters
    ----------
    u0, u1, u2 : place of the particle [m], body axes
    a, b, c : the same in the axes of the surface [m]
    room : what it may move before another patch may touch it [m]
    """
    held, decider, rows = near_scratch.held[d, slot], near_scratch.decider[d, slot], model.mesh.faces.rows
    if decider[0] != s or decider[1] != face:
        decider[0], decider[1] = s, face
        for k in range(PLACE):
            held[k] = rows[face, k]
    # a move changes no distance by more than itself
    margin = margin_left(
        rows,
        face,
        NEAR_MARGIN,
        from_edge(rows, face, 0, a, b, c),
        from_edge(rows, face, 1, a, b, c),
        from_edge(rows, face, 2, a, b, c),
    )
    held[PLACE], held[PLACE + 1], held[PLACE + 2] = u0, u1, u2
    room = max(min(room, margin - model.mesh.faces.edge_width), 0.0)
    held[ROOM] = room * room * SAFE


@kernel(inline="always")
def test_particle(model, near_scratch, d, surface_poses, x0, x1, x2, r, slot, tid, l, count):
    """Test a particle that may touch a mesh of body number `d` of the list, bring its entries up to date, and
    return the number of contacts.

    Parameters
    ----------
    x0, x1, x2, r : its place, world, and radius [m]
    slot, l : its slot, and position in the chunk
    count : contacts of the chunk so far
    """
    mesh, places = model.mesh, model.mesh.places
    body = near_scratch.bodies[d]
    listed_at, tested = near_scratch.listed_at[d, slot], near_scratch.tested[d, slot]
    surface, face = near_scratch.surface[d, slot], near_scratch.face[d, slot]
    u0, u1, u2 = near_scratch.place[tid, 0, l], near_scratch.place[tid, 1, l], near_scratch.place[tid, 2, l]
    moved, largest = distance(u0, u1, u2, listed_at[0], listed_at[1], listed_at[2]), mesh.grid.behind
    n = near_scratch.listed[d, slot]
    # also true where the particle's place is not a number
    if n < 0 or not (moved + largest < near_scratch.limit[d, slot]):
        n, limit = 0, math.inf
        for instance in range(places.body.shape[0]):
            if places.body[instance] == body:
                n, others = list_patches(model, instance, u0, u1, u2, n, surface, face, tested)
                limit = min(limit, others * SAFE)
        listed_at[0], listed_at[1], listed_at[2] = u0, u1, u2
        near_scratch.limit[d, slot], near_scratch.listed[d, slot] = limit, n if n <= MOST_NEAR else -1
        moved = 0.0
    near_scratch.at[d, 0, slot], near_scratch.at[d, 1, slot], near_scratch.at[d, 2, slot] = u0, u1, u2
    if near_scratch.listed[d, slot] < 0:
        near_scratch.clear[d, slot] = 0.0
        near_scratch.decider[d, slot, 0] = -1
        return test_all(model, near_scratch, body, surface_poses, x0, x1, x2, r, tid, l, count)
    clear = near_scratch.limit[d, slot] - moved
    rest, touched, which = clear, 0, -1
    for k in range(n):
        away = tested[k, AWAY]
        if away > largest:
            away -= distance(u0, u1, u2, tested[k, 0], tested[k, 1], tested[k, 2])
        if away <= largest:
            s = surface[k]
            a, b, c = to_surface(surface_poses, s, x0, x1, x2)
            overlap, n0, n1, n2, away, face[k] = contact_from(mesh, mesh.patch_of[s], face[k], a, b, c, r)
            away *= SAFE
            tested[k, 0], tested[k, 1], tested[k, 2], tested[k, AWAY] = u0, u1, u2, away
            if overlap > 0.0:
                w0, w1, w2 = to_world(surface_poses, s, n0, n1, n2)
                count = note_contact(near_scratch, tid, l, s, count, overlap, w0, w1, w2)
        clear = min(clear, away)
        if away <= largest:
            touched, which = touched + 1, k
        else:
            rest = min(rest, away)
    near_scratch.clear[d, slot] = clear
    if touched == 1:
        s = surface[which]
        a, b, c = to_surface(surface_poses, s, x0, x1, x2)
        keep_decider(model, near_scratch, d, slot, s, face[which], u0, u1, u2, a, b, c, rest - largest)
    else:
        near_scratch.decider[d, slot, 0] = -1
    return count


@kernel(inline="always")
def find_contacts(model, near_scratch, d, surface_poses, x0, x1, x2, r, slot, tid, l, count):
    """Do what `test_particle` does, by the triangle that decided last where that is enough."""
    s, held, place = near_scratch.decider[d, slot, 0], near_scratch.held[d], near_scratch.place[tid]
    if s >= 0:
        d0 = place[0, l] - held[slot, PLACE]
        d1 = place[1, l] - held[slot, PLACE + 1]
        d2 = place[2, l] - held[slot, PLACE + 2]
        if d0 * d0 + d1 * d1 + d2 * d2 < held[slot, ROOM]:
            a, b, c = to_surface(surface_poses, s, x0, x1, x2)
            height = height_over(held, slot, a, b, c)
            if height > 0.0 and height <= model.mesh.grid.behind:
                overlap, n0, n1, n2, _ = contact_over(held, slot, height, r)
                if overlap > 0.0:
                    w0, w1, w2 = to_world(surface_poses, s, n0, n1, n2)
                    count = note_contact(near_scratch, tid, l, s, count, overlap, w0, w1, w2)
                return count
    return test_particle(model, near_scratch, d, surface_poses, x0, x1, x2, r, slot, tid, l, count)


@kernel(inline="always")
def distance(a0, a1, a2, b0, b1, b2):
    """Return the distance of two points [m]."""
    return math.sqrt((a0 - b0) * (a0 - b0) + (a1 - b1) * (a1 - b1) + (a2 - b2) * (a2 - b2))


@kernel
def find_mesh_contacts(model, near_scratch, x, radius, motion, surface_poses, lo, n, tid):
    """Detect the contacts of a chunk's `n` particles with meshes, by surface and in the order of the slots.

    Parameters
    ----------
    near_scratch : `NearMeshes`, which lists them in `head`, `link` and `contact`
    x, radius : of all slots [m]
    motion : pose and twist of each body, as `ChargeScratch.motion` (B, 18)
    surface_poses : place of each surface, as from `place_surfaces` (S, 12)
    lo : first slot of the chunk
    tid : number of this thread
    """
    count = 0
    for d in range(near_scratch.bodies.shape[0]):
        pose, due = motion[near_scratch.bodies[d]], near_scratch.due[tid]
        find_due(
            x,
            model.mesh.grid.behind,
            near_scratch.at[d],
            near_scratch.clear[d],
            lo,
            n,
            pose,
            near_scratch.place[tid],
            due,
        )
        # from the last to the first: each contact is put before those of its surface
        for k in range(n):
            l = n - 1 - k
            slot = lo + l
            if not (due[l] <= 0.0):
                count = find_contacts(
                    model,
                    near_scratch,
                    d,
                    surface_poses,
                    x[0, slot],
                    x[1, slot],
                    x[2, slot],
                    radius[slot],
                    slot,
                    tid,
                    l,
                    count,
                )
