"""Checks that need more than one key: what contradicts, and what is odd.

A finding is (key, what, hint); the key is a tuple of its parts, which gives its line in the file.
"""

import math
from typing import TYPE_CHECKING, Any

from nutamill.base import units
from nutamill.base.errors import Fault
from nutamill.base.library import similar
from nutamill.base.units import Kind
from nutamill.case.charge import Portion, portion_faults, stand_ins
from nutamill.case.contact_laws import GIVEN_BY, INSTEAD, OPTIONAL, OTHERWISE, READS
from nutamill.case.touching import wall_keys
from nutamill.result.fields import expand

if TYPE_CHECKING:
    from nutamill.case.mill import Case

Finding = tuple[tuple[str | int, ...], str, str]

SENSOR_BODIES = ("frame", "chamber", "carriage", "driveshaft", "bearing_cross", "intermediate_shaft")
"""Parts a sensor can sit on."""

MOST_PARTICLES = 2e7
"""Particles above which a case is refused as a slip of the pen [1]."""
MOST_NUMBERS = 1e10
"""Numbers of all series, and of all snapshots, above which a case is refused as a slip of the pen [1]."""
MOST_CHECKPOINTS = 1e5
"""Checkpoints above which a case is refused as a slip of the pen [1]."""
PARTICLE_NUMBERS = 9
"""Numbers that a snapshot holds of a particle [1]."""

ANGLE_STOP = math.radians(1.0)
"""Difference between the printed nutation angle and that of the crank's lengths at which a case is refused
[rad].
"""


def faults(case: "Case") -> list[Finding]:
    """Everything that contradicts."""
    checks = (_geometry, _ribs, _inertia, _materials, _laws, _pairs, _charge, _record)
    return [finding for check in checks for finding in check(case)]


def warnings(case: "Case") -> list[Fault]:
    """Everything that is possible but odd."""
    findings = [*_rounded_angle(case), *stand_ins(case.charge)]
    if case.run.end < case.drive.ramp_end:
        what = f"the run ends at {case.run.end:g} s, before the speed is reached at {case.drive.ramp_end:g} s"
        findings.append(Fault("run.until", what, "There will be no steady mean"))
    return findings + _idle_numbers(case)


def _rounded_angle(case: "Case") -> list[Fault]:
    """Warn of a nutation angle that is not the crank's, rounded to the digits that were written: 6 deg agrees
    with 6.082 deg.
    """
    written = f"{math.degrees(case.chamber.nutation_angle):.12g}"
    used = math.degrees(case.mechanism.nutation_angle)
    decimals = len(written.partition(".")[2])
    if float(written) == round(used, decimals):
        return []
    what = f"{written} deg is not used: crank_radius and nutation_point_to_crank give {used:.3f} deg"
    return [
        Fault(
            "chamber.nutation_angle", what, f'Write nutation_angle = "{used:.3f} deg", or change the lengths'
        )
    ]


def _idle_numbers(case: "Case") -> list[Fault]:
    """Numbers of pairs in contact that the chosen laws do not read: who writes one expects it to be used."""
    contact, findings = case.contact, []
    idle = [(number, law) for number, (law, reader) in OPTIONAL.items() if getattr(contact, law) != reader]
    for name in filter(None, (_pair_name(case, *pair) for pair in _contacts(case))):
        for number, law in idle:
            if getattr(contact.pairs[name], number) is not None:
                findings.append(
                    Fault(
                        f"contact.pairs.{name}.{number}",
                        f'is not used with contact.{law} = "{getattr(contact, law)}"',
                    )
                )
    return findings


def frame_mass(case: "Case") -> float:
    """Mass of the frame [kg]: the machine on its mounts less chamber, carriage, driveshaft and bearing cross.

    The intermediate shaft hangs on the ground and is not part of the total.
    """
    parts = case.chamber.mass + case.carriage.mass + case.driveshaft.mass + case.bearing_cross.mass
    return case.mechanism.total_mass - parts


def _record(case: "Case") -> list[Finding]:
    """Records that hold nothing, or more than can be meant."""
    mounts = case.mounts.count if case.mechanism.mounting == "flexible" else 0
    findings = record_findings(case.run, len(expand(mounts, list(case.sensors))))
    particles = max((part.count or 0 for part in case.charge.parts), default=0)
    snapshots = min(case.run.snapshots.last, case.run.end) * case.run.snapshots.rate
    if (numbers := snapshots * PARTICLE_NUMBERS * max(1, particles)) > MOST_NUMBERS:
        findings.append(
            (("run", "snapshots", "rate"), _too_many(numbers), "Lower it, or shorten run.snapshots.last")
        )
    return findings


def record_findings(run: Any, series: int) -> list[Finding]:
    """Return what is wrong with the series and checkpoints of a run of any kind of case, with this number of
    series.
    """
    rows, findings = run.end * run.series_rate, []
    if rows < 1.0:
        what = f"must give at least one row in {run.end:g} s, got {rows:.2g}"
        findings.append((("run", "series_rate"), what, f'Write e.g. "{units.example(Kind.FREQUENCY)}"'))
    if rows * series > MOST_NUMBERS:
        findings.append((("run", "series_rate"), _too_many(rows * series), "Lower it, or end the run sooner"))
    if (checkpoints := run.end / run.checkpoint) > MOST_CHECKPOINTS:
        what = f"makes {checkpoints:.2g} checkpoints, more than the limit of {MOST_CHECKPOINTS:.0e}"
        findings.append((("run", "checkpoint"), what, "Take a longer time"))
    return findings


def _too_many(numbers: float) -> str:
    return f"makes {numbers:.2g} numbers to record, more than the limit of {MOST_NUMBERS:.0e}"


def _geometry(case: "Case") -> list[Finding]:
    findings: list[Finding] = []
    chamber, mechanism = case.chamber, case.mechanism
    ruling = case.mechanism.nutation_angle
    if abs(chamber.nutation_angle - ruling) > ANGLE_STOP:
        lengths = (
            f"crank_radius {_mm(mechanism.crank_radius)} and nutation_point_to_crank "
            f"{_mm(mechanism.nutation_point_to_crank)}"
        )
        what = (
            f"{lengths} give {math.degrees(ruling):.2f} deg, but nutation_angle is "
            f"{math.degrees(chamber.nutation_angle):.4g} deg"
        )
        hint = (
            "One of the three is wrong; with these lengths write nutation_angle = "
            f'"{math.degrees(ruling):.3f} deg"'
        )
        findings.append((("chamber", "nutation_angle"), what, hint))
    if chamber.height >= chamber.floor_depth:
        what = f"must be less than floor_depth {_mm(chamber.floor_depth)}, got {_mm(chamber.height)}"
        findings.append((("chamber", "height"), what, "The ceiling has to lie below the nutation point"))
    if frame_mass(case) <= 0.0:
        parts = mechanism.total_mass - frame_mass(case)
        names = "chamber, carriage, driveshaft and bearing cross"
        what = f"must exceed the {parts:.4g} kg of {names}, got {mechanism.total_mass:g} kg"
        findings.append((("mechanism", "total_mass"), what, "The frame takes what the other parts leave"))
    return findings


def _ribs(case: "Case") -> list[Finding]:
    chamber, rib = case.chamber, case.chamber.rib
    if not chamber.ribs:
        return []
    if rib is None:
        return [
            (
                ("chamber", "rib"),
                f"is missing, with ribs = {chamber.ribs}",
                "Add a table [chamber.rib] with width, depth, length",
            )
        ]
    radius = 0.5 * chamber.inner_diameter
    if rib.depth >= radius:
        return [
            (
                ("chamber", "rib", "depth"),
                f"must be less than the radius of the bore {_mm(radius)}, got {_mm(rib.depth)}",
                "",
            )
        ]
    # neighbours touch first at their inner edges: two half widths under the angle between two ribs
    room = 2.0 * (radius - rib.depth) * math.tan(math.pi / chamber.ribs) if chamber.ribs > 2 else math.inf
    if rib.width >= min(room, 2.0 * radius):
        what = (
            f"{chamber.ribs} ribs of {_mm(rib.width)} by {_mm(rib.depth)} do not fit: there is room for "
            f"{_mm(min(room, 2 * radius))} each"
        )
        return [(("chamber", "ribs"), what, "Fewer or narrower ribs")]
    return []


def _inertia(case: "Case") -> list[Finding]:
    """Moments of inertia that no body can have: the largest principal one is at most the sum of the other
    two.
    """
    findings: list[Finding] = []
    chamber = case.chamber
    steiner = chamber.mass * chamber.mass_centre_depth**2
    central = chamber.inertia_transverse - steiner
    if central <= 0.0:
        what = (
            f"must exceed mass x mass_centre_depth^2 = {steiner:.4g} kg m^2, got "
            f"{chamber.inertia_transverse:.4g} kg m^2"
        )
        findings.append((("chamber", "inertia_transverse"), what, "It is taken about the nutation point"))
    elif chamber.inertia_axial > 2.0 * central:
        most = f"twice the transverse one about the mass centre, {2 * central:.4g} kg m^2"
        what = f"must be at most {most}, got {chamber.inertia_axial:.4g} kg m^2"
        findings.append((("chamber", "inertia_axial"), what, ""))
    for table in ("driveshaft", "intermediate_shaft"):
        part = getattr(case, table)
        if part.inertia_axial > 2.0 * part.inertia_transverse:
            most = f"twice inertia_transverse, {2 * part.inertia_transverse:.4g} kg m^2"
            what = f"must be at most {most}, got {part.inertia_axial:.4g} kg m^2"
            findings.append(((table, "inertia_axial"), what, ""))
    return findings


def _portions(case: "Case") -> list[tuple[tuple[str | int, ...], Portion]]:
    """Parts of the charge, each with the key of its table."""
    if case.charge.part:
        return [(("charge", "part", number), part) for number, part in enumerate(case.charge.part)]
    return [(("charge",), part) for part in case.charge.parts]


def _needed_materials(case: "Case") -> dict[tuple[str | int, ...], str | None]:
    """Materials the run needs, by the key that names them."""
    portions = _portions(case)
    return {(*key, "material"): part.material for key, part in portions} | wall_keys(case) if portions else {}


def _materials(case: "Case") -> list[Finding]:
    findings: list[Finding] = []
    known = sorted(case.materials)
    for key, name in _needed_materials(case).items():
        if name is not None and name not in case.materials:
            hint = similar(name, known) if known else f"Add a table [materials.{name}]"
            findings.append((key, f'no material is called "{name}"', hint))
    for name in known:
        if "-" in name:
            hint = f"Write {name.replace('-', '_')}; a hyphen joins the two materials of a pair"
            findings.append((("materials", name), "the name of a material must not contain a hyphen", hint))
    return findings


def _laws(case: "Case") -> list[Finding]:
    """Laws that do not go together."""
    contact, findings = case.contact, []
    for number, (key, choice) in GIVEN_BY.items():
        if getattr(contact, key) == choice and number not in READS["normal"][contact.normal]:
            what = f'must be "{OTHERWISE[choice]}" with normal = "{contact.normal}", got "{choice}"'
            findings.append((("contact", key), what, INSTEAD.get(contact.normal, "")))
    if contact.cohesion == "none":
        for name, pair in contact.pairs.items():
            if pair.cohesive_pressure:
                what = 'has no effect with contact.cohesion = "none"'
                key = ("contact", "pairs", name, "cohesive_pressure")
                findings.append((key, what, 'Write cohesion = "area" in [contact], or leave it out'))
    return findings


def _pairs(case: "Case") -> list[Finding]:
    findings: list[Finding] = []
    pairs, known = case.contact.pairs, case.materials
    possible = [f"{a}-{b}" for a in known for b in known]
    for name, pair in pairs.items():
        key = ("contact", "pairs", name)
        first, _, second = name.partition("-")
        if name not in possible:
            findings.append((key, "must name two materials of the file", similar(name, possible)))
        elif first != second and f"{second}-{first}" in pairs and first > second:
            findings.append(
                (key, f"this pair appears twice, also as {second}-{first}", "Keep one of the two")
            )
        if pair.overlap_warn >= pair.overlap_stop:
            findings.append(
                (
                    (*key, "overlap_warn"),
                    f"must be less than overlap_stop {pair.overlap_stop:g}, got {pair.overlap_warn:g}",
                    "",
                )
            )
    needs = [
        (number, law) for number, (law, reader) in OPTIONAL.items() if getattr(case.contact, law) == reader
    ]
    for charge, other in _contacts(case):
        name = _pair_name(case, charge, other)
        if name is None:
            what = f"is missing: the charge is {charge} and touches {other}"
            findings.append(
                (
                    ("contact", "pairs", f"{charge}-{other}"),
                    what,
                    f"Add a table [contact.pairs.{charge}-{other}]",
                )
            )
            continue
        for number, law in needs:
            if getattr(pairs[name], number) is None:
                what = f'is missing, with contact.{law} = "{getattr(case.contact, law)}"'
                findings.append((("contact", "pairs", name, number), what, f"Add {number} to the pair"))
    return findings


def _pair_name(case: "Case", first: str, second: str) -> str | None:
    """Name of the pair of two materials as the file has it, in either order; None if it has none."""
    return next(
        (name for name in (f"{first}-{second}", f"{second}-{first}") if name in case.contact.pairs), None
    )


def _contacts(case: "Case") -> list[tuple[str, str]]:
    """Pairs of known materials that may touch, the charge's first, each pair once."""
    known, pairs = case.materials, []
    for first, second, _ in case.touching:
        listed = (first, second) in pairs or (second, first) in pairs
        if first in known and second in known and not listed:
            pairs.append((first, second))
    return pairs


def _charge(case: "Case") -> list[Finding]:
    charge = case.charge
    if charge.part:
        own = [
            key
            for key, value in charge.model_dump(exclude={"part", "packing"}, exclude_none=True).items()
            if value is not None
        ]
        if own:
            what = f"a charge has either parts or keys of its own, got parts and {', '.join(own)}"
            return [(("charge", own[0]), what, "Move it into a [[charge.part]]")]
    elif charge.kind is None:
        return [
            (("charge", "kind"), "is missing", 'Write e.g. kind = "spheres", or add tables [[charge.part]]')
        ]
    findings = [
        ((*key, inner), what, hint)
        for key, part in _portions(case)
        for inner, what, hint in portion_faults(part)
    ]
    if findings:
        return findings
    room = min(case.chamber.inner_diameter, case.chamber.height)
    for key, part in _portions(case):
        given = next(
            name for name in ("diameter", "sizes", "distribution") if getattr(part, name) is not None
        )
        if part.size_range[1] >= room:
            findings.append(
                (
                    (*key, given),
                    f"must be less than the chamber's {_mm(room)}, got {_mm(part.size_range[1])}",
                    "",
                )
            )
    if findings or not all(name in case.materials for name in charge.materials):
        return findings
    return _amounts(case)


def _amounts(case: "Case") -> list[Finding]:
    """More particles than can be meant, or more charge than the chamber holds when poured; what meshes leave
    is not known here.
    """
    free = case.chamber.free_volume
    findings, loose = [], 0.0
    for key, part in _portions(case):
        amount = next(name for name in ("mass", "count", "fill") if getattr(part, name) is not None)
        density = case.materials[part.material].density
        solid = part.solid_volume(density, free)
        loose += solid / part.packing
        if (number := solid / part.size_law().mean_volume) > MOST_PARTICLES:
            what = f"makes {number:.2g} particles, more than the limit of {MOST_PARTICLES:.0e}"
            findings.append(((*key, amount), what, "Take less, or coarser particles"))
    if findings or loose <= free * (1.0 + 1e-9) or case.chamber.mesh is not None:
        return findings
    kind = "ribbed chamber" if case.chamber.ribs else "chamber"
    holds = f"L loose, the {kind} holds {1e3 * free:.3g} L"
    if case.charge.part:
        return [(("charge", "part"), f"the parts need {1e3 * loose:.3g} {holds}", "Take less of one")]
    if amount == "mass":
        most = math.floor(free * density * part.packing * 1000.0) / 1000.0
        return [
            (
                (*key, amount),
                f"{part.mass:g} kg needs {1e3 * loose:.3g} {holds}",
                f"Largest mass that settles: {most:.4g} kg",
            )
        ]
    most = math.floor(part.count * free / loose)
    return [
        (
            (*key, amount),
            f"{part.count} particles need {1e3 * loose:.3g} {holds}",
            f"Largest number that settles: {most}",
        )
    ]


def _mm(length: float) -> str:
    return units.format(float(f"{length:.4g}"), Kind.LENGTH)
