"""Collision energy spectra: what a contact brings along when it begins, counted in bins of energy.

A contact begins in the first substep in which two bodies touch; the velocities it meets then are those before the
impact, as none of its own forces has acted yet.  Counts and energies are whole numbers: they add up to the same sum in any order, so
that every thread fills its own spectra and the sum has the same bits for any number of threads.
"""

import math

import numpy as np

from nutamill.charge.model import BATCH
from nutamill.kernel import kernel, like

LOWEST = -56
"""The lowest bin begins at 2^LOWEST J = 1.4e-17 J; what is lower is counted there."""
BINS = 128
"""Bins of half an octave [1], 6.6 to a decade; the last ends at 256 J, and what is higher is counted there."""
PARTS = 2
"""Normal and tangential part of an impact [1]."""
FINE = 65536.0
"""Parts into which the lower edge of a bin is cut for its sum of energies [1]: an impact is rounded by less than 1.6e-5 of its energy."""
ENERGY_N, ENERGY_T = 0, 1
"""Rows of `columns` in which a batch leaves the two energies [J] of its lanes: free once the distance has been used."""


def bin_edges() -> np.ndarray:
    """Edges of the bins [J] (BINS + 1,)."""
    return 2.0 ** (LOWEST + 0.5 * np.arange(BINS + 1))


def empty_impacts(n_teams: int, n_materials: int) -> np.ndarray:
    """Spectra without impacts, int64 (n_teams, types, PARTS, BINS, 2): number, and energy in `FINE` parts of the bin's lower edge.

    Types are numbered by materials: a pair of particles ``a n_materials + b``, a particle a on a surface of material b the same
    behind all pairs.
    """
    return np.zeros((n_teams, 2 * n_materials * n_materials, PARTS, BINS, 2), np.int64)


@kernel(inline="always")
def impact_energies(m_eff, u0, u1, u2, n0, n1, n2):
    """Normal and tangential part of the kinetic energy of a relative motion [J]: ``m_eff v_n^2/2`` and ``m_eff v_t^2/2``.

    `m_eff` is the reduced mass [kg], u the relative velocity at the contact point [m/s], n the normal [1].
    """
    half = like(0.5, m_eff) * m_eff
    v_n = u0 * n0 + u1 * n1 + u2 * n2
    v_t0, v_t1, v_t2 = u0 - v_n * n0, u1 - v_n * n1, u2 - v_n * n2
    return half * v_n * v_n, half * (v_t0 * v_t0 + v_t1 * v_t1 + v_t2 * v_t2)


@kernel
def count_energy(energy, spectrum):
    """Count one `energy` [J] in a spectrum, int64 (BINS, 2)."""
    octave, upper = 0, 0
    if energy >= 2.0**LOWEST:
        mantissa, exponent = math.frexp(energy)
        octave = min(exponent - 1 - LOWEST, BINS // 2 - 1)
        # above the last bin everything is the last bin's
        upper = int((mantissa >= 0.7071067811865476) | (exponent - 1 - LOWEST > octave))
    share = energy * 2.0**-LOWEST * math.ldexp(FINE, -octave)
    spectrum[2 * octave + upper, 0] += 1
    spectrum[2 * octave + upper, 1] += int(share * (0.7071067811865476 if upper == 1 else 1.0) + 0.5)


@kernel
def note_pair_impacts(columns, begun, first, lanes, material, n_materials, impacts):
    """Count the pairs of a batch that have just met.

    Parameters
    ----------
    columns : of the batch, with rows `ENERGY_N` and `ENERGY_T`
    begun : bit b is set where the contact of lane b begins, uint32
    first : first entry of the batch in `lanes`
    lanes : as `filter_pairs` leaves them
    impacts : int64 (types, PARTS, BINS, 2)
    """
    b = 0
    while begun != 0:
        if begun & 1:
            i, j = lanes[4, first + b], lanes[1, first + b]
            # a pair across two chunks is met in both, and counted by its first particle
            if lanes[5, first + b] == 2 or i < j:
                kind = material[i] * n_materials + material[j]
                count_energy(float(columns[ENERGY_N * BATCH + b]), impacts[kind, 0])
                count_energy(float(columns[ENERGY_T * BATCH + b]), impacts[kind, 1])
        begun >>= 1
        b += 1


@kernel
def note_wall_impacts(columns, begun, first, lanes, material, material_of, n_materials, impacts):
    """As `note_pair_impacts`, for particles that have just met a surface; `material_of` (S,) are the surfaces' materials."""
    b = 0
    while begun != 0:
        if begun & 1:
            slot, s = lanes[1, first + b], lanes[2, first + b]
            kind = (n_materials + material[slot]) * n_materials + material_of[s]
            count_energy(float(columns[ENERGY_N * BATCH + b]), impacts[kind, 0])
            count_energy(float(columns[ENERGY_T * BATCH + b]), impacts[kind, 1])
        begun >>= 1
        b += 1
