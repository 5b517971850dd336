"""A small test bench for the charge: particles, surfaces on bodies at rest or in steady motion, and a
march.
"""

import numpy as np

from nutamill.charge.assembly import charge, positions, spins, velocities
from nutamill.charge.kernels.dynamics import start, window
from nutamill.charge.kernels.team import run_team
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.measures.observe import charge_reading, observe
from nutamill.charge.walls.surface import Surface, SurfaceKind

REST = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
"""Reference frame that does not turn."""

FLOOR = Surface("floor", SurfaceKind.PLANE, 0, 0)


def law(
    k=5e5, zeta=0.0, ratio=1.0, cut=False, friction=0.0, dynamic=None, rolling=0.0, stop=0.9, a=0.0, b=0.0
):
    """A pair law with the things a test does not speak of switched off."""
    return PairLaw(
        k, a, b, ratio, zeta, cut, friction, friction if dynamic is None else dynamic, rolling, 0.1, stop
    )


def at_rest(n_bodies=1):
    """Motion of bodies at rest at the origin."""
    motions = np.zeros((n_bodies, 19))
    motions[:, 3] = 1.0
    return motions


class Bench:
    """A charge with its clock."""

    def __init__(
        self,
        positions,
        pair_laws,
        dt,
        surfaces=(),
        radius=0.0025,
        density=7863.7,
        gravity=(0.0, 0.0, 0.0),
        **options,
    ):
        positions = np.atleast_2d(np.array(positions, float))
        n = len(positions)
        laws = pair_laws if isinstance(pair_laws, dict) else {(0, 0): pair_laws}
        options.setdefault("precision", "double")
        n_bodies = options.pop("n_bodies", 1)
        materials = options.pop("materials", np.zeros(n, int))
        densities = options.pop("densities", [density] * (1 + int(max(materials))))
        for name in ("velocities", "spins"):
            if name in options:
                options[name] = np.atleast_2d(np.array(options[name], float))
        self.charge = charge(
            positions,
            np.broadcast_to(np.asarray(radius, float), (n,)),
            materials,
            densities,
            laws,
            surfaces,
            n_bodies,
            gravity=gravity,
            **options,
        )
        self.model, self.state, self.scratch = self.charge
        self.dt = dt
        self.motions = at_rest(n_bodies)
        start(*self.charge, dt)

    def march(self, n, threads=1):
        """`n` substeps in one window."""
        run_team(window, (*self.charge, self.motions, REST, n, self.dt), threads)
        assert self.state.status[0] == 0, self.state.status
        return self

    @property
    def x(self):
        return positions(self.model, self.state, self.dt)

    @property
    def v(self):
        return velocities(self.model, self.state)

    @property
    def w(self):
        return spins(self.model, self.state)

    def read(self):
        """What `observe` says now."""
        out = charge_reading()
        observe(*self.charge, out)
        return out


def sphere_mass(radius=0.0025, density=7863.7):
    return density * 4.0 / 3.0 * np.pi * radius**3
