"""The vector loops: one contact per lane, the law of `composition.contact` for pairs and for walls.

Everything a loop touches lies in one flat array of rows of `BATCH` lanes: the compiler then sees that lanes
are independent.  Lanes of weight 0 hold left-overs; they are computed and not counted.
"""

import math

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.impacts import BEGUN, ENERGY_N, ENERGY_T, impact_energies
from nutamill.charge.laws.composition import contact
from nutamill.charge.laws.lanes import BATCH

# rows of `columns`, pairs: distance vector and sum of radii, first particle, second particle, memory (8 rows
# each)
A = 4
B = 12
MEMORY = 20
LAW = 28
"""First of the eleven rows with the numbers of the pair law, as `LawColumn`."""
WEIGHT = 39
"""1: counted here; 1/2: a pair across chunks, which the other chunk counts too; 0: empty lane [1]."""
PEAK = 40
"""Largest overlap so far in this lane over the diameter of the smaller particle: half of it [m], and the
radius [m] in `PEAK_RADIUS`.
"""
HELD = 41
"""Which pair law the lane's numbers are of [1]."""
ARM = 12
"""Walls: particle's centre from the body's mass centre [m] (3), world axes; afterwards angular impulse rate
on the body [N m].
"""
ACT = 15
"""Walls: powers of the normal, tangential and rolling part of each lane [W] (3), after the law."""
BODY_V = 42
"""Walls: velocity of the body's mass centre [m/s] (3)."""
BODY_W = 45
"""Walls: spin of the body [rad/s] (3)."""
BODY = 48
"""Walls: number of the body, that of no body in an empty lane [1]."""
PEAK_RADIUS = 50
ROWS = 51
"""Rows of `columns` [1]."""


@kernel(fast=True, inline="always")
def note_depth(columns, b, deep, r, limit, one, zero):
    """Keep the largest overlap of lane `b`, half of it `deep` [m] at a particle of radius `r` [m]; returns
    one where beyond the limit.

    Shares of the radius are compared by products, not by quotients.
    """
    peak, at = columns[b + PEAK * BATCH], columns[b + PEAK_RADIUS * BATCH]
    deeper = deep * at > peak * r
    columns[b + PEAK * BATCH] = deep if deeper else peak
    columns[b + PEAK_RADIUS * BATCH] = r if deeper else at
    return one if deep * limit > r else zero


@kernel(fast=True)
def pair_batch(law, columns, unit, last, now, dt):
    """The law for one batch of touching pairs.

    Parameters
    ----------
    law : `ContactLaw`
    columns : real (ROWS * BATCH,), rows as named in this file; forces replace velocities, memory is brought
        up to date
    unit : metres in a fixed-point unit [m]
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
        n0 = columns[b] * unit
        n1 = columns[b + BATCH] * unit
        n2 = columns[b + 2 * BATCH] * unit
        distance = math.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
        inverse = one / distance
        n0 *= inverse
        n1 *= inverse
        n2 *= inverse
        overlap = columns[b + 3 * BATCH] * unit - distance
        ma, ra = columns[b + (A + 3) * BATCH], columns[b + (A + 7) * BATCH]
        mb, rb = columns[b + (B + 3) * BATCH], columns[b + (B + 7) * BATCH]
        wa0, wa1, wa2 = (
            columns[b + (A + 4) * BATCH],
            columns[b + (A + 5) * BATCH],
            columns[b + (A + 6) * BATCH],
        )
        wb0, wb1, wb2 = (
            columns[b + (B + 4) * BATCH],
            columns[b + (B + 5) * BATCH],
            columns[b + (B + 6) * BATCH],
        )
        # both arms end at the middle of the overlap: the two moments about one point keep angular momentum
        # exactly
        arm_a = ra - half * overlap
        arm_b = rb - half * overlap
        q0 = arm_a * wa0 + arm_b * wb0
        q1 = arm_a * wa1 + arm_b * wb1
        q2 = arm_a * wa2 + arm_b * wb2
        u0 = columns[b + A * BATCH] - columns[b + B * BATCH] + q1 * n2 - q2 * n1
        u1 = columns[b + (A + 1) * BATCH] - columns[b + (B + 1) * BATCH] + q2 * n0 - q0 * n2
        u2 = columns[b + (A + 2) * BATCH] - columns[b + (B + 2) * BATCH] + q0 * n1 - q1 * n0
        stamp = columns[b + (MEMORY + 6) * BATCH]
        alive = one if abs(stamp) == last else zero
        sliding = one if stamp == -last else zero
        # one division for both reduced quantities: divisions are what this loop waits for
        both_m, both_r = ma + mb, ra + rb
        per_both = one / (both_m * both_r)
        m_eff = ma * mb * both_r * per_both
        r_eff = ra * rb * both_m * per_both
        numbers = (
            columns[b + LAW * BATCH], columns[b + (LAW + 1) * BATCH], columns[b + (LAW + 2) * BATCH],
            columns[b + (LAW + 3) * BATCH], columns[b + (LAW + 4) * BATCH], columns[b + (LAW + 5) * BATCH],
            columns[b + (LAW + 6) * BATCH], columns[b + (LAW + 7) * BATCH], columns[b + (LAW + 8) * BATCH],
            columns[b + (LAW + 9) * BATCH], columns[b + (LAW + 10) * BATCH],
        )  # fmt: skip
        (
            f0,
            f1,
            f2,
            g0,
            g1,
            g2,
            m0,
            m1,
            m2,
            s0,
            s1,
            s2,
            t0,
            t1,
            t2,
            sliding,
            history,
            power_n,
            power_t,
            power_r,
        ) = contact(
            law,
            n0,
            n1,
            n2,
            overlap,
            u0,
            u1,
            u2,
            wa0 - wb0,
            wa1 - wb1,
            wa2 - wb2,
            columns[b + MEMORY * BATCH] * alive,
            columns[b + (MEMORY + 1) * BATCH] * alive,
            columns[b + (MEMORY + 2) * BATCH] * alive,
            columns[b + (MEMORY + 3) * BATCH] * alive,
            columns[b + (MEMORY + 4) * BATCH] * alive,
            columns[b + (MEMORY + 5) * BATCH] * alive,
            sliding,
            columns[b + (MEMORY + 7) * BATCH] * alive,
            m_eff,
            r_eff,
            ra + ra,
            rb + rb,
            numbers,
            dt,
        )
        c0 = n1 * g2 - n2 * g1
        c1 = n2 * g0 - n0 * g2
        c2 = n0 * g1 - n1 * g0
        columns[b + A * BATCH] = f0
        columns[b + (A + 1) * BATCH] = f1
        columns[b + (A + 2) * BATCH] = f2
        columns[b + (A + 3) * BATCH] = zero
        columns[b + (A + 4) * BATCH] = arm_a * c0 + m0
        columns[b + (A + 5) * BATCH] = arm_a * c1 + m1
        columns[b + (A + 6) * BATCH] = arm_a * c2 + m2
        columns[b + (A + 7) * BATCH] = zero
        columns[b + B * BATCH] = -f0
        columns[b + (B + 1) * BATCH] = -f1
        columns[b + (B + 2) * BATCH] = -f2
        columns[b + (B + 3) * BATCH] = zero
        columns[b + (B + 4) * BATCH] = arm_b * c0 - m0
        columns[b + (B + 5) * BATCH] = arm_b * c1 - m1
        columns[b + (B + 6) * BATCH] = arm_b * c2 - m2
        columns[b + (B + 7) * BATCH] = zero
        columns[b + MEMORY * BATCH] = s0
        columns[b + (MEMORY + 1) * BATCH] = s1
        columns[b + (MEMORY + 2) * BATCH] = s2
        columns[b + (MEMORY + 3) * BATCH] = t0
        columns[b + (MEMORY + 4) * BATCH] = t1
        columns[b + (MEMORY + 5) * BATCH] = t2
        columns[b + (MEMORY + 6) * BATCH] = -now if sliding > half else now
        columns[b + (MEMORY + 7) * BATCH] = history
        weight = columns[b + WEIGHT * BATCH]
        counts = weight > zero
        sum_n += weight * power_n if counts else zero
        sum_t += weight * power_t if counts else zero
        sum_r += weight * power_r if counts else zero
        deep = half * overlap if counts else zero
        beyond += note_depth(columns, b, deep, ra if ra < rb else rb, numbers[9], one, zero)
        normal, tangential = impact_energies(m_eff, u0, u1, u2, n0, n1, n2)
        columns[b + ENERGY_N * BATCH] = normal
        columns[b + ENERGY_T * BATCH] = tangential
        begins = one - alive if counts else zero
        columns[b + BEGUN * BATCH] = begins
        begun += begins
    return sum_n, sum_t, sum_r, beyond, begun


@kernel(fast=True)
def wall_batch(law, columns, last, now, dt):
    """The law for one batch of particles that touch surfaces; rows 0 to 3 hold normal and overlap [m].

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
        n0, n1, n2, overlap = columns[b], columns[b + BATCH], columns[b + 2 * BATCH], columns[b + 3 * BATCH]
        m, r = columns[b + (A + 3) * BATCH], columns[b + (A + 7) * BATCH]
        w0, w1, w2 = columns[b + (A + 4) * BATCH], columns[b + (A + 5) * BATCH], columns[b + (A + 6) * BATCH]
        z0, z1, z2 = (
            columns[b + BODY_W * BATCH],
            columns[b + (BODY_W + 1) * BATCH],
            columns[b + (BODY_W + 2) * BATCH],
        )
        # contact point from the body's mass centre, in the middle of the overlap as between two particles
        arm = r - half * overlap
        p0 = columns[b + ARM * BATCH] + arm * n0
        p1 = columns[b + (ARM + 1) * BATCH] + arm * n1
        p2 = columns[b + (ARM + 2) * BATCH] + arm * n2
        x0 = columns[b + BODY_V * BATCH] + z1 * p2 - z2 * p1
        x1 = columns[b + (BODY_V + 1) * BATCH] + z2 * p0 - z0 * p2
        x2 = columns[b + (BODY_V + 2) * BATCH] + z0 * p1 - z1 * p0
        u0 = columns[b + A * BATCH] + arm * (w1 * n2 - w2 * n1) - x0
        u1 = columns[b + (A + 1) * BATCH] + arm * (w2 * n0 - w0 * n2) - x1
        u2 = columns[b + (A + 2) * BATCH] + arm * (w0 * n1 - w1 * n0) - x2
        stamp = columns[b + (MEMORY + 6) * BATCH]
        alive = one if abs(stamp) == last else zero
        sliding = one if stamp == -last else zero
        numbers = (
            columns[b + LAW * BATCH], columns[b + (LAW + 1) * BATCH], columns[b + (LAW + 2) * BATCH],
            columns[b + (LAW + 3) * BATCH], columns[b + (LAW + 4) * BATCH], columns[b + (LAW + 5) * BATCH],
            columns[b + (LAW + 6) * BATCH], columns[b + (LAW + 7) * BATCH], columns[b + (LAW + 8) * BATCH],
            columns[b + (LAW + 9) * BATCH], columns[b + (LAW + 10) * BATCH],
        )  # fmt: skip
        (
            f0,
            f1,
            f2,
            g0,
            g1,
            g2,
            m0,
            m1,
            m2,
            s0,
            s1,
            s2,
            t0,
            t1,
            t2,
            sliding,
            history,
            power_n,
            power_t,
            power_r,
        ) = contact(
            law,
            n0,
            n1,
            n2,
            overlap,
            u0,
            u1,
            u2,
            w0 - z0,
            w1 - z1,
            w2 - z2,
            columns[b + MEMORY * BATCH] * alive,
            columns[b + (MEMORY + 1) * BATCH] * alive,
            columns[b + (MEMORY + 2) * BATCH] * alive,
            columns[b + (MEMORY + 3) * BATCH] * alive,
            columns[b + (MEMORY + 4) * BATCH] * alive,
            columns[b + (MEMORY + 5) * BATCH] * alive,
            sliding,
            columns[b + (MEMORY + 7) * BATCH] * alive,
            m,
            r,
            r + r,
            r + r,
            numbers,
            dt,
        )
        columns[b + A * BATCH] = f0
        columns[b + (A + 1) * BATCH] = f1
        columns[b + (A + 2) * BATCH] = f2
        columns[b + (A + 3) * BATCH] = zero
        columns[b + (A + 4) * BATCH] = arm * (n1 * g2 - n2 * g1) + m0
        columns[b + (A + 5) * BATCH] = arm * (n2 * g0 - n0 * g2) + m1
        columns[b + (A + 6) * BATCH] = arm * (n0 * g1 - n1 * g0) + m2
        columns[b + (A + 7) * BATCH] = zero
        columns[b + ARM * BATCH] = p1 * f2 - p2 * f1 + m0
        columns[b + (ARM + 1) * BATCH] = p2 * f0 - p0 * f2 + m1
        columns[b + (ARM + 2) * BATCH] = p0 * f1 - p1 * f0 + m2
        columns[b + MEMORY * BATCH] = s0
        columns[b + (MEMORY + 1) * BATCH] = s1
        columns[b + (MEMORY + 2) * BATCH] = s2
        columns[b + (MEMORY + 3) * BATCH] = t0
        columns[b + (MEMORY + 4) * BATCH] = t1
        columns[b + (MEMORY + 5) * BATCH] = t2
        columns[b + (MEMORY + 6) * BATCH] = -now if sliding > half else now
        columns[b + (MEMORY + 7) * BATCH] = history
        columns[b + ACT * BATCH] = power_n
        columns[b + (ACT + 1) * BATCH] = power_t
        columns[b + (ACT + 2) * BATCH] = power_r
        counts = columns[b + WEIGHT * BATCH] > zero
        sum_n += power_n if counts else zero
        sum_t += power_t if counts else zero
        sum_r += power_r if counts else zero
        sum_i += f0 * x0 + f1 * x1 + f2 * x2 + m0 * z0 + m1 * z1 + m2 * z2 if counts else zero
        deep = half * overlap if counts else zero
        beyond += note_depth(columns, b, deep, r, numbers[9], one, zero)
        normal, tangential = impact_energies(m, u0, u1, u2, n0, n1, n2)
        columns[b + ENERGY_N * BATCH] = normal
        columns[b + ENERGY_T * BATCH] = tangential
        begins = one - alive if counts else zero
        columns[b + BEGUN * BATCH] = begins
        begun += begins
    return sum_n, sum_t, sum_r, sum_i, beyond, begun
