"""A case as a model (numbers that stay) and a state (numbers that move)."""

from dataclasses import dataclass

import numpy as np

from nutamill.case import Case, MechanismCase
from nutamill.case.machine import CHAMBER, CROSS
from nutamill.charge.kernels.copying import checkpoint_arrays
from nutamill.charge.measures.observe import ChargeReading, charge_reading
from nutamill.charge.measures.statistics import ChargeStatistics, StatisticsPlan, charge_statistics
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.sensors import SensorTable, column_names, sensor_table
from nutamill.simulation.coupling import CouplingPlan, CouplingState, Scheme, coupling_state
from nutamill.simulation.setup.charge import chamber_charge
from nutamill.simulation.setup.clock import Clock, run_clock
from nutamill.simulation.setup.mill import (
    DRIVE,
    assemble_mill,
    chamber_rotation,
    mill_mechanism,
    mill_sensors,
)
from nutamill.simulation.setup.part_readout import PartReadout
from nutamill.simulation.setup.particles import particle_masses
from nutamill.simulation.setup.readout import Readout
from nutamill.simulation.setup.rigid_parts import whole_chamber
from nutamill.simulation.setup.statistics import chamber_patches, chamber_survey


@dataclass(frozen=True, slots=True)
class Model:
    """Everything constant about a run, and the work space of its engines."""

    case: Case | MechanismCase
    """What was asked."""
    clock: Clock
    """How the run steps."""
    mechanism: Mechanism
    """Bodies, joints, loads."""
    mechanism_scratch: MechanismScratch
    """Its work space."""
    sensors: SensorTable
    """What is read from the mechanism at each row."""
    charge: ChargeModel | None
    """The charge; None for an empty chamber."""
    charge_scratch: ChargeScratch | None
    """Its work space."""
    reading: ChargeReading
    """Room for what is observed of the charge."""
    survey: StatisticsPlan | None
    """Where the charge's statistics are summed; None for an empty chamber."""
    plan: CouplingPlan
    """How the two are coupled."""
    readout: Readout | PartReadout
    """From rows to series."""


@dataclass(slots=True)
class State:
    """Everything that changes; the arrays of a checkpoint."""

    mechanism: MechanismState
    """Motion, reactions and ledgers of the mechanism."""
    charge: ChargeState | None
    """Motion, contact memory and ledgers of the charge; None for an empty chamber."""
    statistics: ChargeStatistics | None
    """Sums over what the charge did; None for an empty chamber."""
    coupling: CouplingState
    """Counters and sums of the coupling."""
    first_row: np.ndarray
    """Row at the start of the run, (n_columns,), from which ledgers count."""

    def arrays(self) -> dict[str, dict[str, np.ndarray]]:
        """All arrays by part and name, but the statistics, which are kept as their sums over threads."""
        groups = {"mechanism": self.mechanism._asdict()}
        if self.charge is not None:
            groups["charge"] = checkpoint_arrays(self.charge)
        groups["coupling"] = self.coupling._asdict()
        return groups | {"record": {"first_row": self.first_row}}


def build(case: Case, bed: np.ndarray | None) -> tuple[Model, State]:
    """Model and first state of a case: the mill at rest in static equilibrium at crank angle 0, the charge in
    its bed.

    Parameters
    ----------
    case : what is asked
    bed : places of the particles [m] (n, 3), or places and attitudes (n, 7), in chamber axes from the
        nutation point, by `nutamill.simulation.setup.bed.settled_bed`; None for an empty chamber

    Raises
    ------
    CaseError : every fault of the mechanism or of the charge; a substep too long for the contacts
    """
    mill = mill_mechanism(case)
    bodies = [body.name for body in mill.bodies]
    mechanism, mstate, mscratch = assemble_mill(mill)
    chamber, cross = bodies.index(CHAMBER), bodies.index(CROSS)
    sensors = sensor_table(mechanism, mstate, mill_sensors(case))
    weight = None
    if bed is not None and plan_scheme(case) != Scheme.PRESCRIBED:
        weight = np.zeros_like(mstate.wrench)
        weight[chamber] = bed_weight(case, bed)
    static_equilibrium(mechanism, mstate, mscratch, wrench=weight)
    clock = run_clock(case)
    plan = CouplingPlan(
        int(plan_scheme(case)),
        clock.substeps,
        clock.window,
        clock.windows_per_row,
        np.array([chamber]),
        cross,
        np.zeros(3),
        [drive.name for drive in mill.drives].index(DRIVE),
    )
    charge, cstate, cscratch, survey, sums = None, None, None, None, None
    if bed is not None:
        charge, cstate, cscratch = chamber_charge(
            case,
            bed,
            mstate.position[chamber],
            mstate.quaternion[chamber],
            clock.substep,
            chamber_patches(case),
        )
        survey = chamber_survey(case, charge, cstate, clock.substep)
        sums = charge_statistics(survey, cstate)
    readout = Readout(
        case,
        column_names(sensors),
        [bushing.name for bushing in mill.bushings],
        [joint.name for joint in mill.joints],
        bed is not None,
    )
    model = Model(
        case, clock, mechanism, mscratch, sensors, charge, cscratch, charge_reading(), survey, plan, readout
    )
    return model, State(mstate, cstate, sums, coupling_state(len(plan.carriers)), np.zeros(readout.n_columns))


def plan_scheme(case: Case) -> Scheme:
    """How charge and mechanism act on each other, as the case says."""
    return Scheme[case.run.coupling.upper()]


def bed_weight(case: Case, bed: np.ndarray) -> np.ndarray:
    """Weight of the bed as a wrench (6,) on the chamber about its mass centre: force [N], moment [N m], world
    axes.
    """
    mass = particle_masses(case)
    force = np.array([0.0, 0.0, -case.mechanism.gravity * mass.sum()])
    centre = (mass @ bed[:, :3]) / mass.sum() - whole_chamber(case.chamber).mass_centre
    return np.concatenate([force, np.cross(chamber_rotation(case) @ centre, force)])
