"""What is known of the charge of a machine before it is run: amounts, contacts, and what they cost."""

import math
from dataclasses import dataclass

import numpy as np

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.required import required
from nutamill.case.charge import Portion
from nutamill.case.machine import Machine
from nutamill.case.placement import region_axes
from nutamill.charge.filling.room import fill_faults
from nutamill.charge.particles.particles import Particles
from nutamill.charge.particles.sizes import mass_percentiles
from nutamill.simulation.setup.clock import Clock, ContactFacts, contact_facts, contact_speed
from nutamill.simulation.setup.particles import charge_parts
from nutamill.simulation.setup.regions import charge_room, free_volume, region_of
from nutamill.simulation.setup.threads import team_size
from nutamill.simulation.setup.walls import region_corners

NANOSECONDS, FAR_NANOSECONDS = 85.0, 160.0
"""Wall time per sphere and substep on one thread that forecasts count with [ns]: medians of the runs of
`nutamill validate`, two at once on two cores; the second where the arrays of the charge are too large for the
nearer caches.
"""

NEAR = 20_000
"""Spheres whose arrays still fit the nearer caches [1]."""

THREAD_GAIN = 0.9
"""Share of a further thread's work that shortens the run [1], for forecasts."""

SPHERE_MEMORY = 6e3
"""Memory for each sphere [bytes]."""

WIDE = 20.0
"""Diameter of the largest sphere over that of the smallest from which on a charge gives a warning [1]."""


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
    """Volume of that bed over the free volume of its region [1]."""
    region: str
    """The region that it is put into."""


@dataclass(frozen=True, slots=True)
class ChargeFacts:
    """What a charge comes to."""

    parts: list[PartFacts]
    """Its parts."""
    contacts: list[ContactFacts]
    """Facts of each pair of materials."""
    volumes: dict[str, tuple[float, float]]
    """Free volume [m^3] and height [m] of each region that is filled."""
    diameters: tuple[float, float]
    """Smallest and largest diameter of their spheres [m]."""

    @property
    def particles(self) -> int:
        """Number of particles [1]."""
        return sum(part.particles for part in self.parts)

    @property
    def pebbles(self) -> int:
        """Number of their spheres [1]."""
        return sum(part.pebbles for part in self.parts)

    @property
    def mass(self) -> float:
        """Their mass [kg]."""
        return sum(part.mass for part in self.parts)

    @property
    def filling(self) -> float:
        """Volume of the charge as settled beds over the free volume of the regions [1]."""
        bulk = sum(part.filling * self.volumes[part.region][0] for part in self.parts)
        return bulk / sum(volume for volume, _ in self.volumes.values())

    @property
    def warnings(self) -> list[Fault]:
        """A warning, with what it costs, of spheres of very different sizes."""
        smallest, largest = self.diameters
        ratio = largest / smallest
        if ratio <= WIDE:
            return []
        # spheres side by side on the larger one, each on a hexagon
        touched = 2.0 * math.pi / math.sqrt(3.0) * (1.0 + ratio) ** 2
        what = (
            f"the largest sphere is {ratio:.0f} times as wide as the smallest, "
            f"{units.shown(smallest, 'mm', '.3g')}, and may touch {touched:.2g} of them at once. All "
            f"{self.pebbles} spheres march with the substep of the smallest"
        )
        return [Fault("charge", what, "A larger smallest size makes the run shorter")]

    def lines(self, machine: Machine) -> list[str]:
        """Return the charge and its contacts as text."""
        shown = [
            self._amount_line(part, "          " if number else "charge    ")
            for number, part in enumerate(self.parts)
        ]
        if len(shown) > 1:
            together = f"          together {self.particles}, {self.mass:.4g} kg"
            one = len(self.volumes) == 1
            region = self.parts[0].region
            shown.append(together + (f", {self._fill_text(self.filling, region)}" if one else ""))
        speed = contact_speed(machine)
        shown += [
            f"contacts  at {speed:.1f} m/s; k stiffness, e restitution, d damping ratio, f friction",
            f"          {'pair':20} {'k':>10} {'duration':>9} {'overlap':>9} {'e':>5} {'d':>6} {'f':>5}",
        ]
        for facts in self.contacts:
            soft = "  soft" if facts.overlap > facts.law.overlap_warn else ""
            shown.append(
                f"          {facts.pair:20} {units.shown(facts.stiffness, 'kN/m', '5.4g'):>10} "
                f"{units.shown(facts.time, 'us', '.0f'):>9} {f'{100 * facts.overlap:.1f} % d':>9} "
                f"{facts.restitution:5.2f} {facts.law.damping_ratio:6.3f} "
                f"{facts.law.static_friction:5.3g}{soft}"
            )
        return shown + self._film_lines() + self._bridge_lines()

    def _film_lines(self) -> list[str]:
        """Return Stokes numbers of the films of a wet charge."""
        shown = []
        for facts in self.contacts:
            if facts.film is not None and facts.law.liquid_viscosity > 0.0:
                thickness, roughness = (
                    units.shown(size, "um", ".3g")
                    for size in (facts.law.film_thickness, facts.law.film_roughness)
                )
                shown.append(
                    f"          {facts.pair:20} film {thickness} to {roughness}, St {facts.film.stokes:.3g}, "
                    f"sticks below {facts.film.sticks_below:.3g}"
                )
        return ["liquid    films, and Stokes numbers at the same speed", *shown] if shown else []

    def _bridge_lines(self) -> list[str]:
        """Return pull, reach and work of the bridges of a wet charge."""
        shown = [
            f"          {facts.pair:20} pull {units.shown(facts.bridge.pull, 'mN', '.3g')}, breaks at "
            f"{units.shown(facts.bridge.rupture, 'um', '.3g')}, parting takes {facts.bridge.work:.2e} J"
            for facts in self.contacts
            if facts.bridge is not None
        ]
        return ["bridges   of the quickest particles", *shown] if shown else []

    def _amount_line(self, part: PartFacts, head: str) -> str:
        """Return number, mass, sizes and fill of a part of the charge."""
        ten, half, ninety = (units.in_unit(size, "mm") for size in part.sizes)
        spread = f"d10/50/90 {ten:.3g}/{half:.3g}/{ninety:.3g} mm" if ninety > ten else f"d {half:.4g} mm"
        pebbles = f" of {part.pebbles} spheres" if part.pebbles > part.particles else ""
        return (
            f"{head}{part.particles} {part.name}{pebbles}, {part.mass:.4g} kg, {spread}, "
            f"{self._fill_text(part.filling, part.region, part.packing)}"
        )

    def _fill_text(self, filling: float, region: str, packing: float | None = None) -> str:
        """Return bulk volume as a share of the region, in litres, and as a height."""
        volume, height = self.volumes[region]
        at = f" at solids fraction {packing:.3g}" if packing else ""
        return (
            f"fill {100 * filling:.1f} % loose{at} ({units.shown(filling * volume, 'L', '.2f')}, "
            f"{units.shown(filling * height, 'mm', '.0f')} of {units.shown(height, 'mm', '.0f')})"
        )


def charge_facts(machine: Machine) -> ChargeFacts | None:
    """Compute number, mass, filling and contact numbers of the charge of a machine, or None without a charge.

    Raises
    ------
    CaseError : more charge than a region holds
    """
    if not machine.charge.parts:
        return None
    volumes: dict[str, tuple[float, float]] = {}
    parts: list[PartFacts] = []
    for name in dict.fromkeys(region_of(machine, part).name for part in machine.charge.parts):
        region = next(one for one in machine.regions if one.name == name)
        seen = region_corners(machine, region) @ region_axes(region)[:, 2]
        height = required(region.height) if region.shape == "cylinder" else float(np.ptp(seen))
        volumes[name] = (free_volume(machine, region), height)
        _refuse_full(machine, name)
    diameters: list[float] = []
    for part, particles in zip(machine.charge.parts, charge_parts(machine), strict=True):
        diameters += _sphere_diameters(particles)
        name = region_of(machine, part).name
        density = machine.materials[required(part.material)].density
        parts.append(_facts(part, particles, density, name, volumes[name][0]))
    return ChargeFacts(parts, contact_facts(machine), volumes, (min(diameters), max(diameters)))


def _sphere_diameters(particles: Particles) -> list[float]:
    """Return the smallest and largest diameter of the spheres of each shape [m]."""
    diameters: list[float] = []
    for number, shape in enumerate(particles.shapes):
        scale = particles.scale[particles.shape_of == number]
        if len(scale):
            ends = shape.radii.min() * scale.min(), shape.radii.max() * scale.max()
            diameters += [2.0 * float(radius) for radius in ends]
    return diameters


def _facts(part: Portion, particles: Particles, density: float, region: str, room: float) -> PartFacts:
    """Return what a part of the charge comes to in a free volume of `room` [m^3]."""
    volume = particles.volume
    solid = float(volume.sum())
    ten, half, ninety = mass_percentiles(particles.diameter, volume)
    return PartFacts(
        name=f"{part.kind} of {part.material}",
        particles=particles.number,
        pebbles=particles.pebbles,
        mass=solid * density,
        sizes=(ten, half, ninety),
        packing=part.packing,
        filling=solid / part.packing / room,
        region=region,
    )


def _refuse_full(machine: Machine, name: str) -> None:
    """Raise CaseError where the beds asked for in a region need more than its free volume, or cannot be
    placed in it.
    """
    region = next(one for one in machine.regions if one.name == name)
    room, parts = free_volume(machine, region), charge_parts(machine)
    members = [n for n, part in enumerate(machine.charge.parts) if region_of(machine, part).name == name]
    needed = 0.0
    for number in members:
        part = machine.charge.parts[number]
        needed += part.solid_volume(machine.materials[required(part.material)].density, room) / part.packing
    if needed > room * (1.0 + 1e-9):
        volumes = f"{units.shown(needed, 'L')} where {units.shown(room, 'L')} are free"
        what = f"does not fit as a loose bed, got {volumes}"
        raise CaseError(Fault("charge", what, "Take less charge or a larger chamber"))
    radii = np.concatenate([parts[number].bounding_radius for number in members])
    if faults := fill_faults(radii, charge_room(machine, region)):
        raise CaseError(*faults)


def charge_seconds(machine: Machine, clock: Clock, pebbles: int) -> float:
    """Return the wall time that the charge of a run takes, with so many spheres [s]."""
    threads = 1 + THREAD_GAIN * (team_size(machine) - 1)
    nanoseconds = NANOSECONDS if pebbles <= NEAR else FAR_NANOSECONDS
    return machine.run.end / clock.substep * pebbles * nanoseconds * 1e-9 / threads
