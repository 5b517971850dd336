"""Balancing: the masses on the driveshaft that make the machine shake least, by influence coefficients of the
engine itself.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.analysis.source import vector
from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import Kind, rpm
from nutamill.case import Case, Machine
from nutamill.case.mill_quantities import FRAME_FIX
from nutamill.design.empty import once_per_turn, steady_series
from nutamill.design.isolation import shaking_unbalance
from nutamill.design.weights import Weight, driven_bodies, weighted, weighted_body, with_charge_mass
from nutamill.simulation.setup.altered import angle_series, supports, turning_drive

TRIAL = 0.2
"""Share of the shaking unbalance that a trial mass has [1]; the mill answers linearly within a per cent or
so.
"""

TRIMS = 1
"""Corrections with the same influence coefficients after the first one [1]: the weights themselves change
what they act on.
"""

GRADE = 16.0
"""Balance quality grade of crushing machines, G 16 [mm/s], ISO 21940-11:2016."""


class Balancing(NamedTuple):
    """What balancing does at one speed."""

    speed: float
    """Driveshaft speed [rad/s]."""
    weights: tuple[Weight, ...]
    """Masses that shake least, one for each plane."""
    before: float
    """Root mean square of the amplitudes once per turn over all readings without balance mass: travel of the
    mounts [m], or force of each corner on the floor [N] on rigid mounts."""
    after: float
    """The same with the weights, run again."""
    unbalance: complex
    """Unbalance of the mill without weights [kg m]; towards the pin is real."""
    residual: complex
    """Unbalance with them [kg m]."""
    turning_mass: float
    """Mass of all parts that the drive moves, weights included [kg]."""

    @property
    def grade(self) -> float:
        """Quality grade that the residual unbalance comes to, ``|U| speed / m`` [mm/s], ISO 21940-11."""
        return units.in_unit(abs(self.residual) * self.speed / self.turning_mass, "mm/s")


def permissible_unbalance(grade: float, speed: float, mass: float) -> float:
    """Compute the permissible residual unbalance [kg m] of a rotor of `mass` [kg] at `speed` [rad/s] for a
    `grade` [mm/s]: ``G m / speed``.

    Source: ISO 21940-11:2016, equation for ``U_per`` from the balance quality grade.
    """
    return units.si_value(grade, "mm/s") * mass / speed


def balance_mill(
    case: Case | Machine,
    planes: Sequence[tuple[float, float]],
    speed: float | None = None,
    charge: bool = False,
) -> Balancing:
    """Balance masses that minimise the vibration of a machine at a speed, in one plane or two.

    The machine runs without weights, then with a trial mass in each plane; as the vibration is linear in the
    unbalances, the best ones follow by least squares over the travel of all supports (of a mill on rigid
    mounts: over the force of each corner on the floor). The machine is then run with them.  Of a mill as
    drawn the masses take the place of its own, on any other machine they are added to what its drive turns.

    Parameters
    ----------
    planes : radius and depth below the nutation point of each plane [m], one or two
    speed : driveshaft speed [rad/s]; the case's if None
    charge : with the mass of the charge fixed to the chamber's base

    Raises
    ------
    CaseError : a machine without supports or without a drive that turns a body, a speed that is not
        positive, no plane, more than two, lengths that are none, or two planes of one depth

    Source
    ------
    Goodman, J. Eng. Ind. 86(3), 273-279, 1964 (least-squares balancing by influence coefficients)
    """
    loaded = with_charge_mass(case) if charge else case
    turning = turning_drive(case.machine).speed
    at = turning if speed is None else speed
    _check(planes, at)
    if not supports(case.machine):
        _half_spacing(case)
    bare = weighted(loaded, ())
    unbalance = shaking_unbalance(bare, at)
    start = readings(case, bare, at)
    trial = -TRIAL * abs(unbalance)
    influence = np.empty((len(start), len(planes)), complex)
    for k, plane in enumerate(planes):
        influence[:, k] = (readings(case, weighted(loaded, [_weight(trial, plane)]), at) - start) / trial
    best, end = np.zeros(len(planes), complex), start
    for _ in range(1 + TRIMS):
        best = best + np.linalg.lstsq(influence, -end, rcond=None)[0]
        weights = tuple(_weight(complex(u), plane) for u, plane in zip(best, planes, strict=True))
        balanced = weighted(loaded, weights)
        end = readings(case, balanced, at)
    parts = weighted(case, weights)  # without the charge
    moved = driven_bodies(parts)
    mass = sum(body.mass for body in parts.bodies if body.name in moved)
    before, after = (float(np.sqrt((np.abs(part) ** 2).mean())) for part in (start, end))
    return Balancing(at, weights, before, after, unbalance, shaking_unbalance(balanced, at), mass)


def readings(case: Case | Machine, machine: Machine, speed: float) -> np.ndarray:
    """Return the complex amplitudes once per period that balancing makes small: travel of the supports [m],
    or on rigid mounts the force of each corner [N].

    `machine` is that of the case with other weights. Raises CaseError for a machine that stands on neither.
    """
    feet, series = supports(machine), steady_series(machine, speed)
    angle = series[angle_series(machine)]
    if feet:
        return once_per_turn(angle, np.hstack([vector(series, f"bushing_{name}_travel") for name in feet]))
    half_spacing = _half_spacing(case)
    # the fixing's force and moment as vertical forces of four corners and shares of the horizontal ones
    force = once_per_turn(angle, vector(series, f"joint_{FRAME_FIX}_force"))
    moment = once_per_turn(angle, vector(series, f"joint_{FRAME_FIX}_moment"))
    upright = [moment[axis] / (4.0 * half_spacing) for axis in (0, 1)]
    return np.array([*force[:2] / 4.0, *upright])


def _half_spacing(case: Case | Machine) -> float:
    """Return the distance of the corners of a bolted mill [m], which its drawing alone knows."""
    if case.drawing is None:
        what = "must stand on bushings: a fixed joint has no corners to read forces from"
        raise CaseError(Fault(case.name, what, "Describe what it stands on as [[bushings]]"))
    return case.drawing.mounts.half_spacing


def balance_lines(balancing: Balancing, case: Case | Machine, grade: float = GRADE) -> list[str]:
    """Format weights, vibration and residual unbalance as a table, and the keys that put the weights into a
    case.
    """
    unit, factor = ("mm", 1e3) if supports(case.machine) else ("N", 1.0)
    what = "travel of the mounts" if unit == "mm" else "force of each corner on the floor"
    rows = [
        f"balancing at {rpm(balancing.speed):.4g} rpm: "
        f"unbalance {units.shown(abs(balancing.unbalance), 'kg mm')}"
    ]
    rows.append(f"{'mass (kg)':>10} {'radius (mm)':>12} {'depth (mm)':>11} {'azimuth':>9}")
    for weight in balancing.weights:
        rows.append(
            f"{weight.mass:10.4f} {units.in_unit(weight.radius, 'mm'):12.4g} "
            f"{units.in_unit(weight.depth, 'mm'):11.4g} {units.in_unit(weight.azimuth, 'deg'):7.2f} °"
        )
    ratio = 100.0 * balancing.after / balancing.before
    rows.append(
        f"{what} once per turn, r.m.s.: {factor * balancing.before:.4g} {unit} before, "
        f"{factor * balancing.after:.4g} {unit} after ({ratio:.3g} %)"
    )
    allowed = permissible_unbalance(grade, balancing.speed, balancing.turning_mass)
    left = (
        f"residual unbalance {units.shown(abs(balancing.residual), 'kg mm')} "
        f"of {balancing.turning_mass:.4g} kg: G {balancing.grade:.3g}"
    )
    rows.append(f"{left}; G {grade:g} allows {units.shown(allowed, 'kg mm')}")
    rows.append("in a case: " + " ".join(f"-s {key}" for key in _keys(balancing.weights, case)))
    return rows


def _keys(weights: Sequence[Weight], case: Case | Machine) -> list[str]:
    """Return the keys that put weights into a case: of a mill as drawn its balance masses, else mass, mass
    centre and inertia of the body that carries them.
    """
    if case.drawing is not None:
        return [
            f'balance.{"second." if k else ""}{name}="{value}"'
            for k, weight in enumerate(weights)
            for name, value in _texts(weight)
        ]
    body = weighted_body(case.machine, weights)
    position = ", ".join(f'"{units.shown(value, "mm", ".7g")}"' for value in body.position)
    inertia = ", ".join(f'"{value:.6g} kg m^2"' for value in body.inertia)
    return [
        f'bodies.{body.name}.mass="{body.mass:.7g} kg"',
        f"'bodies.{body.name}.position=[{position}]'",
        f"'bodies.{body.name}.inertia=[{inertia}]'",
    ]


def _texts(weight: Weight) -> list[tuple[str, str]]:
    return [
        ("mass", f"{weight.mass:.5g} kg"),
        ("radius", units.shown(weight.radius, "mm", ".6g")),
        ("depth", units.shown(weight.depth, "mm", ".6g")),
        ("azimuth", units.shown(weight.azimuth, "deg", ".5g")),
    ]


def _weight(unbalance: complex, plane: tuple[float, float]) -> Weight:
    return Weight(abs(unbalance) / plane[0], *plane, float(np.angle(unbalance) % (2.0 * np.pi)))


def _check(planes: Sequence[tuple[float, float]], speed: float) -> None:
    """Refuse planes and a speed that make no sense."""
    if not speed > 0.0:
        what = f"must be positive, got {units.format(speed, Kind.SPEED)}"
        raise CaseError(Fault("--speed", what, "A machine at rest has no unbalance to take away"))
    if not 1 <= len(planes) <= 2:
        raise CaseError(
            Fault(
                "--plane", f"needs one or two planes, got {len(planes)}", 'Write e.g. --plane "80 mm, 420 mm"'
            )
        )
    given = " and ".join(", ".join(units.format(length, Kind.LENGTH) for length in plane) for plane in planes)
    if not all(length > 0.0 for plane in planes for length in plane):
        raise CaseError(Fault("--plane", f"radius and depth must be positive, got {given}"))
    if len(planes) == 2 and abs(planes[0][1] - planes[1][1]) < 1e-3:
        raise CaseError(
            Fault(
                "--plane",
                f"the depths of two planes must differ, got {given}",
                "Give one plane, or move one",
            )
        )
