"""This package: it makes the states that all engines start from, and runs them."""

import time as wall
from collections import defaultdict
from dataclasses import dataclass, field

import numpy as np
from scene import Law, Record, Scene

from nutamill.case import Case, load_case
from nutamill.charge.readout import positions, spins, velocities
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.setup.clock import ContactFacts, contact_facts
from nutamill.simulation.setup.model import Model, Scratch, State, build
from nutamill.simulation.setup.particles import particle_count
from nutamill.simulation.speed import developed_case, developed_flow, mechanism_step, on_threads

SAND = (
    "mechanism.mounting=rigid",
    "charge.diameter=1.95 mm",
    "charge.mass=1.14197 kg",
    "materials.steel.density=2480 kg/m^3",
    "contact.stiffness=direct",
    "contact.pairs.steel-steel.normal_stiffness=10 kN/m",
    "contact.pairs.steel-acrylic.normal_stiffness=10 kN/m",
    "drive.ramp=14000 rpm/s",
    "run.dt=5 us",
    "run.until=0.13 s",
)
"""Spheres of the size of the published sand, at speed within 50 ms: the pellets' coefficients, softer, at the
density of quartz.
"""


@dataclass(slots=True)
class Ours:
    """A developed flow that goes on from piece to piece."""

    scene: Scene
    """The state the others start from."""
    rows: int
    """Rows of the record in one measured piece [1]."""
    model: Model
    """As it is now; its lists may grow."""
    state: State
    """As it is now."""
    scratch: Scratch
    """Its work space."""
    begun: float
    """Time of the scene's state [s]."""
    mechanism: float
    """Wall time of one window of the mechanism [s]."""
    written: list[np.ndarray] = field(default_factory=list)
    """Rows of the record since the scene's state."""
    times: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))
    """What `piece` returned, by number of threads [ns]."""
    snapshots: list[tuple[float, np.ndarray]] = field(default_factory=list)
    """Time since the scene's state [s] and particles, at the end of each piece."""

    def piece(self, threads: int) -> float:
        """March one piece; wall time of the charge per particle and substep [ns]."""
        model, state, scratch = on_threads(self.model, threads), self.state, self.scratch
        begun = wall.perf_counter()
        model, rows, fault = enter(model, state, scratch, self.rows)
        seconds = wall.perf_counter() - begun
        if fault is not None:
            raise fault
        self.model = model
        self.written.append(model.readout.series(rows, state.first_row))
        self.snapshots.append((float(state.mechanism.time[0]) - self.begun, particles(model, state)))
        windows = self.rows * model.plan.windows_per_row
        taken = 1e9 * (seconds - windows * self.mechanism) / (windows * model.plan.substeps) / self.scene.n
        self.times[threads].append(taken)
        return taken

    def record(self, begin: float, end: float) -> Record:
        """What was written from `begin` to `end` after the scene's state [s]; a wrench is a mean over a row
        and belongs to its middle.
        """
        half = 0.5 / self.model.case.run.series_rate
        names, rows = self.model.readout.names, np.vstack(self.written)
        wrench = [
            rows[:, names.index(f"charge_{part}_{axis}")] for part in ("force", "moment") for axis in "xyz"
        ]
        time = rows[:, names.index("time")] - self.begun - half
        inside = (time > begin) & (time < end)
        times, snapshots = zip(
            *(seen for seen in self.snapshots if begin < seen[0] <= end + 2 * half), strict=True
        )
        return Record(time[inside], np.column_stack(wrench)[inside], np.array(times), np.array(snapshots))


def pellets() -> Ours:
    """The published pellets half a second after a fast ramp to 700 rpm."""
    model, state, scratch = developed_flow(developed_case())
    return _ours("pellets", model, state, scratch, 48)


def sand() -> Ours:
    """Sand-sized spheres one revolution after a very fast ramp to 700 rpm."""
    case = load_case("numill", SAND)
    model, state, scratch = build(case.machine, _loose_layers(case))
    record_first_row(model, state, scratch)
    model, _, fault = enter(model, state, scratch, round(case.run.until * case.run.series_rate))
    if fault is not None:
        raise fault
    return _ours("sand-sized", model, state, scratch, 8)


def _loose_layers(case: Case) -> np.ndarray:
    """Places of equal spheres [m] (n, 3) in layers from the floor up, chamber axes; shaken a little, they
    fall as they start.
    """
    diameter, chamber, n = case.charge.diameter, case.chamber, particle_count(case.machine)
    pitch = 1.03 * diameter
    steps = np.arange(-int(chamber.inner_diameter / pitch), int(chamber.inner_diameter / pitch) + 1) * pitch
    random = np.random.default_rng(case.run.seed)
    layers, height = [], 0.53 * diameter - chamber.floor_depth
    while sum(map(len, layers)) < n:
        x, y = (axis.ravel() for axis in np.meshgrid(*(steps + random.random() * pitch for _ in range(2))))
        inside = np.hypot(x, y) < chamber.inner_diameter / 2 - 0.53 * diameter
        layers.append(np.column_stack([x[inside], y[inside], np.full(inside.sum(), height)]))
        height += pitch
    places = np.vstack(layers)[:n]
    return places + random.uniform(-1, 1, places.shape) * 0.012 * diameter


def _ours(name: str, model: Model, state: State, scratch: Scratch, rows: int) -> Ours:
    """The scene of the present state, and the run that goes on from it."""
    case = model.case
    mechanism, chamber = case.mechanism, case.chamber
    column = model.readout.names.index("crank_angle")
    _, last, _ = enter(model, state, scratch, 1)
    angle = float(model.readout.series(last, state.first_row)[-1, column])
    pair, wall_pair = contact_facts(case.machine)
    density = case.materials[case.charge.material].density
    mass = density * np.pi * case.charge.diameter**3 / 6
    scene = Scene(
        name=name,
        diameter=case.charge.diameter,
        density=density,
        pair=_law(pair, mass / 2),
        wall=_law(wall_pair, mass),
        bore=chamber.inner_diameter / 2,
        floor=-chamber.floor_depth,
        ceiling=-chamber.ceiling_depth,
        tilt=float(np.arctan2(mechanism.crank_radius, mechanism.nutation_point_to_crank)),
        speed=case.drive.speed,
        angle=angle,
        gravity=mechanism.gravity,
        substep=model.clock.substep,
        particles=particles(model, state),
    )
    mechanism_time = mechanism_step(model, state, scratch)
    return Ours(scene, rows, model, state, scratch, float(state.mechanism.time[0]), mechanism_time)


def _law(facts: ContactFacts, reduced_mass: float) -> Law:
    """A pair's numbers in the terms of the scene."""
    law, k = facts.law, facts.stiffness
    return Law(
        stiffness=k,
        tangential=law.tangential_ratio * k,
        damping_rate=2 * law.damping_ratio * np.sqrt(k / reduced_mass),
        restitution=facts.restitution,
        sliding=law.static_friction,
        rolling=law.rolling_friction,
        reduced_mass=reduced_mass,
    )


def particles(model: Model, state: State) -> np.ndarray:
    """Position, velocity and spin (n, 9) of all particles, world axes, at one time."""
    charge = state.charge
    return np.hstack(
        [
            positions(model.charge, charge, model.clock.substep),
            velocities(model.charge, charge),
            spins(model.charge, charge),
        ]
    )
