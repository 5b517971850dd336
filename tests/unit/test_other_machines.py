"""Papers of machines that are no nutating mill: rows at a place or time, slices, and their quantities."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import xarray

from nutamill.base.errors import CaseError, ResultError
from nutamill.base.steady import Estimate
from nutamill.studies.papers import body, drum
from nutamill.studies.papers.cells import cells, title_of
from nutamill.studies.papers.compare import Key, Measured, compare
from nutamill.studies.papers.figures import draw_figure
from nutamill.studies.papers.library import parse_paper, read_paper
from nutamill.studies.papers.runs import planned_runs, read_modes
from nutamill.studies.papers.table import record
from nutamill.studies.validate import find_modes
from validation import morrell

PAPER = """
schema = 1
short = "drop"
citation = "nobody"
[configurations.ball]
title = "a ball"
base = "piston"
hold = "0.3 s"
average = "0.1 s"
[configurations.shaken]
title = "a trough"
base = "sprung-trough"
set = ["charge.kind=none"]
speed_key = "unbalance_motors.motor.speed"
speeds = ["600 rpm"]
hold = "2 s"
[[rows]]
id = "early"
quantity = "height"
configuration = "ball"
at = "24 ms"
factor = 2.0
experiment = "-60 mm"
source = "here"
absolute = 0.001
[[figures]]
number = "1"
title = "height"
form = "place"
panels = [{ quantity = "height", curves = [{ label = "ours", configurations = ["ball"] }] }]
"""


def test_machines_without_a_crank_and_without_a_speed_are_planned(tmp_path):
    ball, shaken = planned_runs(parse_paper(PAPER, "paper.toml"), tmp_path)
    assert (ball.name, shaken.name) == ("ball", "shaken-600rpm")
    assert (ball.case.run.end, shaken.case.run.end) == (0.3, 2.0)
    assert shaken.case.unbalance_motors[0].speed == pytest.approx(600.0 * math.pi / 30.0)


def test_a_computed_reference_is_called_so_in_table_and_figure():
    paper = read_paper("sprung-trough")
    row = paper.rows[0]
    ours = {Key.of(*need): Measured(Estimate.exact(0.0024), math.nan, 1) for need in row.needs}
    (finding,) = compare([row], ours)
    assert cells(finding, paper)[1] == "2.378 mm (computed)"
    assert record(finding, paper)["experiment_is"] == "computed"
    figure = draw_figure(paper.figures[0], paper, [], ours)
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "paper, computed" in legend and "paper, measured" not in legend


def test_a_row_at_a_time_takes_its_own_number_times_its_factor():
    paper = parse_paper(PAPER, "paper.toml")
    key = Key.of("ball", 0.0, "height", 0.024)
    measured = {key: Measured(Estimate.exact(-0.0301), math.nan, 1)}
    (finding,) = compare(paper.rows, measured)
    assert finding.value == pytest.approx(-0.0602) and finding.within
    assert title_of(paper.rows[0], paper) == "height, a ball, at 0.024 s"
    axes = draw_figure(paper.figures[0], paper, [], measured).axes[0]
    assert axes.lines[0].get_xydata().tolist() == [[0.024, pytest.approx(-60.2)]]
    with pytest.raises(ResultError, match="none of its rows has a result"):
        draw_figure(paper.figures[0], paper, [], {})


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('at = "24 ms"\n', "", 'height needs at. Write e.g. at = "'),
        ('at = "24 ms"', 'at = "24 mm"', "at: "),
        ('quantity = "height"\nconf', 'quantity = "lowest_height"\nconf', "at has no use with lowest_height"),
    ],
)
def test_a_place_that_a_row_lacks_or_has_no_use_for_is_refused(old, new, message):
    assert old in PAPER
    with pytest.raises(CaseError) as raised:
        parse_paper(PAPER.replace(old, new, 1), "paper.toml")
    assert message in str(raised.value)


def moved(time, height):
    series = xarray.Dataset({"time": ("n", time), "ball_position_z": ("n", height)})
    return SimpleNamespace(series=series, path="a.h5")


def test_heights_and_speeds_of_a_thrown_body_are_those_of_a_parabola():
    time = np.linspace(0.0, 0.2, 2001)
    result = moved(time, 0.1 - 2.0 * time + 0.5 * 20.0 * time**2)  # lowest after 0.1 s
    assert body.height(result, 1.0, 0.05).mean == pytest.approx(0.1 - 0.1 + 0.025)
    assert body.upward_speed(result, 1.0, 0.05).mean == pytest.approx(-1.0)
    assert body.lowest_height(result, 1.0).mean == pytest.approx(0.0, abs=1e-12)
    assert body.time_of_lowest(result, 1.0).mean == pytest.approx(0.1)
    # mean of the last whole millisecond, 0.5 ms before the end
    assert body.rebound_speed(result, 1.0).mean == pytest.approx(-2.0 + 20.0 * 0.1995, abs=0.03)
    with pytest.raises(ResultError, match="ends at its lowest height"):
        body.rebound_speed(moved(time, -time), 1.0)
    with pytest.raises(ResultError, match="has no height"):
        body.height(SimpleNamespace(series=xarray.Dataset(), path="a.h5"), 1.0, 0.0)


def test_amplitude_is_that_of_the_end_and_a_decay_is_not_steady():
    time = np.linspace(0.0, 4.0, 40001)
    wave = 0.002 * np.sin(20.0 * math.pi * time)
    steady = body.amplitude(moved(time, wave + 0.01 * np.exp(-4.0 * time)), 2.0)
    assert steady.mean == pytest.approx(0.002, rel=0.01) and steady.steady
    assert not body.amplitude(moved(time, wave * np.exp(-time)), 2.0).steady


def bed(angle, turned=1.0):
    """A bed in layers that fall off evenly from 0.3 m/s at the top to -0.1 at the wall."""
    rng = np.random.default_rng(1)
    along, across = rng.uniform(-0.1, 0.1, 40000), rng.uniform(-0.11, -0.03, 40000)
    speed = 0.3 + (across + 0.03) * 5.0
    level = math.cos(angle) * along + math.sin(angle) * across
    height = -math.sin(angle) * along + math.cos(angle) * across
    zero = np.zeros_like(level)
    one = {
        "positions": np.column_stack([zero, turned * level, height]),
        "velocities": np.column_stack([zero, turned * math.cos(angle) * speed, -math.sin(angle) * speed]),
        "radii": np.full(len(level), 0.0015),
    }

    class Snapshots(list):
        time = np.array([1.0])

    return SimpleNamespace(snapshots=Snapshots([one]), reached=1.0, path="a.h5")


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_angle_speeds_and_place_of_rest_of_a_bed_are_those_it_was_made_with(turned):
    made = bed(math.radians(27.0), turned)
    assert drum.bed_angle(made, 0.5).mean == pytest.approx(math.radians(27.0), abs=math.radians(0.5))
    assert drum.bed_speed(made, 0.5, -0.05).mean == pytest.approx(0.2, abs=0.005)
    assert drum.still_depth(made, 0.5).mean == pytest.approx(-0.09, abs=0.001)
    with pytest.raises(ResultError, match="has no grains at 50 mm"):
        drum.bed_speed(made, 0.5, 0.05)
    with pytest.raises(ResultError, match="has no snapshots of a charge"):
        drum.bed_of(made, -0.5)


def test_morrells_model_gives_the_printed_toe_and_no_load_power_and_no_printed_net_power():
    own = morrell.draw()
    assert own.toe == pytest.approx(morrell.TOE, abs=0.15)  # a printed digit
    assert morrell.lines()[0] == "no-load power 41.94 kW, printed 41.94 kW"
    assert own.power < morrell.NET < morrell.CALIBRATION * own.power


def test_natural_frequencies_of_a_machine_of_parts_are_stored(tmp_path):
    _, shaken = planned_runs(parse_paper(PAPER, "paper.toml"), tmp_path)
    find_modes([shaken])
    # 1263.31 N/m and 2 kg
    assert read_modes(shaken) == pytest.approx([math.sqrt(1263.31 / 2.0) / (2.0 * math.pi)], rel=1e-6)
