"""A machine as a model (constants), a state (what changes) and work space."""

from dataclasses import dataclass

import numpy as np

from nutamill.base.errors import CaseError, Fault, StepError
from nutamill.base.required import required
from nutamill.case.machine import Machine
from nutamill.charge.measures.statistics import ChargeStatistics, StatisticsPlan, charge_statistics
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState
from nutamill.mechanism.dynamics import OK, start
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.sensors import SensorTable, sensor_table
from nutamill.mechanism.stop_tables import step_faults
from nutamill.result.fields import Field
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
from nutamill.simulation.fmus.exchange import Exchange
from nutamill.simulation.lammps.grains import Grains
from nutamill.simulation.row import RowTable, row_groups
from nutamill.simulation.setup.carriers import Carrier, carriers_of
from nutamill.simulation.setup.charge import machine_charge
from nutamill.simulation.setup.clock import Clock, run_clock
from nutamill.simulation.setup.mechanism import assemble_machine, machine_sensors, refuse_unsupported
from nutamill.simulation.setup.particles import particle_masses, region_bodies
from nutamill.simulation.setup.readout import Readout
from nutamill.simulation.setup.statistics import charge_survey, wall_patches


@dataclass(frozen=True, slots=True)
class Model:
    """The constants of a run."""

    machine: Machine
    """The machine."""
    clock: Clock
    """Lengths of substep, window and row."""
    mechanism: Mechanism
    """Bodies, joints, loads."""
    sensors: SensorTable
    """Sensors of the mechanism, read at each row."""
    charge: ChargeModel | None
    """The charge; None without one."""
    survey: StatisticsPlan | None
    """Grid and patches of the charge's statistics; None without one."""
    plan: CouplingPlan
    """How the two are coupled."""
    readout: Readout
    """From rows to series."""

    def coupled(self) -> CoupledModel:
        """Return the arrays that the coupled march takes."""
        row = self.readout.table.starts
        return CoupledModel(
            self.mechanism,
            self.sensors,
            self.charge,  # type: ignore[arg-type]  # None compiles a march without a charge
            self.survey,  # type: ignore[arg-type]
            self.plan,
            row,
        )


@dataclass(slots=True)
class State:
    """What changes in a run: the arrays of a checkpoint."""

    mechanism: MechanismState
    """Motion, reactions and ledgers of the mechanism."""
    charge: ChargeState | None
    """Motion, contact memory and ledgers of the charge; None without one."""
    statistics: ChargeStatistics | None
    """Sums of the charge's statistics; None without one."""
    coupling: CouplingState
    """Counters and sums of the coupling."""
    first_row: np.ndarray
    """Row at the start of the run, (n_columns,), from which ledgers count."""
    exchange: Exchange | None = None
    """The FMUs of the machine; None without any."""
    grains: Grains | None = None
    """The particles in LAMMPS; None where this program moves them."""

    def coupled(self) -> CoupledState:
        """Return the arrays that the coupled march takes."""
        return CoupledState(
            self.mechanism,
            self.charge,  # type: ignore[arg-type]  # None compiles a march without a charge
            self.statistics,  # type: ignore[arg-type]
            self.coupling,
        )


@dataclass(slots=True)
class Scratch:
    """Work space of a run; no number in it has to survive an entry of the compiled march."""

    mechanism: MechanismScratch
    """Work space of the mechanism."""
    charge: ChargeScratch | None
    """Work space of the charge; None without one."""

    def coupled(self, model: Model, state: State) -> CoupledScratch:
        """Return the arrays that the coupled march of `state` takes."""
        return coupled_scratch(
            state.coupled(),
            self.mechanism,
            self.charge,  # type: ignore[arg-type]  # None compiles a march without a charge
            model.plan.scheme,
        )


def build(
    machine: Machine,
    bed: np.ndarray | None,
    exchange: Exchange | None = None,
    carrier_poses: np.ndarray | None = None,
) -> tuple[Model, State, Scratch]:
    """Build model, first state and work space of a machine: as assembled or in static equilibrium, the charge
    in its beds.

    Parameters
    ----------
    machine : the machine
    bed : positions of the particles [m] (n, 3), or positions and attitudes (n, 7), by
        `nutamill.simulation.setup.bed.settled_bed`; None without a charge
    exchange : its FMUs, started; None without any
    carrier_poses : mass centre [m] and attitude of each carrier (n_carriers, 7) with which the bed is placed
        among the walls, for a state that is restored later; those of the first state if None

    Raises
    ------
    CaseError : every fault of the mechanism or of the charge; a substep too long for the contacts
    StepError : no finite accelerations, or no equilibrium where the machine starts from rest
    """
    if machine.fmus and exchange is None:
        hint = 'Take them out, e.g. -s "fmus=[]", and give the drive a motor'
        raise CaseError(Fault("fmus", "are run by run and resume only", hint))
    mechanism, mstate, mscratch = assemble_machine(machine)
    named = machine_sensors(machine)
    sensors = sensor_table(mechanism, mstate, [sensor for sensor, _ in named])
    carriers = [] if bed is None else carriers_of(machine)
    scheme, clock = plan_scheme(machine), run_clock(machine)
    if faults := step_faults(mechanism, "run.step" if bed is None else "run.window", clock.window):
        raise CaseError(*faults)
    if machine.run.start == "rest":
        refuse_unsupported(machine)
        weight = None if scheme == Scheme.PRESCRIBED else bed_weight(machine, bed, mstate)
        static_equilibrium(mechanism, mstate, mscratch, wrench=weight)
    elif start(mechanism, mstate, mscratch) != OK:
        raise StepError(
            f"{machine.name}: the first accelerations are not finite. Look at the masses and inertias of the "
            "bodies."
        )
    if exchange is not None:
        exchange.prepare(mechanism, mstate, clock.window, scheme == Scheme.PRESCRIBED)
    bodies = np.array([carrier.body for carrier in carriers], np.int64)
    plan = CouplingPlan(
        int(scheme) if bed is not None else int(Scheme.STAGGERED),
        clock.substeps,
        clock.window,
        clock.windows_per_row,
        bodies,
        wrench_points(machine, carriers),
        reference_drive(machine),
    )
    charge, cstate, cscratch, survey, sums = None, None, None, None, None
    if bed is not None:
        if carrier_poses is None:
            carrier_poses = np.column_stack([mstate.position[bodies], mstate.quaternion[bodies]])
        charge, cstate, cscratch = machine_charge(
            machine, bed, carrier_poses, clock.substep, wall_patches(machine)
        )
        survey = charge_survey(machine, charge, cstate, clock.substep)
        sums = charge_statistics(survey, cstate)
        cstate.impacts.on[0] = survey.on
    readout = machine_readout(machine, mechanism, mstate, [carrier.name for carrier in carriers])
    model = Model(machine, clock, mechanism, sensors, charge, survey, plan, readout)
    coupling = coupling_state(len(carriers), reference_axis(machine))
    state = State(mstate, cstate, sums, coupling, np.zeros(readout.n_columns), exchange)
    return model, state, Scratch(mscratch, cscratch)


def machine_readout(
    machine: Machine, mechanism: Mechanism, state: MechanismState, carriers: list[str]
) -> Readout:
    """Return the names and fields of the series of a machine, from its parts, its sensors and the bodies that
    carry walls of a charge.

    Raises
    ------
    CaseError : a recorded series, or one that a quantity is taken of, that the machine does not have
    """
    named = machine_sensors(machine)
    sensors = sensor_table(mechanism, state, [sensor for sensor, _ in named])
    groups = row_groups(mechanism, sensors, carriers)
    return Readout(machine, RowTable(groups), [name for _, names in named for name in names])


def recorded_fields(machine: Machine) -> list[Field]:
    """Return what a run of a machine records, without making its charge.

    Raises
    ------
    CaseError : every fault of the mechanism; a series to be recorded that the machine does not have
    """
    mechanism, state, _ = assemble_machine(machine)
    carriers = carriers_of(machine) if machine.charge.parts else []
    return machine_readout(machine, mechanism, state, [carrier.name for carrier in carriers]).fields


def plan_scheme(machine: Machine) -> Scheme:
    """Return the coupling scheme of a machine."""
    return Scheme[machine.run.coupling.upper()]


def reference_drive(machine: Machine) -> int:
    """Return the index of the drive with which fields and neighbour lists rotate, or -1 without one."""
    return (
        -1 if machine.fields.drive is None else [d.name for d in machine.drives].index(machine.fields.drive)
    )


def reference_axis(machine: Machine) -> tuple[np.ndarray, np.ndarray]:
    """Return point [m] and direction of that drive's axis as assembled, world, or z without a drive."""
    if machine.fields.drive is None:
        return np.zeros(3), np.array([0.0, 0.0, 1.0])
    drive = machine.drives[reference_drive(machine)]
    joint = next(joint for joint in machine.joints if joint.name == drive.joint)
    axis = required(joint.axis)
    return np.array(joint.point, float), np.asarray(axis, float) / np.linalg.norm(axis)


def wrench_points(machine: Machine, carriers: list[Carrier]) -> np.ndarray:
    """Return the point of each carrier about which the moment of the charge is recorded [m] (n_carriers, 3),
    axes of the body from its mass centre: as a sensor of the file says, else the mass centre.
    """
    points = np.zeros((len(carriers), 3))
    given = {
        entry.of: entry.at for entry in machine.sensors if entry.kind == "charge" and entry.at is not None
    }
    for c, carrier in enumerate(carriers):
        if carrier.name in given:
            points[c] = carrier.rotation.T @ (np.array(given[carrier.name]) - carrier.position)
    return points


def bed_weight(machine: Machine, bed: np.ndarray | None, state: MechanismState) -> np.ndarray | None:
    """Return the weight of the beds as wrenches (n_bodies, 6) on the bodies that carry them, about their mass
    centres as assembled: force [N], moment [N m], world axes, or None without a charge.
    """
    if bed is None:
        return None
    wrench, mass, carriers = np.zeros_like(state.wrench), particle_masses(machine), carriers_of(machine)
    for number, members in region_bodies(machine):
        carrier = carriers[number]
        force = mass[members].sum() * np.array(machine.gravity)
        centre = (mass[members] @ bed[members, :3]) / mass[members].sum()
        wrench[carrier.body] += np.concatenate([force, np.cross(carrier.rotation @ centre, force)])
    return wrench
