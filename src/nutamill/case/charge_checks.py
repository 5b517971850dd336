"""Checks of a charge against its materials, its contact laws and the vessels that it is put into.

A finding is (key, what, hint); the key is a tuple of its parts, which gives its line in the file.
"""

import math
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from nutamill.base import units
from nutamill.base.errors import Fault
from nutamill.base.library import similar
from nutamill.base.required import required
from nutamill.base.units import Kind, in_unit, shown, si_value
from nutamill.case.charge import AMOUNT_KEYS, SIZE_KEYS, Portion, portion_faults
from nutamill.case.contact_laws import (
    GIVEN_BY,
    INSTEAD,
    NEEDS_A_LAW,
    OPTIONAL,
    OTHERWISE,
    READS,
    is_read,
)

if TYPE_CHECKING:
    from nutamill.case.machine import Machine
    from nutamill.case.mill import Case

    AnyCase: TypeAlias = Case | Machine

Finding = tuple[tuple[str | int, ...], str, str]

MOST_PARTICLES = 2e7
"""Particles above which a case is refused as a slip of the pen [1]."""


class Vessel(NamedTuple):
    """The space that charge is put into, as far as the case file alone determines it."""

    label: str
    """What it is, for messages."""
    volume: float | None
    """Free volume [m^3]; None where only its mesh or its walls determine it."""
    width: float | None
    """Smallest width [m]; None where only its mesh determines it."""
    meshed: bool = False
    """Whether a mesh may make it smaller or larger than `volume`."""

    @property
    def owner(self) -> str:
        """The label as an owner."""
        return f"{self.label.removeprefix('ribbed ')}'s"


def vessel_of(case: "AnyCase", part: Portion) -> Vessel:
    """Return the vessel of a part of the charge: the one it names, or the only one."""
    return case.vessels[part.region] if part.region is not None else next(iter(case.vessels.values()))


def charge_findings(case: "AnyCase") -> list[Finding]:
    """Return everything that contradicts in charge, materials and contact laws."""
    return [finding for check in (_materials, _laws, _pairs, _charge) for finding in check(case)]


def idle_numbers(case: "AnyCase") -> list[Fault]:
    """Return the numbers of touching pairs that the chosen laws do not read.

    A number in a file is meant to be used.
    """
    contact, findings = case.contact, []
    idle = [
        (number, law)
        for number, (law, _) in OPTIONAL.items()
        if not is_read(number, law, getattr(contact, law))
    ]
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


def _portions(case: "AnyCase") -> list[tuple[tuple[str | int, ...], Portion]]:
    """Return the parts of the charge, each with the key of its table."""
    if case.charge.part:
        return [(("charge", "part", number), part) for number, part in enumerate(case.charge.part)]
    return [(("charge",), part) for part in case.charge.parts]


def _needed_materials(case: "AnyCase") -> dict[tuple[str | int, ...], str | None]:
    """Return the materials the run needs, by the key that names them."""
    if not (portions := _portions(case)):
        return {}
    needed: dict[tuple[str | int, ...], str | None] = {}
    needed.update({(*key, "material"): part.material for key, part in portions})
    needed.update(case.wall_materials)
    return needed


def _materials(case: "AnyCase") -> list[Finding]:
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


def _laws(case: "AnyCase") -> list[Finding]:
    """Return faults of contact laws that do not go together."""
    contact = case.contact
    findings: list[Finding] = []
    for number, (key, choice) in GIVEN_BY.items():
        if getattr(contact, key) == choice and number not in READS["normal"][contact.normal]:
            what = f'must be "{OTHERWISE[choice]}" with normal = "{contact.normal}", got "{choice}"'
            findings.append((("contact", key), what, INSTEAD.get(contact.normal, "")))
    for number, (law, choice) in NEEDS_A_LAW.items():
        for name, pair in contact.pairs.items():
            if getattr(pair, number) and getattr(contact, law) == "none":
                what = f'has no effect with contact.{law} = "none"'
                place = ("contact", "pairs", name, number)
                findings.append((place, what, f'Write {law} = "{choice}" in [contact], or leave it out'))
    return findings


def _pairs(case: "AnyCase") -> list[Finding]:
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
        written = _pair_name(case, charge, other)
        if written is None:
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
            if getattr(pairs[written], number) is None:
                what = f'is missing, with contact.{law} = "{getattr(case.contact, law)}"'
                findings.append((("contact", "pairs", written, number), what, f"Add {number} to the pair"))
    return findings


def _pair_name(case: "AnyCase", first: str, second: str) -> str | None:
    """Return the name of a pair of materials as the file has it, in either order, or None without such a
    pair.
    """
    return next(
        (name for name in (f"{first}-{second}", f"{second}-{first}") if name in case.contact.pairs), None
    )


def _contacts(case: "AnyCase") -> list[tuple[str, str]]:
    """Return the pairs of known materials that may touch, each once, those of the charge first."""
    known, pairs = case.materials, []
    for first, second, _ in case.touching:
        listed = (first, second) in pairs or (second, first) in pairs
        if first in known and second in known and not listed:
            pairs.append((first, second))
    return pairs


def _charge(case: "AnyCase") -> list[Finding]:
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
    for key, part in _portions(case):
        if part.region is not None and part.region not in case.vessels:
            known = list(case.vessels)
            findings.append(
                ((*key, "region"), f'no region is called "{part.region}"', similar(part.region, known))
            )
        elif part.region is None and len(case.vessels) != 1:
            names = ", ".join(case.vessels) or "none"
            what = f"is missing: the machine has {len(case.vessels)} regions to fill ({names})"
            hint = "Name one of them" if case.vessels else "Add a [[regions]] table"
            findings.append(((*key, "region"), what, hint))
    if findings:
        return findings
    for key, part in _portions(case):
        given = next(name for name in SIZE_KEYS if getattr(part, name) is not None)
        vessel = vessel_of(case, part)
        if vessel.width is not None and part.size_range[1] >= vessel.width:
            what = f"must be less than the {vessel.owner} {_mm(vessel.width)}, got {_mm(part.size_range[1])}"
            findings.append(((*key, given), what, ""))
    if findings or not all(name in case.materials for name in case.charge.materials):
        return findings
    return [finding for name in case.vessels for finding in _amounts(case, name)]


def _amounts(case: "AnyCase", name: str) -> list[Finding]:
    """Return faults of too many particles, or of more charge than a vessel holds when poured.

    The room that meshes leave is not known here.
    """
    vessel, findings, loose = case.vessels[name], [], 0.0
    portions = [(key, part) for key, part in _portions(case) if (part.region or name) == name]
    for key, part in portions:
        amount = next(kind for kind in AMOUNT_KEYS if getattr(part, kind) is not None)
        density = case.materials[required(part.material)].density
        if amount == "fill" and vessel.volume is None:
            continue
        solid = part.solid_volume(density, vessel.volume or 0.0)
        loose += solid / part.packing
        if (number := solid / part.size_law().mean_volume) > MOST_PARTICLES:
            what = f"makes {number:.2g} particles, more than the limit of {MOST_PARTICLES:.0e}"
            findings.append(((*key, amount), what, "Take less, or coarser particles"))
    free = vessel.volume
    if findings or not portions or free is None or vessel.meshed or loose <= free * (1.0 + 1e-9):
        return findings
    needed = shown(loose, "L", ".3g")
    holds = f"loose, the {vessel.label} holds {shown(free, 'L', '.3g')}"
    if case.charge.part:
        return [(("charge", "part"), f"the parts need {needed} {holds}", "Take less of one")]
    if amount == "mass":
        most = si_value(math.floor(in_unit(free * density * part.packing, "g")), "g")
        what = f"{part.mass:g} kg needs {needed} {holds}"
        return [((*key, amount), what, f"Largest mass that settles: {most:.4g} kg")]
    most = math.floor(required(part.count) * free / loose)
    what = f"{part.count} particles need {needed} {holds}"
    return [((*key, amount), what, f"Largest number that settles: {most}")]


def _mm(length: float) -> str:
    return units.format(float(f"{length:.4g}"), Kind.LENGTH)
