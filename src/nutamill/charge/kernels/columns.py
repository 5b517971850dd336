"""The vector loops: one contact per lane, the law of `composition.contact` for pairs and for walls.

Everything a loop touches is in one flat array of rows of `BATCH` lanes: the compiler then sees that lanes are
independent.  Unused lanes have weight 0 and hold stale data, which is computed and discarded.
"""

import math

from nutamill.base.frames import add3, cross3, dot3, scale3, sub3, velocity_at
from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.film_lanes import load_film, store_film_power, true_overlap
from nutamill.charge.kernels.impacts import BEGUN, ENERGY_N, ENERGY_T, impact_energies
from nutamill.charge.kernels.rows import (
    ACT,
    ARM,
    BODY_V,
    BODY_W,
    DISTANCE,
    FORCE_A,
    FORCE_B,
    HISTORY,
    LAW,
    MASS_A,
    MASS_B,
    NORMAL,
    OVERLAP,
    PARTING,
    PEAK,
    PEAK_RADIUS,
    RADIUS_A,
    RADIUS_B,
    REACH,
    ROLLED,
    SPRING,
    STAMP,
    V_A,
    V_B,
    W_A,
    W_B,
    WEIGHT,
)  # fmt: skip
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.laws.meeting import meeting
from nutamill.charge.laws.pair import LawColumn

LIMIT = int(LawColumn.LIMIT)


@kernel(inline="always")
def load3(columns, b, row):
    """Return the vector of lane `b` in the rows from `row` on."""
    return columns[b + row * BATCH], columns[b + (row + 1) * BATCH], columns[b + (row + 2) * BATCH]


@kernel(inline="always")
def store3(columns, b, row, a):
    """Write the vector `a` of lane `b` to the rows from `row` on."""
    columns[b + row * BATCH] = a[0]
    columns[b + (row + 1) * BATCH] = a[1]
    columns[b + (row + 2) * BATCH] = a[2]


@kernel(inline="always")
def load_law(columns, b):
    """Return the numbers of the pair law of lane `b`, as `LawColumn` (13)."""
    return (
        columns[b + LAW * BATCH], columns[b + (LAW + 1) * BATCH], columns[b + (LAW + 2) * BATCH],
        columns[b + (LAW + 3) * BATCH], columns[b + (LAW + 4) * BATCH], columns[b + (LAW + 5) * BATCH],
        columns[b + (LAW + 6) * BATCH], columns[b + (LAW + 7) * BATCH], columns[b + (LAW + 8) * BATCH],
        columns[b + (LAW + 9) * BATCH], columns[b + (LAW + 10) * BATCH], columns[b + (LAW + 11) * BATCH],
        columns[b + (LAW + 12) * BATCH],
    )  # fmt: skip


@kernel(inline="always")
def load_stamp(columns, b, last):
    """Return whether the memory of lane `b` is of the substep with stamp `last`, and whether the contact was
    sliding then: 1 or 0.
    """
    one, zero = like(1.0, last), like(0.0, last)
    stamp = columns[b + STAMP * BATCH]
    return one if abs(stamp) == last else zero, one if stamp == -last else zero


@kernel(inline="always")
def load_memory(columns, b, alive):
    """Return spring (3), rolled (3) and history of the contact memory of lane `b`, zeros unless `alive`."""
    spring = scale3(alive, load3(columns, b, SPRING))
    rolled = scale3(alive, load3(columns, b, ROLLED))
    return spring, rolled, columns[b + HISTORY * BATCH] * alive


@kernel(inline="always")
def store_memory(columns, b, spring, rolled, sliding, history, now):
    """Write the contact memory of lane `b`, of the substep with stamp `now`."""
    store3(columns, b, SPRING, spring)
    store3(columns, b, ROLLED, rolled)
    columns[b + STAMP * BATCH] = -now if sliding > like(0.5, now) else now
    columns[b + HISTORY * BATCH] = history


@kernel(inline="always")
def store_load(columns, b, row, force, moment):
    """Write force and moment on a particle to its eight rows in lane `b`, from `row` on."""
    zero = like(0.0, columns[b])
    store3(columns, b, row, force)
    columns[b + (row + 3) * BATCH] = zero
    store3(columns, b, row + 4, moment)
    columns[b + (row + 7) * BATCH] = zero


@kernel(fast=True, inline="always")
def note_depth(columns, b, deep, r, limit, one, zero):
    """Update the largest overlap of lane `b`, half of it `deep` [m] at a particle of radius `r` [m], and
    return one where beyond the limit.

    Shares of the radius are compared by products, not by quotients.
    """
    peak, at = columns[b + PEAK * BATCH], columns[b + PEAK_RADIUS * BATCH]
    deeper = deep * at > peak * r
    columns[b + PEAK * BATCH] = deep if deeper else peak
    columns[b + PEAK_RADIUS * BATCH] = r if deeper else at
    return one if deep * limit > r else zero


@kernel(inline="always")
def book_impact(columns, b, m_eff, u, n, overlap, begins):
    """Write the energies of the relative motion `u` of lane `b`, whether its contact `begins` [1], and its
    `overlap` [m], 0 in an unused lane, with the sign of `PARTING`.
    """
    zero = like(0.0, overlap)
    deep = overlap if overlap > zero else zero
    columns[b + PARTING * BATCH] = deep if dot3(u, n) <= zero else -deep
    normal, tangential = impact_energies(m_eff, u[0], u[1], u[2], n[0], n[1], n[2])
    columns[b + ENERGY_N * BATCH] = normal
    columns[b + ENERGY_T * BATCH] = tangential
    columns[b + BEGUN * BATCH] = begins


@kernel(fast=True)
def pair_batch(law, columns, unit, reach, last, now, dt):
    """Compute the law for one batch of touching pairs.

    Parameters
    ----------
    law : `ContactLaw`
    columns : real (ROWS * BATCH,), rows as named in this file; forces replace velocities, memory is brought
        up to date
    unit : metres in a fixed-point unit [m]
    reach : by how much the published radii of two particles are larger than theirs [m]; not used where dry
    last, now : stamps of the last and of this substep [1]
    dt : substep [s]

    Returns
    -------
    powers of normal, tangential and rolling part [W] (3), number of lanes beyond the overlap limit, of
    contacts that begin
    """
    one, zero, half = like(1.0, dt), like(0.0, dt), like(0.5, dt)
    sum_n, sum_t, sum_r = zero, zero, zero
    # no whole numbers: with one of 64 bits in the loop, the compiler would take half as many lanes at a time
    beyond, begun = zero, zero
    for b in range(BATCH):
        n = load3(columns, b, DISTANCE)
        n = n[0] * unit, n[1] * unit, n[2] * unit
        distance = math.sqrt(dot3(n, n))
        n = scale3(one / distance, n)
        overlap = true_overlap(law.film, columns[b + REACH * BATCH] * unit - distance, reach)
        ma, ra = columns[b + MASS_A * BATCH], columns[b + RADIUS_A * BATCH]
        mb, rb = columns[b + MASS_B * BATCH], columns[b + RADIUS_B * BATCH]
        wa, wb = load3(columns, b, W_A), load3(columns, b, W_B)
        # both arms end at the middle of the overlap: the two moments about one point keep angular momentum
        # exactly
        arm_a, arm_b = ra - half * overlap, rb - half * overlap
        q = add3(scale3(arm_a, wa), scale3(arm_b, wb))
        u = velocity_at(sub3(load3(columns, b, V_A), load3(columns, b, V_B)), q, n)
        # before the division: the order of loads decides in which order sums are added up
        alive, sliding = load_stamp(columns, b, last)
        # one division for both reduced quantities: divisions are what this loop waits for
        both_m, both_r = ma + mb, ra + rb
        per_both = one / (both_m * both_r)
        m_eff, r_eff = ma * mb * both_r * per_both, ra * rb * both_m * per_both
        numbers = load_law(columns, b)
        spring, rolled, history = load_memory(columns, b, alive)
        force, friction, moment, spring, rolled, sliding, history, powers, film_power, lasts = meeting(
            law.film, law, n, overlap, u, sub3(wa, wb), spring, rolled, sliding, history, alive, m_eff, r_eff,
            (ra + ra, rb + rb), numbers, load_film(law.film, columns, b, zero), dt,
        )  # fmt: skip
        couple = cross3(n, friction)
        store_load(columns, b, FORCE_A, force, add3(scale3(arm_a, couple), moment))
        store_load(
            columns, b, FORCE_B, (-force[0], -force[1], -force[2]), sub3(scale3(arm_b, couple), moment)
        )
        store_memory(columns, b, spring, rolled, sliding, history, now)
        store_film_power(law.film, film_power, b, columns)
        weight = columns[b + WEIGHT * BATCH]
        counts = weight > zero
        sum_n += weight * powers[0] if counts else zero
        sum_t += weight * powers[1] if counts else zero
        sum_r += weight * powers[2] if counts else zero
        deep = half * overlap if counts else zero
        beyond += note_depth(columns, b, deep, ra if ra < rb else rb, numbers[LIMIT], one, zero)
        begins = one - lasts if counts else zero
        book_impact(columns, b, m_eff, u, n, overlap if counts else zero, begins)
        begun += begins
    return sum_n, sum_t, sum_r, beyond, begun


@kernel(fast=True)
def wall_batch(law, columns, last, now, dt):
    """Compute the law for one batch of particles that touch surfaces. Rows 0 to 3 hold normal and overlap.

    Parameters
    ----------
    as `pair_batch`

    Returns
    -------
    powers of normal, tangential and rolling part and of the surfaces' motion on the charge [W] (4), number of
    lanes beyond the limit, of contacts that begin
    """
    one, zero, half = like(1.0, dt), like(0.0, dt), like(0.5, dt)
    sum_n, sum_t, sum_r, sum_i = zero, zero, zero, zero
    # no whole numbers: with one of 64 bits in the loop, the compiler would take half as many lanes at a time
    beyond, begun = zero, zero
    for b in range(BATCH):
        n, overlap = load3(columns, b, NORMAL), columns[b + OVERLAP * BATCH]
        m, r = columns[b + MASS_A * BATCH], columns[b + RADIUS_A * BATCH]
        w, body_w = load3(columns, b, W_A), load3(columns, b, BODY_W)
        # contact point from the body's mass centre, in the middle of the overlap as between two particles
        arm = r - half * overlap
        p = add3(load3(columns, b, ARM), scale3(arm, n))
        wall_v = velocity_at(load3(columns, b, BODY_V), body_w, p)
        u = sub3(add3(load3(columns, b, V_A), scale3(arm, cross3(w, n))), wall_v)
        alive, sliding = load_stamp(columns, b, last)
        numbers = load_law(columns, b)
        spring, rolled, history = load_memory(columns, b, alive)
        force, friction, moment, spring, rolled, sliding, history, powers, film_power, lasts = meeting(
            law.film, law, n, overlap, u, sub3(w, body_w), spring, rolled, sliding, history, alive, m, r,
            (r + r, r + r), numbers, load_film(law.film, columns, b, zero), dt,
        )  # fmt: skip
        store_load(columns, b, FORCE_A, force, add3(scale3(arm, cross3(n, friction)), moment))
        store3(columns, b, ARM, add3(cross3(p, force), moment))
        store_memory(columns, b, spring, rolled, sliding, history, now)
        store_film_power(law.film, film_power, b, columns)
        store3(columns, b, ACT, powers)
        counts = columns[b + WEIGHT * BATCH] > zero
        sum_n += powers[0] if counts else zero
        sum_t += powers[1] if counts else zero
        sum_r += powers[2] if counts else zero
        # computed under its condition: the compiler would not know it for a sum over lanes otherwise
        sum_i += (
            force[0] * wall_v[0] + force[1] * wall_v[1] + force[2] * wall_v[2]
            + moment[0] * body_w[0] + moment[1] * body_w[1] + moment[2] * body_w[2]
        ) if counts else zero  # fmt: skip
        deep = half * overlap if counts else zero
        beyond += note_depth(columns, b, deep, r, numbers[LIMIT], one, zero)
        begins = one - lasts if counts else zero
        book_impact(columns, b, m, u, n, overlap if counts else zero, begins)
        begun += begins
    return sum_n, sum_t, sum_r, sum_i, beyond, begun
