"""What a user gives to `nutamill breakage` and gets from it: ores, results, tables, intervals, refusals."""

import math

import numpy as np
import pytest
from ground_run import AXES, ENERGY, NUMBER, POWER, write
from scipy.special import stdtrit
from typer.testing import CliRunner

from nutamill import cli
from nutamill.analysis.breakage.answer import breakage, comparison_lines
from nutamill.analysis.breakage.impacts import captured_mass, grinding_of, reduced_radii
from nutamill.analysis.breakage.ore import load_ore
from nutamill.analysis.flow import impact_spectra, window
from nutamill.base.errors import CaseError, ResultError
from nutamill.base.library import ore_names
from nutamill.result import open_result


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("ground")
    write(place / "run.h5")
    write(place / "twice.h5", (2.0, 2.0, 2.0, 2.0))
    write(place / "uneven.h5", (0.0, 1.0, 1.1, 0.9))
    write(place / "weak.h5", numbers=np.where(ENERGY < 1e-6, NUMBER, 0.0))
    write(place / "few.h5", numbers=np.where(ENERGY < 1e-6, NUMBER, np.where(ENERGY > 0.02, 1.0, 0.0)))
    write(place / "none.h5", statistics=False)
    return place


@pytest.fixture
def invoke(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return lambda *words: CliRunner().invoke(cli.app, words)


def test_impacts_at_walls_alone_break_nothing(tmp_path):
    axes = AXES | {"pair_second": np.full(len(AXES["pair_second"]), np.nan)}
    write(tmp_path / "walls.h5", axes=axes)
    with pytest.raises(ResultError, match=r"walls\.h5: holds no impacts of particles with each other"):
        grinding(tmp_path, "walls")


def test_a_result_of_an_earlier_version_lacks_the_work_of_loading_and_nothing_else(tmp_path):
    axes = {name: values for name, values in AXES.items() if name != "pair_share"}
    write(tmp_path / "old.h5", axes=axes | {"part": np.array(["normal", "tangential"])})
    with pytest.raises(
        ResultError, match=r"old\.h5: holds no work of loading of its contacts.*Run the case again"
    ):
        grinding(tmp_path, "old")
    with open_result(tmp_path / "old.h5") as result:
        assert float(impact_spectra(window(result, 4.0))["rate"].sum()) == pytest.approx(4.0 * NUMBER.sum())


def test_what_leaves_a_bin_counts_as_no_impact(tmp_path):
    # contacts of an earlier time that were pressed deeper in this window
    numbers = np.where(np.arange(40) == 7, -3.0, NUMBER)
    write(tmp_path / "deeper.h5", numbers=numbers)
    whole = grinding(tmp_path, "deeper").whole
    assert whole.number[0, 7] == 0.0 and whole.rate[0, 7] == 0.0
    assert np.all((whole.energy >= whole.edges[:-1]) & (whole.energy <= whole.edges[1:]))


def grinding(folder, name, last=4.0):
    with open_result(folder / f"{name}.h5") as result:
        return grinding_of(result, last)


ORE = """
schema = 1
source = "a test"
density = "3000 kg/m^3"
feed = "1 mm"
feed_exponent = 2.0
product = "0.3 mm"
fineness = 0.8
[drop_weight]
A = 50.0
b = 0.5
size = "28.9 mm"
size_exponent = 0.4
"""
BREAKS = ORE.replace("size_exponent = 0.4", 'size_exponent = 0.4\nleast_energy = "0.3 J/kg"')
"""An ore that only impacts of some strength break."""


def test_ores_of_the_package_are_read_and_name_their_sources():
    assert ore_names()
    assert all(load_ore(name).source for name in ore_names())


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('source = "a test"', 'source = ""', 'source: string should have at least 1 character, got ""'),
        ('source = "a test"\n', "", "source"),
        ("A = 50.0", "A = 120.0", "drop_weight.A: must be less than 100, got 120"),
        ("A = 50.0", "A = 0.0", "drop_weight.A: must be greater than 0, got 0.0"),
        ("b = 0.5", "b = -1.0", "drop_weight.b: must be greater than 0, got -1.0"),
        ("b = 0.5", "b = 400.0", "drop_weight.b: must be at most 100, got 400"),
        ('feed = "1 mm"', 'feed = "0.2 mm"', "product must be less than feed, got 0.3 mm and 0.2 mm"),
        ("[drop_weight]", "[tavares]\nA = 50.0\n[drop_weight]", "tavares.steepness"),
        (ORE[ORE.index("[drop_weight]") :], "", "must have one of [drop_weight] and [tavares], got none"),
        ('density = "3000 kg/m^3"', "density = 3000", "needs a unit"),
        ("feed_exponent = 2.0", "feed_exponent = 1e-6", "must be at least 0.2"),
    ],
)
def test_an_ore_that_is_not_one_is_refused(tmp_path, old, new, expected):
    (tmp_path / "ore.toml").write_text(ORE.replace(old, new))
    with pytest.raises(CaseError) as refusal:
        load_ore(tmp_path / "ore.toml")
    assert expected in str(refusal.value)


def test_reduced_radius_of_two_balls_and_of_a_ball_at_a_wall():
    radii = reduced_radii(np.array([0.005, 0.004, 0.005]), np.array([0.005, 0.006, np.nan]))
    assert radii == pytest.approx([0.00125, 0.0012, 0.0025])


def test_twice_the_impacts_at_the_same_power_need_half_the_energy(folder):
    ore = load_ore("smc-sample-a")
    once, twice = (breakage(grinding(folder, name), ore) for name in ("run", "twice"))
    assert once.energy / twice.energy == pytest.approx(2.0, rel=1e-3)
    assert twice.selection == pytest.approx(2.0 * once.selection, rel=1e-12, abs=0.0)
    assert once.grinding.power == pytest.approx(POWER)
    assert once.p80[-1] == pytest.approx(ore.product, rel=1e-3) and np.all(np.diff(once.p80) < 0.0)


def test_the_interval_follows_from_the_scatter_of_the_windows(folder):
    ore = load_ore("smc-sample-a")
    even, uneven = (breakage(grinding(folder, name, 3.0), ore) for name in ("run", "uneven"))
    assert even.selection_half_width == pytest.approx(0.0, abs=1e-12 * even.selection.max())
    # three windows with 1, 1.1 and 0.9 times as many
    student = stdtrit(2, 0.975) * 0.1 / math.sqrt(3.0)
    assert uneven.selection_half_width == pytest.approx(student * even.selection, rel=1e-9, abs=0.0)
    assert uneven.energy_half_width == pytest.approx(student * even.energy, rel=0.05)


def test_one_window_has_no_interval(folder):
    answer = breakage(grinding(folder, "run", 1.0), load_ore("smc-sample-a"))
    assert np.isnan(answer.selection_half_width).all() and math.isnan(answer.energy_half_width)


def test_runs_are_compared_at_the_energy_of_the_first(folder):
    ore = load_ore("smc-sample-a")
    first = breakage(grinding(folder, "run"), ore)
    second = breakage(grinding(folder, "twice"), ore, first.energies[-1])
    lines = comparison_lines([first, second])
    assert len(lines) == 5 and lines[3].startswith("run.h5: NuMill")
    assert lines[1].split()[4] == "1.000" and lines[2].split()[4] == "0.500"
    assert second.p80[-1] < first.p80[-1]


def test_impacts_that_are_too_weak_are_refused_with_the_bins_that_are_empty(folder, tmp_path):
    (tmp_path / "ore.toml").write_text(BREAKS)
    ore = load_ore(tmp_path / "ore.toml")
    with pytest.raises(ResultError) as refusal:
        breakage(grinding(folder, "weak"), ore)
    assert "too few or too weak for this ore" in str(refusal.value)
    mass = float(captured_mass(ore.top_size, np.array(0.00125), ore.density))
    needed = 0.3 * 28.9e-3 / ore.top_size * mass
    lowest = ENERGY[needed < ENERGY][0] / 2.0**0.25
    assert f"Empty bins: {lowest:.2g} to {ENERGY[-1] * 2.0**0.25:.2g} J" in str(refusal.value)
    with pytest.raises(ResultError, match=r"rests on (2|1\.\d) of .* at least 10 are needed"):
        breakage(grinding(folder, "few", 1.0), ore)


def test_a_run_without_statistics_is_refused(invoke):
    reply = invoke("breakage", "none.h5", "--ore", "smc-sample-a")
    assert reply.exit_code == 2 and "none.h5: holds no statistics of the charge" in reply.stderr


def test_a_feed_coarser_than_the_balls_is_refused(invoke, folder):
    (folder / "coarse.toml").write_text(ORE.replace('feed = "1 mm"', 'feed = "20 mm"'))
    reply = invoke("breakage", "run.h5", "--ore", "coarse.toml")
    assert reply.exit_code == 2
    assert "the ore must be finer than the balls that grind it, got a feed up to 22.36 mm" in reply.stderr


def test_an_ore_that_hardly_breaks_has_no_energy_for_its_product(invoke, folder):
    (folder / "tough.toml").write_text(ORE.replace("b = 0.5", "b = 1e-9").replace("28.9 mm", "10000 m"))
    reply = invoke("breakage", "run.h5", "run.h5", "--ore", "tough.toml")
    assert reply.exit_code == 0 and not reply.stderr
    assert reply.stdout.splitlines()[-4].split()[2] == "inf"


def test_an_ore_given_by_its_fracture_energies_is_ground(invoke, folder):
    law = """[tavares]
A = 60.0
steepness = 0.03
fracture_energy = "100 J/kg"
half_size = "1 mm"
size_exponent = 1.2
spread = 0.5
largest = 4.0
damage_exponent = 5.0
"""
    (folder / "weakening.toml").write_text(ORE[: ORE.index("[drop_weight]")] + law)
    reply = invoke("breakage", "twice.h5", "run.h5", "--ore", "weakening.toml", "-o", "weakening.png")
    assert reply.exit_code == 0, reply.output
    # half the impacts at the same power need twice the energy
    twice, once = (float(line.split()[2]) for line in reply.stdout.splitlines()[-5:-3])
    assert once / twice == pytest.approx(2.0, rel=0.01)


def test_command_prints_its_tables_and_saves_a_picture(invoke, folder):
    reply = invoke("breakage", "run.h5", "uneven.h5", "--ore", "smc-sample-a", "--last", "3 s")
    assert reply.exit_code == 0, reply.output
    assert "estimate for sample A of the SMC test: 3 s of run.h5, 400 W" in reply.stdout
    assert "P80 (mm)" in reply.stdout and "of first" in reply.stdout
    assert (folder / "run-breakage-smc-sample-a-3s.png").stat().st_size > 10_000


def test_an_energy_to_compare_at_is_taken_with_its_unit(invoke):
    reply = invoke("breakage", "run.h5", "--ore", "smc-sample-a", "--energy", "2 kWh/t", "-o", "two.png")
    assert reply.exit_code == 0 and reply.stdout.splitlines()[-2].split()[0] == "2"
    reply = invoke("breakage", "run.h5", "--ore", "smc-sample-a", "--energy", "-2 kWh/t")
    assert reply.exit_code == 2 and '--energy: must be positive, got "-2 kWh/t"' in reply.stderr
    reply = invoke("breakage", "run.h5", "--ore", "smc-sample-a", "--energy", "2")
    assert reply.exit_code == 2 and '--energy: needs a unit: write "2 kWh/t"' in reply.stderr
