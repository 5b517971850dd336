"""Every recorded quantity, declared once: its name in file, dataset and figures, symbol, unit, meaning, axes and point.

The writer takes names, the result file stores what stands here beside the numbers, figures take their axis labels from
here.  Some names carry a part of the machine, for instance ``mount_{mount}_force_x``: ``mount_2_force_x`` is a name,
and so is ``frame_corner_acceleration_z`` of the sensor called ``frame_corner`` in the case file.

Signs are those of docs/conventions.md.
"""

import difflib
import functools
import re
from collections.abc import Sequence
from dataclasses import replace

from nutamill.errors import CaseError, Fault
from nutamill.fields.field import WORLD, Field, energy, vector
from nutamill.fields.parts import PART_SERIES

CRANK = "driveshaft: radial towards its axis, tangential in the direction of rotation"
__all__ = [
    "PART_SERIES",
    "SERIES",
    "SNAPSHOT",
    "STATISTICS",
    "STATISTICS_AXES",
    "Field",
    "expand",
    "series_field",
    "snapshot_field",
    "statistics_field",
]

O_FIXED = "nutation point as assembled"


def _crank_force(name: str, where: str, point: str) -> tuple[Field, ...]:
    """Radial, tangential and resultant force of the crank at one of its two probes, raw and without gravity's share."""
    said = f"force the crank exerts at the {where}"
    tared = "with the share of gravity taken off, as a reading zeroed at rest in the turning axes"
    raw = (
        Field(f"{name}_radial", "F_r", "N", f"{where} force, radial", f"{said}, towards the driveshaft axis", CRANK, point),
        Field(f"{name}_tangential", "F_t", "N", f"{where} force, tangential", f"{said}, in the direction of rotation", CRANK, point),
        Field(f"{name}_resultant", "F", "N", f"{where} force", f"{said}: root of radial squared plus tangential squared", "", point),
    )
    return raw + tuple(
        replace(field, name=f"{field.name}_tared", label=f"{field.label}, tared", meaning=f"{field.meaning}, {tared}") for field in raw
    )


def _contact_losses(name: str, label: str) -> tuple[Field, ...]:
    """Energy the contacts of one class have dissipated, by part of the law."""
    return tuple(
        energy(f"{name}_{part}_loss", f"D_{{\\mathrm{{{name},{part[0]}}}}}", f"{label}, {part}", f"energy dissipated so far {how}, {label}")
        for part, how in (
            ("normal", "by the normal dashpots"),
            ("tangential", "by sliding"),
            ("rolling", "by rolling resistance"),
        )
    )


TIME = Field("time", "t", "s", "time", "simulated time since the start of the run")
CHAMBER_POINT = "nutation point, moving with the chamber"

JOINTS = ("frame_fix", "intermediate_shaft_bearing", "driveshaft_bearing", "load_cell", "crank_pin", "chamber_pivot", "yoke_pivot")
"""Joints of a mill whose reactions are recorded; the frame is fixed on rigid mounts only."""
TURNING = ("frame", "driveshaft", "chamber")
"""Bodies whose attitudes are recorded, so that a reaction can be written in their axes."""

SERIES: tuple[Field, ...] = (
    TIME,
    Field("crank_angle", "\\theta", "rad", "crank angle", "angle the driveshaft has turned in the frame since the start, not wrapped"),
    Field("driveshaft_speed", "\\Omega", "rad/s", "driveshaft speed", "speed of the driveshaft in the frame"),
    Field("driveshaft_torque", "T", "N m", "driveshaft torque", "motor torque on the driveshaft, positive when it drives"),
    Field("driveshaft_power", "P", "W", "driveshaft power", "motor torque times driveshaft speed"),
    Field("coupling_torque", "T_c", "N m", "coupling torque", "torsion moment in the coupling, on the driveshaft, about its axis"),
    *_crank_force("crank_pin_force", "crank-pin", "load cell, between torque arm and carriage"),
    *_crank_force("pin_joint_force", "pin-joint", "crank pin's joint on the chamber"),
    *vector(
        "nutation_point_force",
        "F_O,",
        "N",
        "nutation-point force",
        "force the universal joint exerts on the chamber",
        WORLD,
        CHAMBER_POINT,
    ),
    Field("nutation_point_force_resultant", "F_O", "N", "nutation-point force", "magnitude of that force", "", CHAMBER_POINT),
    *vector(
        "mount_{mount}_force",
        "F_m,",
        "N",
        "mount {mount} force",
        "force of mount {mount} on the frame",
        WORLD,
        "mount {mount} on the frame",
    ),
    *vector(
        "mount_{mount}_travel",
        "u_m,",
        "m",
        "mount {mount} travel",
        "displacement of the frame at mount {mount}, zero as assembled",
        WORLD,
        "mount {mount} on the frame",
    ),
    *vector(
        "{joint}_reaction_force",
        "F_j,",
        "N",
        "{joint} reaction",
        "force the {joint} exerts on its second body",
        WORLD,
        "point of the {joint} on its second body",
    ),
    *vector(
        "{joint}_reaction_moment",
        "M_j,",
        "N m",
        "{joint} reaction moment",
        "moment the {joint} exerts on its second body, friction included and the motor's left out",
        WORLD,
        "point of the {joint} on its second body",
    ),
    *(
        Field(
            f"{{body}}_attitude_{part}",
            f"q_{part}",
            "1",
            f"{{body}} attitude, {part}",
            f"component {part} of the quaternion that turns axes of the {{body}} into world axes",
            WORLD,
        )
        for part in "wxyz"
    ),
    *vector(
        "{sensor}_acceleration",
        "a",
        "m/s^2",
        "{sensor} acceleration",
        "acceleration of the point of sensor {sensor}, gravity not included",
        "axes of the body that carries the sensor",
        "{sensor}",
    ),
    *vector("charge_mass_centre", "r_c,", "m", "charge mass centre", "mass centre of all particles", WORLD, f"from the {O_FIXED}"),
    Field(
        "charge_phase_lag", "\\varphi", "rad", "charge phase lag", "crank angle less azimuth of the charge's mass centre, positive behind"
    ),
    *vector("charge_force", "F_c,", "N", "charge force", "force of the charge on the chamber, mean of a window", WORLD, CHAMBER_POINT),
    *vector(
        "charge_moment",
        "M_c,",
        "N m",
        "charge moment",
        "moment of the charge on the chamber, mean of a window",
        WORLD,
        f"about the {CHAMBER_POINT}",
    ),
    Field("coordination_number", "Z", "1", "coordination number", "mean number of contacts of a particle, walls not counted"),
    Field("pair_contacts", "N_p", "1", "pair contacts", "particle pairs in contact"),
    Field("wall_contacts", "N_w", "1", "wall contacts", "contacts of particles with surfaces"),
    Field(
        "largest_pair_overlap", "\\delta_p/d", "1", "largest pair overlap", "largest since the last sample, share of the particle diameter"
    ),
    Field(
        "largest_wall_overlap", "\\delta_w/d", "1", "largest wall overlap", "largest since the last sample, share of the particle diameter"
    ),
    energy("motor_work", "W", "motor work", "work the motor has done so far"),
    energy("kinetic_energy_mechanism", "E_{k,m}", "kinetic energy, mechanism", "present kinetic energy of all bodies"),
    energy("kinetic_energy_charge", "E_{k,c}", "kinetic energy, charge", "present kinetic energy of all particles, spin included"),
    energy("potential_energy", "E_g", "potential energy", "present potential energy of bodies and charge in gravity"),
    energy("elastic_energy", "E_e", "elastic energy", "present energy in mounts, coupling, springs and contacts"),
    energy("mount_{mount}_loss", "D_m", "mount {mount}", "energy dissipated so far in mount {mount}"),
    energy("driveshaft_bearing_loss", "D_4", "driveshaft bearing", "energy dissipated so far by friction of driveshaft on frame"),
    energy("crank_pin_loss", "D_6", "crank pin", "energy dissipated so far by friction of crank pin in chamber"),
    energy("chamber_pivot_loss", "D_7", "chamber pivot", "energy dissipated so far by friction of chamber on bearing cross"),
    energy("yoke_pivot_loss", "D_8", "yoke pivot", "energy dissipated so far by friction of bearing cross on frame"),
    energy("coupling_loss", "D_c", "coupling", "energy dissipated so far in the shaft coupling"),
    *_contact_losses("pair", "pellet-pellet"),
    *_contact_losses("wall", "pellet-wall"),
    energy("substep_loss", "D_s", "substep", "work of contact forces so far on mean less predicted velocities, which no contact owns"),
    energy("interface_work", "W_c", "interface work", "work the chamber has done on the charge so far"),
    energy("ledger_residual", "R", "ledger residual", "kinetic + potential + elastic + dissipated - motor work - value at the start"),
    Field(
        "interface_impulse_defect",
        "\\Delta J",
        "N s",
        "interface impulse defect",
        "momentum the charge has gained less the impulses of its weight and of the chamber, magnitude of the sum so far",
    ),
)
"""All series, in the order in which they stand in files and tables."""

SNAPSHOT: tuple[Field, ...] = (
    Field("positions", "x", "m", "particle positions", "centres of the particles by id", WORLD, f"from the {O_FIXED}", "(n_particles, 3)"),
    Field("velocities", "v", "m/s", "particle velocities", "velocities of the centres by id", WORLD, "", "(n_particles, 3)"),
    Field("attitudes", "q", "1", "particle attitudes", "unit quaternions (w, x, y, z) of clumps by id", WORLD, "", "(n_particles, 4)"),
    Field("spins", "\\omega", "rad/s", "particle spins", "angular velocities by id", WORLD, "", "(n_particles, 3)"),
    Field(
        "radii",
        "R",
        "m",
        "particle radii",
        "radii by id, of a clump that of the sphere of its volume",
        shape="(n_particles,)",
    ),
    Field(
        "contact_forces",
        "F",
        "N",
        "contact forces",
        "magnitude of the resultant of all contact forces on a particle in the last substep, by id; not of clumps",
        shape="(n_particles,)",
    ),
    Field("materials", "", "1", "particle materials", "place in the list of the charge's materials, by id", shape="(n_particles,)"),
    Field("chamber_floor", "f", "m", "chamber floor", "middle of the chamber's floor", WORLD, f"from the {O_FIXED}", "(3,)"),
    Field("chamber_attitude", "q", "1", "chamber attitude", "unit quaternion (w, x, y, z), chamber to world", WORLD, "", "(4,)"),
    Field("body_positions", "p", "m", "body positions", "mass centres of the bodies", WORLD, f"from the {O_FIXED}", "(n_bodies, 3)"),
    Field("body_attitudes", "q", "1", "body attitudes", "unit quaternions (w, x, y, z), body to world", WORLD, "", "(n_bodies, 4)"),
)
"""All arrays a snapshot may hold."""

CRANK_FRAME = "chamber, turned about its axis by the crank angle: azimuth from the crank, positive in the direction of rotation"
GRID = "(radius, azimuth, height)"
SPECTRUM = "(pair, part, energy)"
PATCH = "(patch)"


def _cell(name: str, symbol: str, unit: str, label: str, meaning: str) -> Field:
    """One time integral over a cell of the grid in the chamber."""
    return Field(f"cell_{name}", symbol, unit, label, f"time integral of {meaning}", CRANK_FRAME, "", GRID)


def _patch(name: str, symbol: str, unit: str, label: str, meaning: str) -> Field:
    """One sum over a patch of the chamber's surfaces."""
    return Field(f"wall_{name}", symbol, unit, label, meaning, "", "", PATCH)


STATISTICS: tuple[Field, ...] = (
    Field("sampled_time", "t_s", "s", "sampled time", "samples taken so far times their interval", shape="()"),
    Field("impact_number", "n", "1", "impacts", "contacts begun so far, by pair of materials, part and energy", shape=SPECTRUM),
    Field(
        "impact_energy",
        "E",
        "J",
        "impact energy",
        "sum of m_eff v^2/2 of the normal or tangential relative velocity with which contacts have begun so far",
        shape=SPECTRUM,
    ),
    _patch("normal_work", "W_n", "J", "normal work", "energy taken out so far by the normal forces on the wall"),
    _patch("shear_work", "W_t", "J", "shear work", "energy taken out so far by the tangential forces on the wall"),
    _patch("rolling_work", "W_r", "J", "rolling work", "energy taken out so far by the rolling resistance on the wall"),
    _patch("load", "J_n", "N s", "load", "time integral of the normal force on the wall"),
    _patch("cutting_energy", "W_c", "J", "cutting energy", "sum of E f(angle of impact) of all impacts so far, after Finnie 1960"),
    _patch("contacts", "t_c", "s", "contact time", "time integral of the number of contacts"),
    _cell("solid_volume", "V_s", "m^3 s", "solid volume", "the solid volume in the cell"),
    _cell("mass", "m", "kg s", "mass", "the mass of the particles centred in the cell"),
    _cell("momentum_r", "p_r", "kg m", "radial momentum", "their momentum relative to the chamber, outwards"),
    _cell("momentum_a", "p_a", "kg m", "azimuthal momentum", "their momentum relative to the chamber, in the direction of rotation"),
    _cell("momentum_z", "p_z", "kg m", "axial momentum", "their momentum relative to the chamber, upwards along its axis"),
    _cell("square_speed", "m v^2", "J s", "mass times squared speed", "their mass times squared speed relative to the chamber"),
    _cell("particles", "N", "s", "particles", "their number"),
    _cell("neighbours", "Z", "s", "touching neighbours", "the number of particles that touch them"),
    Field(
        "neighbour_time",
        "t_Z",
        "s",
        "particles by neighbours",
        "time integral of the particles with so many neighbours",
        shape="(neighbours)",
    ),
)
"""What a charge has done since the start of the run: every entry is cumulative, so that differences belong to a window."""

STATISTICS_AXES: tuple[Field, ...] = (
    Field("pair", "", "1", "pair of materials", "materials that meet; walls are named so", shape="(pair)"),
    Field("part", "", "1", "part", "part of the relative velocity", shape="(part)"),
    Field("energy", "E", "J", "impact energy", "middle of the bin, half an octave wide", shape="(energy)"),
    Field("radius", "r", "m", "radius", "middle of the cell", CRANK_FRAME, "middle of the chamber's floor", "(radius)"),
    Field("azimuth", "\\psi", "rad", "azimuth", "middle of the cell", CRANK_FRAME, "middle of the chamber's floor", "(azimuth)"),
    Field("height", "z", "m", "height", "middle of the cell", CRANK_FRAME, "middle of the chamber's floor", "(height)"),
    Field("cell_volume", "V", "m^3", "cell volume", "volume of the cell", shape="(radius, height)"),
    Field("neighbours", "Z", "1", "neighbours", "touching neighbours; the last also counts more", shape="(neighbours)"),
    Field("patch_surface", "", "1", "surface", "name of the surface", shape=PATCH),
    Field(
        "patch_column", "", "1", "column", "place of the patch along the azimuth, or face of a rib (-x, +x, -y, +y, -z, +z)", shape=PATCH
    ),
    Field("patch_azimuth", "\\alpha", "rad", "azimuth", "middle of the patch; not a number on a rib", "chamber", shape=PATCH),
    Field(
        "patch_along",
        "z",
        "m",
        "height or radius",
        "middle of the patch: height over the floor; on floor and ceiling radius",
        "chamber",
        shape=PATCH,
    ),
    Field("patch_area", "A", "m^2", "area", "free area of the patch", shape=PATCH),
)
"""What the statistics are laid out along."""

_NAME = "[a-z][a-z0-9_]*"
_PARTS = {
    "mount": "[1-9][0-9]*",
    "body": "|".join(TURNING),
    **dict.fromkeys(("sensor", "joint", "bushing", "spring", "torque", "drive"), _NAME),
}
_SERIES = {field.name: field for field in SERIES}
_SNAPSHOT = {field.name: field for field in SNAPSHOT}
_STATISTICS = {field.name: field for field in STATISTICS + STATISTICS_AXES}


def _pattern(template: str) -> str:
    return re.sub(r"\\{(\w+)\\}", lambda part: f"(?P<{part[1]}>{_PARTS[part[1]]})", re.escape(template))


_TEMPLATES = tuple((re.compile(_pattern(field.name)), field) for field in (*PART_SERIES, *SERIES) if "{" in field.name)


def _filled(field: Field, **part: object) -> Field:
    """`field` with the parts of the machine put in its texts; spaces instead of underscores where people read."""
    spoken = {key: str(value).replace("_", " ") for key, value in part.items()}
    return replace(
        field,
        name=field.name.format(**part),
        label=field.label.format(**spoken),
        meaning=field.meaning.format(**spoken),
        point=field.point.format(**spoken),
    )


@functools.cache
def series_field(name: str) -> Field:
    """The recorded quantity called `name`, parts of the machine filled in.

    Raises
    ------
    CaseError : no quantity has this name; the nearest one is proposed
    """
    if name in _SERIES and "{" not in name:
        return _SERIES[name]
    for pattern, field in _TEMPLATES:
        if match := pattern.fullmatch(name):
            return _filled(field, **match.groupdict())
    raise CaseError(_unknown(name, expand(mounts=4, sensors=("frame_corner",))))


def snapshot_field(name: str) -> Field:
    """The snapshot array called `name`; raises CaseError as `series_field` does."""
    if name in _SNAPSHOT:
        return _SNAPSHOT[name]
    raise CaseError(_unknown(name, _SNAPSHOT))


def statistics_field(name: str) -> Field:
    """The statistics array or axis called `name`; raises CaseError as `series_field` does."""
    if name in _STATISTICS:
        return _STATISTICS[name]
    raise CaseError(_unknown(name, _STATISTICS))


def _unknown(name: str, known) -> Fault:
    near = difflib.get_close_matches(name, known, 1)
    hint = f'Did you mean "{near[0]}"?' if near else "`nutamill info fields` lists all names."
    return Fault(f"record {name}", "must be a recorded quantity, no such name", hint)


def expand(mounts: int = 0, sensors: Sequence[str] = ()) -> list[str]:
    """Names of all series of a machine with `mounts` mounts and the given acceleration sensors, `time` first.

    Parameters
    ----------
    mounts : number of mounts [1]; they are counted from 1
    sensors : names of the sensors as in the case file
    """
    joints = [joint for joint in JOINTS if joint != "frame_fix" or not mounts]
    parts = {"mount": [str(k) for k in range(1, mounts + 1)], "sensor": list(sensors), "joint": joints, "body": list(TURNING)}
    names = []
    for name in _SERIES:
        part = next((part for part in parts if f"{{{part}}}" in name), None)
        names += [name] if part is None else [name.format(**{part: value}) for value in parts[part]]
    return names
