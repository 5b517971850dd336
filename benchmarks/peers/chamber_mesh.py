"""The chamber as triangles, for engines that know no cylinder."""

from itertools import pairwise

import numpy as np

AROUND = 128
"""Flat faces of the bore [1]: the charge rushes along it, and an edge of few and large faces kicks every
sphere that passes.
"""

ALONG = 4
"""Bands of triangles from floor to ceiling [1]."""

RINGS = (0.75, 0.5, 0.25)
"""Rings of corners in floor and ceiling, share of the radius [1]."""


def chamber_triangles(bore: float, floor: float, ceiling: float) -> np.ndarray:
    """Corners [m] (n, 3, 3) of bore, floor and ceiling, chamber axes; the mean distance of the bore's faces
    is its radius.
    """
    outer = bore / (1 - np.pi**2 / AROUND**2 / 3)
    heights = np.linspace(floor, ceiling, ALONG + 1)
    walls = [band(ring(outer, AROUND, low), ring(outer, AROUND, high)) for low, high in pairwise(heights)]
    ends = []
    for height in (floor, ceiling):
        circles = [ring(outer * share, AROUND // 2, height) for share in RINGS]
        edge = ring(outer, AROUND, height)
        ends.append(halved(edge, circles[0]))
        ends += [band(a, b) for a, b in pairwise(circles)]
        inmost, centre = circles[-1], np.array([0.0, 0.0, height])
        ends.append(np.array([[inmost[k - 1], inmost[k], centre] for k in range(len(inmost))]))
    return np.vstack(walls + ends)


def ring(radius: float, n: int, height: float) -> np.ndarray:
    """Corners of a regular polygon [m] (n, 3) about the axis."""
    angle = 2 * np.pi * np.arange(n) / n
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(n, height)])


def band(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Triangles between two rings of as many corners."""
    c, d = np.roll(a, -1, axis=0), np.roll(b, -1, axis=0)
    return np.concatenate([np.stack([a, c, b], axis=1), np.stack([c, d, b], axis=1)])


def halved(outer: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """Triangles between a ring and one of half as many corners."""
    a, b, c, d, e = (
        outer[::2],
        outer[1::2],
        np.roll(outer[::2], -1, axis=0),
        inner,
        np.roll(inner, -1, axis=0),
    )
    return np.concatenate([np.stack(corners, axis=1) for corners in ((a, b, d), (b, e, d), (b, c, e))])
