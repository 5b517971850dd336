"""A charge of spheres with the defaults of the tests, and a pair law with most effects off."""

import numpy as np

from nutamill.charge.face import Charge
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.particles.particles import spheres
from nutamill.charge.walls.surface import Surface, SurfaceKind

FLOOR = Surface("floor", SurfaceKind.PLANE, 0, 0)


def law(
    k=5e5, zeta=0.0, ratio=1.0, cut=False, friction=0.0, dynamic=None, rolling=0.0, stop=0.9, a=0.0, b=0.0
):
    """A pair law with every effect off that is not given."""
    return PairLaw(
        k, a, b, ratio, zeta, cut, friction, friction if dynamic is None else dynamic, rolling, 0.1, stop
    )


class Bench(Charge):
    """A charge of spheres without gravity, in double precision, of one material by default."""

    def __init__(
        self,
        positions,
        pair_laws,
        dt,
        surfaces=(),
        radius=0.0025,
        density=7863.7,
        gravity=(0.0, 0.0, 0.0),
        materials=0,
        densities=None,
        precision="double",
        **options,
    ):
        positions = np.atleast_2d(np.array(positions, float))
        diameters = np.broadcast_to(2.0 * np.asarray(radius, float), (len(positions),))
        densities = [density] * (1 + int(np.max(materials))) if densities is None else densities
        for name in ("velocities", "spins"):
            if name in options:
                options[name] = np.atleast_2d(np.array(options[name], float))
        placed = spheres(diameters, materials).placed(positions)
        super().__init__(
            placed, densities, pair_laws, surfaces, dt=dt, gravity=gravity, precision=precision, **options
        )


def sphere_mass(radius=0.0025, density=7863.7):
    return density * 4.0 / 3.0 * np.pi * radius**3
