"""Fixed-point positions: what the pair law sees of the positions of the state.

Differences of fixed-point positions are exact, so that the law may run in single precision: with 32 bits over
half a metre a unit is about 1e-10 m, where a float32 position would be wrong by 3e-8 m, or 0.01 N at 5e5 N/m.
"""

import math

from nutamill.base.kernel import kernel
from nutamill.charge.model import Clock

PUBLISHED = int(Clock.PUBLISHED)


@kernel(inline="always")
def fixed_point(distance, scale):
    """Return the nearest fixed-point number to `distance` [m], `scale` units in a metre [1/m]."""
    return math.floor(distance * scale + 0.5)


@kernel
def publish(model, state, i):
    """Publish position and radius of slot `i` in the current buffer, and half the reach of the film with the
    radius: the pairs that touch then include those with a film between them.
    """
    points = state.published_points[state.clock[PUBLISHED]]
    for k in range(3):
        points[i, k] = fixed_point(state.x[k, i] - model.centre[k], model.scale)
    points[i, 3] = fixed_point(state.mass_props[0, i] + 0.5 * model.film_reach, model.scale)
