"""A charge at rest in the chamber loads the mechanism as a rigid body of its mass, centre and inertia
does.
"""

import math

import numpy as np
from mill_bench import SMOOTH, march_mill, mill, whole_turns

from nutamill.case.rigid_parts import whole_chamber
from nutamill.simulation.setup.clock import run_clock

BORE, D, DENSITY = 0.070, 0.046672, 7863.7
ACRYLIC, STEEL, SOFTENING = 3.2e9, 200e9, 0.1
TURNS = 6
"""Turns that are compared [1]."""
RPM = 200
"""Slow enough that gravity holds the spheres on the floor: the rim of the floor falls at most with 3
m/s^2.
"""


def wedged_ring():
    """Seven spheres of 5 um more than a third of the bore: one in the middle, six around, squeezed by the
    wall, in balance.
    """
    # wall against the middle sphere and, at 60 degrees, two neighbours
    at_wall, at_sphere = SOFTENING * D / (1 / ACRYLIC + 1 / STEEL), SOFTENING * STEEL * D / 2
    ring = (2 * at_sphere * D + at_wall * (BORE - D / 2)) / (2 * at_sphere + at_wall)
    turn = np.arange(6) * math.pi / 3
    x = np.concatenate([[[0.0, 0.0]], ring * np.column_stack([np.cos(turn), np.sin(turn)])])
    return np.column_stack([x, np.full(7, D / 2 - 0.350)])


def test_wedged_spheres_load_the_crank_as_a_rigid_body_of_their_mass_centre_and_inertia():
    # Seven spheres wedged in the bore cannot move in the chamber. The same mill with chamber and charge as
    # one rigid body: mass, centre, and inertias about the nutation point are sums. Contacts give by a/w0^2,
    # w0^2 = k/m: a share (w/w0)^2 of the charge's force, harmonic in w and 2 w, in each of the two contacts
    # in series; and both runs take the same windows, with reactions of second order, (w dt)^2. Friction's
    # springs have no dashpot: the spheres go on ringing from the start, lift off the floor and come back, at
    # all frequencies. So mean and first harmonics of turns are compared, and the scatter between the turns
    # says what of the ringing is left in their mean: four standard errors.
    mass = DENSITY * math.pi / 6 * D**3
    bed = wedged_ring()
    options = [
        "mechanism.mounting=rigid",
        *SMOOTH,
        f"drive.speed={RPM} rpm",
        "drive.ramp=1000 rpm/s",
        "run.threads=1",
        f"contact.softening={SOFTENING}",
    ]
    stuck = [
        f"charge.diameter={D * 1e3} mm",
        f"charge.mass={6.9 * mass} kg",
        "contact.pairs.steel-acrylic.sliding_friction=1",
        "contact.pairs.steel-steel.sliding_friction=1",
    ]
    case = mill(*options, *stuck)
    assert len(bed) == 7
    speed = RPM * 2 * math.pi / 60
    until = RPM / 1000 + (TURNS + 0.2) * 60 / RPM
    from_mass_centre = bed - whole_chamber(case.chamber).mass_centre
    held = whole_turns(march_mill(case, until, from_mass_centre), speed, TURNS)
    empty = case.chamber
    total = empty.mass + 7 * mass
    depth = (empty.mass * empty.mass_centre_depth - mass * bed[:, 2].sum()) / total
    own = 7 * 0.1 * mass * D**2
    transverse = empty.inertia_transverse + mass * (bed[:, 0] ** 2 + bed[:, 2] ** 2).sum() + own
    axial = empty.inertia_axial + mass * (bed[:, 0] ** 2 + bed[:, 1] ** 2).sum() + own
    rigid = mill(
        *options, "charge.kind=none", f"chamber.mass={total} kg", f"chamber.mass_centre_depth={depth} m",
        f"chamber.inertia_transverse={transverse} kg m^2", f"chamber.inertia_axial={axial} kg m^2",
    )  # fmt: skip
    body = whole_turns(march_mill(rigid, until), speed, TURNS)
    without = whole_turns(march_mill(mill(*options, "charge.kind=none"), until), speed, TURNS)
    # the softest spring is that of a sphere at the acrylic wall
    k = SOFTENING * D / (1 / ACRYLIC + 1 / STEEL)
    share = 2 * (2 * speed) ** 2 * mass / k
    charge_force = np.abs(body["crank_pin_force_radial"] - without["crank_pin_force_radial"])
    # the seven weigh half as much as the chamber, and are felt: 32 N of 87 N
    assert charge_force.min() > 30.0
    for name in ("crank_pin_force_radial", "crank_pin_force_tangential"):
        scheme = (speed * run_clock(case.machine).window) ** 2 * np.abs(body[name]).max()
        turns = (held[name] - body[name]).reshape(TURNS, -1)
        harmonics = np.fft.rfft(turns)[:, :6] / turns.shape[1]
        ringing = harmonics.std(axis=0, ddof=1) / math.sqrt(TURNS)
        allowed = share * charge_force.max() + scheme + 4 * ringing
        assert (np.abs(harmonics.mean(axis=0)) < allowed).all(), name
