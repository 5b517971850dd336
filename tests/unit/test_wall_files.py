"""Walls from mesh files: read, refused with what to write instead, filled, run and resumed."""

import math
import os
import shutil
import signal

import numpy as np
import pytest

from nutamill.analysis.summary import warning_lines
from nutamill.base.errors import CaseError, NotInstalledError
from nutamill.case import Case, load_case
from nutamill.case.drawing import CHAMBER
from nutamill.case.rigid_parts import whole_chamber
from nutamill.charge.laws.oscillator import scaled_contact_time
from nutamill.charge.walls.mesh import on_charge_side
from nutamill.design.preflight import preflight
from nutamill.result import Recorder, open_result
from nutamill.simulation import runs
from nutamill.simulation.setup import walls
from nutamill.simulation.setup.bed import settled_bed
from nutamill.simulation.setup.charge import pair_law
from nutamill.simulation.setup.clock import contact_facts, run_clock
from nutamill.simulation.setup.model import build
from nutamill.simulation.setup.particles import charge_particles, particle_count
from nutamill.simulation.setup.regions import free_volume
from nutamill.simulation.setup.statistics import pair_types
from nutamill.simulation.setup.walls import placed_walls, wall_mesh, wall_surfaces
from nutamill.view.drawing import machine_parts

FLOOR, CEILING, RADIUS = -350.0, -122.0, 70.0
"""The chamber of the published mill, in chamber axes from the nutation point [mm]."""


def tube(n=48, scale=1.0):
    """Triangles (t, 3, 3) of the chamber's inside as a prism of `n` facets, normals outwards."""
    angle = 2 * np.pi * np.arange(n) / n
    ring = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    low, high = (np.column_stack([ring, np.full(n, z)]) for z in (FLOOR, CEILING))
    out = []
    for i in range(n):
        j = (i + 1) % n
        out += [
            (low[i], low[j], high[j]),
            (low[i], high[j], high[i]),
            ((0, 0, FLOOR), low[j], low[i]),
            ((0, 0, CEILING), high[i], high[j]),
        ]
    return scale * np.array(out)


def block(low, high):
    """Triangles of an upright box, normals outwards."""
    corner = np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])], float
    )
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.array([[corner[k] for k in t] for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def stl(path, triangles):
    """Write an STL file."""
    text = ["solid made"]
    for triangle in triangles:
        text += [
            "facet normal 0 0 0",
            "outer loop",
            *(f"vertex {x!r} {y!r} {z!r}" for x, y, z in triangle.tolist()),
            "endloop",
            "endfacet",
        ]
    path.write_text("\n".join([*text, "endsolid made", ""]))
    return path


MESHED = """
base = "numill"
[chamber.mesh]
file = "tube.stl"
unit = "mm"
[charge]
mass = "0.05 kg"
[mechanism]
mounting = "rigid"
"""

LIFTER = """
[[walls]]
file = "lifter.stl"
unit = "mm"
at = ["0 mm", "0 mm", "-350 mm"]
material = "{material}"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of the case apart from the present one, with a tube and a lifter of 10 mm by 10 mm in its
    middle.
    """
    home = tmp_path / "home"
    home.mkdir()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    monkeypatch.setattr(
        "nutamill.simulation.setup.bed.bed_file", lambda case: tmp_path / "beds" / case.digest
    )
    stl(home / "tube.stl", tube())
    stl(home / "lifter.stl", block((-5, -5, -5), (5, 5, 100)))
    return home


def case_of(folder, text=MESHED, overrides=()):
    (folder / "mill.toml").write_text(text)
    return load_case(folder / "mill.toml", overrides)


def with_lifter(folder):
    return case_of(folder, MESHED + LIFTER.format(material=load_case("numill").chamber.material))


def refusal(act, *arguments):
    with pytest.raises(CaseError) as caught:
        act(*arguments)
    return str(caught.value)


def test_a_mesh_beside_the_case_is_read_and_identified_by_its_content(folder):
    case = case_of(folder)
    assert case.chamber.mesh.file == str(folder / "tube.stl")
    again = Case.from_toml(case.to_toml())
    assert again == case
    assert again.chamber.mesh == case.chamber.mesh
    # moved with its case it is the same case; another content is another
    moved = shutil.copytree(folder, folder.parent / "moved")
    assert load_case(moved / "mill.toml") == case
    stl(moved / "tube.stl", tube(36))
    assert load_case(moved / "mill.toml") != case
    # one key is enough for another file
    stl(folder / "fine.stl", tube(96))
    assert case_of(folder, MESHED + "[run]\nseed = 2\n").with_(
        "chamber.mesh.file", str(folder / "fine.stl")
    ).chamber.mesh.sha256 != (case.chamber.mesh.sha256)


@pytest.mark.parametrize(
    "text, line",
    [
        (
            '[chamber.mesh]\nfile = "tub.stl"\nunit = "mm"',
            "mill.toml:3: chamber.mesh.file: tub.stl not found (looked in ",
        ),
        (
            '[chamber.mesh]\nfile = "tube.stl"',
            'mill.toml:2: chamber.mesh.unit: is missing. Add e.g. unit = "m" under [chamber.mesh]',
        ),
        (
            '[chamber.mesh]\nfile = "tube.stl"\nunit = "ft"',
            'mill.toml:4: chamber.mesh.unit: must be one of "m", "cm", "mm", "um", "in", got "ft"',
        ),
        (
            LIFTER.format(material="stele"),
            'walls[0].material: no material is called "stele". Did you mean "steel"?',
        ),
        ('[[walls]]\nfile = "lifter.stl"\nunit = "mm"', "walls[0].material: is missing"),
    ],
)
def test_wrong_keys_of_a_mesh_are_refused(folder, text, line):
    assert line in refusal(case_of, folder, f'base = "numill"\n{text}')


def test_a_similar_file_is_suggested(folder):
    assert "Similar: tube.stl" in refusal(
        case_of, folder, 'base = "numill"\n[chamber.mesh]\nfile = "tub.stl"\nunit = "mm"'
    )


@pytest.mark.parametrize(
    "unit, scale, message",
    [("m", 1.0, "tube.stl in m is 302 m"), ("mm", 1e-3, "tube.stl in mm is 0.000302 m")],
)
def test_a_mesh_in_another_unit_is_refused_with_the_unit_to_write(folder, unit, scale, message):
    stl(folder / "tube.stl", tube(scale=scale))
    case = case_of(folder, MESHED.replace('"mm"', f'"{unit}"'))
    meant = "mm" if unit == "m" else "m"
    # diagonal of 140 x 140 x 228 mm: 302 mm
    expected = (
        f'chamber.mesh.unit: {message} large, the chamber is 0.302 m. In {meant}? Write unit = "{meant}"'
    )
    assert refusal(preflight, case) == expected


def chamber_mesh(case):
    return wall_mesh(case.machine, case.machine.walls[0])


def lifter_mesh(case):
    return wall_mesh(case.machine, case.machine.walls[-1])


def room_of(case):
    return free_volume(case.machine, case.machine.regions[0])


def test_a_lifter_in_another_unit_is_refused_too(folder):
    text = MESHED + LIFTER.format(material="steel").replace('unit = "mm"', 'unit = "{}"')
    assert (
        'walls[0].unit: lifter.stl in m is 106 m large, the chamber is 0.302 m. In mm? Write unit = "mm"'
        in refusal(preflight, case_of(folder, text.format("m")))
    )
    assert "walls[0].unit: lifter.stl in um is 0.000106 m large" in refusal(
        preflight, case_of(folder, text.format("um"))
    )


def test_a_lifter_outside_the_chamber_is_refused_with_where_it_is(folder):
    case = case_of(folder, MESHED + LIFTER.format(material="steel"))
    heights = np.ptp(lifter_mesh(case).vertices[:, 2])
    moved = case.with_("walls", [case.walls[0].model_copy(update={"at": (0.0, 0.0, -2.0)})])
    message = refusal(preflight, moved)
    assert message.startswith("walls[0].at: lifter.stl spans z = ")
    assert heights < 0.4  # so that 2 m below the nutation point no part of it is in the chamber
    assert "the chamber -350 to -122 mm" in message


def test_an_open_mesh_is_refused_with_its_file_and_triangle(folder):
    stl(folder / "tube.stl", tube()[1:])
    assert "tube.stl: triangle " in (message := refusal(preflight, case_of(folder)))
    assert "the mesh must be closed" in message


def test_files_that_are_no_meshes_are_refused(folder):
    (folder / "tube.stl").write_text("solid nothing\nfacet normal\n")
    assert refusal(preflight, case_of(folder)).startswith("tube.stl: ")
    (folder / "tube.step").write_text("ISO-10303-21;")
    message = refusal(preflight, case_of(folder, MESHED.replace("tube.stl", "tube.step")))
    assert message == "tube.step: must be a file of the kinds .stl and .obj, got .step"


def test_a_mesh_that_has_changed_or_gone_since_is_refused(folder):
    case = case_of(folder)
    stl(folder / "tube.stl", tube(36))
    assert refusal(preflight, case).startswith(
        "tube.stl: has changed since the case was read. Restore the file"
    )
    (folder / "tube.stl").unlink()
    message = refusal(preflight, Case.from_toml(case.to_toml()))
    assert message.startswith("tube.stl: cannot be read: No such file or directory (")
    assert message.endswith(
        f"A run needs the mesh its case was made with, SHA-256 {case.chamber.mesh.sha256}"
    )


def test_without_the_optional_package_the_refusal_says_how_to_get_it(folder, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "trimesh", None)
    stl(folder / "tube.stl", tube(50))
    with pytest.raises(NotInstalledError) as error:
        preflight(case_of(folder))
    assert str(error.value) == (
        "tube.stl: reading a mesh needs the package trimesh, which is not installed."
        ' Type in your clone of the nutamill repository: pip install ".[mesh]"'
    )


def test_an_obj_file_gives_the_same_mesh(folder):
    stl_mesh = chamber_mesh(case_of(folder))
    lines = []
    for k, triangle in enumerate(tube()):
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in triangle.tolist()] + [
            f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}"
        ]
    (folder / "tube.obj").write_text("\n".join(lines))
    obj_mesh = chamber_mesh(case_of(folder, MESHED.replace("tube.stl", "tube.obj")))
    assert len(obj_mesh.faces) == len(stl_mesh.faces)
    # STL readers keep single precision
    assert obj_mesh.corners == pytest.approx(stl_mesh.corners, abs=1e-7)


def test_check_prints_triangles_patches_volume_and_distance_of_the_mesh_from_the_drawing(folder):
    sheet = "\n".join(preflight(with_lifter(folder)).lines())
    # prism over circle: sin(2 pi/48)/(2 pi/48) = 0.99715; the middle of a facet is 70 (1 - cos(pi/48)) =
    # 0.150 mm inside the bore
    volume = np.pi * 0.07**2 * 0.228 * 0.99715e3
    expected = (
        f"mesh      tube.stl: 192 triangles, 3 smooth patches, {volume:.4g} L (-0.285 % of the drawn chamber)"
    )
    assert f"{expected}, within 0.15 mm of the drawing" in sheet
    assert "          lifter.stl: 12 triangles, 6 smooth patches, 0.0105 L" in sheet


def test_volume_for_the_charge_is_that_of_the_meshes(folder):
    case = with_lifter(folder)
    assert room_of(case) == pytest.approx(chamber_mesh(case).volume - 1.05e-5)
    drawn = case_of(folder, 'base = "numill"\n' + LIFTER.format(material="steel"))
    assert room_of(drawn) == pytest.approx(np.pi * 0.07**2 * 0.228 - 1.05e-5)
    heavy = case_of(folder, MESHED, ["charge.mass=17 kg"])
    assert "charge: does not fit as a loose bed, got 3.7" in refusal(preflight, heavy)


@pytest.mark.parametrize(
    "text", [MESHED, 'base = "numill"\n[charge]\nmass = "0.05 kg"\n'], ids=["meshed", "drawn"]
)
def test_a_bed_settles_among_meshed_walls(folder, text, monkeypatch):
    # settling itself is tested elsewhere: 5 ms of it, in which pellets fall and meet the walls
    monkeypatch.setattr("nutamill.simulation.setup.bed.LONGEST", 0.005)
    case = case_of(folder, text + LIFTER.format(material="steel"), ["charge.mass=0.3 kg", "run.threads=1"])
    bed = settled_bed(case.machine) + whole_chamber(case.chamber).mass_centre
    lifter = lifter_mesh(case)
    radius = charge_particles(case.machine).bounding_radius[0]
    assert len(bed) == particle_count(case.machine)
    # as deep in a wall as pellets press at most: overlap_stop
    assert np.hypot(bed[:, 0], bed[:, 1]).max() < 0.07 - 0.8 * radius
    assert bed[:, 2].min() > -0.350 + 0.8 * radius
    assert on_charge_side(lifter, bed - case.walls[0].at).all()
    # and none within reach of the lifter's sides: |x|, |y| below 5 mm and a radius
    beside = np.abs(bed[:, :2]).max(axis=1) - 0.005
    assert (beside[bed[:, 2] < -0.226] > 0.8 * radius).all()
    first, second = (settled_bed(case.machine) for _ in range(2))
    assert (first == second).all()


def test_no_pellet_is_placed_in_a_gap_in_which_none_fits(folder, monkeypatch):
    monkeypatch.setattr("nutamill.simulation.setup.bed.LONGEST", 0.0005)
    stl(folder / "plate.stl", block((-30, 0, -5), (30, 4, 100)))
    # two plates 3 mm apart, where one in eighty of all places is; pellets are 5 mm thick
    plate = (
        '[[walls]]\nfile = "plate.stl"\nunit = "mm"\nat = ["0 mm", "{y} mm", "-350 mm"]\nmaterial = "steel"\n'
    )
    case = case_of(
        folder,
        'base = "numill"\n' + plate.format(y=0) + plate.format(y=7),
        ["charge.mass=0.3 kg", "run.threads=1"],
    )
    bed = settled_bed(case.machine)
    assert len(bed) == particle_count(case.machine)
    between = (np.abs(bed[:, 0]) < 0.03) & (bed[:, 1] > 0.0) & (bed[:, 1] < 0.011) & (bed[:, 2] < -0.25)
    assert not between.any()


def test_surfaces_of_meshes_hang_on_the_chamber_where_the_case_says(folder):
    case = with_lifter(folder)
    names = [surface.name for surface in wall_surfaces(case.machine)]
    assert names[:3] == ["tube.stl patch 1", "tube.stl patch 2", "tube.stl patch 3"]
    assert names[3:] == [f"lifter.stl patch {k}" for k in range(1, 7)]
    first, lifter = wall_surfaces(case.machine)[0], wall_surfaces(case.machine)[3]
    assert np.array(lifter.origin) - first.origin == pytest.approx([0, 0, -0.350], abs=1e-12)


def test_a_pellet_behind_the_meshed_wall_is_refused_by_name(folder):
    case = case_of(folder, MESHED, ["charge.mass=0.001 kg"])
    bed = np.array([[0.0, 0.0, 0.240 - 0.3], [0.09, 0.0, 0.240 - 0.3]])
    assert 'mesh "tube.stl": particles must start inside of it, these do not: 1' in refusal(
        build, case.machine, bed
    )


def test_a_run_in_a_meshed_chamber_goes_on_from_where_it_stopped(folder, tmp_path, monkeypatch):
    def bed(case, *_):
        rows = np.arange(10) * 0.0055 - 0.02475
        places = np.stack(np.meshgrid(rows, rows, [0.240 - 0.3475]), axis=-1).reshape(-1, 3)
        return places[: particle_count(case.machine)]

    monkeypatch.setattr(runs, "settled_bed", bed)
    monkeypatch.setattr("nutamill.simulation.progress.PAUSE", 0.0)
    case = case_of(
        folder, MESHED, ["drive.ramp=10000 rpm/s", "run.until=15 ms", "run.checkpoint=5 ms", "run.threads=1"]
    )

    def interrupt(progress):
        if progress.phase in ("ramp", "steady"):
            os.kill(os.getpid(), signal.SIGINT)

    with runs.run(case, tmp_path / "whole.h5") as whole:
        assert whole.provenance["chamber.mesh.sha256"] == case.chamber.mesh.sha256
        expected = {name: whole.series[name].values for name in whole.series}
    with pytest.raises(KeyboardInterrupt):
        runs.run(case, tmp_path / "parts.h5", interrupt)
    content = (folder / "tube.stl").read_text()
    stl(folder / "tube.stl", tube(36))
    for cached in (walls._read, walls.world_surfaces, walls.region_corners):
        cached.cache_clear()  # as in another process
    assert "has changed" in refusal(runs.resume, tmp_path / "parts.h5")
    (folder / "tube.stl").write_text(content)
    with runs.resume(tmp_path / "parts.h5") as parts:
        assert parts.state == "complete"
        assert all(np.array_equal(parts.series[name].values, values) for name, values in expected.items())


def enclosed(vertices, triangles):
    """Volume within triangles whose corners run counter-clockwise seen from outside."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.sum(a * np.cross(b, c)) / 6.0


def test_result_keeps_meshed_walls_in_their_place_for_pictures_without_the_files(folder):
    case = with_lifter(folder)
    Recorder.create(folder / "run.h5", case.to_toml(), {}, ["time"], 4800.0, walls=placed_walls(case.machine))
    for file in folder.glob("*.stl"):
        file.unlink()
    with open_result(folder / "run.h5") as result:
        walls = result.walls
        parts = {part.name: part for part in machine_parts(Case.from_toml(result.case_text), walls=walls)}
        cut = {
            part.name: part
            for part in machine_parts(Case.from_toml(result.case_text), opening=math.pi, walls=walls)
        }
    assert enclosed(*walls["walls[0]"][:2]) == pytest.approx(0.01 * 0.01 * 0.105)
    assert np.ptp(walls["walls[0]"].vertices, axis=0) == pytest.approx([0.01, 0.01, 0.105])
    assert walls["walls[0]"].vertices[:, 2].min() == pytest.approx(0.240 - 0.355)
    # a prism of 48 facets; of a room too the triangles face outwards, though those that the charge meets face
    # inwards
    drawn = 24 * np.sin(2 * np.pi / 48) * 1e-9 * RADIUS**2 * (CEILING - FLOOR)
    assert enclosed(*walls["chamber.mesh"][:2]) == pytest.approx(drawn)
    assert len(parts["walls[0]"].triangles) == 12 and parts["walls[0]"].body == CHAMBER
    assert len(parts["chamber wall"].triangles) == len(walls["chamber.mesh"].triangles)
    # looking along +y into the half that is cut away, no triangle has its middle there
    shell = cut["chamber wall"]
    assert 0 < len(shell.triangles) < len(parts["chamber wall"].triangles)
    assert shell.vertices[shell.triangles].mean(axis=1)[:, 1].min() > -1e-9


STIFF_LIFTER = """
[contact]
stiffness = "direct"
[contact.pairs]
steel-steel = { normal_stiffness = "100 kN/m" }
steel-acrylic = { normal_stiffness = "100 kN/m", overlap_warn = 0.05 }
[contact.pairs.steel-carbide]
sliding_friction = 0.3
restitution = 0.6
overlap_warn = 0.08
normal_stiffness = "10000 kN/m"
[materials.carbide]
density = "15000 kg/m^3"
young_modulus = "600 GPa"
poisson_ratio = 0.2
[run]
series_rate = "10 Hz"
window = 1
"""


def test_a_stiff_lifter_shortens_the_step(folder):
    plain = case_of(folder, MESHED + STIFF_LIFTER)
    lifted = case_of(folder, MESHED + LIFTER.format(material="carbide") + STIFF_LIFTER)
    cut = lifted.contact.tension == "cut"
    # the same ball on a spring 100 times as stiff: a tenth of the time, but for the two dashpots
    times = {facts.pair: facts.time for facts in contact_facts(lifted.machine)}
    laws = [pair_law(lifted.machine, "steel", other) for other in ("carbide", "acrylic")]
    damped = [scaled_contact_time(law.damping_ratio, cut) for law in laws]
    ratio = times["steel-carbide wall"] / times["steel-acrylic wall"]
    assert ratio == pytest.approx(0.1 * damped[0] / damped[1], rel=1e-12)
    slow, fast = run_clock(plain.machine), run_clock(lifted.machine)
    assert fast.ruled_by == "steel-carbide wall, 20 substeps per contact"
    assert fast.substep <= times["steel-carbide wall"] / 20 < slow.substep
    # a step that suits the other contacts is refused
    with pytest.raises(CaseError, match="a steel-carbide wall contact lasts"):
        run_clock(lifted.with_("run.dt", slow.substep).machine)
    pairs = ["steel-steel", "steel-acrylic wall", "steel-carbide wall"]
    assert (
        [pair.name for pair in lifted.touching] == [pair.name for pair in pair_types(lifted.machine)] == pairs
    )


NAMES = ["time", "crank_angle", "driveshaft_speed", "largest_pair_overlap", "largest_wall_overlap"]


def test_an_overlap_at_a_lifter_is_measured_against_the_limit_of_its_material(folder, tmp_path):
    """The limits are 5 % at the chamber and 8 % at the lifter: 7 % may be the lifter's, 9 % is too much."""
    lifted = case_of(folder, MESHED + LIFTER.format(material="carbide") + STIFF_LIFTER)
    for overlap, warned in ((0.07, False), (0.09, True)):
        path = tmp_path / f"{overlap}.h5"
        recorder = Recorder.create(path, lifted.to_toml(), {}, NAMES, 10.0)
        recorder.append(np.array([[0.1, 0.0, 0.0, 0.0, overlap]]))
        recorder.close()
        with open_result(path) as result:
            assert any("largest wall overlap" in line for line in warning_lines(result)) == warned
