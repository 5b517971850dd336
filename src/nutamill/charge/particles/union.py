"""Volume, mass centre and inertia of a union of spheres, overlaps counted once.

The solid is cut into slices across z.  In a slice it is a union of discs, whose area and moments follow from
the arcs that no other disc covers (Green's theorem, closed form).  Along z the integrand is smooth except
where the picture changes: where a sphere begins or ends, where two of them meet, where three do.  Between
these heights Gauss-Legendre quadrature on ``z = a + (b - a) sin^2(pi t/2)``, which takes the square roots at
both ends away, converges to rounding.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np

POINTS = 24
"""Quadrature points between two heights [1]; two thirds of them give the stated error."""

SLICES_AT_ONCE = 4096
"""Slices worked on together [1]; bounds the memory."""


class SolidProperties(NamedTuple):
    """Volume integrals of a solid of unit density."""

    volume: float
    """Volume [m^3]."""
    mass_centre: np.ndarray
    """Mass centre [m] (3,), in the axes of the centres."""
    inertia: np.ndarray
    """Inertia tensor about the mass centre over density [m^5] (3, 3), in the axes of the centres."""
    error: float
    """Largest relative difference of volume and inertia to a coarser quadrature [1]: a bound on their own
    error.
    """


def union_properties(centres: np.ndarray, radii: np.ndarray) -> SolidProperties:
    """Compute volume, mass centre and inertia of the union of spheres.

    Parameters
    ----------
    centres : [m] (k, 3)
    radii : [m] (k,), all positive
    """
    centres, radii = np.asarray(centres, float), np.asarray(radii, float)
    # about the middle and in units of the size, so that little is lost in differences
    middle, size = centres.mean(axis=0), float(radii.max())
    local, own = (centres - middle) / size, radii / size
    heights = _heights(local, own)
    fine, coarse = (
        _properties(_moments(local, own, heights, points)) for points in (POINTS, 2 * POINTS // 3)
    )
    error = max(
        abs(fine[0] - coarse[0]) / fine[0],
        float(np.abs(fine[2] - coarse[2]).max()) / float(np.trace(fine[2])),
    )
    return SolidProperties(fine[0] * size**3, middle + size * fine[1], fine[2] * size**5, error)


def _properties(moments: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Compute volume, mass centre and central inertia from the moments 1, x, y, z, xx, xy, yy, xz, yz, zz
    (10,).
    """
    volume, first = moments[0], moments[1:4]
    xx, xy, yy, xz, yz, zz = moments[4:]
    second = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - np.outer(first, first) / volume
    return float(volume), first / volume, np.trace(second) * np.eye(3) - second


def _heights(centres, radii) -> np.ndarray:
    """Return the heights at which a slice changes its form, rising (m,): ends of spheres and of the circles
    that two share, and points that three share.

    Points inside another sphere do not count.
    """
    up = np.array([0.0, 0.0, 1.0])
    points: list[tuple[np.ndarray, tuple[int, ...]]] = [
        (c + side * r * up, (i,))
        for i, (c, r) in enumerate(zip(centres, radii, strict=True))
        for side in (-1.0, 1.0)
    ]
    k = len(radii)
    for i, j in itertools.combinations(range(k), 2):
        points += [
            (point, (i, j)) for point in _ends_of_shared_circle(centres[i], radii[i], centres[j], radii[j])
        ]
    for three in itertools.combinations(range(k), 3):
        points += [(point, three) for point in _shared_points(centres[list(three)], radii[list(three)])]
    seen = []
    for point, own in points:
        deep = np.linalg.norm(centres - point, axis=1) < radii * (1.0 - 1e-9)
        deep[list(own)] = False
        if not deep.any():
            seen.append(point[2])
    heights = np.unique(seen)
    return heights[np.concatenate([[True], np.diff(heights) > 1e-14])]


def _ends_of_shared_circle(p, r, q, s) -> list[np.ndarray]:
    """Return the lowest and highest point (3,) of the circle in which two spheres meet, if they do."""
    gap = q - p
    d = float(np.linalg.norm(gap))
    if d == 0.0:
        return []
    along = (d * d + r * r - s * s) / (2.0 * d)
    if abs(along) >= r:
        return []
    axis = gap / d
    uphill = np.array([0.0, 0.0, 1.0]) - axis[2] * axis
    steep = float(np.linalg.norm(uphill))
    reach = math.sqrt(r * r - along * along) * uphill / steep if steep > 1e-12 else np.zeros(3)
    return [p + along * axis - reach, p + along * axis + reach]


def _shared_points(p, r) -> list[np.ndarray]:
    """Return the two points (3,) that three spheres share, if they do."""
    a, b = p[1] - p[0], p[2] - p[0]
    normal = np.cross(a, b)
    square = float(normal @ normal)
    if square < 1e-20:
        return []
    # x = p0 + u a + v b + w normal, with x.a and x.b from the differences of the three equations
    right = 0.5 * np.array([r[0] ** 2 - r[1] ** 2 + a @ a, r[0] ** 2 - r[2] ** 2 + b @ b])
    u, v = np.linalg.solve([[a @ a, a @ b], [a @ b, b @ b]], right)
    foot = u * a + v * b
    rest = r[0] ** 2 - foot @ foot
    if rest <= 0.0:
        return []
    step = math.sqrt(rest / square) * normal
    return [p[0] + foot - step, p[0] + foot + step]


def _moments(centres, radii, heights, points) -> np.ndarray:
    """Compute the moments 1, x, y, z, xx, xy, yy, xz, yz, zz of the union (10,)."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    t = 0.5 * (nodes + 1.0)
    share, pull = np.sin(0.5 * math.pi * t) ** 2, 0.25 * math.pi * np.sin(math.pi * t) * weights
    low, span = heights[:-1, None], np.diff(heights)[:, None]
    z, weight = (low + span * share).ravel(), (span * pull).ravel()
    total = np.zeros(10)
    for first in range(0, len(z), SLICES_AT_ONCE):
        part = slice(first, first + SLICES_AT_ONCE)
        zs, w = z[part], weight[part]
        area, x, y, xx, xy, yy = _slice_moments(centres, radii, zs)
        total += [q @ w for q in (area, x, y, zs * area, xx, xy, yy, zs * x, zs * y, zs * zs * area)]
    return total


def _slice_moments(centres, radii, z) -> np.ndarray:
    """Compute area and moments x, y, xx, xy, yy of the union of discs at the heights z (6, len(z))."""
    k = len(radii)
    rho = np.sqrt(np.maximum(radii**2 - (z[:, None] - centres[:, 2]) ** 2, 0.0))
    out = np.zeros((6, len(z)))
    for i in range(k):
        starts, ends = _open_arcs(centres, rho, i)
        r = rho[:, i, None]
        x, y = centres[i, :2]
        out += (_along_arc(x, y, r, ends) - _along_arc(x, y, r, starts)).sum(axis=2)
    return out


def _open_arcs(centres, rho, i) -> tuple[np.ndarray, np.ndarray]:
    """Return begin and end of the arcs of circle i outside all other discs [rad], (slices, 2 k - 1) each.

    Empty arcs have no length.
    """
    others = [j for j in range(rho.shape[1]) if j != i]
    gap = centres[others, :2] - centres[i, :2]
    d = np.hypot(gap[:, 0], gap[:, 1])
    r, s = rho[:, i, None], rho[:, others]
    with np.errstate(divide="ignore", invalid="ignore"):
        half = np.arccos(np.clip((r * r + d * d - s * s) / (2.0 * r * d), -1.0, 1.0))
    half = np.where(d >= r + s, 0.0, half)
    half = np.where(d <= np.abs(r - s), np.where(s > r, math.pi, 0.0), half)
    start = np.mod(np.arctan2(gap[:, 1], gap[:, 0]) - half, 2.0 * math.pi)
    end = start + 2.0 * half
    # covered arcs, cut in two where they pass the angle 0
    turn = 2.0 * math.pi
    begins = np.concatenate([start, np.zeros_like(start)], axis=1)
    stops = np.concatenate([np.minimum(end, turn), np.maximum(end - turn, 0.0)], axis=1)
    order = np.argsort(begins, axis=1)
    begins, stops = np.take_along_axis(begins, order, 1), np.take_along_axis(stops, order, 1)
    none = np.zeros((len(rho), 1))
    reached = np.maximum.accumulate(np.concatenate([none, stops], axis=1), axis=1)
    opened = np.concatenate([begins, none + turn], axis=1)
    return reached, np.maximum(opened, reached)


def _along_arc(cx, cy, r, t) -> np.ndarray:
    """Compute the integrals from angle 0 to t along a circle whose differences are area, x, y, xx, xy, yy of
    what it encloses (6, ...).

    Green's theorem: the integral of f over a region is that of F dy along its edge, with dF/dx = f.
    """
    s, c = np.sin(t), np.cos(t)
    s2, s4 = np.sin(2.0 * t), np.sin(4.0 * t)
    c1, c2, c3, c4 = s, t / 2 + s2 / 4, s - s**3 / 3, 3 * t / 8 + s2 / 4 + s4 / 32
    c1s1, c2s1, c3s1 = s * s / 2, -(c**3) / 3, -(c**4) / 4
    c1s2, c2s2 = s**3 / 3, t / 8 - s4 / 32
    square = cx**2 * c1 + 2 * cx * r * c2 + r**2 * c3
    return np.stack(
        [
            r * (cx * c1 + r * c2),
            r / 2 * square,
            r * (cx * cy * c1 + cx * r * c1s1 + cy * r * c2 + r**2 * c2s1),
            r / 3 * (cx**3 * c1 + 3 * cx**2 * r * c2 + 3 * cx * r**2 * c3 + r**3 * c4),
            r / 2 * (cy * square + r * (cx**2 * c1s1 + 2 * cx * r * c2s1 + r**2 * c3s1)),
            r
            * (
                cx * (cy**2 * c1 + 2 * cy * r * c1s1 + r**2 * c1s2)
                + r * (cy**2 * c2 + 2 * cy * r * c2s1 + r**2 * c2s2)
            ),
        ]
    )
