"""Arrays of the charge: what a snapshot may hold, and what the statistics sum."""

from nutamill.result.fields.field import O_FIXED, WORLD, Field

SNAPSHOT: tuple[Field, ...] = (
    Field(
        "positions",
        "x",
        "m",
        "particle positions",
        "centres of the particles by id",
        WORLD,
        f"from the {O_FIXED}",
        "(n_particles, 3)",
    ),
    Field(
        "velocities",
        "v",
        "m/s",
        "particle velocities",
        "velocities of the centres by id",
        WORLD,
        "",
        "(n_particles, 3)",
    ),
    Field(
        "attitudes",
        "q",
        "1",
        "particle attitudes",
        "unit quaternions (w, x, y, z) of clumps by id",
        WORLD,
        "",
        "(n_particles, 4)",
    ),
    Field(
        "spins",
        "\\omega",
        "rad/s",
        "particle spins",
        "angular velocities by id",
        WORLD,
        "",
        "(n_particles, 3)",
    ),
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
        "magnitude of the resultant of all contact forces on a particle in the last substep, by id; "
        "not of clumps",
        shape="(n_particles,)",
    ),
    Field(
        "materials",
        "",
        "1",
        "particle materials",
        "place in the list of the charge's materials, by id",
        shape="(n_particles,)",
    ),
    Field(
        "chamber_floor",
        "f",
        "m",
        "chamber floor",
        "middle of the chamber's floor",
        WORLD,
        f"from the {O_FIXED}",
        "(3,)",
    ),
    Field(
        "chamber_attitude",
        "q",
        "1",
        "chamber attitude",
        "unit quaternion (w, x, y, z), chamber to world",
        WORLD,
        "",
        "(4,)",
    ),
    Field(
        "body_positions",
        "p",
        "m",
        "body positions",
        "mass centres of the bodies",
        WORLD,
        f"from the {O_FIXED}",
        "(n_bodies, 3)",
    ),
    Field(
        "body_attitudes",
        "q",
        "1",
        "body attitudes",
        "unit quaternions (w, x, y, z), body to world",
        WORLD,
        "",
        "(n_bodies, 4)",
    ),
)
"""All arrays a snapshot may hold."""

CRANK_FRAME = (
    "chamber, turned about its axis by the crank angle: azimuth from the crank, positive in the "
    "direction of rotation"
)
GRID = "(radius, azimuth, height)"
SPECTRUM = "(pair, part, energy)"
PATCH = "(patch)"


def _cell(name: str, symbol: str, unit: str, label: str, meaning: str) -> Field:
    """Declare one time integral over a cell of the grid in the chamber."""
    return Field(f"cell_{name}", symbol, unit, label, f"time integral of {meaning}", CRANK_FRAME, "", GRID)


def _patch(name: str, symbol: str, unit: str, label: str, meaning: str) -> Field:
    """Declare one sum over a patch of the chamber's surfaces."""
    return Field(f"wall_{name}", symbol, unit, label, meaning, "", "", PATCH)


STATISTICS: tuple[Field, ...] = (
    Field(
        "sampled_time", "t_s", "s", "sampled time", "samples taken so far times their interval", shape="()"
    ),
    Field(
        "impact_number",
        "n",
        "1",
        "impacts",
        "contacts begun so far, by pair of materials, part and energy; of the part loading, contacts that "
        "have turned, once each",
        shape=SPECTRUM,
    ),
    Field(
        "impact_energy",
        "E",
        "J",
        "impact energy",
        "sum of m_eff v^2/2 of the normal or tangential relative velocity with which contacts have "
        "begun so far; of the part loading, sum of the work that has loaded their springs at their deepest",
        shape=SPECTRUM,
    ),
    _patch(
        "normal_work", "W_n", "J", "normal work", "energy taken out so far by the normal forces on the wall"
    ),
    _patch(
        "shear_work", "W_t", "J", "shear work", "energy taken out so far by the tangential forces on the wall"
    ),
    _patch(
        "rolling_work",
        "W_r",
        "J",
        "rolling work",
        "energy taken out so far by the rolling resistance on the wall",
    ),
    _patch("load", "J_n", "N s", "load", "time integral of the normal force on the wall"),
    _patch(
        "cutting_energy",
        "W_c",
        "J",
        "cutting energy",
        "sum of E f(angle of impact) of all impacts so far, after Finnie 1960",
    ),
    _patch("contacts", "t_c", "s", "contact time", "time integral of the number of contacts"),
    _cell("solid_volume", "V_s", "m^3 s", "solid volume", "the solid volume in the cell"),
    _cell("mass", "m", "kg s", "mass", "the mass of the particles centred in the cell"),
    _cell("momentum_r", "p_r", "kg m", "radial momentum", "their momentum relative to the chamber, outwards"),
    _cell(
        "momentum_a",
        "p_a",
        "kg m",
        "azimuthal momentum",
        "their momentum relative to the chamber, in the direction of rotation",
    ),
    _cell(
        "momentum_z",
        "p_z",
        "kg m",
        "axial momentum",
        "their momentum relative to the chamber, upwards along its axis",
    ),
    _cell(
        "square_speed",
        "m v^2",
        "J s",
        "mass times squared speed",
        "their mass times squared speed relative to the chamber",
    ),
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
"""What a charge has done since the start of the run: every entry is cumulative, so that differences belong to
a window.
"""

STATISTICS_AXES: tuple[Field, ...] = (
    Field(
        "pair",
        "",
        "1",
        "pair",
        "materials that meet, of several sizes with their class; walls are named so",
        shape="(pair)",
    ),
    Field("pair_materials", "", "1", "pair of materials", "materials that meet", shape="(pair)"),
    Field(
        "pair_first",
        "d",
        "m",
        "diameter",
        "diameter of the particle of mean volume of the first of a pair",
        shape="(pair)",
    ),
    Field(
        "pair_second",
        "d",
        "m",
        "diameter",
        "the same of the second; not a number for a wall",
        shape="(pair)",
    ),
    Field(
        "pair_share",
        "",
        "1",
        "share of the first",
        "share of the work of loading that the first of a pair takes: k_second/(k_first + k_second)",
        shape="(pair)",
    ),
    Field(
        "part",
        "",
        "1",
        "part",
        "normal and tangential part of the approach, and loading",
        shape="(part)",
    ),
    Field("energy", "E", "J", "impact energy", "middle of the bin, half an octave wide", shape="(energy)"),
    Field(
        "radius",
        "r",
        "m",
        "radius",
        "middle of the cell",
        CRANK_FRAME,
        "middle of the chamber's floor",
        "(radius)",
    ),
    Field(
        "azimuth",
        "\\psi",
        "rad",
        "azimuth",
        "middle of the cell",
        CRANK_FRAME,
        "middle of the chamber's floor",
        "(azimuth)",
    ),
    Field(
        "height",
        "z",
        "m",
        "height",
        "middle of the cell",
        CRANK_FRAME,
        "middle of the chamber's floor",
        "(height)",
    ),
    Field("cell_volume", "V", "m^3", "cell volume", "volume of the cell", shape="(radius, height)"),
    Field(
        "neighbours",
        "Z",
        "1",
        "neighbours",
        "touching neighbours; the last also counts more",
        shape="(neighbours)",
    ),
    Field("patch_surface", "", "1", "surface", "name of the surface", shape=PATCH),
    Field(
        "patch_column",
        "",
        "1",
        "column",
        "place of the patch along the azimuth, or face of a rib (-x, +x, -y, +y, -z, +z)",
        shape=PATCH,
    ),
    Field(
        "patch_azimuth",
        "\\alpha",
        "rad",
        "azimuth",
        "middle of the patch; not a number on a rib",
        "chamber",
        shape=PATCH,
    ),
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
"""Axes of the statistics."""
