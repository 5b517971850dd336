"""What can be known about a machine, given part by part, before one step is run."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nutamill.base.errors import CaseError, Fault, StepError
from nutamill.base.host import free_disk, total_memory
from nutamill.base.notebook_hook import notebook_html
from nutamill.base.units import in_unit, shown
from nutamill.case import Machine
from nutamill.case.machine_checks import series_count
from nutamill.design.charge_facts import SPHERE_MEMORY, ChargeFacts, charge_facts, charge_seconds
from nutamill.design.crossings import Crossing, crossing_lines, crossings
from nutamill.design.engine_choice import engine_lines
from nutamill.design.forecast import RUN_MEMORY, Forecast, idle_threads
from nutamill.mechanism.constraints import redundancies
from nutamill.mechanism.dynamics import OK, start
from nutamill.mechanism.modes import modes, static_equilibrium
from nutamill.mechanism.rows import Placement, constraint_tables
from nutamill.simulation.lammps.faults import refuse_for_lammps
from nutamill.simulation.setup.altered import turning_drive
from nutamill.simulation.setup.carriers import carriers_of
from nutamill.simulation.setup.clock import Clock, run_clock
from nutamill.simulation.setup.light_carriers import light_carrier_warnings
from nutamill.simulation.setup.mechanism import assemble_machine, mechanism_parts, refuse_unsupported
from nutamill.simulation.setup.model import machine_readout
from nutamill.simulation.setup.wall_checks import refuse_walls
from nutamill.simulation.setup.walls import MeshFacts, mesh_facts

ROW_MICROSECONDS = 0.5
"""Wall time per constraint row and step that forecasts count with [us]."""


UNSTABLE = -1.0 + 1e-9
"""Damping ratio [1] up to which a motion about rest does not swing but falls away."""


@dataclass(frozen=True, slots=True)
class MachineSheet:
    """What is known of a mechanism before it is run."""

    case: Machine
    """The case."""
    masses: dict[str, float]
    """Masses of the bodies [kg]."""
    mass_centre: np.ndarray
    """Mass centre of all bodies as assembled [m], (3,), world."""
    rows: int
    """Scalar constraints, those of the drives included [1]."""
    driven: int
    """Scalar constraints of the drives [1]."""
    freedoms: int
    """Degrees of freedom that joints leave, the driven ones included [1]."""
    redundant: list[str]
    """What is held more than once, and by what."""
    not_unique: list[str]
    """Joints whose reactions that leaves undetermined."""
    gap: float
    """Largest gap of a constraint once the mechanism is put together [m or rad]."""
    modes: list[tuple[float, float]]
    """Natural frequencies [Hz] and damping ratios [1] about rest, slowest first."""
    modes_missing: str
    """Why there are none; empty if there are."""
    crossings: list[Crossing]
    """Natural frequencies that the ramp of its drive passes; none without one drive that turns it."""
    meshes: list[MeshFacts]
    """Facts of each mesh."""
    clock: Clock
    """Substep of the charge, window and row."""
    charge: ChargeFacts | None
    """Facts of its charge; None without one."""
    light: list[Fault]
    """Warnings of light carriers and of a long window."""
    rate: float | None
    """Wall time of a simulated second, by a trial [1]; None without one."""
    engine: list[str]
    """When LAMMPS pays, for a machine that asks for it."""

    def _repr_html_(self) -> str:
        return notebook_html("cases.sheet_html", self)

    def lines(self) -> list[str]:
        """Format the sheet as text."""
        case = self.case
        masses = ", ".join(f"{name} {mass:.4g}" for name, mass in self.masses.items())
        centre = ", ".join(f"{in_unit(value, 'mm'):.4g}" for value in self.mass_centre)
        forecast = self._forecast()
        lines = [
            f"{case.title or case.name}: ok",
            *(f"  warning: {warning}" for warning in self._warnings()),
            f"bodies    {len(self.masses)}, {sum(self.masses.values()):.5g} kg in all, mass centre "
            f"at ({centre}) mm",
            f"          masses in kg: {masses}",
            f"joints    {_counted(len(case.joints), 'joint')}, {_counted(len(case.drives), 'drive')}, "
            f"{_counted(self.rows, 'constraint')}; loops close within {self.gap:.1e}",
            f"freedom   {_counted(self.freedoms, 'degree')} of freedom, {self.driven} of them driven",
        ]
        lines += [f"redundant {text}" for text in self.redundant]
        if self.not_unique:
            lines.append(f"          reactions not unique: {', '.join(self.not_unique)}")
        if self.modes:
            stable = [f"{f:.4g} Hz ({round(100 * z, 6) + 0.0:.2g} %)" for f, z in self.modes if z > UNSTABLE]
            lines.append("modes     " + (", ".join(stable) or "none that swing") + " about rest, drives held")
            if len(stable) < len(self.modes):
                lines.append("          this equilibrium is unstable")
            lines += crossing_lines(self.crossings, "as it is")
        else:
            lines.append(f"modes     none: {self.modes_missing}")
        for k, mesh in enumerate(self.meshes):
            shape = f"{mesh.triangles} triangles, {mesh.patches} smooth patches"
            lines.append(f"{'' if k else 'mesh':10}{mesh.name}: {shape}, {shown(mesh.volume, 'L')}")
        if self.charge is not None:
            lines += self.charge.lines(self.case)
        steps = case.run.end / self.clock.substep
        lines.append(
            f"time step {shown(self.clock.substep, 'us', '.3g')} ({self.clock.ruled_by}), {steps:.3g} steps"
        )
        lines.append(
            f"          mechanism step {shown(self.clock.window, 'us', '.3g')}, series every "
            f"{shown(1.0 / case.run.series_rate, 'us')}"
        )
        lines.append(f"forecast  about {forecast.text}")
        return lines + self.engine

    def _warnings(self) -> list[Fault]:
        """Return what is possible but odd about the machine, and what is too much for this computer."""
        sizes = self.charge.warnings if self.charge is not None else []
        large = self._forecast().warnings(total_memory(), free_disk(self.case.file_in()))
        return [*self.case.warnings, *self.light, *sizes, *idle_threads(self.case.run), *large]

    def _forecast(self) -> Forecast:
        """Return the forecast of wall time and file size."""
        run = self.case.run
        seconds = run.end / self.clock.window * (2.0 + ROW_MICROSECONDS * self.rows) * 1e-6
        spheres = self.charge.pebbles if self.charge is not None else 0
        seconds += charge_seconds(self.case, self.clock, spheres)
        snapshots = min(run.snapshots.last, run.end) * run.snapshots.rate * spheres * 36
        return Forecast(
            wall_time=max(seconds, 1.0) if self.rate is None else self.rate * run.end,
            memory=RUN_MEMORY + SPHERE_MEMORY * spheres,
            file_size=8 * series_count(self.case) * run.end * run.series_rate + snapshots + 1e6,
            time_key="An earlier run.until or a longer run.step",
            memory_key="Nothing",
            file_key="A lower run.series_rate",
            by_trial=self.rate is not None,
        )


def _counted(number: int, noun: str) -> str:
    """Return a number of things, with the plural where it is needed."""
    return f"{number} {noun}{'s' * (number != 1)}"


def machine_sheet(case: Machine, trial: Callable[[Machine], float | None] | None = None) -> MachineSheet:
    """Return what is known about a mechanism without running it.

    The first call compiles the mechanism's kernels.

    Parameters
    ----------
    case : the machine
    trial : as for `nutamill.design.preflight.preflight`

    Raises
    ------
    CaseError : every fault of the mechanism or of the charge
    StepError : its first accelerations are not finite
    """
    parts = mechanism_parts(case)
    refuse_walls(case)
    refuse_for_lammps(case)
    mechanism, state, scratch = assemble_machine(case)
    labels = constraint_tables(Placement(parts.bodies), parts.joints, parts.drives, parts.gears)[3]
    redundant = redundancies(mechanism, state, scratch, labels)
    masses = np.array([body.mass for body in parts.bodies])
    centre = masses @ np.array([body.position for body in parts.bodies]) / masses.sum()
    machine_readout(
        case, mechanism, state, [part.name for part in carriers_of(case)] if case.charge.parts else []
    )
    if start(mechanism, state, scratch) != OK:
        raise StepError(
            f"{case.name}: the accelerations at the start are not finite. Check the masses and inertias."
        )
    gap = float(np.abs(scratch.gap).max(initial=0.0))
    vibrations, missing = _modes(case, mechanism, state, scratch)
    rank = len(mechanism.rows) - len(redundant)
    rate = None if trial is None else trial(case)
    return MachineSheet(
        case=case,
        masses={body.name: body.mass for body in parts.bodies},
        mass_centre=centre,
        rows=len(mechanism.rows),
        driven=len(mechanism.drives),
        freedoms=6 * len(parts.bodies) - rank + int((mechanism.drives["row"] >= 0).sum()),
        redundant=redundant,
        not_unique=[
            joint.name
            for joint, record in zip(parts.joints, mechanism.joints, strict=True)
            if not record.reaction_unique
        ],
        gap=gap,
        modes=vibrations,
        modes_missing=missing,
        crossings=_passed(case, vibrations),
        meshes=mesh_facts(case),
        clock=run_clock(case),
        charge=charge_facts(case),
        light=light_carrier_warnings(case),
        rate=rate,
        engine=engine_lines(case, rate, trial),
    )


def _passed(case: Machine, vibrations: list[tuple[float, float]]) -> list[Crossing]:
    """Return the modes that the drive of a machine passes, none where no single drive turns it."""
    try:
        return crossings([mode for mode in vibrations if mode[1] > UNSTABLE], turning_drive(case))
    except CaseError:
        return []


def _modes(case: Machine, mechanism, state, scratch) -> tuple[list[tuple[float, float]], str]:
    """Return the modes about rest, or why there are none."""
    try:
        refuse_unsupported(case)
    except StepError as error:
        return [], str(error).removeprefix("static equilibrium: ").partition(". ")[0]
    try:
        static_equilibrium(mechanism, state, scratch)
        vibrations = modes(mechanism, state, scratch)
    except CaseError as error:
        return [], f"{error.faults[0].what}"
    except StepError:
        return [], "there is no equilibrium near the assembled pose"
    listed = [
        (float(f), float(z))
        for f, z in zip(vibrations.frequency, vibrations.damping_ratio, strict=True)
        if z < 1.0
    ]
    return listed, "" if listed else "nothing is free to vibrate with the drives held"
