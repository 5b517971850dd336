"""A small test bench for the coupling: a rigid body with walls inside or on top, particles, and the march of
both.
"""

import math

import numpy as np
from charge_bench import law, sphere_mass

from nutamill.charge.assembly import charge
from nutamill.charge.kernels.copying import copied
from nutamill.charge.kernels.dynamics import start as start_charge
from nutamill.charge.kernels.team import run_team
from nutamill.charge.measures.observe import charge_reading
from nutamill.charge.measures.statistics import charge_statistics, statistics_plan
from nutamill.charge.model import Ledger
from nutamill.charge.readout import positions, spins, velocities
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.dynamics import OK, start
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointKind
from nutamill.mechanism.sensors import Sensor, SensorKind, sensor_table
from nutamill.simulation.coupling import (
    RUNNING,
    CouplingPlan,
    Scheme,
    coupling_state,
    march_coupled,
    march_iterated,
)

G = 9.81
Z = (0.0, 0.0, 1.0)
ORIGIN = (0.0, 0.0, 0.0)
ROTOR = "rotor"

SENSORS = [
    Sensor("place", SensorKind.POINT_POSITION, "box"),
    Sensor("velocity", SensorKind.POINT_VELOCITY, "box"),
]
PLACE_Z, VELOCITY_Z = 3, 6
"""Columns of a row; column 0 is the time, 7 to 9 are kinetic, potential and elastic energy of the
mechanism.
"""
KINETIC, POTENTIAL, ELASTIC, DRIVE_WORK, BUSHING_LOSS = 7, 8, 9, 10, 11

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
        self.mechanism = assemble(bodies, joints, bushings, drives=drives, gravity=gravity)
        self.sensors = sensor_table(*self.mechanism[:2], SENSORS)
        assert start(*self.mechanism) == OK
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
        self.plan = CouplingPlan(int(scheme), substeps, window, windows_per_row, numbers, 0, np.zeros(3), 0)
        self.coupling = coupling_state(1)
        self.rows = np.zeros((0, 1))

    def march(self, n_windows, threads=1):
        """March `n_windows` windows; `rows` are those of this march."""
        reading = charge_reading()
        first = 1 + len(SENSORS) * 3
        columns = (
            first
            + 3
            + len(self.mechanism[1].drive_work)
            + len(self.mechanism[1].bushing_loss)
            + len(self.mechanism[1].joint_loss)
        )
        self.charge_column = columns
        total = columns + 16 + 1 + len(Ledger) + 14
        self.rows = np.zeros((n_windows // self.plan.windows_per_row, total))
        survey = statistics_plan(*self.charge[:2], self.plan.dt / self.plan.substeps, on=False)
        seen = (reading, survey, charge_statistics(survey, self.charge[1]))
        parts = (*self.mechanism, self.sensors, *self.charge, self.plan, self.coupling, *seen)
        if self.plan.scheme == Scheme.ITERATED:
            kept = [copied(part) for part in (self.mechanism[1], self.charge[1])]
            run_team(march_iterated, (*parts, *kept, n_windows, self.rows), threads)
        else:
            run_team(march_coupled, (*parts, n_windows, self.rows), threads)
        assert self.coupling.outcome[0] == RUNNING, (self.coupling.outcome, self.charge[1].status)
        return self

    def until(self, end):
        return self.march(round(end / self.plan.dt))

    @property
    def z(self):
        """Height of the box [m]."""
        return self.mechanism[1].position[0, 2]

    @property
    def speed(self):
        """Velocity of the box along z [m/s]."""
        return self.mechanism[1].velocity[0, 2]

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
        c = self.charge_column
        mechanism = self.rows[:, KINETIC : ELASTIC + 1].sum(axis=1)
        return (
            mechanism + self.rows[:, c : c + 8].sum(axis=1) - self.rows[:, c + 17 + 7]
        )  # the last is the work of gravity


__all__ = [
    "FLOOR",
    "KINETIC",
    "PLACE_Z",
    "VELOCITY_Z",
    "CoupledBench",
    "G",
    "Scheme",
    "inside_of_a_box",
    "law",
    "math",
    "sphere_mass",
]
