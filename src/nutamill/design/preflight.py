"""The pre-flight sheet: what can be known about a case before one step is run."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nutamill.base import units
from nutamill.base.errors import Fault
from nutamill.base.host import free_disk, total_memory
from nutamill.base.notebook_hook import notebook_html
from nutamill.case import Case, Machine
from nutamill.case.charge import SIZE_KEYS
from nutamill.design.charge_facts import SPHERE_MEMORY, ChargeFacts, charge_facts, charge_seconds
from nutamill.design.crossings import Crossing, crossing_lines, crossings
from nutamill.design.engine_choice import engine_lines
from nutamill.design.forecast import RUN_MEMORY, Forecast, idle_threads
from nutamill.design.mesh_drawing import chamber_volume, distance_from_drawing
from nutamill.design.weights import with_charge_mass
from nutamill.mechanism.modes import modes, static_equilibrium
from nutamill.result.fields import expand
from nutamill.simulation.lammps.faults import refuse_for_lammps
from nutamill.simulation.record import CHECKPOINT_SIZE
from nutamill.simulation.setup.clock import Clock, run_clock
from nutamill.simulation.setup.light_carriers import light_carrier_warnings
from nutamill.simulation.setup.mechanism import assemble_machine
from nutamill.simulation.setup.particles import charge_parts
from nutamill.simulation.setup.threads import team_size
from nutamill.simulation.setup.wall_checks import refuse_walls
from nutamill.simulation.setup.walls import MeshFacts, mesh_facts

MECHANISM_MICROSECONDS = 23.0
"""Wall time per mechanism step that forecasts count with [us]."""

STATISTICS_SIZE = 4e5
"""Size of the statistics at one checkpoint, packed [bytes]: some thousand cells and patches."""
FEWER = "Fewer or coarser particles ({})"
"""What brings down all that grows with the charge, with the key of its size."""
PACKED = 0.65
"""Share of its size to which a series is compressed [1], for forecasts."""


@dataclass(frozen=True, slots=True)
class Preflight:
    """What is known of a case before it is run."""

    case: Case
    """The case."""
    parts: dict[str, float]
    """Masses of the bodies [kg]."""
    assembly_gap: float
    """Largest gap of a joint as assembled [m]."""
    nutation_angle: float
    """Half-angle of the nutation cone from the two lengths [rad]."""
    charge: ChargeFacts | None
    """Facts of the charge; None without one."""
    meshes: list[MeshFacts]
    """Facts of each mesh, the chamber's first."""
    off_drawing: float | None
    """Largest distance of the chamber's mesh from bore, floor and ceiling as drawn [m]; None where it has
    none.
    """
    clock: Clock
    """Substep, window and row."""
    empty_modes: list[tuple[float, float]]
    """Natural frequencies [Hz] and damping ratios [1] of the empty mill, slowest first."""
    crossings: list[Crossing]
    """Natural frequencies that the ramp passes, with the charge as a rigid mass at the chamber's base."""
    forecast: Forecast
    """What the run will take."""
    engine: list[str]
    """When LAMMPS pays, for a case that asks for it."""
    warnings: list[Fault]
    """What is possible but odd about the case, and what is too much for this machine."""

    def _repr_html_(self) -> str:
        return notebook_html("cases.sheet_html", self)

    def lines(self) -> list[str]:
        """Format the sheet as text."""
        case, count = self.case, len(self.warnings)
        state = f"{count} warning{'s' * (count != 1)}" if count else "no warnings"
        shown = [f"{case.title or case.name}: ok, {state}"]
        shown += [f"  warning: {warning}" for warning in self.warnings]
        shown += self._machine_lines()
        shown += self._mesh_lines()
        if self.charge is not None:
            shown += self.charge.lines(case.machine)
        shown.append(
            f"time step {_microseconds(self.clock.substep)} ({self.clock.ruled_by}), "
            f"{self._steps():.3g} steps"
        )
        shown.append(
            f"          mechanism step {_microseconds(self.clock.window)}, series every "
            f"{units.shown(1.0 / case.run.series_rate, 'us')}"
        )
        shown += self._mode_lines()
        threads = team_size(case.machine)
        shown.append(f"forecast  on {threads} thread{'s' * (threads > 1)} about {self.forecast.text}")
        return shown + self.engine

    def _steps(self) -> float:
        return self.case.run.end / self.clock.substep

    def _machine_lines(self) -> list[str]:
        mounting = (
            f"{self.case.mounts.count} mounts"
            if self.case.mechanism.mounting == "flexible"
            else "rigid mounts"
        )
        total = sum(mass for name, mass in self.parts.items() if name != "intermediate_shaft")
        masses = ", ".join(f"{name.replace('_', ' ')} {mass:.2f}" for name, mass in self.parts.items())
        return [
            f"machine   {len(self.parts)} bodies, {mounting}, {total:.2f} kg in all;"
            f" loop closes within {units.shown(max(self.assembly_gap, 1e-9), 'um', '.3f')}; nutation "
            f"{units.shown(self.nutation_angle, 'deg', '.2f')}",
            f"          masses in kg: {masses}",
        ]

    def _mesh_lines(self) -> list[str]:
        shown: list[str] = []
        for mesh in self.meshes:
            text = (
                f"{'mesh' if not shown else '':10}{mesh.name}: {mesh.triangles} triangles, "
                f"{mesh.patches} smooth patches"
            )
            text += f", {units.shown(mesh.volume, 'L')}"
            if self.off_drawing is not None and not shown:
                more = 100 * (mesh.volume / chamber_volume(self.case) - 1)
                text += (
                    f" ({more:+.3g} % of the drawn chamber), within "
                    f"{units.shown(self.off_drawing, 'mm', '.3g')} of the drawing"
                )
            shown.append(text)
        return shown

    def _mode_lines(self) -> list[str]:
        if not self.empty_modes:
            return []
        listed = ", ".join(f"{frequency:.2f}" for frequency, _ in self.empty_modes)
        loaded = "with charge" if self.charge is not None and self.case.chamber.bars else "as it is"
        return [f"modes     empty: {listed} Hz", *crossing_lines(self.crossings, loaded)]


def preflight(case: Case, trial: Callable[[Machine], float | None] | None = None) -> Preflight:
    """Return what is known about a case without running it.

    The first call compiles the mechanism's kernels.

    Parameters
    ----------
    case : the case
    trial : measures the wall time that a simulated second takes [1], as
        `nutamill.simulation.trial.trial_rate` does; a table gives it if None

    Raises
    ------
    CaseError : a mechanism that cannot be assembled, a substep too long for the contacts, a mesh that is
        none, or too much charge
    """
    clock = run_clock(case.machine)
    machine = case.machine
    refuse_walls(machine)
    refuse_for_lammps(machine)
    mechanism, state, scratch = assemble_machine(machine)
    static_equilibrium(mechanism, state, scratch)
    charge = charge_facts(machine)
    rate = None if trial is None else trial(machine)
    loaded = with_charge_mass(case) if case.chamber.bars else case
    forecast = _forecast(case, clock, charge, rate)
    return Preflight(
        case=case,
        parts={body.name: body.mass for body in machine.bodies},
        assembly_gap=float(np.abs(scratch.gap).max()),
        nutation_angle=case.mechanism.nutation_angle,
        charge=charge,
        meshes=mesh_facts(machine),
        off_drawing=distance_from_drawing(case) if case.chamber.mesh is not None else None,
        clock=clock,
        empty_modes=oscillations(case.with_("chamber.bars.mass", 0.0) if case.chamber.bars else case),
        crossings=crossings(oscillations(loaded), case.drive),
        forecast=forecast,
        engine=engine_lines(machine, rate, trial),
        warnings=[
            *case.warnings,
            *light_carrier_warnings(machine),
            *(charge.warnings if charge is not None else []),
            *idle_threads(case.run),
            *forecast.warnings(total_memory(), free_disk(case.file_in())),
        ],
    )


def _forecast(case: Case, clock: Clock, charge: ChargeFacts | None, rate: float | None) -> Forecast:
    """Return what a run with such a charge takes, and which keys bring it down."""
    pebbles, particles = (charge.pebbles, charge.particles) if charge is not None else (0, 0)
    part = next(iter(case.charge.parts), None)
    size = (
        "charge.part"
        if case.charge.part
        else next((f"charge.{key}" for key in SIZE_KEYS if part and getattr(part, key)), "")
    )
    sooner = "an earlier run.max" if case.run.until == "steady" else "an earlier run.until"
    parts = _file_parts(case, particles, pebbles, size)
    return Forecast(
        wall_time=_wall_time(case, clock, pebbles) if rate is None else rate * case.run.end,
        memory=RUN_MEMORY + SPHERE_MEMORY * pebbles,
        file_size=sum(parts.values()),
        time_key=f"Coarser particles ({size}), softer contacts or {sooner}" if size else sooner.capitalize(),
        memory_key=FEWER.format(size) if size else "Nothing",
        file_key=max(parts, key=lambda key: parts[key]),
        by_trial=rate is not None,
    )


def wall_time(case: Case | Machine) -> float:
    """Estimate the wall time of a run [s] without settling and compilation.

    It needs no assembling, unlike the rest of `preflight`.
    """
    pebbles = sum(particles.pebbles for particles in charge_parts(case.machine))
    return _wall_time(case, run_clock(case.machine), pebbles)


def oscillations(case: Case) -> list[tuple[float, float]]:
    """Return frequencies [Hz] and damping ratios [1] of the oscillating modes about rest, slowest first.

    Rigid mounts have none.
    """
    if case.mechanism.mounting == "rigid":
        return []
    mechanism, state, scratch = assemble_machine(case.machine)
    static_equilibrium(mechanism, state, scratch)
    vibrations = modes(mechanism, state, scratch, loose="keep")
    return [
        (float(f), float(z))
        for f, z in zip(vibrations.frequency, vibrations.damping_ratio, strict=True)
        if z < 1.0
    ]


def _wall_time(case: Case | Machine, clock: Clock, pebbles: int) -> float:
    charge = charge_seconds(case.machine, clock, pebbles)
    return charge + case.run.end / clock.window * MECHANISM_MICROSECONDS * 1e-6


def _file_parts(case: Case, particles: int, pebbles: int, size: str) -> dict[str, float]:
    """Return the parts of the size of a result file [bytes], by what brings each down."""
    names = len(expand(case.mounts.count if case.mechanism.mounting == "flexible" else 0, list(case.sensors)))
    series = case.run.end * case.run.series_rate * names * 8 * PACKED
    snapshots = min(case.run.snapshots.last, case.run.end) * case.run.snapshots.rate * particles * 36 * PACKED
    times = case.run.end / case.run.checkpoint if case.run.statistics and particles else 0.0
    return {
        "A lower run.series_rate": series + 2e6,
        "A lower run.snapshots.rate": snapshots,
        "A longer run.checkpoint": times * STATISTICS_SIZE,
        FEWER.format(size): 2 * CHECKPOINT_SIZE * pebbles,
    }


def _microseconds(seconds: float) -> str:
    return units.shown(seconds, "us", ".3g")
