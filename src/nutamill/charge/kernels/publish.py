"""Fixed-point positions: what the pair law sees of the master state.

Differences of fixed-point positions are exact, so that the law may run in single precision: with 32 bits over
half a metre a unit is about 1e-10 m, where a float32 position would be wrong by 3e-8 m, or 0.01 N at 5e5 N/m.
"""

import math

from nutamill.base.kernel import kernel


@kernel(inline="always")
def fixed_point(distance, scale):
    """Nearest fixed-point number to `distance` [m], `scale` units in a metre [1/m]."""
    return math.floor(distance * scale + 0.5)


@kernel
def publish(model, state, i):
    """Publish position and radius of slot `i` in the current buffer."""
    points = state.points[state.clock[1]]
    for k in range(3):
        points[i, k] = fixed_point(state.x[k, i] - model.centre[k], model.scale)
    points[i, 3] = fixed_point(state.body[0, i], model.scale)
