"""The demonstration: a case short enough to run in under a minute, and its notice."""

import itertools
import math

from nutamill.case import Case, Machine
from nutamill.charge.laws.pair import spring_stiffness
from nutamill.simulation.setup.altered import bolted, drive_key, supports, turning_drive
from nutamill.simulation.setup.charge import pair_law, quickest_meeting
from nutamill.simulation.setup.walls import material_order

RAMP_TIME = 0.2
"""Time from rest to full speed in a demonstration [s]."""

TURNS = 3
"""Turns at full speed in a demonstration [1]."""

SOFTER = 9.0
"""Factor by which contacts between particles are softer [1]; contacts with walls are not."""


def quick(case: Case | Machine) -> Case | Machine:
    """Return the case in demonstration quality: bolted down, short ramp, a few turns at speed, softer
    contacts between particles.

    A mill as drawn keeps its drawing.

    Raises
    ------
    CaseError : a machine without a drive that turns
    """
    speed = turning_drive(case.machine).speed
    rows = (
        2.0 / case.run.series_rate
    )  # the record begins up to a row after the ramp and ends up to a row before the end
    changes = {
        "title": f"demonstration of {case.name}: {simplified(case)}",
        "run.until": RAMP_TIME + TURNS * 2.0 * math.pi / speed + rows,
        "run.snapshots.last": 0.1,
        f"{_drive_key(case)}.ramp": speed / RAMP_TIME,
    }
    if softens(case):
        changes["contact.stiffness"] = "direct"
        for first, second in itertools.product(case.charge.materials, material_order(case.machine)):
            wall = second not in case.charge.materials
            softer, met = 1.0 if wall else SOFTER, quickest_meeting(case.machine, first, second, wall)
            stiffness = spring_stiffness(
                pair_law(case.machine, first, second), met.diameter, met.other_diameter
            )
            changes[f"contact.pairs.{pair_name(case, first, second)}.normal_stiffness"] = stiffness / softer
    if isinstance(case, Machine):
        return (bolted(case) if supports(case) else case).with_(changes)
    return case.with_({"mechanism.mounting": "rigid", **changes})


def _drive_key(case: Case | Machine) -> str:
    """Return the key of the drive that turns a case."""
    return drive_key(case) if isinstance(case, Machine) else "drive"


def softens(case: Case | Machine) -> bool:
    """Return whether the demonstration of a case has softer springs. Hertz contacts have none."""
    return bool(case.charge.parts) and case.contact.stiffness == "young" and case.contact.normal != "hertz"


def pair_name(case: Case | Machine, first: str, second: str) -> str:
    """Return the name of the table of a pair of materials in the case file."""
    return next(name for name in (f"{first}-{second}", f"{second}-{first}") if name in case.contact.pairs)


def simplified(case: Case | Machine) -> str:
    """Return what the demonstration of a case simplifies, for its title and its reports."""
    softer = f", contacts between particles {SOFTER:g} times softer" if softens(case) else ""
    bolts = "rigid mounts, " if case.drawing is not None or supports(case.machine) else ""
    return f"{bolts}{RAMP_TIME:g} s ramp, {TURNS} turns at speed{softer}"


def banner(case: Case | Machine) -> str:
    """Return the text printed before a demonstration."""
    return (
        f"demonstration: {simplified(case)}. It shows the program, not the machine. Run without --quick for "
        "numbers"
    )
