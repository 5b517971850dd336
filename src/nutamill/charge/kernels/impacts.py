"""Collision energy spectra: the energy of each contact when it begins, counted in bins.

A contact begins in the first substep in which two bodies touch.  The velocities it meets then are those
before the impact, as none of its own forces has acted yet.  The work of loading is booked where a contact
turns (`nutamill.charge.kernels.loading`).  Counts and energies are whole numbers: they add
up to the same sum in any order, so that every thread fills its own spectra and the sum has the same bits for
any number of threads.
"""

import math

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.model import ImpactBook
from nutamill.charge.walls.patches import patch_of, whole

LOWEST = -56
"""The lowest bin begins at 2^LOWEST J = 1.4e-17 J; what is lower is counted there."""
BINS = 128
"""Bins of half an octave [1], 6.6 to a decade; the last ends at 256 J, and what is higher is counted
there.
"""
PARTS, LOADING = 3, 2
"""Parts of a contact [1]: normal and tangential energy of approach, and the last, the work of loading."""
FINE = 65536.0
"""Parts into which the lower edge of a bin is cut for its sum of energies [1]: an impact is rounded by less
than 1.6e-5 of its energy.
"""
ENERGY_N, ENERGY_T, BEGUN = 0, 1, 2
"""Rows of `columns` in which a batch leaves the two energies [J] of its lanes, and 1 where a contact that
counts has just begun, else 0: free once the distance has been used."""


def bin_edges() -> np.ndarray:
    """Return the edges of the bins [J] (BINS + 1,)."""
    return 2.0 ** (LOWEST + 0.5 * np.arange(BINS + 1))


def impact_book(n_threads: int, n_materials: int, n_patches: int) -> ImpactBook:
    """Return a book without impacts."""
    spectra = np.zeros((n_threads, 2 * n_materials * n_materials, PARTS, BINS, 2), np.int64)
    return ImpactBook(np.ones(1, np.int64), spectra, np.zeros((n_threads, n_patches), np.int64))


@kernel(inline="always")
def impact_energies(m_eff, u0, u1, u2, n0, n1, n2):
    """Return normal and tangential part of the kinetic energy of a relative motion [J]: ``m_eff v_n^2/2`` and
    ``m_eff v_t^2/2``.

    `m_eff` is the reduced mass [kg], u the relative velocity at the contact point [m/s], n the normal [1].
    """
    half = like(0.5, m_eff) * m_eff
    v_n = u0 * n0 + u1 * n1 + u2 * n2
    v_t0, v_t1, v_t2 = u0 - v_n * n0, u1 - v_n * n1, u2 - v_n * n2
    return half * v_n * v_n, half * (v_t0 * v_t0 + v_t1 * v_t1 + v_t2 * v_t2)


@kernel
def count_energy(energy, times, spectrum_out):
    """Count one `energy` [J] so many `times` in a spectrum, int64 (BINS, 2): 1, or -1 to take it back."""
    octave, upper = 0, 0
    if energy >= 2.0**LOWEST:
        mantissa, exponent = math.frexp(energy)
        octave = min(exponent - 1 - LOWEST, BINS // 2 - 1)
        # above the last bin everything is the last bin's
        upper = int((mantissa >= 0.7071067811865476) | (exponent - 1 - LOWEST > octave))
    share = energy * 2.0**-LOWEST * math.ldexp(FINE, -octave)
    share *= 0.7071067811865476 if upper == 1 else 1.0
    spectrum_out[2 * octave + upper, 0] += times
    spectrum_out[2 * octave + upper, 1] += times * int(share + 0.5)


@kernel
def cutting_energy(normal, tangential):
    """Return the share of an impact's energy that cuts a ductile wall [J]: ``E f(angle)`` with the angle of
    impact ``tan a = sqrt(E_n/E_t)``.

    ``f = sin 2a - 3 sin^2 a`` for ``tan a <= 1/3``, else ``cos^2 a / 3``.  Divided by twice the flow pressure
    of the wall [Pa] it is the volume [m^3] that the impact removes.

    Parameters
    ----------
    normal, tangential : energies E_n and E_t of the impact [J]

    Source
    ------
    I. Finnie, "Erosion of surfaces by solid particles", Wear 3 (1960), with a chip twice as long as deep.
    """
    if 9.0 * normal <= tangential:
        return 2.0 * math.sqrt(normal * tangential) - 3.0 * normal
    return tangential / 3.0


@kernel
def note_pair_impacts(columns, lanes, material, first, across, n_materials, tid, book_out):
    """Book the pairs of a batch that touch for the first time.

    Parameters
    ----------
    columns : of the batch, with rows `ENERGY_N`, `ENERGY_T` and `BEGUN`
    lanes : as from `filter_pairs`
    material : of each slot
    first : first entry of the batch in `lanes`
    across : row 3 of `lanes` for a pair across two chunks
    n_materials : number of materials
    tid : number of this thread, whose page is used
    book_out : `ImpactBook`
    """
    for b in range(BATCH):
        if columns[BEGUN * BATCH + b] > 0.0:
            i, j = lanes[4, first + b], lanes[1, first + b]
            # a pair across two chunks is met in both, and counted by its first particle
            if lanes[3, first + b] != across or i < j:
                spectra = book_out.spectra[tid, material[i] * n_materials + material[j]]
                count_energy(float(columns[ENERGY_N * BATCH + b]), 1, spectra[0])
                count_energy(float(columns[ENERGY_T * BATCH + b]), 1, spectra[1])


@kernel
def note_wall_impacts(
    model, columns, lanes, measured, x, radius, material, surface_poses, first, tid, book_out
):
    """Book the wall contacts of a batch that begin, as `note_pair_impacts`. `lanes` and `measured` are those
    of `find_walls`.
    """
    n_materials = model.law_of.shape[0]
    for b in range(BATCH):
        if columns[BEGUN * BATCH + b] > 0.0:
            q = first + b
            slot, s = lanes[1, q], lanes[2, q]
            normal, tangential = float(columns[ENERGY_N * BATCH + b]), float(columns[ENERGY_T * BATCH + b])
            spectra = book_out.spectra[
                tid, (n_materials + material[slot]) * n_materials + model.surface_material[s]
            ]
            count_energy(normal, 1, spectra[0])
            count_energy(tangential, 1, spectra[1])
            arm = radius[slot] - 0.5 * float(measured[3, q])
            p = patch_of(
                model.patches,
                surface_poses[s],
                model.surface_size[s],
                s,
                x[0, slot] + arm * float(measured[0, q]),
                x[1, slot] + arm * float(measured[1, q]),
                x[2, slot] + arm * float(measured[2, q]),
            )
            book_out.cut[tid, p] += whole(cutting_energy(normal, tangential), model.per_cut)
