"""Work of loading of each contact at its deepest, counted in the spectra of the impacts.

A contact is booked in the first substep in which it opens; while it lasts and is pressed deeper than before,
its former work is taken back and the larger one booked, so that each contact counts once.  The work is that
of the spring of the solids on its line of loading: what it stores and what it loses to plastic deformation,
without dashpot, cohesion and liquid.  Which overlap has been booked is in the history of the normal law,
which changes no force by it.

Rocky breaks particles by this energy: Ansys Rocky, DEM Technical Manual 2024 R2, section 2.4.
"""

import math

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.impacts import ENERGY_N, LOADING, count_energy
from nutamill.charge.kernels.rows import HISTORY, LAW, PARTING, WEIGHT
from nutamill.charge.laws.composition import loading_to_book, loading_turned, loading_work
from nutamill.charge.laws.lanes import BATCH

MEMORY_HISTORY = 7
"""Place of the history in the memory of a contact."""


@kernel(inline="always")
def load_normal(columns, b):
    """Return the numbers of the normal law of lane `b` (5)."""
    return (
        columns[b + LAW * BATCH], columns[b + (LAW + 1) * BATCH], columns[b + (LAW + 2) * BATCH],
        columns[b + (LAW + 3) * BATCH], columns[b + (LAW + 4) * BATCH],
    )  # fmt: skip


@kernel(inline="always")
def has_turned(normal, columns, b):
    """Return whether work of loading of lane `b` is to be booked or taken back. `normal` is the tag of the
    normal law.
    """
    parting, history = columns[b + PARTING * BATCH], columns[b + HISTORY * BATCH]
    turned = loading_turned(normal, load_normal(columns, b), parting, history)
    return turned and columns[b + WEIGHT * BATCH] > like(0.0, parting)


@kernel(fast=True)
def count_turned(normal, columns):
    """Return the number of lanes of a batch in which work of loading is to be booked or taken back [1].

    Parameters
    ----------
    normal : tag of the normal law
    columns : of the batch, after the law
    """
    one, zero = like(1.0, columns[0]), like(0.0, columns[0])
    count = zero
    for b in range(BATCH):
        count += one if has_turned(normal, columns, b) else zero
    return count


@kernel
def turn(normal, b, before, m_eff, r_eff, diameters, dt, columns_out):
    """Return the work of loading of lane `b` to book, and that to take back [J], 0 for none, and remember its
    overlap.

    The contact was at rest less than a substep before.  A time t later, under the deceleration F/m*, it opens
    at F t/m*, and its overlap is less by half of that times t.

    Parameters
    ----------
    normal : tag of the normal law
    before : history of the substep before
    m_eff, r_eff : reduced mass [kg] and radius [m]; diameters : of the two [m] (2)
    dt : substep [s]
    columns_out : of the batch, after the law
    """
    c0, c1, c2, c3, c4 = load_normal(columns_out, b)
    p = float(c0), float(c1), float(c2), float(c3), float(c4)
    parting, history = float(columns_out[b + PARTING * BATCH]), float(columns_out[b + HISTORY * BATCH])
    _, force = loading_work(normal, p, abs(parting), r_eff, diameters)
    speed = math.sqrt(2.0 * float(columns_out[b + ENERGY_N * BATCH]) / m_eff)
    beyond = 0.5 * speed * min(dt, m_eff * speed / force)
    booked, taken_back, history = loading_to_book(normal, p, parting, beyond, history, before)
    columns_out[b + HISTORY * BATCH] = history
    # rounded as the memory will hold them, so that exactly what was booked is taken back
    booked = float(like(booked, columns_out[0]))
    taken_back = float(like(taken_back, columns_out[0]))
    work, _ = loading_work(normal, p, booked, r_eff, diameters)
    former, _ = loading_work(normal, p, taken_back, r_eff, diameters)
    return work, former


@kernel
def book_loading(work, former, spectrum_out):
    """Count `work` in a spectrum and take `former` back [J], each unless it is 0."""
    if work > 0.0:
        count_energy(work, 1, spectrum_out)
    if former > 0.0:
        count_energy(former, -1, spectrum_out)


@kernel
def note_pair_loading(
    normal, lanes, rows, material, memory, first, across, n_materials, dt, tid, columns_out, book_out
):
    """Book the work of loading of the pairs of a batch that turn.

    Parameters
    ----------
    normal : tag of the normal law
    rows : published velocities, masses and radii
    memory : contact memory of the chunk's list, of the substep before
    dt : substep [s]
    columns_out : of the batch, after the law; `HISTORY` is brought up to date
    lanes, material, first, across, n_materials, tid, book_out : as `impacts.note_pair_impacts`
    """
    for b in range(BATCH):
        if has_turned(normal, columns_out, b):
            q = first + b
            i, j = lanes[4, q], lanes[1, q]
            ma, ra, mb, rb = float(rows[i, 3]), float(rows[i, 7]), float(rows[j, 3]), float(rows[j, 7])
            work, former = turn(
                normal, b, float(memory[lanes[2, q], MEMORY_HISTORY]), ma * mb / (ma + mb),
                ra * rb / (ra + rb), (2.0 * ra, 2.0 * rb), float(dt), columns_out,
            )  # fmt: skip
            # as with impacts: a pair across two chunks is met in both
            if lanes[3, q] != across or i < j:
                spectra = book_out.spectra[tid, material[i] * n_materials + material[j]]
                book_loading(work, former, spectra[LOADING])


@kernel
def note_wall_loading(normal, model, lanes, rows, material, memory, first, dt, tid, columns_out, book_out):
    """Book the work of loading of the wall contacts of a batch that turn, as `note_pair_loading`. `lanes` are
    those of `find_walls`, `memory` is the wall memory.
    """
    n_materials = model.law_of.shape[0]
    for b in range(BATCH):
        if has_turned(normal, columns_out, b):
            q = first + b
            slot = lanes[1, q]
            m, r = float(rows[slot, 3]), float(rows[slot, 7])
            work, former = turn(
                normal, b, float(memory[lanes[3, q], MEMORY_HISTORY]), m, r, (2.0 * r, 2.0 * r), float(dt),
                columns_out,
            )  # fmt: skip
            other = model.surface_material[lanes[2, q]]
            spectra = book_out.spectra[tid, (n_materials + material[slot]) * n_materials + other]
            book_loading(work, former, spectra[LOADING])
