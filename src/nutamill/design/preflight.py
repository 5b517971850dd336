"""The pre-flight sheet: what can be known about a case before one step is run."""

from dataclasses import dataclass

import numpy as np

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.host import free_disk, total_memory
from nutamill.base.units import rpm
from nutamill.case import Case
from nutamill.case.charge import SIZE_KEYS
from nutamill.charge.filling.room import fill_faults
from nutamill.charge.particles.sizes import mass_percentiles
from nutamill.design.forecast import RUN_MEMORY, Forecast
from nutamill.mechanism.modes import modes, static_equilibrium
from nutamill.result.fields import expand
from nutamill.simulation.setup.clock import Clock, ContactFacts, contact_facts, crank_circle_speed, run_clock
from nutamill.simulation.setup.mill import assemble_mill, mill_mechanism
from nutamill.simulation.setup.particles import charge_particles, charge_parts, with_charge_mass
from nutamill.simulation.setup.threads import team_size, usable_cores
from nutamill.simulation.setup.walls import MeshFacts, charge_room, free_volume, mesh_facts

NANOSECONDS, FAR_NANOSECONDS = 85.0, 160.0
"""Wall time per sphere and substep on one thread that forecasts count with [ns]: medians of the runs of
`nutamill validate`, two at once on two cores; the second where the arrays of the charge are too large for the
nearer caches.
"""

NEAR = 20_000
"""Spheres whose arrays still fit the nearer caches [1]."""

THREAD_GAIN = 0.9
"""Share of a further thread's work that shortens the run [1], for forecasts."""

MECHANISM_MICROSECONDS = 23.0
"""Wall time per mechanism step that forecasts count with [us]."""

STATISTICS_SIZE = 4e5
"""Size of the statistics at one checkpoint, packed [bytes]: some thousand cells and patches."""
FEWER = "Fewer or coarser particles ({})"
"""What brings down all that grows with the charge, with the key of its size."""
SPHERE_MEMORY = 6e3
"""Memory for each sphere [bytes]."""
PACKED = 0.65
"""Share of its size to which a series is compressed [1], for forecasts."""


@dataclass(frozen=True, slots=True)
class Crossing:
    """A natural frequency that the ramp passes."""

    frequency: float
    """Undamped natural frequency [Hz]."""
    damping_ratio: float
    """Share of critical damping [1]."""
    speed: float
    """Driveshaft speed at which the unbalance excites it [rad/s]."""
    time: float
    """When the ramp passes that speed [s]."""


@dataclass(frozen=True, slots=True)
class PartFacts:
    """What a part of the charge comes to."""

    name: str
    """Material and kind."""
    particles: int
    """Number of particles [1]."""
    pebbles: int
    """Number of their spheres [1]."""
    mass: float
    """Their mass [kg]."""
    sizes: tuple[float, float, float]
    """Equivalent diameters below which 10, 50 and 90 % of the mass lie [m]."""
    packing: float
    """Solids fraction of the settled bed [1]."""
    filling: float
    """Volume of that bed over the free volume of the chamber [1]."""


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
    charge: list[PartFacts]
    """Facts of each part of the charge; empty without charge."""
    free_volume: float
    """Volume inside the chamber, less ribs and meshed walls [m^3]."""
    meshes: list[MeshFacts]
    """Facts of each mesh, the chamber's first."""
    contacts: list[ContactFacts]
    """Facts of each pair of materials; empty without charge."""
    clock: Clock
    """Substep, window and row."""
    empty_modes: list[tuple[float, float]]
    """Natural frequencies [Hz] and damping ratios [1] of the empty mill, slowest first."""
    crossings: list[Crossing]
    """Natural frequencies that the ramp passes, with the charge as a rigid mass at the chamber's base."""
    forecast: Forecast
    """What the run will take."""
    warnings: list[Fault]
    """What is possible but odd about the case, and what is too much for this machine."""

    def lines(self) -> list[str]:
        """The sheet as text."""
        case, count = self.case, len(self.warnings)
        state = f"{count} warning{'s' * (count != 1)}" if count else "no warnings"
        shown = [f"{case.title or case.name}: ok, {state}"]
        shown += [f"  warning: {warning}" for warning in self.warnings]
        shown += self._machine_lines()
        shown += self._mesh_lines()
        if self.contacts:
            shown += self._charge_lines()
        shown.append(
            f"time step {_microseconds(self.clock.substep)} ({self.clock.ruled_by}), "
            f"{self._steps():.3g} steps"
        )
        shown.append(
            f"          mechanism step {_microseconds(self.clock.window)}, series every "
            f"{units.shown(1.0 / case.run.series_rate, 'us')}"
        )
        shown += self._mode_lines()
        threads = team_size(case)
        shown.append(f"forecast  on {threads} thread{'s' * (threads > 1)} about {self.forecast.text}")
        return shown

    @property
    def particles(self) -> int:
        """Number of particles [1]."""
        return sum(part.particles for part in self.charge)

    @property
    def charge_mass(self) -> float:
        """Their mass [kg]."""
        return sum(part.mass for part in self.charge)

    @property
    def filling(self) -> float:
        """Volume of the charge as a settled bed over the free volume of the chamber [1]."""
        return sum(part.filling for part in self.charge)

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
            f" loop closes within {max(1e6 * self.assembly_gap, 0.001):.3f} um; nutation "
            f"{units.shown(self.nutation_angle, 'deg', '.2f')}",
            f"          masses in kg: {masses}",
        ]

    def _mesh_lines(self) -> list[str]:
        shown = []
        for mesh in self.meshes:
            text = (
                f"{'mesh' if not shown else '':10}{mesh.name}: {mesh.triangles} triangles, "
                f"{mesh.patches} smooth patches"
            )
            text += f", {1e3 * mesh.volume:.4g} L"
            if mesh.volume_drawn is not None:
                more = 100 * (mesh.volume / mesh.volume_drawn - 1)
                text += (
                    f" ({more:+.3g} % of the drawn chamber), within "
                    f"{units.shown(mesh.off_drawing, 'mm', '.3g')} of the drawing"
                )
            shown.append(text)
        return shown

    def _charge_lines(self) -> list[str]:
        speed = crank_circle_speed(self.case)
        shown = [
            self._amount_line(part, "          " if number else "charge    ")
            for number, part in enumerate(self.charge)
        ]
        if len(shown) > 1:
            shown.append(
                f"          together {self.particles}, {self.charge_mass:.4g} kg, "
                f"{self._fill_text(self.filling)}"
            )
        shown += [
            f"contacts  {'pair':22} {'k normal':>10} {'duration':>9} "
            f"{f'overlap at {speed:.1f} m/s':>20} {'restitution':>11}"
            f" {'damping':>8} {'friction':>8}",
        ]
        for facts in self.contacts:
            soft = "  soft" if facts.overlap > facts.law.overlap_warn else ""
            shown.append(
                f"          {facts.pair:22} {units.shown(facts.stiffness, 'kN/m', '5.4g')} "
                f"{units.shown(facts.time, 'us', '6.0f')} {100 * facts.overlap:16.1f} % d"
                f" {facts.restitution:11.3f} {facts.law.damping_ratio:8.4f} "
                f"{facts.law.static_friction:8.3g}{soft}"
            )
        return shown

    def _amount_line(self, part: PartFacts, head: str) -> str:
        """Number, mass, sizes and fill of a part of the charge."""
        ten, half, ninety = (units.in_unit(size, "mm") for size in part.sizes)
        spread = f"d10/50/90 {ten:.3g}/{half:.3g}/{ninety:.3g} mm" if ninety > ten else f"d {half:.4g} mm"
        pebbles = f" of {part.pebbles} spheres" if part.pebbles > part.particles else ""
        return (
            f"{head}{part.particles} {part.name}{pebbles}, {part.mass:.4g} kg, {spread}, "
            f"{self._fill_text(part.filling, part.packing)}"
        )

    def _fill_text(self, filling: float, packing: float | None = None) -> str:
        """Bulk volume as a share of the chamber, in litres, and as a height."""
        chamber = self.case.chamber
        at = f" at solids fraction {packing:.3g}" if packing else ""
        volume, height = 1e3 * filling * self.free_volume, 1e3 * filling * chamber.height
        return (
            f"fill {100 * filling:.1f} % loose{at} ({volume:.2f} L, {height:.0f} mm of "
            f"{1e3 * chamber.height:.0f} mm)"
        )

    def _mode_lines(self) -> list[str]:
        if not self.empty_modes:
            return []
        listed = ", ".join(f"{frequency:.2f}" for frequency, _ in self.empty_modes)
        loaded = "with charge" if self.particles and self.case.chamber.bars else "as it is"
        shown = [f"modes     empty: {listed} Hz"]
        last = ""
        for crossing in self.crossings:
            place = f"{crossing.frequency:.2f} Hz = {rpm(crossing.speed):.0f} rpm"
            if place == last:  # the two sways of a machine that is alike in x and y
                continue
            last = place
            shown.append(
                f"          {loaded}: {place} (damping {100 * crossing.damping_ratio:.1f} %)"
                f" is passed at t = {crossing.time:.1f} s; the largest motion comes later"
            )
        return shown


def preflight(case: Case) -> Preflight:
    """Return what is known about a case without running it; compiles the mechanism's kernels the first
    time.

    Raises
    ------
    CaseError : a mechanism that cannot be assembled, a substep too long for the contacts, a mesh that is
        none, or too much charge
    """
    clock = run_clock(case)
    mill = mill_mechanism(case)
    mechanism, state, scratch = assemble_mill(mill)
    static_equilibrium(mechanism, state, scratch)
    room = free_volume(case)
    charge = _part_facts(case, room)
    pebbles = sum(part.pebbles for part in charge)
    _refuse_full(case, room)
    forecast = _forecast(case, clock, pebbles, sum(part.particles for part in charge))
    return Preflight(
        case=case,
        parts={body.name: body.mass for body in mill.bodies},
        assembly_gap=float(np.abs(scratch.gap).max()),
        nutation_angle=case.mechanism.nutation_angle,
        charge=charge,
        free_volume=room,
        meshes=mesh_facts(case),
        contacts=contact_facts(case) if charge else [],
        clock=clock,
        empty_modes=oscillations(case.with_("chamber.bars.mass", 0.0) if case.chamber.bars else case),
        crossings=_crossings(case),
        forecast=forecast,
        warnings=[
            *case.warnings,
            *_idle_threads(case),
            *forecast.warnings(total_memory(), free_disk(case.file_in())),
        ],
    )


def _idle_threads(case: Case) -> list[Fault]:
    """Return a warning where a case asks for more threads than there are cores."""
    cores = usable_cores()
    if case.run.threads == "auto" or case.run.threads <= cores:
        return []
    what = f"asks for {case.run.threads} threads on a machine with {cores} core{'s' * (cores > 1)}"
    return [Fault("run.threads", what, 'More threads than cores slow a run down: write threads = "auto"')]


def _forecast(case: Case, clock: Clock, pebbles: int, particles: int) -> Forecast:
    """Return what a run with so many spheres in so many particles takes, and which keys bring it down."""
    part = next(iter(case.charge.parts), None)
    size = (
        "charge.part"
        if case.charge.part
        else next((f"charge.{key}" for key in SIZE_KEYS if part and getattr(part, key)), "")
    )
    sooner = "an earlier run.max" if case.run.until == "steady" else "an earlier run.until"
    parts = _file_parts(case, particles, size)
    return Forecast(
        wall_time=_wall_time(case, clock, pebbles),
        memory=RUN_MEMORY + SPHERE_MEMORY * pebbles,
        file_size=sum(parts.values()),
        time_key=f"Coarser particles ({size}), softer contacts or {sooner}" if size else sooner.capitalize(),
        memory_key=FEWER.format(size) if size else "Nothing",
        file_key=max(parts, key=lambda key: parts[key]),
    )


def _refuse_full(case: Case, room: float) -> None:
    """Raise CaseError where the beds asked for need more than a free volume of `room` [m^3], or cannot be
    placed in it.
    """
    if not case.charge.parts:
        return
    densities = [case.materials[part.material].density for part in case.charge.parts]
    asked = zip(case.charge.parts, densities, strict=True)
    needed = sum(part.solid_volume(density, room) / part.packing for part, density in asked)
    if needed > room * (1.0 + 1e-9):
        what = f"does not fit as a loose bed, got {1e3 * needed:.4g} L where {1e3 * room:.4g} L are free"
        raise CaseError(Fault("charge", what, "Take less charge or a larger chamber"))
    if faults := fill_faults(charge_particles(case).bounding_radius, charge_room(case)):
        raise CaseError(*faults)


def wall_time(case: Case) -> float:
    """Expected wall time of a run [s], settling and compilation left out; of `preflight` this alone, which
    takes no assembling.
    """
    return _wall_time(case, run_clock(case), sum(particles.pebbles for particles in charge_parts(case)))


def _part_facts(case: Case, room: float) -> list[PartFacts]:
    """What each part of the charge comes to in a free volume of `room` [m^3]."""
    facts = []
    for part, particles in zip(case.charge.parts, charge_parts(case), strict=True):
        volume = particles.volume
        solid = float(volume.sum())
        facts.append(
            PartFacts(
                name=f"{part.kind} of {part.material}",
                particles=particles.number,
                pebbles=particles.pebbles,
                mass=solid * case.materials[part.material].density,
                sizes=tuple(mass_percentiles(particles.diameter, volume)),
                packing=part.packing,
                filling=solid / part.packing / room,
            )
        )
    return facts


def oscillations(case: Case) -> list[tuple[float, float]]:
    """Frequencies [Hz] and damping ratios [1] of the modes that swing, about rest, slowest first; none on
    rigid mounts.
    """
    if case.mechanism.mounting == "rigid":
        return []
    mechanism, state, scratch = assemble_mill(mill_mechanism(case))
    static_equilibrium(mechanism, state, scratch)
    vibrations = modes(mechanism, state, scratch, loose="keep")
    return [
        (float(f), float(z))
        for f, z in zip(vibrations.frequency, vibrations.damping_ratio, strict=True)
        if z < 1.0
    ]


def _crossings(case: Case) -> list[Crossing]:
    """Modes between rest and full speed, with the charge as a rigid mass at the chamber's base if it has one,
    and when they are passed.
    """
    loaded = with_charge_mass(case) if case.chamber.bars else case
    times, speeds = case.drive.breakpoints()
    crossings = []
    for frequency, damping in oscillations(loaded):
        speed = 2 * np.pi * frequency
        above = np.flatnonzero(speeds >= speed)
        if above.size and above[0] > 0:
            k = above[0]
            time = times[k - 1] + (speed - speeds[k - 1]) / (speeds[k] - speeds[k - 1]) * (
                times[k] - times[k - 1]
            )
            crossings.append(Crossing(frequency, damping, speed, float(time)))
    return crossings


def _wall_time(case: Case, clock: Clock, pebbles: int) -> float:
    threads = 1 + THREAD_GAIN * (team_size(case) - 1)
    nanoseconds = NANOSECONDS if pebbles <= NEAR else FAR_NANOSECONDS
    charge = case.run.end / clock.substep * pebbles * nanoseconds * 1e-9 / threads
    return charge + case.run.end / clock.window * MECHANISM_MICROSECONDS * 1e-6


def _file_parts(case: Case, particles: int, size: str) -> dict[str, float]:
    """Return the parts of the size of a result file [bytes], by what brings each down."""
    names = len(expand(case.mounts.count if case.mechanism.mounting == "flexible" else 0, list(case.sensors)))
    series = case.run.end * case.run.series_rate * names * 8 * PACKED
    snapshots = min(case.run.snapshots.last, case.run.end) * case.run.snapshots.rate * particles * 36 * PACKED
    times = case.run.end / case.run.checkpoint if case.run.statistics and particles else 0.0
    return {
        "A lower run.series_rate": series + 2e6,
        "A lower run.snapshots.rate": snapshots,
        "A longer run.checkpoint": times * STATISTICS_SIZE,
        FEWER.format(size): 2 * 1.5e3 * particles,
    }


def _microseconds(seconds: float) -> str:
    return units.shown(seconds, "us", ".3g")
