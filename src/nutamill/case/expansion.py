"""The drawing of a nutating mill as a machine: its bodies, joints, bushings, drive, walls and sensors
(MCA 2026, Table 4; rigid mounts: SAIMM 2025).
"""

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.required import required
from nutamill.case.connections import BushingRates
from nutamill.case.drawing import (
    CARRIAGE,
    CHAMBER,
    CROSS,
    DRIVESHAFT,
    FRAME,
    GROUND,
    SHAFT,
    MeshFile,
)
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
from nutamill.case.rigid_parts import RigidPart, chamber_shell, compose, remove, rotated, whole_chamber
from nutamill.case.run import MachineRun, WatchEntry
from nutamill.case.walls import RegionEntry, WallEntry
from nutamill.result.fields import TURNING

if TYPE_CHECKING:
    from nutamill.case.mill import Case

Triple = tuple[float, float, float]

Y_AXIS, Z_AXIS = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)

TILTED = (CHAMBER, CROSS)
"""Bodies whose axes are those of the tilted chamber as assembled; the others have world axes."""
MECHANISM_STEP = 55e-6
"""Longest step of a mill without charge [s]: errors of the joint reactions are then of the order of 1e-5."""


def chamber_rotation(case: "Case") -> np.ndarray:
    """Return ``R_WC`` (3, 3) as assembled, at crank angle 0, with the lower end of the chamber towards +x."""
    angle = -case.mechanism.nutation_angle
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def bare_driveshaft(case: "Case") -> RigidPart:
    """Return driveshaft and torque arm without carriage and balance, world axes from the nutation point."""
    shaft = case.driveshaft
    inertia = np.diag([shaft.inertia_transverse, shaft.inertia_transverse, shaft.inertia_axial])
    return RigidPart(shaft.mass, np.array([0.0, 0.0, -shaft.mass_centre_depth]), inertia)


def moving_parts(case: "Case") -> dict[str, RigidPart]:
    """Return every part but the frame, in world axes from the nutation point, at crank angle 0."""
    mechanism, rotation = case.mechanism, chamber_rotation(case)
    crank_pin = np.array([mechanism.crank_radius, 0.0, -mechanism.nutation_point_to_crank])
    driveshaft = bare_driveshaft(case)
    for weight in case.balance.weights:
        across = [weight.radius * math.cos(weight.azimuth), weight.radius * math.sin(weight.azimuth)]
        driveshaft = compose(
            driveshaft, RigidPart(weight.mass, np.array([*across, -weight.depth]), np.zeros((3, 3)))
        )
    shaft = case.intermediate_shaft
    return {
        CHAMBER: rotated(whole_chamber(case.chamber), rotation),
        CROSS: RigidPart(case.bearing_cross.mass, np.zeros(3), case.bearing_cross.inertia * np.eye(3)),
        CARRIAGE: RigidPart(case.carriage.mass, crank_pin, case.carriage.inertia * np.eye(3)),
        DRIVESHAFT: driveshaft,
        SHAFT: RigidPart(
            shaft.mass,
            np.array([0.0, 0.0, -case.shaft_coupling.depth]),
            np.diag([shaft.inertia_transverse, shaft.inertia_transverse, shaft.inertia_axial]),
        ),
    }


def frame_part(case: "Case") -> RigidPart:
    """Return the frame: the unribbed, empty machine on its mounts without its moving parts.

    The file gives mass, height of the mass centre and radii of gyration of the whole machine on the mounts.
    The moving parts are subtracted as averages over a revolution, so that the frame is symmetric about the
    driveshaft axis.

    Raises
    ------
    CaseError : no possible inertia left for the frame; `nutamill.case.mill_checks` refuses one without mass
    """
    parts = {
        **moving_parts(case),
        CHAMBER: rotated(chamber_shell(case.chamber), chamber_rotation(case)),
        DRIVESHAFT: bare_driveshaft(case),
    }
    del parts[SHAFT]  # supported by the ground, not by the mounts
    frame, mass = case.frame, case.mechanism.total_mass
    mass_centre = np.array([0.0, 0.0, -case.mounts.depth + frame.mass_centre_height])
    inertia = mass * np.diag([frame.gyration_rocking**2] * 2 + [frame.gyration_yaw**2])
    whole = RigidPart(mass, mass_centre, inertia)
    about_axis = remove(whole, *(_averaged_over_a_revolution(part) for part in parts.values()))
    lowest = np.linalg.eigvalsh(about_axis.inertia)
    if lowest[0] <= 0 or lowest[2] > lowest[0] + lowest[1]:
        what = (
            "the radii of gyration of the whole machine leave the frame moments of inertia of "
            f"{lowest.round(3).tolist()} kg m^2, which no body has"
        )
        raise CaseError(Fault("frame", what, "Give larger frame.gyration_rocking or frame.gyration_yaw"))
    return about_axis


def _averaged_over_a_revolution(part: RigidPart) -> RigidPart:
    """Return the average of a part over a revolution about the z axis: mass centre on the axis, same axial
    and mean transverse inertia about it.
    """
    x, y, z = part.mass_centre
    inertia = part.inertia + part.mass * np.diag([(x * x + y * y) / 2, (x * x + y * y) / 2, x * x + y * y])
    transverse = (inertia[0, 0] + inertia[1, 1]) / 2
    return RigidPart(part.mass, np.array([0.0, 0.0, z]), np.diag([transverse, transverse, inertia[2, 2]]))


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
        walls=_walls(case),
        regions=(_region(case),),
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
                position=_triple(part.mass_centre),
                turn=tilt if name in TILTED else None,
            )
        )
    return tuple(bodies)


def _triple(vector: Iterable[float]) -> Triple:
    """Return the three components of a vector as plain numbers."""
    x, y, z = map(float, vector)
    return x, y, z


def _joints(case: "Case") -> tuple[JointEntry, ...]:
    """Return the joints. The numbers in the comments are the rows of MCA 2026, Table 4."""
    mechanism = case.mechanism
    crank_pin = (mechanism.crank_radius, 0.0, -mechanism.nutation_point_to_crank)
    nutation_point = (0.0, 0.0, 0.0)
    bearing = (0.0, 0.0, float(moving_parts(case)[DRIVESHAFT].mass_centre[2]))
    coupling = (0.0, 0.0, -case.shaft_coupling.depth)
    chamber_x = _triple(chamber_rotation(case)[:, 0])
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
                at=_triple(point),
                axes=sensor.body,
            )
        )
    return tuple(sensors)


def _walls(case: "Case") -> tuple[WallEntry, ...]:
    """Return bore, floor and ceiling, or the chamber's mesh, then ribs and meshed walls."""
    chamber, rotation = case.chamber, chamber_rotation(case)
    axis, across = _triple(rotation[:, 2]), _triple(rotation[:, 0])

    def placed(x: float, y: float, z: float) -> Triple:
        return _triple(rotation @ np.array([x, y, z]))

    floor, ceiling = placed(0.0, 0.0, -chamber.floor_depth), placed(0.0, 0.0, -chamber.ceiling_depth)
    drawn = partial(WallEntry, body=CHAMBER, material=chamber.material)
    walls = []
    if chamber.mesh is None:
        radius = chamber.inner_diameter / 2
        walls += [
            drawn(
                name="bore", shape="cylinder", point=floor, axis=axis, radius=radius, height=chamber.height
            ),
            drawn(name="floor", shape="plane", point=floor, axis=axis),
            drawn(name="ceiling", shape="plane", point=ceiling, axis=_triple(-rotation[:, 2])),
        ]
    walls += [_rib(case, number, placed, axis) for number in range(chamber.ribs)]
    meshes: list[tuple[str, MeshFile, str, Literal["inside", "outside"]]] = []
    if chamber.mesh is not None:
        meshes.append(("chamber_mesh", chamber.mesh, chamber.material, "inside"))
    meshes += [(f"wall_{n}", wall, wall.material, "outside") for n, wall in enumerate(case.walls, start=1)]
    for name, mesh, material, side in meshes:
        walls.append(
            WallEntry(
                name=name,
                body=CHAMBER,
                material=material,
                shape="mesh",
                side=side,
                point=placed(*mesh.at),
                axis=axis,
                across=across,
                file=mesh.file,
                unit=mesh.unit,
                sha256=mesh.sha256,
                extent=math.hypot(chamber.inner_diameter, chamber.inner_diameter, chamber.height),
            )
        )
    return tuple(walls)


def _rib(
    case: "Case", number: int, placed: Callable[[float, float, float], Triple], axis: Triple
) -> WallEntry:
    """Return rib `number` as a box, which reaches as far into wall and floor as into the charge, so that
    there is no gap.
    """
    chamber, rib = case.chamber, required(case.chamber.rib)
    angle = 2 * math.pi * number / chamber.ribs
    c, s = math.cos(angle), math.sin(angle)
    height, radius = min(rib.length, chamber.height), chamber.inner_diameter / 2
    middle = placed(radius * c, radius * s, (height - rib.depth) / 2 - chamber.floor_depth)
    return WallEntry(
        name=f"rib_{number + 1}",
        body=CHAMBER,
        material=rib.material,
        shape="box",
        point=middle,
        axis=axis,
        across=placed(c, s, 0.0),
        size=(2.0 * rib.depth, rib.width, height + rib.depth),
    )


def _region(case: "Case") -> RegionEntry:
    """Return the inside of the chamber."""
    chamber, rotation = case.chamber, chamber_rotation(case)
    axis = _triple(rotation[:, 2])
    if chamber.mesh is not None:
        return RegionEntry(name=CHAMBER, body=CHAMBER, shape="mesh", wall="chamber_mesh", axis=axis)
    return RegionEntry(
        name=CHAMBER,
        body=CHAMBER,
        shape="cylinder",
        point=_triple(rotation @ np.array([0.0, 0.0, -chamber.floor_depth])),
        axis=axis,
        radius=chamber.inner_diameter / 2,
        height=chamber.height,
        free_volume=None if case.walls else chamber.free_volume,
    )
