"""A charge driven directly: particles, walls at rest or in steady motion, and impacts followed from touch to
release.
"""

import math
from typing import NamedTuple

import numpy as np

from nutamill.charge.face import Charge
from nutamill.charge.laws.composition import contact_law
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.particles.particles import spheres
from nutamill.charge.walls.surface import Surface, SurfaceKind

G = 9.81
DOWN = (0.0, 0.0, -G)
FLOOR = Surface("floor", SurfaceKind.PLANE, 0, 0)
SAMPLES = 400
"""Substeps in the contact time of a followed impact [1]."""


def pair(
    k=0.0,
    zeta=0.0,
    ratio=1.0,
    cut=False,
    friction=0.0,
    rolling=0.0,
    unloading=1.0,
    modulus=0.0,
    shear_modulus=0.0,
    stop=0.9,
    tangential_damping=0.0,
) -> PairLaw:
    """Numbers of a contact with the things a case does not speak of switched off.

    Parameters
    ----------
    k : stiffness [N/m] of the linear laws; modulus, shear_modulus : E* and G* [Pa] of Hertz and Mindlin
    zeta : damping ratio [1]; ratio : tangential stiffness over that of the normal law, or over Mindlin's [1]
    cut : no tension on release; friction, rolling : coefficients [1]; unloading : stiffness over that of
        loading [1]
    stop : overlap at which the march stops [diameter]; tangential_damping : tangential dashpot over
        ``2 sqrt(m* k_t)`` [1]
    """
    return PairLaw(
        stiffness_direct=k,
        stiffness_per_diameter_a=0.0,
        stiffness_per_diameter_b=0.0,
        tangential_ratio=ratio,
        damping_ratio=zeta,
        tension_cut=cut,
        static_friction=friction,
        dynamic_friction=friction,
        rolling_friction=rolling,
        overlap_warn=stop / 2,
        overlap_stop=stop,
        unloading_ratio=unloading,
        contact_modulus=modulus,
        contact_shear_modulus=shear_modulus or modulus,
        tangential_damping=tangential_damping,
    )


def sphere_mass(radius: float, density: float) -> float:
    """Mass of a sphere [kg]."""
    return 4.0 / 3.0 * math.pi * radius**3 * density


class Bench(Charge):
    """A charge of spheres with the defaults of the validation cases.

    Parameters
    ----------
    places : [m] (n, 3)
    pairs : numbers of the contact, or of each pair of materials
    dt : substep [s]
    radius : of all, or of each [m]
    densities : by material [kg/m^3]
    law : names of the normal, tangential and rolling law
    materials : of all, or of each
    options : as `nutamill.charge.face.Charge`
    """

    def __init__(
        self,
        places,
        pairs,
        dt,
        surfaces=(),
        radius=0.0025,
        densities=(2500.0,),
        law=("linear", "displacement", "none"),
        gravity=(0.0, 0.0, 0.0),
        materials=0,
        precision="double",
        **options,
    ):
        places = np.atleast_2d(np.array(places, float))
        n = len(places)
        for name in ("velocities", "spins"):
            if name in options:
                options[name] = np.broadcast_to(np.array(options[name], float), (n, 3))
        placed = spheres(np.broadcast_to(2.0 * np.asarray(radius, float), (n,)), materials).placed(places)
        super().__init__(
            placed,
            densities,
            pairs,
            surfaces,
            dt=dt,
            law=contact_law(*law),
            gravity=gravity,
            precision=precision,
            **options,
        )


class Impact(NamedTuple):
    """What came of an impact."""

    v: np.ndarray
    """Velocities afterwards [m/s] (n, 3)."""
    w: np.ndarray
    """Spins afterwards [rad/s] (n, 3)."""
    force: float
    """Largest normal force [N]."""
    overlap: float
    """Largest overlap [m]."""
    time: float
    """Time with a normal force [s]."""
    curve: np.ndarray
    """Normal force [N] and overlap [m] in each substep with a force (n, 2)."""


def follow(bench: Bench, along, mass: float, radii: float, limit: int) -> Impact:
    """March until the particles have touched and parted.

    Parameters
    ----------
    along : direction [1] (3,) in which particle 0 approaches; particle 1 or a wall through the origin stands
        in the way
    mass : of particle 0 [kg]
    radii : sum of the radii [m], of the particle's alone for a wall
    limit : substeps after which the contact must have ended
    """
    along = np.array(along)
    curve, before = [], bench.velocities[0]
    for _ in range(limit):
        x, ids = bench.state.x, list(bench.state.ids)
        other = x[:, ids.index(1)] if len(bench.positions) == 2 else np.zeros(3)
        overlap = radii - (other - x[:, ids.index(0)]) @ along
        now = bench.step(1).velocities[0]
        if overlap > 0.0:
            curve.append((-mass * (now - before) @ along / bench.dt, overlap))
        elif curve:
            break
        before = now
    curve = np.array(curve)
    pressed = np.flatnonzero(np.abs(curve[:, 0]) > 1e-12 * np.abs(curve[:, 0]).max())
    duration = (pressed[-1] - pressed[0] + 1) * bench.dt
    return Impact(bench.velocities, bench.spins, curve[:, 0].max(), curve[:, 1].max(), duration, curve)


def strike_floor(
    radius, density, numbers, contact_time, v_n, v_t=0.0, spin=0.0, law=("linear", "displacement", "none")
) -> Impact:
    """A sphere strikes the floor at `v_n` [m/s], with `v_t` [m/s] along x and `spin` [rad/s] about y
    (positive: rolling along x).
    """
    dt = contact_time / SAMPLES
    bench = Bench(
        [0, 0, radius + 3.3 * dt * v_n],
        numbers,
        dt,
        [FLOOR],
        radius,
        (density,),
        law,
        velocities=[v_t, 0, -v_n],
        spins=[0, spin, 0],
    )
    return follow(bench, (0, 0, -1), sphere_mass(radius, density), radius, 4 * SAMPLES)
