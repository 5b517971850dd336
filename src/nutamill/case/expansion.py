"""The drawing of a nutating mill as a machine: its bodies, joints, bushings, drive, walls and sensors
(MCA 2026, Table 4; rigid mounts: SAIMM 2025).
"""

from typing import TYPE_CHECKING

from nutamill.case.connections import BushingRates
from nutamill.case.drawing import (
    CARRIAGE,
    CHAMBER,
    CROSS,
    DRIVESHAFT,
    FRAME,
    GROUND,
    SHAFT,
)
from nutamill.case.drawn_bodies import Triple, chamber_rotation, frame_part, moving_parts, triple
from nutamill.case.drawn_walls import drawn_region, drawn_walls
from nutamill.case.machine import (
    BodyEntry,
    BushingEntry,
    DriveEntry,
    FieldAxes,
    FrictionEntry,
    JointEntry,
    JointName,
    Machine,
    SensorEntry,
    Turn,
)
from nutamill.case.mill_quantities import (
    CHAMBER_PIVOT,
    COUPLING,
    DRIVE,
    DRIVESHAFT_BEARING,
    FRAME_FIX,
    LOAD_CELL,
    NUTATION_POINT,
    PIN_JOINT,
    SHAFT_BEARING,
    YOKE_PIVOT,
    mill_quantities,
    mill_series,
)
from nutamill.case.run import MachineRun, WatchEntry
from nutamill.result.fields import TURNING

if TYPE_CHECKING:
    from nutamill.case.mill import Case

Y_AXIS, Z_AXIS = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)

TILTED = (CHAMBER, CROSS)
"""Bodies whose axes are those of the tilted chamber as assembled; the others have world axes."""
MECHANISM_STEP = 55e-6
"""Longest step of a mill without charge [s]: errors of the joint reactions are then of the order of 1e-5."""


def mill_machine(case: "Case") -> Machine:
    """Return the machine that the drawing of a mill describes.

    Raises
    ------
    CaseError : no mass or no possible inertia left for the frame
    """
    machine = Machine(
        title=case.title,
        gravity=(0.0, 0.0, -case.mechanism.gravity),
        bodies=_bodies(case),
        joints=_joints(case),
        bushings=_bushings(case),
        drives=(DriveEntry(name=DRIVE, joint=DRIVESHAFT_BEARING, **case.drive.model_dump()),),
        sensors=_sensors(case),
        quantities=mill_quantities(case),
        walls=drawn_walls(case),
        regions=(drawn_region(case),),
        fmus=case.fmus,
        charge=case.charge,
        materials=case.materials,
        contact=case.contact,
        fields=FieldAxes(body=CHAMBER, drive=DRIVE),
        run=_run(case),
    )
    machine._name = case.name
    machine._written = {"chamber_mesh": "chamber.mesh"}
    machine._written |= {f"wall_{number + 1}": f"walls[{number}]" for number in range(len(case.walls))}
    return machine


def _run(case: "Case") -> MachineRun:
    """Return how the machine is run and recorded: from rest, with the series of a mill."""
    force, lever = "crank_pin_force_resultant", case.mechanism.crank_radius
    torque = WatchEntry(series="driveshaft_torque", force=force, lever=lever)
    run = case.run.model_dump() | ({} if case.charge.parts else {"dt": "auto"})
    return MachineRun(
        **run,
        step=MECHANISM_STEP,
        start="rest",
        watch=(WatchEntry(series=force), torque),
        series=mill_series(case),
    )


def _bodies(case: "Case") -> tuple[BodyEntry, ...]:
    """Return the frame, then the moving parts."""
    parts, rotation = {FRAME: frame_part(case), **moving_parts(case)}, chamber_rotation(case)
    tilt = Turn(axis=Y_AXIS, angle=-case.mechanism.nutation_angle)
    bodies = []
    for name, part in parts.items():
        inertia = rotation.T @ part.inertia @ rotation if name in TILTED else part.inertia
        six = [inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2]]
        bodies.append(
            BodyEntry(
                name=name,
                mass=part.mass,
                inertia=tuple(map(float, six)),
                position=triple(part.mass_centre),
                turn=tilt if name in TILTED else None,
            )
        )
    return tuple(bodies)


def _joints(case: "Case") -> tuple[JointEntry, ...]:
    """Return the joints. The numbers in the comments are the rows of MCA 2026, Table 4."""
    mechanism = case.mechanism
    crank_pin = (mechanism.crank_radius, 0.0, -mechanism.nutation_point_to_crank)
    nutation_point = (0.0, 0.0, 0.0)
    bearing = (0.0, 0.0, float(moving_parts(case)[DRIVESHAFT].mass_centre[2]))
    coupling = (0.0, 0.0, -case.shaft_coupling.depth)
    chamber_x = triple(chamber_rotation(case)[:, 0])
    friction = FrictionEntry(
        coefficient=mechanism.joint_friction,
        radius=mechanism.joint_friction_radius,
        constant=mechanism.joint_friction_constant,
        viscous=mechanism.joint_friction_viscous,
    )
    rows: list[tuple[str, JointName, tuple[str, str], Triple, Triple | None, FrictionEntry | None]] = [
        (SHAFT_BEARING, "revolute", (GROUND, SHAFT), coupling, Z_AXIS, None),  # 2
        (DRIVESHAFT_BEARING, "revolute", (FRAME, DRIVESHAFT), bearing, Z_AXIS, friction),  # 4
        (LOAD_CELL, "fixed", (DRIVESHAFT, CARRIAGE), crank_pin, None, None),  # 5
        (PIN_JOINT, "point_on_line", (CARRIAGE, CHAMBER), crank_pin, Z_AXIS, friction),  # 6
        (CHAMBER_PIVOT, "revolute", (CROSS, CHAMBER), nutation_point, chamber_x, None),  # 7
        (YOKE_PIVOT, "revolute", (FRAME, CROSS), nutation_point, Y_AXIS, None),  # 8
    ]
    if mechanism.mounting == "rigid":
        rows.insert(0, (FRAME_FIX, "fixed", (GROUND, FRAME), (0.0, 0.0, -case.mounts.depth), None, None))
    return tuple(
        JointEntry(name=name, kind=kind, between=between, point=point, axis=axis, friction=law)
        for name, kind, between, point, axis, law in rows
    )


def _bushings(case: "Case") -> tuple[BushingEntry, ...]:
    """Return the shaft coupling (3) and, with flexible mounts, the mounts (1)."""
    point = (0.0, 0.0, -case.shaft_coupling.depth)
    rows: list[tuple[str, tuple[str, str], Triple, BushingRates]] = [
        (COUPLING, (SHAFT, DRIVESHAFT), point, case.shaft_coupling)
    ]
    if case.mechanism.mounting == "flexible":
        rows += [
            (f"mount_{number}", (GROUND, FRAME), (x, y, -case.mounts.depth), case.mounts)
            for number, (x, y) in enumerate(case.mounts.points, start=1)
        ]
    return tuple(
        BushingEntry(name=name, between=between, point=at, axis=Z_AXIS, **_rates(part))
        for name, between, at, part in rows
    )


def _rates(part: BushingRates) -> dict[str, float]:
    """Return stiffness and damping by their keys."""
    return part.model_dump(include=set(BushingRates.model_fields))


def _sensors(case: "Case") -> tuple[SensorEntry, ...]:
    """Return what is read of a mill beside joints, bushings and drive: forces at the crank in driveshaft axes
    (x from the axis to the pin), the nutation point, attitudes, and the accelerometers.
    """
    sensors = [
        SensorEntry(name=f"{LOAD_CELL}_crank", kind="reaction", of=LOAD_CELL, axes=DRIVESHAFT),
        SensorEntry(name=f"{PIN_JOINT}_crank", kind="reaction", of=PIN_JOINT, axes=DRIVESHAFT),
        SensorEntry(name=NUTATION_POINT, kind="position", of=CROSS, at=(0.0, 0.0, 0.0)),
    ]
    sensors += [SensorEntry(name=body, kind="attitude", of=body) for body in TURNING]
    sensors.append(SensorEntry(name="charge", kind="charge", of=CHAMBER, at=(0.0, 0.0, 0.0)))
    rotation = chamber_rotation(case)
    for name, sensor in case.sensors.items():
        point = rotation @ sensor.at if sensor.body in TILTED else sensor.at
        sensors.append(
            SensorEntry(
                name=name,
                kind="acceleration",
                of=sensor.body,
                at=triple(point),
                axes=sensor.body,
            )
        )
    return tuple(sensors)
