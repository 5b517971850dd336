"""Checks that need more than one key: what contradicts, and what is odd.

A finding is (key, what, hint); the key is a tuple of its parts, which gives its line in the file.
"""

import math
from typing import TYPE_CHECKING

from nutamill.base import units
from nutamill.base.errors import Fault
from nutamill.base.units import Kind, in_unit, shown
from nutamill.case.charge import stand_ins
from nutamill.case.charge_checks import Finding, charge_findings, idle_numbers
from nutamill.case.fmus import fmu_findings
from nutamill.case.mill_quantities import DRIVE
from nutamill.case.record_checks import record_findings
from nutamill.result.fields import expand

if TYPE_CHECKING:
    from nutamill.case.mill import Case

ANGLE_STOP = math.radians(1.0)
"""Difference between the printed nutation angle and that of the crank's lengths at which a case is refused
[rad].
"""


def faults(case: "Case") -> list[Finding]:
    """Return every contradiction in the mill."""
    own = [finding for check in (_geometry, _ribs, _inertia) for finding in check(case)]
    driven = fmu_findings(case.fmus, {DRIVE: case.drive.motor is not None}, [])
    return [*own, *charge_findings(case), *_record(case), *driven]


def warnings(case: "Case") -> list[Fault]:
    """Return everything that is possible but odd."""
    findings = [*_rounded_angle(case), *stand_ins(case.charge)]
    if case.run.end < case.drive.ramp_end:
        what = f"the run ends at {case.run.end:g} s, before the speed is reached at {case.drive.ramp_end:g} s"
        findings.append(Fault("run.until", what, "There will be no steady mean"))
    return findings + idle_numbers(case)


def _rounded_angle(case: "Case") -> list[Fault]:
    """Return a warning of a nutation angle that differs from the crank's by more than its rounding.

    6 deg agrees with 6.082 deg.
    """
    written = f"{in_unit(case.chamber.nutation_angle, 'deg'):.12g}"
    used = in_unit(case.mechanism.nutation_angle, "deg")
    decimals = len(written.partition(".")[2])
    if float(written) == round(used, decimals):
        return []
    what = f"{written} deg is not used: crank_radius and nutation_point_to_crank give {used:.3f} deg"
    return [
        Fault(
            "chamber.nutation_angle", what, f'Write nutation_angle = "{used:.3f} deg", or change the lengths'
        )
    ]


def frame_mass(case: "Case") -> float:
    """Return the mass of the frame [kg]: the machine on its mounts less chamber, carriage, driveshaft and
    bearing cross.

    The intermediate shaft hangs on the ground and is not part of the total.
    """
    parts = case.chamber.mass + case.carriage.mass + case.driveshaft.mass + case.bearing_cross.mass
    return case.mechanism.total_mass - parts


def _record(case: "Case") -> list[Finding]:
    """Return faults of records that hold nothing, or more than can be meant."""
    mounts = case.mounts.count if case.mechanism.mounting == "flexible" else 0
    return record_findings(case, len(expand(mounts, list(case.sensors))))


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
            f"{lengths} give {shown(ruling, 'deg', '.2f')}, but nutation_angle is "
            f"{shown(chamber.nutation_angle, 'deg')}"
        )
        hint = (
            "One of the three is wrong; with these lengths write nutation_angle = "
            f'"{shown(ruling, "deg", ".3f")}"'
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
    """Return faults of moments of inertia that no body can have.

    The largest principal one is at most the sum of the other two.
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


def _mm(length: float) -> str:
    return units.format(float(f"{length:.4g}"), Kind.LENGTH)
