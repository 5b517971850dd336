"""A small test bench for the coupling: a rigid body with walls inside or on top, particles, and the march of
both.
"""

import math

import numpy as np
from charge_bench import law, sphere_mass

from nutamill import System
from nutamill.charge.assembly import charge
from nutamill.charge.kernels.dynamics import start as start_charge
from nutamill.charge.kernels.team import run_team
from nutamill.charge.measures.statistics import charge_statistics, statistics_plan
from nutamill.charge.readout import positions, spins, velocities
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointKind
from nutamill.mechanism.sensors import Sensor, SensorKind, sensor_table
from nutamill.simulation.coupling import march_coupled
from nutamill.simulation.coupling_model import (
    CoupledModel,
    CoupledState,
    CouplingPlan,
    Outcome,
    Scheme,
    coupled_scratch,
    coupling_state,
)
from nutamill.simulation.row import CONTACT_TERMS, RowTable, row_groups

G = 9.81
Z = (0.0, 0.0, 1.0)
ORIGIN = (0.0, 0.0, 0.0)
ROTOR = "rotor"

SENSORS = [
    Sensor("box", SensorKind.POINT_POSITION, "box"),
    Sensor("box", SensorKind.POINT_VELOCITY, "box"),
]

FLOOR = Surface("floor", SurfaceKind.PLANE, 0, 0)


def inside_of_a_box(half):
    """Six planes that look inwards, `half` = half sizes [m] (3,), about the carrier's mass centre."""
    turns = {
        "bottom": np.eye(3),
        "top": np.diag([1.0, -1.0, -1.0]),
        "left": np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
        "right": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
        "front": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
        "back": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    }
    return [
        Surface(name, SurfaceKind.PLANE, 0, 0, tuple(-np.asarray(half) * rotation[:, 2]), rotation)
        for name, rotation in turns.items()
    ]


class CoupledBench:
    """A body "box" that carries all surfaces, particles on it, and the march of both.

    Parameters
    ----------
    mass, inertia : of the box; its mass centre starts at the origin
    guided : held by a joint that lets it slide along z only; else it is free
    stiffness, damping : of a bushing along z between ground and box; none if zero
    """

    def __init__(
        self,
        places,
        surfaces,
        pair_law,
        window,
        mass,
        inertia=None,
        guided=True,
        stiffness=0.0,
        damping=0.0,
        gravity=(0.0, 0.0, 0.0),
        box_velocity=ORIGIN,
        box_spin=ORIGIN,
        scheme=Scheme.STAGGERED,
        substeps=10,
        windows_per_row=1,
        radius=0.0025,
        density=7863.7,
        carriers=("box",),
        **options,
    ):
        inertia = np.eye(3) if inertia is None else inertia
        bodies = [
            Body("box", mass, inertia, ORIGIN, velocity=box_velocity, angular_velocity=box_spin),
            Body(ROTOR, 1.0, np.eye(3), (5.0, 0.0, 0.0)),
        ]
        joints = [Joint("bearing", JointKind.REVOLUTE, GROUND, ROTOR, (5.0, 0.0, 0.0), Z)]
        if guided:
            joints.append(Joint("guide", JointKind.PRISMATIC, GROUND, "box", ORIGIN, Z))
        bushings = []
        if stiffness > 0.0:
            bushings = [
                Bushing(
                    "spring", GROUND, "box", ORIGIN, Z, (0.0, stiffness, 0.0, 0.0), (0.0, damping, 0.0, 0.0)
                )
            ]
        drives = [Drive("motor", "bearing", (0.0,), (0.0,))]
        self.system = System(bodies, joints, bushings, drives, gravity)
        self.sensors = sensor_table(self.system.mechanism, self.system.state, SENSORS)
        self.table = RowTable(row_groups(self.system.mechanism, self.sensors, ["box"]))
        places = np.atleast_2d(np.array(places, float))
        n = len(places)
        options.setdefault("precision", "double")
        for name in ("velocities", "spins"):
            if name in options:
                options[name] = np.broadcast_to(np.array(options[name], float), (n, 3))
        radii = np.broadcast_to(np.asarray(radius, float), (n,))
        self.charge = charge(
            places,
            radii,
            np.zeros(n, int),
            [density],
            {(0, 0): pair_law},
            surfaces,
            1,
            gravity=gravity,
            **options,
        )
        start_charge(*self.charge, window / substeps)
        numbers = np.array([[body.name for body in bodies].index(name) for name in carriers])
        self.plan = CouplingPlan(int(scheme), substeps, window, windows_per_row, numbers, np.zeros((1, 3)), 0)
        self.coupling = coupling_state(1)
        self.rows = np.zeros((0, 1))

    def march(self, n_windows, threads=1):
        """March `n_windows` windows; `rows` are those of this march."""
        system, (model, state, scratch) = self.system, self.charge
        self.rows = np.zeros((n_windows // self.plan.windows_per_row, self.table.starts.columns))
        survey = statistics_plan(model, state, self.plan.dt / self.plan.substeps, on=False)
        coupled = CoupledState(system.state, state, charge_statistics(survey, state), self.coupling)
        parts = (
            CoupledModel(system.mechanism, self.sensors, model, survey, self.plan, self.table.starts),
            coupled,
            coupled_scratch(coupled, system.scratch, scratch, self.plan.scheme),
        )
        run_team(march_coupled, (*parts, n_windows, self.rows), threads)
        assert self.coupling.outcome[0] == Outcome.RUNNING, (self.coupling.outcome, state.status)
        return self

    def read(self, group, name=None):
        """Columns of `rows` by group and name."""
        return self.table.read(self.rows, group, name)

    def until(self, end):
        return self.march(round(end / self.plan.dt))

    @property
    def z(self):
        """Height of the box [m]."""
        return self.system.position("box")[2]

    @property
    def speed(self):
        """Velocity of the box along z [m/s]."""
        return self.system.velocity("box")[2]

    @property
    def x(self):
        return positions(self.charge[0], self.charge[1], self.plan.dt / self.plan.substeps)

    @property
    def v(self):
        return velocities(self.charge[0], self.charge[1])

    @property
    def w(self):
        return spins(self.charge[0], self.charge[1])

    def energy(self):
        """Mechanical energy in every row of the last march [J]: of the box, its spring, the charge and its
        contacts.
        """
        stored = self.read("mechanism_energy").sum(axis=1) + self.read("charge_energy").sum(axis=1)
        return stored - self.read("ledger", "gravity")

    def contact_work(self):
        """Work of all contacts on the charge in every row of the last march [J]."""
        terms = [
            self.read("ledger", f"{where}_{term}") for where in ("pair", "wall") for term in CONTACT_TERMS
        ]
        return sum(terms)


__all__ = [
    "FLOOR",
    "CoupledBench",
    "G",
    "Scheme",
    "inside_of_a_box",
    "law",
    "math",
    "sphere_mass",
]
