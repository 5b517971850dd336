"""Wear of walls in units of a workshop, and worn meshes for the next run."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from ground_run import write
from scipy.special import stdtrit
from test_wall_files import MESHED, stl, tube
from typer.testing import CliRunner

from nutamill import cli
from nutamill.analysis.wear import by_surface, friction_at, life_of, liner_of, wall_wear, wear_lines
from nutamill.base.errors import CaseError
from nutamill.base.units import in_unit
from nutamill.case import load_case
from nutamill.export.drawn_chamber import FACETS, drawn_chamber
from nutamill.export.worn import depth_at, write_worn
from nutamill.result import open_result
from nutamill.simulation.setup.statistics import wall_patches
from nutamill.simulation.setup.walls import meshed_walls, wall_mesh

LOAD, SPEED, FRICTION = 50.0, 0.2, 0.2
"""A block on a patch of 1 m^2: load [N], sliding speed [m/s]; friction of steel on acrylic [1]."""
K, HARDNESS = 1e-4, 2e9


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("worn")
    sliding = np.array([FRICTION * LOAD * SPEED, 3.0 * FRICTION * LOAD * SPEED])
    walls = {"wall_shear_work": sliding, "wall_cutting_energy": np.array([8.0, 0.0])}
    write(place / "run.h5", **walls)
    write(place / "uneven.h5", (0.0, 1.0, 1.1, 0.9), **walls)
    write(place / "none.h5", statistics=False)
    return place


@pytest.fixture
def invoke(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return lambda *words: CliRunner().invoke(cli.app, words)


def worn(folder, name="run", last=4.0, **liner):
    with open_result(folder / f"{name}.h5") as result:
        return wall_wear(result, liner_of(HARDNESS, **liner), last)


def test_a_sliding_block_wears_by_coefficient_load_and_distance_over_hardness(folder):
    wear = worn(folder, coefficient=K)
    assert wear.depth == pytest.approx(np.array([1.0, 3.0]) * K * LOAD * SPEED / HARDNESS, rel=1e-12, abs=0.0)


def test_a_surface_has_the_friction_of_its_own_wall_and_of_none_whose_name_it_begins_with():
    walls = [SimpleNamespace(name=name, material=name, file=None) for name in ("lid", "lid_top")]
    friction = {"lid": 0.5, "lid_top": 0.2}
    contact = SimpleNamespace(pair=lambda own, wall: SimpleNamespace(sliding_friction=friction[wall]))
    machine = SimpleNamespace(walls=walls, contact=contact, charge=SimpleNamespace(materials=["steel"]))
    frictions = [friction_at(machine, surface) for surface in ("lid", "lid side", "lid top", "lid_top face")]
    assert frictions == [0.5, 0.5, 0.2, 0.2]


def test_impacts_cut_their_weighed_energy_over_twice_the_hardness(folder):
    wear = worn(folder, cutting=0.1)
    assert wear.depth == pytest.approx([0.1 * 8.0 / (2.0 * HARDNESS), 0.0], rel=1e-12, abs=0.0)


def test_a_surface_has_a_mean_a_worst_place_and_an_interval(folder):
    (bore,) = by_surface(worn(folder, "uneven", 3.0, coefficient=K))
    unit = K * LOAD * SPEED / HARDNESS
    assert bore.name == "bore" and bore.sliding == pytest.approx(2.0 * unit, rel=1e-12, abs=0.0)
    assert (bore.worst, bore.azimuth) == (pytest.approx(3.0 * unit, rel=1e-12, abs=0.0), 4.0)
    # three windows with 1, 1.1 and 0.9 times as much
    assert bore.half_width == pytest.approx(
        2.0 * unit * stdtrit(2, 0.975) * 0.1 / math.sqrt(3.0), rel=1e-12, abs=0.0
    )


def test_a_liner_lasts_its_thickness_over_the_worst_depth(folder):
    (bore,) = by_surface(worn(folder, coefficient=K))
    assert life_of(0.01, bore.worst) == pytest.approx(0.01 * HARDNESS / (3.0 * K * LOAD * SPEED))
    assert life_of(0.01, 0.0) == math.inf
    hours = 0.01 * HARDNESS / (3.0 * K * LOAD * SPEED) / 3600.0
    assert f"{hours:.4g}" in wear_lines([bore], 0.01)[1]


def test_command_prints_mm_per_1000_hours_and_saves_a_picture(invoke, folder):
    reply = invoke("wear", "run.h5", "--hardness", "2 GPa", "--coefficient", "1e-4", "--thickness", "10 mm")
    assert reply.exit_code == 0, reply.output
    depth = in_unit(1000.0 * 3600.0 * 2.0 * K * LOAD * SPEED / HARDNESS, "mm")
    assert f"{depth:.3g}" in reply.stdout and "life (h)" in reply.stdout
    assert (folder / "run-wear-3s.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (
            ("--coefficient", "1e-4", "--after", "100 h"),
            "run.h5: its statistics have 2 patches of the walls, this version makes",
        ),
        ((), "needs --coefficient for wear by sliding, --cutting for wear by impacts"),
        (("--coefficient", "2"), "--coefficient: must be 0 to 1, got 2"),
        (("--cutting", "-0.5"), "--cutting: must be 0 to 1, got -0.5"),
        (("--coefficient", "1e-4", "--hardness", "-1 GPa"), "--hardness: must be positive, got -1 GPa"),
        (("--coefficient", "1e-4", "--after", "100"), "--after: needs a unit"),
        (("--coefficient", "1e-4", "--thickness", "0 mm"), '--thickness: must be positive, got "0 mm"'),
    ],
)
def test_wear_that_has_no_answer_is_refused(invoke, words, expected):
    reply = invoke("wear", "run.h5", *(() if "--hardness" in words else ("--hardness", "2 GPa")), *words)
    assert reply.exit_code == 2 and expected in reply.stderr


def test_a_run_without_statistics_is_refused(invoke):
    reply = invoke("wear", "none.h5", "--hardness", "2 GPa", "--coefficient", "1e-4")
    assert reply.exit_code == 2 and "none.h5: holds no statistics of the charge" in reply.stderr


def test_depth_between_patches_is_on_straight_lines_and_goes_round():
    heights = np.array([[1.0, 2.0, 4.0]])
    points = np.array([[1.0, 0.0, z] for z in (0.0, 0.5, 1.0, 1.5, 2.5, 3.0)])
    assert depth_at(points, heights, False, 0.0, 3.0) == pytest.approx([1.0, 1.0, 1.5, 2.0, 4.0, 4.0])
    around = np.array([[1.0], [2.0], [3.0], [4.0]])  # middles at 45, 135, 225, 315 degrees
    angle = np.radians([45.0, 90.0, 0.0, -45.0])
    places = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    assert depth_at(places, around, True, 0.0, 1.0) == pytest.approx([1.0, 1.5, 2.5, 4.0])


@pytest.fixture
def meshed(tmp_path, folder):
    """A machine whose chamber is a mesh of 48 facets, and wear of 1 mm in a second all over it."""
    stl(tmp_path / "tube.stl", tube())
    (tmp_path / "mill.toml").write_text(MESHED)
    machine = load_case(tmp_path / "mill.toml").machine
    patches = int(wall_patches(machine).first[-1])
    wear = worn(folder, coefficient=K)._replace(sliding=np.full(patches, 1e-3), cutting=np.zeros(patches))
    return machine, wear


def test_a_worn_chamber_is_larger_by_the_depth_on_every_side_and_can_be_run_again(meshed, tmp_path):
    pytest.importorskip("trimesh")
    machine, wear = meshed
    (path,) = write_worn(machine, wear, 1.0, tmp_path)
    again = load_case(tmp_path / "mill.toml", [f'chamber.mesh.file="{path}"']).machine
    (before, after) = (wall_mesh(one, meshed_walls(one)[0]) for one in (machine, again))
    assert np.ptp(after.vertices[:, 2]) - np.ptp(before.vertices[:, 2]) == pytest.approx(2e-3, abs=1e-12)
    apothem, height = 0.07 * math.cos(math.pi / 48), 0.228
    exact = 48 * math.tan(math.pi / 48) * (apothem + 1e-3) ** 2 * (height + 2e-3)
    assert abs(after.volume) == pytest.approx(exact, rel=1e-12)


def test_a_drawn_chamber_is_written_worn_in_the_axes_of_a_chamber_mesh(folder, tmp_path):
    pytest.importorskip("trimesh")
    case = load_case("numill")
    table = wall_patches(case.machine)
    depth = np.full(int(table.first[-1]), 1e-3)
    depth[int(table.first[1]) : int(table.first[2])] = 3e-3  # the floor
    wear = worn(folder, coefficient=K)._replace(sliding=depth, cutting=np.zeros(len(depth)))
    (path,) = write_worn(case, wear, 2.0, tmp_path)
    (tmp_path / "mill.toml").write_text(MESHED.replace("tube.stl", path.name))
    again = load_case(tmp_path / "mill.toml").machine
    mesh = wall_mesh(again, meshed_walls(again)[0])
    chamber = case.chamber
    ends = mesh.vertices[:, 2].min(), mesh.vertices[:, 2].max()
    assert ends == pytest.approx((-chamber.floor_depth - 6e-3, -chamber.ceiling_depth + 2e-3), abs=1e-9)
    apothem = 0.07 * math.cos(math.pi / FACETS) + 2e-3
    exact = FACETS * math.tan(math.pi / FACETS) * apothem**2 * (ends[1] - ends[0])
    assert abs(mesh.volume) == pytest.approx(exact, rel=1e-6)


def test_a_chamber_with_ribs_is_not_written_without_them(folder, tmp_path):
    case = load_case("numill", ["chamber.ribs=2"])
    none = np.zeros(int(wall_patches(case.machine).first[-1]))
    wear = worn(folder, coefficient=K)._replace(sliding=none, cutting=none)
    with pytest.raises(CaseError, match=r"smooth cylinder with flat ends, .* has the walls rib_1, rib_2"):
        write_worn(case, wear, 1.0, tmp_path)


def test_ends_without_a_wall_are_refused(tmp_path):
    machine = load_case("numill").machine
    walls = tuple(wall for wall in machine.walls if wall.name != "ceiling")
    with pytest.raises(CaseError, match="triangles of its cylinder are on no wall"):
        drawn_chamber(machine.model_copy(update={"walls": walls}), machine.regions[0])


def test_wear_deeper_than_the_triangles_are_large_is_refused(meshed, tmp_path):
    pytest.importorskip("trimesh")
    machine, wear = meshed
    inwards = wear._replace(sliding=-wear.sliding)
    with pytest.raises(CaseError, match=r"turn over\. Take a shorter time"):
        write_worn(machine, inwards, 100.0, tmp_path)
