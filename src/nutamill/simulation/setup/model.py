"""A case as a model (constants), a state (what changes) and work space."""

from dataclasses import dataclass

import numpy as np

from nutamill.case import Case, Machine
from nutamill.case.drawing import CHAMBER, CROSS
from nutamill.charge.kernels.copying import checkpoint_arrays
from nutamill.charge.measures.statistics import ChargeStatistics, StatisticsPlan, charge_statistics
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.sensors import SensorTable, sensor_table
from nutamill.simulation.coupling_model import (
    CoupledModel,
    CoupledScratch,
    CoupledState,
    CouplingPlan,
    CouplingState,
    Scheme,
    coupled_scratch,
    coupling_state,
)
from nutamill.simulation.row import RowTable, row_groups
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
    """The constants of a run."""

    case: Case | Machine
    """The case."""
    clock: Clock
    """Lengths of substep, window and row."""
    mechanism: Mechanism
    """Bodies, joints, loads."""
    sensors: SensorTable
    """Sensors of the mechanism, read at each row."""
    charge: ChargeModel | None
    """The charge; None for an empty chamber."""
    survey: StatisticsPlan | None
    """Grid and patches of the charge's statistics; None for an empty chamber."""
    plan: CouplingPlan
    """How the two are coupled."""
    readout: Readout | PartReadout
    """From rows to series."""

    def coupled(self) -> CoupledModel:
        """Return the arrays that the coupled march takes."""
        row = self.readout.table.starts
        return CoupledModel(self.mechanism, self.sensors, self.charge, self.survey, self.plan, row)


@dataclass(slots=True)
class State:
    """What changes in a run: the arrays of a checkpoint."""

    mechanism: MechanismState
    """Motion, reactions and ledgers of the mechanism."""
    charge: ChargeState | None
    """Motion, contact memory and ledgers of the charge; None for an empty chamber."""
    statistics: ChargeStatistics | None
    """Sums of the charge's statistics; None for an empty chamber."""
    coupling: CouplingState
    """Counters and sums of the coupling."""
    first_row: np.ndarray
    """Row at the start of the run, (n_columns,), from which ledgers count."""

    def coupled(self) -> CoupledState:
        """Return the arrays that the coupled march takes."""
        return CoupledState(self.mechanism, self.charge, self.statistics, self.coupling)

    def arrays(self) -> dict[str, dict[str, np.ndarray]]:
        """Return all arrays by part and name, except the statistics, which a checkpoint has as sums over
        threads.
        """
        groups = {"mechanism": self.mechanism._asdict()}
        if self.charge is not None:
            groups["charge"] = checkpoint_arrays(self.charge)
        groups["coupling"] = self.coupling._asdict()
        return groups | {"record": {"first_row": self.first_row}}


@dataclass(slots=True)
class Scratch:
    """Work space of a run; no number in it has to survive an entry of the compiled march."""

    mechanism: MechanismScratch
    """Work space of the mechanism."""
    charge: ChargeScratch | None
    """Work space of the charge; None for an empty chamber."""

    def coupled(self, model: Model, state: State) -> CoupledScratch:
        """Return the arrays that the coupled march of `state` takes."""
        return coupled_scratch(state.coupled(), self.mechanism, self.charge, model.plan.scheme)


def build(case: Case, bed: np.ndarray | None) -> tuple[Model, State, Scratch]:
    """Build model, first state and work space of a case: the mill in static equilibrium at crank angle 0, the
    charge in its bed.

    Parameters
    ----------
    case : the case
    bed : positions of the particles [m] (n, 3), or positions and attitudes (n, 7), in chamber axes from the
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
        position, quaternion = mstate.position[chamber], mstate.quaternion[chamber]
        charge, cstate, cscratch = chamber_charge(
            case, bed, position, quaternion, clock.substep, chamber_patches(case)
        )
        survey = chamber_survey(case, charge, cstate, clock.substep)
        sums = charge_statistics(survey, cstate)
    readout = Readout(case, RowTable(row_groups(mechanism, sensors, bed is not None)))
    model = Model(case, clock, mechanism, sensors, charge, survey, plan, readout)
    state = State(mstate, cstate, sums, coupling_state(len(plan.carriers)), np.zeros(readout.n_columns))
    return model, state, Scratch(mscratch, cscratch)


def plan_scheme(case: Case) -> Scheme:
    """Return the coupling scheme of a case."""
    return Scheme[case.run.coupling.upper()]


def bed_weight(case: Case, bed: np.ndarray) -> np.ndarray:
    """Return the weight of the bed as a wrench (6,) on the chamber about its mass centre: force [N], moment
    [N m], world axes.
    """
    mass = particle_masses(case)
    force = np.array([0.0, 0.0, -case.mechanism.gravity * mass.sum()])
    centre = (mass @ bed[:, :3]) / mass.sum() - whole_chamber(case.chamber).mass_centre
    return np.concatenate([force, np.cross(chamber_rotation(case) @ centre, force)])
