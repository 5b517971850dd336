"""Series of a mill: what is recorded at every sample."""

from collections.abc import Sequence
from dataclasses import replace

from nutamill.result.fields.field import O_FIXED, WORLD, Field, energy, vector

CRANK = "driveshaft: radial towards its axis, tangential in the direction of rotation"


def _crank_force(name: str, where: str, point: str) -> tuple[Field, ...]:
    """Declare the radial, tangential and resultant force of the crank at one of its two probes,
    raw and without gravity's share.
    """
    meaning = f"force the crank exerts at the {where}"
    tared = "with the share of gravity taken off, as a reading zeroed at rest in the turning axes"
    raw = (
        Field(
            f"{name}_radial",
            "F_r",
            "N",
            f"{where} force, radial",
            f"{meaning}, towards the driveshaft axis",
            CRANK,
            point,
        ),
        Field(
            f"{name}_tangential",
            "F_t",
            "N",
            f"{where} force, tangential",
            f"{meaning}, in the direction of rotation",
            CRANK,
            point,
        ),
        Field(
            f"{name}_resultant",
            "F",
            "N",
            f"{where} force",
            f"{meaning}: root of radial squared plus tangential squared",
            "",
            point,
        ),
    )
    return raw + tuple(
        replace(
            field,
            name=f"{field.name}_tared",
            label=f"{field.label}, tared",
            meaning=f"{field.meaning}, {tared}",
        )
        for field in raw
    )


def _contact_losses(name: str, label: str) -> tuple[Field, ...]:
    """Declare the energy that the contacts of one class have dissipated, by part of the law."""
    return tuple(
        energy(
            f"{name}_{part}_loss",
            f"D_{{\\mathrm{{{name},{part[0]}}}}}",
            f"{label}, {part}",
            f"energy dissipated so far {how}, {label}",
        )
        for part, how in (
            ("normal", "by the normal dashpots"),
            ("tangential", "by sliding"),
            ("rolling", "by rolling resistance"),
            ("film", "by films and bridges of liquid, with a wet charge"),
        )
    )


TIME = Field("time", "t", "s", "time", "simulated time since the start of the run")
CHAMBER_POINT = "nutation point, moving with the chamber"

JOINTS = (
    "frame_fix",
    "intermediate_shaft_bearing",
    "driveshaft_bearing",
    "crank_pin_load_cell",
    "pin_joint",
    "chamber_pivot",
    "yoke_pivot",
)
"""Joints of a mill whose reactions are recorded; the frame is fixed on rigid mounts only.

The series `crank_pin_force` is read at `crank_pin_load_cell`, the series `pin_joint_force` at `pin_joint`.
"""
RENAMED_JOINTS = {"load_cell": "crank_pin_load_cell", "crank_pin": "pin_joint"}
"""Joints whose names have changed, for messages."""
TURNING = ("frame", "driveshaft", "chamber")
"""Bodies with recorded attitudes, so that a reaction can be written in their axes."""


def known_joints(name: str, known: Sequence[str] = JOINTS) -> str:
    """Return the hint for an unknown joint: its new name, or the names that are known."""
    if name in RENAMED_JOINTS:
        return f"The joint {name} is now called {RENAMED_JOINTS[name]}"
    return f"Known are {', '.join(known)}" if known else "The file has no joints"


SERIES: tuple[Field, ...] = (
    TIME,
    Field(
        "crank_angle",
        "\\theta",
        "rad",
        "crank angle",
        "angle the driveshaft has turned in the frame since the start, not wrapped",
    ),
    Field("driveshaft_speed", "\\Omega", "rad/s", "driveshaft speed", "speed of the driveshaft in the frame"),
    Field(
        "driveshaft_torque",
        "T",
        "N m",
        "driveshaft torque",
        "motor torque on the driveshaft, positive when it drives",
    ),
    Field("driveshaft_power", "P", "W", "driveshaft power", "motor torque times driveshaft speed"),
    Field(
        "coupling_torque",
        "T_c",
        "N m",
        "coupling torque",
        "torsion moment in the coupling, on the driveshaft, about its axis",
    ),
    *_crank_force("crank_pin_force", "crank-pin", "crank_pin_load_cell, between torque arm and carriage"),
    *_crank_force("pin_joint_force", "pin-joint", "pin_joint, the crank pin in the chamber"),
    *vector(
        "nutation_point_force",
        "F_O,",
        "N",
        "nutation-point force",
        "force the universal joint exerts on the chamber",
        WORLD,
        CHAMBER_POINT,
    ),
    Field(
        "nutation_point_force_resultant",
        "F_O",
        "N",
        "nutation-point force",
        "magnitude of that force",
        "",
        CHAMBER_POINT,
    ),
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
    *vector(
        "charge_mass_centre",
        "r_c,",
        "m",
        "charge mass centre",
        "mass centre of all particles",
        WORLD,
        f"from the {O_FIXED}",
    ),
    Field(
        "charge_phase_lag",
        "\\varphi",
        "rad",
        "charge phase lag",
        "crank angle less azimuth of the charge's mass centre, positive behind",
    ),
    *vector(
        "charge_force",
        "F_c,",
        "N",
        "charge force",
        "force of the charge on the chamber, mean since the sample before",
        WORLD,
        CHAMBER_POINT,
    ),
    *vector(
        "charge_moment",
        "M_c,",
        "N m",
        "charge moment",
        "moment of the charge on the chamber, mean since the sample before",
        WORLD,
        f"about the {CHAMBER_POINT}",
    ),
    Field(
        "coordination_number",
        "Z",
        "1",
        "coordination number",
        "mean number of contacts of a particle, walls not counted",
    ),
    Field("pair_contacts", "N_p", "1", "pair contacts", "particle pairs in contact"),
    Field("wall_contacts", "N_w", "1", "wall contacts", "contacts of particles with surfaces"),
    Field(
        "largest_pair_overlap",
        "\\delta_p/d",
        "1",
        "largest pair overlap",
        "largest since the last sample, share of the particle diameter",
    ),
    Field(
        "largest_wall_overlap",
        "\\delta_w/d",
        "1",
        "largest wall overlap",
        "largest since the last sample, share of the particle diameter",
    ),
    energy("motor_work", "W", "motor work", "work the motor has done so far"),
    energy(
        "kinetic_energy_mechanism",
        "E_{k,m}",
        "kinetic energy, mechanism",
        "present kinetic energy of all bodies",
    ),
    energy(
        "kinetic_energy_charge",
        "E_{k,c}",
        "kinetic energy, charge",
        "present kinetic energy of all particles, spin included",
    ),
    energy(
        "potential_energy",
        "E_g",
        "potential energy",
        "present potential energy of bodies and charge in gravity",
    ),
    energy(
        "elastic_energy", "E_e", "elastic energy", "present energy in mounts, coupling, springs and contacts"
    ),
    energy("mount_{mount}_loss", "D_m", "mount {mount}", "energy dissipated so far in mount {mount}"),
    energy(
        "driveshaft_bearing_loss",
        "D_4",
        "driveshaft bearing",
        "energy dissipated so far by friction of driveshaft on frame",
    ),
    energy(
        "pin_joint_loss", "D_6", "pin joint", "energy dissipated so far by friction of crank pin in chamber"
    ),
    energy(
        "chamber_pivot_loss",
        "D_7",
        "chamber pivot",
        "energy dissipated so far by friction of chamber on bearing cross",
    ),
    energy(
        "yoke_pivot_loss",
        "D_8",
        "yoke pivot",
        "energy dissipated so far by friction of bearing cross on frame",
    ),
    energy("coupling_loss", "D_c", "coupling", "energy dissipated so far in the shaft coupling"),
    *_contact_losses("pair", "pellet-pellet"),
    *_contact_losses("wall", "pellet-wall"),
    energy(
        "substep_loss",
        "D_s",
        "substep",
        "work of contact forces so far on mean less predicted velocities, which no contact owns",
    ),
    energy("interface_work", "W_c", "interface work", "work the chamber has done on the charge so far"),
    energy(
        "ledger_residual",
        "R",
        "ledger residual",
        "kinetic + potential + elastic + dissipated - motor work - value at the start",
    ),
    Field(
        "interface_impulse_defect",
        "\\Delta J",
        "N s",
        "interface impulse defect",
        "momentum the charge has gained less the impulses of its weight and of the chamber, "
        "magnitude of the sum so far",
    ),
)
