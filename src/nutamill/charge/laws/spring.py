"""A spring in the tangent plane of a contact with a limit: friction and rolling type C use it.

The stored vector belongs to the end of the last substep.  It is projected onto the present tangent plane,
grows by half a substep's motion, pulls, and grows by the other half: the trapezoidal rule.
"""

import math

from nutamill.base.frames import add3, dot3, scale3, sub3
from nutamill.base.kernel import kernel, like

LEAST_LENGTH = 1e-12
"""Length of a tangential spring that counts as nothing, over the reduced radius [1]."""
LEAST_ANGLE = 1e-18
"""Angle of rolling that counts as nothing [rad]."""


@kernel(inline="always")
def tangent_spring(stored, half, n):
    """Return the stored vector in the tangent plane, in the middle of the substep (3).

    Parameters
    ----------
    stored : (3), world axes: length [m], angle [rad], or force [N]
    half : its growth in half a substep (3), same unit
    n : contact normal [1] (3)
    """
    return add3(stored, sub3(half, scale3(dot3(stored, n), n)))


@kernel(inline="always")
def share_at_limit(limit, k, square, least):
    """Return the share of a spring that pulls with `limit` [1].  `k` is its stiffness, `square` the square of
    its length, and `least` a length that counts as nothing.
    """
    # the root is only wanted as a divisor: an estimate refined takes the place of root and division, and is
    # infinite where a single-precision square is below 1e-38
    return limit / (k * math.sqrt(square + least * least))


@kernel(inline="always")
def spring_with_limit(stored, half, n, k, holds, slides, least):
    """Return a spring with Coulomb's limit in the middle of a substep (3), and 1 where it was beyond the
    limit, else 0.

    A spring with ``|k spring| > holds`` is shortened to ``|k spring| = slides``.

    Parameters
    ----------
    stored, half, n : as `tangent_spring`
    k : stiffness [N/m]; 1 where the force is stored
    holds, slides : largest pull before and while sliding [N]
    least : length that counts as nothing, unit of `stored`
    """
    spring = tangent_spring(stored, half, n)
    square = dot3(spring, spring)
    beyond = k * k * square > holds * holds
    scale = share_at_limit(slides, k, square, least) if beyond else like(1.0, k)
    spring = scale3(scale, spring)
    # beside the other choice, not in the caller: only so the compiler makes one choice of the two
    at_limit = like(1.0, k) if beyond else like(0.0, k)
    return spring, at_limit
