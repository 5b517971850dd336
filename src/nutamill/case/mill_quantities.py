"""The series of a mill, as quantities of its machine: forces at the crank, lag of the charge, loads of joints
and mounts, entries of the energy ledger.

Forces at the crank act on the part that the crank drives, in driveshaft axes: radial towards the axis,
tangential in the direction of rotation.  A reading zeroed at rest loses gravity's radial share, which rotates
with the crank.  Its tangential share at rest is taken as zero, because the first row may contain the start of
a ramp.
"""

from typing import TYPE_CHECKING

import numpy as np

from nutamill.base.required import required
from nutamill.base.wrench import WRENCH
from nutamill.case.drawing import CHAMBER
from nutamill.case.machine import Machine, QuantityEntry
from nutamill.result.fields import JOINTS, expand

if TYPE_CHECKING:
    from nutamill.case.mill import Case

FRAME_FIX, SHAFT_BEARING, DRIVESHAFT_BEARING = "frame_fix", "intermediate_shaft_bearing", "driveshaft_bearing"
LOAD_CELL, PIN_JOINT = "crank_pin_load_cell", "pin_joint"
CHAMBER_PIVOT, YOKE_PIVOT = "chamber_pivot", "yoke_pivot"
COUPLING, DRIVE, NUTATION_POINT = "shaft_coupling", "motor", "nutation_point"

RUBBING = (DRIVESHAFT_BEARING, PIN_JOINT, CHAMBER_PIVOT, YOKE_PIVOT)
"""Joints of which the ledger has a loss."""
OF_THE_CHARGE = (
    "charge_",
    "coordination_number",
    "pair_",
    "wall_",
    "largest_",
    "kinetic_energy_charge",
    "substep_loss",
    "interface_",
)
"""Beginnings of the series that only a mill with a charge has."""
OF_THE_FILM = ("pair_film_", "wall_film_")
"""Beginnings of the series that only a mill with a wet charge has."""


def mill_quantities(case: "Case") -> tuple[QuantityEntry, ...]:
    """Return the series of a mill that are taken of others, as quantities of its machine."""
    drive, speed, torque = f"drive_{DRIVE}_angle", f"drive_{DRIVE}_speed", f"drive_{DRIVE}_torque"
    same = {"crank_angle": drive, "driveshaft_speed": speed, "driveshaft_torque": torque}
    same |= {"coupling_torque": f"bushing_{COUPLING}_moment_z"}
    same |= {f"nutation_point_force_{axis}": f"joint_{CHAMBER_PIVOT}_force_{axis}" for axis in "xyz"}
    for mount in mounts_of(case):
        for kind in ("force", "travel"):
            same |= {f"{mount}_{kind}_{axis}": f"bushing_{mount}_{kind}_{axis}" for axis in "xyz"}
        same[f"{mount}_loss"] = f"bushing_{mount}_loss"
    for joint in joints_of(case):
        same |= {f"{joint}_reaction_{part}": f"joint_{joint}_{part}" for part in WRENCH}
    same |= {"motor_work": f"drive_{DRIVE}_work", "coupling_loss": f"bushing_{COUPLING}_loss"}
    same |= {f"{joint}_loss": f"joint_{joint}_loss" for joint in RUBBING}
    if case.charge.parts:
        same |= {f"charge_{part}": f"{CHAMBER}_charge_{part}" for part in WRENCH}
    pivot = tuple(f"nutation_point_force_{axis}" for axis in "xyz")
    centre = tuple(f"charge_mass_centre_{axis}" for axis in "xy")
    point = tuple(f"{NUTATION_POINT}_position_{axis}" for axis in "xy")
    lag = [QuantityEntry(name="charge_phase_lag", of=(drive, *centre, *point), take="lag")]
    return (
        *(QuantityEntry(name=name, of=(source,)) for name, source in same.items()),
        QuantityEntry(name="driveshaft_power", of=(torque, speed), take="product"),
        QuantityEntry(name="nutation_point_force_resultant", of=pivot, take="resultant"),
        *_crank_force("crank_pin_force", LOAD_CELL),
        *_crank_force("pin_joint_force", PIN_JOINT),
        *(lag if case.charge.parts else []),
    )


def mill_series(case: "Case") -> tuple[str, ...]:
    """Return the names of the series that are recorded of a mill, in their order."""
    names = expand(len(mounts_of(case)), list(case.sensors))
    absent: tuple[str, ...] = () if case.charge.parts else OF_THE_CHARGE
    absent += OF_THE_FILM if case.contact.film == "none" else ()
    return tuple(name for name in names if not name.startswith(absent))


def crank_radius(machine: Machine) -> float:
    """Return the distance of the crank pin from the axis of the driveshaft [m], 0 in a machine without this
    joint or this drive.
    """
    joints = {joint.name: joint for joint in machine.joints}
    drive = next((drive for drive in machine.drives if drive.name == DRIVE), None)
    if drive is None or PIN_JOINT not in joints or drive.joint not in joints:
        return 0.0
    bearing = joints[drive.joint]
    axis, arm = np.array(required(bearing.axis)), np.subtract(joints[PIN_JOINT].point, bearing.point)
    return float(np.linalg.norm(np.cross(axis, arm)) / np.linalg.norm(axis))


def mounts_of(case: "Case") -> list[str]:
    """Return the names of the mounts. Rigid mounts have none."""
    rigid = case.mechanism.mounting == "rigid"
    return [] if rigid else [f"mount_{number}" for number in range(1, case.mounts.count + 1)]


def joints_of(case: "Case") -> list[str]:
    """Return the names of the joints."""
    return [joint for joint in JOINTS if joint != FRAME_FIX or case.mechanism.mounting == "rigid"]


def _crank_force(name: str, joint: str) -> tuple[QuantityEntry, ...]:
    """Return radial, tangential and resultant force of the crank on the part it drives, raw and zeroed."""
    x, y = f"-{joint}_crank_reaction_force_x", f"{joint}_crank_reaction_force_y"
    radial, tangential = f"{name}_radial", f"{name}_tangential"
    return (
        QuantityEntry(name=radial, of=(x,)),
        QuantityEntry(name=tangential, of=(y,)),
        QuantityEntry(name=f"{name}_resultant", of=(radial, tangential), take="resultant"),
        QuantityEntry(name=f"{radial}_tared", of=(x,), zeroed=True),
        QuantityEntry(name=f"{tangential}_tared", of=(y,)),
        QuantityEntry(
            name=f"{name}_resultant_tared", of=(f"{radial}_tared", f"{tangential}_tared"), take="resultant"
        ),
    )
