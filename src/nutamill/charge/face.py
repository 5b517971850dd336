"""A charge by itself: particles, walls and contact laws, marched from a script, a notebook or a test.

import nutamill as nm
ball = nm.spheres([0.01]).placed([[0.0, 0.0, 0.1]])
steel = nm.linear_pair(stiffness=1e5, restitution=0.8, friction=0.3)
charge = nm.Charge(ball, [7850.0], steel, [nm.plane("floor")], dt=2e-6)
charge.march(0.2)
print(charge.positions, charge.wrenches)
"""

import math
import warnings
from collections.abc import Mapping, Sequence
from typing import Self

import numpy as np

from nutamill.base.errors import CaseError, Fault, StepError
from nutamill.base.frames import MOTION_SIZE, pose_in_window, twist_in_window
from nutamill.base.light_carriers import carrier_faults, carrier_warnings
from nutamill.charge.arrays import grow
from nutamill.charge.assembly import charge_of
from nutamill.charge.kernels.dynamics import start, window
from nutamill.charge.kernels.team import MOST_THREADS, run_team
from nutamill.charge.laws.composition import STANDARD_LAW, ContactLaw
from nutamill.charge.laws.oscillator import damping_ratio_from_restitution
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.measures.observe import ChargeReading, charge_reading, observe
from nutamill.charge.messages import status_text, status_time
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, Clock, Status
from nutamill.charge.particles.particles import Particles
from nutamill.charge.pushed_carriers import pushed_carriers
from nutamill.charge.readout import attitudes, positions, spins, velocities
from nutamill.charge.walls.patches import PatchTable
from nutamill.charge.walls.surface import Surface

ENERGIES = (
    "translation",
    "rotation",
    "pair_normal",
    "pair_tangential",
    "pair_rolling",
    "wall_normal",
    "wall_tangential",
    "wall_rolling",
)
"""Names of the energies of a charge: kinetic, and stored in the springs of its contacts."""

FIXED_FRAME = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
"""Reference of the neighbour list that does not turn."""

SUBSTEPS_AT_ONCE = 10_000
"""Most substeps in one compiled call [1], so that an interrupt is answered."""


def at_rest(carriers: int = 1) -> np.ndarray:
    """Return the motion (carriers, 19) of bodies at rest with their mass centres at the origin."""
    motion = np.zeros((carriers, MOTION_SIZE))
    motion[:, 3] = 1.0
    return motion


def linear_pair(
    stiffness: float,
    restitution: float = 1.0,
    friction: float = 0.0,
    rolling_friction: float = 0.0,
    tangential_ratio: float = 1.0,
    overlap_stop: float = 0.5,
) -> PairLaw:
    """Return the contact of two materials as a spring, a dashpot and friction, for the standard law.

    Parameters
    ----------
    stiffness : of the normal spring [N/m]
    restitution : speed of separation over speed of approach, head-on [1]
    friction, rolling_friction : coefficients [1]
    tangential_ratio : tangential over normal stiffness [1]
    overlap_stop : overlap at which a march stops [diameter]
    """
    return PairLaw(
        stiffness_direct=stiffness,
        stiffness_per_diameter_a=0.0,
        stiffness_per_diameter_b=0.0,
        tangential_ratio=tangential_ratio,
        damping_ratio=damping_ratio_from_restitution(restitution, False),
        tension_cut=False,
        static_friction=friction,
        dynamic_friction=friction,
        rolling_friction=rolling_friction,
        overlap_warn=overlap_stop / 2,
        overlap_stop=overlap_stop,
    )


class Charge:
    """Particles among walls, and the march of both through time.

    Walls are carried by bodies whose motion is given: at rest, or given by `motion`.  Neighbour lists grow as
    they must.

    Parameters
    ----------
    particles : spheres or clumps, placed, in world axes
    materials : density of each material [kg/m^3]
    pairs : contact of each pair of materials (a, b), or the one contact of all
    walls : wall pieces, each carried by a body
    dt : substep [s]; a twentieth of the shortest contact is usual
    law : law of all contacts
    gravity : [m/s^2] (3,), world axes
    motion : motion of each carrier (n_carriers, 19), see `nutamill.base.frames.MOTION_SIZE`; at rest with
        their mass centres at the origin if None
    velocities, spins : of the particles [m/s], [rad/s] (n, 3), world axes; zero if None
    threads : size of the team that marches; it changes no bit of the result
    precision : "single", or "double" for verification
    skin, domain, patches : as `nutamill.charge.assembly.charge`
    carrier_masses : least effective mass of each carrier at its walls [kg] (n_carriers,), infinite where its
        motion is given (`nutamill.System.effective_mass`); None where no carrier follows the charge's push.
        A march then counts as a window in which the motion is held: a carrier that is light, or a window that
        is long for it, gives a warning, and one that is unstable is refused

    Attributes
    ----------
    dt, threads : as above
    motion : motion of each carrier at the present time (n_carriers, 19); a change of it holds from now on
    model, state, scratch : the arrays of the engine; new ones after the lists have grown

    Raises
    ------
    CaseError : every fault of particles, contacts, walls, step and team
    """

    def __init__(
        self,
        particles: Particles,
        materials: Sequence[float],
        pairs: PairLaw | Mapping[tuple[int, int], PairLaw],
        walls: Sequence[Surface] = (),
        *,
        dt: float,
        law: ContactLaw = STANDARD_LAW,
        gravity: Sequence[float] = (0.0, 0.0, -9.81),
        motion: np.ndarray | None = None,
        velocities: np.ndarray | None = None,
        spins: np.ndarray | None = None,
        threads: int = 1,
        precision: str = "single",
        skin: float | None = None,
        domain: tuple[Sequence[float], float] | None = None,
        patches: PatchTable | None = None,
        carrier_masses: Sequence[float] | None = None,
    ) -> None:
        if motion is None:
            motion = at_rest(1 + max((wall.body for wall in walls), default=0))
        motion = np.array(motion, float)
        faults = _march_faults(dt, threads, motion, carrier_masses)
        if faults:
            raise CaseError(*faults)
        if isinstance(pairs, PairLaw):
            numbers = range(len(materials))
            pairs = {(a, b): pairs for a in numbers for b in numbers if a <= b}
        parts = charge_of(
            particles,
            materials,
            pairs,
            walls,
            len(motion),
            velocities,
            spins,
            gravity=gravity,
            law=law,
            skin=skin,
            precision=precision,
            domain=domain,
            poses=motion[:, :7],
            patches=patches,
        )
        start(*parts, dt)
        self._take(parts, dt, motion, threads, [wall.name for wall in walls])
        self._carrier_masses = carrier_masses

    @classmethod
    def from_parts(
        cls,
        model: ChargeModel,
        state: ChargeState,
        scratch: ChargeScratch,
        dt: float,
        motion: np.ndarray,
        threads: int = 1,
        walls: Sequence[str] = (),
    ) -> Self:
        """Return a charge around started arrays of the engine.

        Parameters
        ----------
        model, state, scratch : after `nutamill.charge.kernels.dynamics.start`
        dt, motion, threads : as above
        walls : names of the wall pieces, for messages; their numbers are used where there are none
        """
        charge = cls.__new__(cls)
        charge._take((model, state, scratch), dt, np.array(motion, float), threads, walls)
        return charge

    def _take(self, parts, dt, motion, threads, walls) -> None:
        self.model, self.state, self.scratch = parts
        self.dt, self.motion, self.threads = dt, motion, threads
        self._walls = list(walls)
        self._carrier_masses = None
        self._impulse = np.zeros((len(motion), 6))
        self._marched = 0.0

    @property
    def parts(self) -> tuple[ChargeModel, ChargeState, ChargeScratch]:
        """Model, state and scratch, as the kernels take them."""
        return self.model, self.state, self.scratch

    def march(self, time: float, motion: np.ndarray | None = None) -> Self:
        """March for a `time` [s], rounded to whole substeps.

        Parameters
        ----------
        motion : motion of each carrier from now on (n_carriers, 19); as before if None

        Raises
        ------
        StepError : an overlap beyond its limit, or a particle that left the domain
        CaseError : a carrier that is too light for a march of this length
        """
        self._check_carriers(time)
        if motion is not None:
            self.motion = np.array(motion, float).reshape(self.motion.shape)
        return self.step(round(time / self.dt))

    def _check_carriers(self, time: float) -> None:
        """Check the masses of the carriers: warn where one is light, or a window of `time` [s] long for it.

        Raises
        ------
        CaseError : a carrier that is unstable in such a window
        """
        if self._carrier_masses is None:
            return
        carriers = pushed_carriers(self.model, self.state, self._carrier_masses)
        faults = [fault for carrier in carriers for fault in carrier_faults(carrier, time)]
        if faults:
            raise CaseError(*faults)
        for carrier in carriers:
            for warning in carrier_warnings(carrier, time):
                warnings.warn(str(warning), stacklevel=3)

    def step(self, substeps: int = 1) -> Self:
        """March for a number of substeps. Raises as `march`."""
        self._impulse[:] = 0.0
        for first in range(0, substeps, SUBSTEPS_AT_ONCE):
            n = min(SUBSTEPS_AT_ONCE, substeps - first)
            self._window(n)
            self._impulse += self.state.impulse
            self._move_carriers(n * self.dt)
        self._marched = substeps * self.dt
        return self

    def _window(self, substeps: int) -> None:
        """March one window, with larger lists where they are full."""
        full = True
        while full:
            run_team(window, (*self.parts, self.motion, FIXED_FRAME, substeps, self.dt), self.threads)
            full = self.state.status[0] == Status.LISTS_FULL
            if full or self.state.clock[Clock.CROWDED]:
                self.model, self.state, self.scratch = grow(*self.parts)
        if self.state.status[0] != Status.OK:
            raise StepError(
                f"t = {status_time(self.state, self.dt):.6g} s: {status_text(self.state, self._walls)}. "
                f"The substep is {self.dt:.3g} s. Shorten it or stiffen the contacts."
            )

    def _move_carriers(self, time: float) -> None:
        """Bring the motion of the carriers that move to the end of a window."""
        for b in np.flatnonzero(self.motion[:, 7:].any(axis=1)):
            begin = self.motion[b].copy()
            pose_in_window(begin, time, self.motion[b, :3], self.motion[b, 3:7])
            twist_in_window(begin, time, self.motion[b, 7:10], self.motion[b, 10:13])

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return int(self.state.clock[Clock.STEP]) * self.dt

    @property
    def positions(self) -> np.ndarray:
        """Mass centres of the particles [m] (n, 3), world."""
        return positions(self.model, self.state, self.dt)

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of the particles [m/s] (n, 3), world axes."""
        return velocities(self.model, self.state)

    @property
    def spins(self) -> np.ndarray:
        """Spins of the particles [rad/s] (n, 3), world axes."""
        return spins(self.model, self.state)

    @property
    def attitudes(self) -> np.ndarray | None:
        """Quaternions (n, 4) from the axes of each clump to world axes, or None for spheres."""
        return attitudes(self.model, self.state)

    @property
    def impulses(self) -> np.ndarray:
        """Impulse [N s] and angular impulse [N m s] of the charge on each carrier in the last march
        (n_carriers, 6), about its moving mass centre, world axes.
        """
        return self._impulse.copy()

    @property
    def wrenches(self) -> np.ndarray:
        """Mean force [N] and moment [N m] of the charge on each carrier over the last march (n_carriers, 6),
        about its mass centre, world axes, zero before the first.
        """
        return self._impulse / self._marched if self._marched > 0.0 else self._impulse.copy()

    @property
    def energies(self) -> dict[str, float]:
        """Kinetic energies and energies stored in the contacts [J], by the names of `ENERGIES`."""
        return dict(zip(ENERGIES, self.reading().energy.tolist(), strict=True))

    @property
    def contacts(self) -> tuple[int, int]:
        """Number of contacts between particles, and of particles with walls [1]."""
        pairs, walls = self.reading().contacts
        return round(float(pairs)), round(float(walls))

    @property
    def largest_overlap(self) -> np.ndarray:
        """Largest overlap so far of pairs and of walls [diameter] (2,)."""
        return self.state.largest_overlap[:2]

    def reading(self) -> ChargeReading:
        """Return energies, contacts, mass centre and momentum at the present time."""
        out = charge_reading()
        observe(*self.parts, out, 0, 1)
        return out


def _march_faults(dt: float, threads: int, motion: np.ndarray, masses: Sequence[float] | None) -> list[Fault]:
    """Return what is wrong with the step, the team, the motion of the carriers and their masses."""
    faults = []
    if not (math.isfinite(dt) and dt > 0.0):
        faults.append(Fault("dt", f"must be positive, got {dt} s"))
    if not 1 <= threads <= MOST_THREADS:
        faults.append(Fault("threads", f"must be from 1 to {MOST_THREADS}, got {threads}"))
    if motion.ndim != 2 or motion.shape[1] != MOTION_SIZE or len(motion) == 0:
        faults.append(Fault("motion", f"must have shape (n_carriers, {MOTION_SIZE}), got {motion.shape}"))
    elif not np.isfinite(motion).all():
        faults.append(Fault("motion", "must be finite"))
    if masses is not None and not (len(masses) == len(motion) and all(mass > 0.0 for mass in masses)):
        faults.append(Fault("carrier_masses", f"must be a positive mass for each carrier, got {masses}"))
    return faults
