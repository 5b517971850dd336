"""Published papers as data: files refused when wrong, rows compared, tables and figures written, missing
results named.
"""

import csv
import json
import math
from concurrent.futures import Future
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from nutamill.base.errors import CaseError, ResultError, StepError
from nutamill.base.steady import Estimate
from nutamill.case import Case
from nutamill.cli import app
from nutamill.result import Recorder, open_result
from nutamill.result.checksums import Checksums
from nutamill.studies import validate as room
from nutamill.studies.papers.cells import verdict
from nutamill.studies.papers.compare import Key, Measured, _together, compare
from nutamill.studies.papers.figures import draw_over_speed
from nutamill.studies.papers.library import paper_names, parse_paper, read_paper
from nutamill.studies.papers.particle_views import draw_particles
from nutamill.studies.papers.quantities import QUANTITIES, charge_at_pin
from nutamill.studies.papers.runs import chosen, planned_runs
from nutamill.studies.papers.table import csv_text, json_text, markdown, read_identified, tally

RATE = 2000.0
RPM = math.pi / 30.0

PAPER = """
schema = 1
short = "Paper"
citation = "A. Author, A paper, 2026"
[configurations.empty]
title = "empty"
set = ["charge.kind=none", "mechanism.mounting=rigid"]
speeds = ["600 rpm", "700 rpm"]
quick = ["700 rpm"]
hold = "1 s"
[configurations.bars]
title = "bars"
set = ["charge.kind=none", 'chamber.bars.mass="1 kg"']
speeds = ["700 rpm"]
[[rows]]
id = "force"
quantity = "force"
configuration = "empty"
speed = "700 rpm"
experiment = "600 N"
simulation = "660 N"
simulation_speed = "600 rpm"
source = "Table 1"
relative = 0.05
headline = true
[[rows]]
id = "more"
quantity = "force"
configuration = "bars"
speed = "700 rpm"
against = { configuration = "empty", how = "change" }
experiment = 0.3
source = "Table 2"
absolute = 0.02
[[figures]]
number = "1"
title = "Force"
form = "lambda"
panels = [{ quantity = "force", curves = [{ label = "empty", configurations = ["empty"] }] }]
[[figures]]
number = "2"
title = "Torque"
form = "speed"
panels = [{ quantity = "torque", curves = [{ label = "bars", configurations = ["bars"] }] }]
"""


@pytest.fixture
def paper():
    return parse_paper(PAPER, "paper.toml")


def faults(text):
    with pytest.raises(CaseError) as raised:
        parse_paper(text, "paper.toml")
    return [str(fault) for fault in raised.value.faults]


@pytest.mark.parametrize("name", paper_names())
def test_every_run_of_a_published_paper_is_a_sound_case_of_its_own(name, tmp_path):
    runs = planned_runs(read_paper(name), tmp_path)
    assert len({run.name for run in runs}) == len({run.case.digest for run in runs}) == len(runs)
    assert all(run.path.name == f"{run.name}-{run.case.digest[:12]}.h5" for run in runs)
    assert all(run.case.run.end - run.case.machine.drive.ramp_end >= run.average - 1e-12 for run in runs)


def test_like_is_compared_with_like_where_experiment_and_simulation_had_other_speeds():
    rows = {row.id: row for row in read_paper("mca2026").rows}
    assert [
        rows[name].speed / RPM for name in ("table7-pellets-force", "table7-ribbed-torque")
    ] == pytest.approx([723.0, 688.0])
    assert rows["table7-pellets-force"].simulation_speed / RPM == pytest.approx(700.0)
    assert rows["table6-ribs-force"].needs == [
        ("ribbed", 700 * RPM, "force"),
        ("pellets", 700 * RPM, "force"),
    ]


def test_wrong_numbers_of_a_paper_are_refused_all_at_once_with_their_lines():
    text = (
        PAPER.replace('"600 N"', '"600 rpm"')
        .replace("experiment = 0.3", 'experiment = "30 %"')
        .replace('title = "bars"', 'titel = "bars"')
    )
    messages = faults(text)
    assert len(messages) == 4
    assert (
        messages[0]
        == "paper.toml:11: configurations.bars.title: is missing. Add e.g. title under [configurations.bars]"
    )
    assert any(line.startswith("paper.toml:12: configurations.bars.titel: unknown key") for line in messages)
    assert any(line.startswith("paper.toml:15: rows[0]: experiment: ") and "rpm" in line for line in messages)
    assert any(
        'must be a plain number, got "30 %"' in line and ": rows[1]: experiment" in line for line in messages
    )


def test_rows_that_name_what_is_not_there_are_refused():
    messages = faults(
        PAPER.replace('configuration = "bars"', 'configuration = "bar"').replace(
            'id = "more"', 'id = "force"'
        )
    )
    assert any('no configuration is called "bar"' in line for line in messages)
    assert any('rows[1].id: is the id of two rows, got "force"' in line for line in messages)
    assert (
        "must be a speed of bars, got 650 rpm"
        in faults(PAPER.replace('bars"\nspeed = "700', 'bars"\nspeed = "650'))[0]
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "experiment = 0.3\n",
            "",
            "rows[1]: has a target but no published value. Add experiment or simulation, or leave it out",
        ),
        (
            "absolute = 0.02",
            "absolute = 0.02\nrelative = 0.1",
            "must have one target, relative or absolute, got both",
        ),
        (
            'form = "speed"',
            'form = "speed"\nconfiguration = "bars"',
            'figures[1]: needs panels, and neither configuration nor speed, with form = "speed"',
        ),
        (
            'form = "speed"',
            'form = "particles"',
            'figures[1]: needs a configuration and a speed, and no panels, with form = "particles"',
        ),
    ],
)
def test_a_row_or_figure_that_contradicts_itself_is_refused(old, new, message):
    assert any(message in line for line in faults(PAPER.replace(old, new, 1)))


def test_a_name_after_only_that_is_nothing_of_the_paper_is_refused(paper, tmp_path):
    with pytest.raises(CaseError, match="--only moon: is not the name of a row, a configuration or a run"):
        chosen(paper, planned_runs(paper, tmp_path), ["moon"], False)


def test_a_change_no_case_knows_is_refused_before_anything_runs(tmp_path):
    with pytest.raises(CaseError, match=r"configurations.bars: .*chamber.bar: unknown key"):
        planned_runs(
            parse_paper(PAPER.replace("chamber.bars.mass", "chamber.bar.mass"), "paper.toml"), tmp_path
        )


def test_an_unknown_name_after_only_is_refused_with_the_nearest(tmp_path, monkeypatch):
    monkeypatch.setattr(room, "read_paper", lambda name: parse_paper(PAPER, "paper.toml"))
    with pytest.raises(CaseError, match=r'--only emtpy: .*Did you mean "empty"'):
        room.validate("paper", only=["emtpy"], folder=tmp_path)


# ------------------------------------------------------------------------------------------------ rows from
# numbers


def number(mean, half_width=math.nan, scatter=math.nan):
    return Measured(Estimate(mean, half_width, mean, 9, True), scatter, 1)


def compared(paper, **values):
    keys = {"empty": Key.of("empty", 700 * RPM, "force"), "bars": Key.of("bars", 700 * RPM, "force")}
    return compare(paper.rows, {keys[name]: value for name, value in values.items()})


def test_error_is_a_share_of_the_experiment_and_the_target_decides(paper):
    force, _ = compared(paper, empty=number(624.0, 3.0), bars=number(800.0))
    assert force.error == pytest.approx(0.04) and force.within
    assert force.simulation_error == pytest.approx(0.10)
    assert not compared(paper, empty=number(636.0), bars=number(800.0))[0].within


def test_change_between_two_runs_carries_both_uncertainties(paper):
    # d(b/e) = (b/e) sqrt((db/b)^2 + (de/e)^2)
    _, change = compared(paper, empty=number(600.0, 6.0), bars=number(768.0, 3.0))
    assert change.value == pytest.approx(0.28) and change.error == pytest.approx(-0.02) and change.points
    assert change.half_width == pytest.approx(1.28 * math.hypot(6.0 / 600.0, 3.0 / 768.0))


def test_seeds_are_averaged_and_their_scatter_is_apart_from_the_interval():
    together = _together(
        [Estimate(9.0, 0.3, 9.5, 20, True), Estimate(11.0, 0.4, 11.5, 20, False), "not run. Do: it"]
    )
    estimate = together.estimate
    assert (estimate.mean, together.runs, estimate.plain_mean) == (10.0, 2, 10.5)
    assert estimate.half_width == pytest.approx(0.25)  # sqrt(0.3^2 + 0.4^2) / 2
    assert together.scatter == pytest.approx(math.sqrt(2.0))
    assert together.trouble == "not run. Do: it" and not estimate.steady


def test_tables_hold_the_same_numbers_in_si(paper):
    findings = compared(paper, empty=number(624.0, 3.0), bars=number(800.0))
    line = next(csv.DictReader(csv_text(findings, paper).splitlines()))
    stored = json.loads(json_text(findings, paper))["rows"][0]
    assert float(line["nutamill"]) == stored["nutamill"] == 624.0 and stored["scatter_over_seeds"] is None
    assert (stored["unit"], stored["speed_rpm"], stored["simulation_speed_rpm"]) == ("N", 700.0, 600.0)
    shown = markdown(findings, paper).splitlines()[2]
    assert (
        shown
        == "| crank-pin force, empty, 700 rpm | 600 N | 660 N at 600 rpm | +10 % | 624.0 ± 3.0 N | +4.0 "
        "% | 5 % | within, predicted |"
    )


def test_rows_of_a_mill_changed_on_purpose_are_shown_and_not_counted():
    changed = parse_paper(
        PAPER.replace('title = "bars"', 'title = "bars"\nsensitivity = "bars instead of nothing"'),
        "paper.toml",
    )
    findings = compared(changed, empty=number(624.0), bars=number(800.0))
    assert [verdict(finding, changed) for finding in findings] == ["within, predicted", "within, sensitivity"]
    assert tally(findings, changed).startswith(
        "2 of 2 rows have a result; 1 of 1 with a target meet it; 1 of 1 are nearer"
    )
    assert json.loads(json_text(findings, changed))["rows"][1]["sensitivity"] == "bars instead of nothing"


# --------------------------------------------------------------------------------------------- numbers from
# results


def write_result(path, case, force=620.0, moment=(0.0, 0.0, 0.0), state="complete", snapshots=(), slower=0.0):
    """A synthetic result of a case: one second at its speed; `moment` is the charge's in axes that turn with
    the crank.

    Before the last sample the speed is `slower` [rad/s]: a ramp.
    """
    time = np.arange(round(RATE) + 1) / RATE
    angle = case.drive.speed * time
    out, along, up = moment
    columns = {
        "time": time,
        "crank_angle": angle,
        "driveshaft_speed": case.drive.speed - slower * (time < time[-1]),
        "crank_pin_force_resultant_tared": force + 0.0 * time,
        "charge_moment_x": out * np.cos(angle) - along * np.sin(angle),
        "charge_moment_y": out * np.sin(angle) + along * np.cos(angle),
        "charge_moment_z": up + 0.0 * time,
        # the frame sways by 1 mm, in its seventh turn by 3 mm
        "mount_1_travel_x": np.where(np.floor(angle / math.tau) == 6, 3e-3, 1e-3) * np.cos(angle),
    }
    recorder = Recorder.create(path, case.to_toml(), {}, list(columns), RATE)
    recorder.append(np.stack(list(columns.values()), axis=1))
    for at, arrays in snapshots:
        recorder.snapshot(at, arrays)
    recorder.state(state)
    recorder.close()
    return open_result(path)


@pytest.fixture
def run(paper, tmp_path):
    return planned_runs(paper, tmp_path)[1]


def test_pin_force_of_the_charge_balances_its_moment_about_the_nutation_point(run):
    # reference: the chamber without mass, held by a force at O, a torsion about its axis, and a pin force in
    # the plane of the crank
    down, out = 0.366, 0.039
    place, push = np.array([0.03, 0.05, -0.28]), np.array([-40.0, 25.0, -12.0])
    moment = np.cross(place, push)
    pin = np.array([out, 0.0, -down])
    axis = pin / np.linalg.norm(pin)
    balance = np.column_stack([np.cross(pin, [-1.0, 0.0, 0.0]), np.cross(pin, [0.0, 1.0, 0.0]), axis])
    radial, tangential, _ = np.linalg.solve(balance, -moment)
    with write_result(run.path, run.case, moment=moment) as result:
        force = charge_at_pin(result)
        # the horizontal pin force is within 6 deg of the plane across the axis; along e_t both are the same
        # to round-off
        assert np.allclose(force.radial, radial, rtol=1e-9)
        assert np.allclose(force.tangential, tangential, rtol=1e-9)
        lag = QUANTITIES["charge_lag"].measure(result, 1.0).mean
        assert lag == pytest.approx(math.atan2(tangential, radial))


def test_largest_sway_on_the_ramp_has_its_turn(run):
    with write_result(run.path, run.case, slower=1.0) as result:
        time, travel = (
            QUANTITIES[name].measure(result, 1.0) for name in ("resonance_time", "resonance_travel")
        )
    turn, sample = math.tau / run.case.drive.speed, 1.0 / RATE
    assert time.mean == pytest.approx(6.5 * turn, abs=sample) and time.half_width == pytest.approx(
        0.5 * turn, abs=sample
    )
    # the samples next to the crests are off them by half a sample at most
    assert travel.mean == pytest.approx(3e-3, rel=0.5 * (math.pi * sample / turn) ** 2)


def test_superposition_is_refused_where_the_charge_acted_on_the_mill(run):
    with write_result(run.path, run.case) as result, pytest.raises(ResultError, match=r"prescribed"):
        QUANTITIES["superposed_force"].measure(result, 1.0)


# ------------------------------------------------------------------------------------------------- the whole
# command


class AtOnce:
    """Stands for processes, and writes synthetic results: 600 rpm is interrupted once, bars always blow
    up.
    """

    def submit(self, task):
        future = Future()
        if task.work == "run":
            STARTED.append(task.name)
            path = Path(task.path)
            begun = path.exists()
            path.unlink(missing_ok=True)
            if task.name.startswith("bars"):
                future.set_exception(StepError("t = 1 s: it blew up"))
                return future
            state = "interrupted" if "600" in task.name and not begun else "complete"
            write_result(path, Case.from_toml(task.case_text, task.name), state=state).close()
        future.set_result(None)
        return future

    def stop(self):
        """Nothing runs."""


STARTED = []


@pytest.fixture
def marched(monkeypatch):
    """Names of the runs that `AtOnce` was given."""
    STARTED.clear()
    monkeypatch.setattr(room, "LocalProcesses", lambda jobs: AtOnce())
    monkeypatch.setattr("nutamill.studies.sweep.warm_up", lambda log, law: None)
    monkeypatch.setattr(room, "read_paper", lambda name: parse_paper(PAPER, "paper.toml"))
    return STARTED


def test_finished_runs_are_read_begun_ones_resumed_and_a_failure_does_not_stop_the_rest(marched, tmp_path):
    done = room.validate("paper", folder=tmp_path, log=lambda line: None)
    assert sorted(marched) == ["bars-700rpm", "empty-600rpm", "empty-700rpm"]
    assert any("it blew up" in failure for failure in done.failures)
    assert done.findings[0].value == pytest.approx(620.0)
    assert done.findings[1].trouble == "not run. Do: nutamill validate paper --only bars-700rpm"
    marched.clear()
    room.validate("paper", only=["empty"], folder=tmp_path, log=lambda line: None)
    assert marched == ["empty-600rpm"]  # the others are complete: their files are read
    room.validate("paper", only=["empty"], folder=tmp_path, log=lambda line: None)
    assert marched == ["empty-600rpm"]


def test_quick_starts_the_decisive_runs_only_and_every_file_holds_all_rows(marched, tmp_path):
    done = room.validate("paper", quick=True, folder=tmp_path, log=lambda line: None)
    assert marched == ["empty-700rpm"]
    assert [file.name for file in done.files] == [
        "comparison.csv",
        "comparison.json",
        "comparison.md",
        "figure-1.png",
    ]
    assert len(json.loads((tmp_path / "comparison.json").read_text())["rows"]) == 2


def test_short_table_replaces_what_stands_between_its_marks_and_names_what_is_not_run(marched, tmp_path):
    done = room.validate("paper", quick=True, folder=tmp_path, log=lambda line: None)
    readme = tmp_path / "README.md"
    readme.write_text("above\n<!-- validate paper -->\nold\n<!-- end paper -->\nbelow\n")
    room.write_tables(readme, done, "paper")
    lines = readme.read_text().splitlines()
    assert (lines[0], lines[1], lines[-2], lines[-1]) == (
        "above",
        "<!-- validate paper -->",
        "<!-- end paper -->",
        "below",
    )
    assert lines[4].startswith("| crank-pin force, empty, 700 rpm | 600 N |") and "old" not in lines
    nothing = done.__class__(done.paper, [f._replace(value=math.nan) for f in done.findings], [], [], [])
    room.write_tables(readme, nothing, "paper")
    assert "1 more rows have no result yet; `nutamill validate paper` makes them." in readme.read_text()
    marks = "<!-- validate paper all -->\n<!-- end paper all -->\n"
    readme.write_text(f"<!-- validate paper -->\n<!-- end paper -->\n{marks}")
    room.write_tables(readme, room.validate("paper", folder=tmp_path, start=False, log=str), "paper")
    short, everything = readme.read_text().split("<!-- validate paper all -->")
    assert "its error" in everything and "its error" not in short
    identified = tmp_path / "identify.json"
    rows = [{"published": "paper/force", "posterior_90": [571.4, 612.0]}]
    rows += [{"published": name, "posterior_90": [0.0, 1.0]} for name in ("other/force", None)]
    identified.write_text(json.dumps({"rows": rows}))
    readme.write_text("<!-- validate paper -->\n<!-- end paper -->\n")
    room.write_tables(readme, done, "paper", read_identified(identified, "paper"))
    assert readme.read_text().splitlines()[1].endswith("| error | identified, 90 % |")
    assert readme.read_text().splitlines()[3].endswith("| 571 to 612 N |")
    with pytest.raises(CaseError, match=r"is no identify\.json of an identification"):
        read_identified(readme, "paper")
    readme.write_text("<!-- validate paper -->\nno end")
    with pytest.raises(CaseError, match=r"has no line .* Add that line"):
        room.write_tables(readme, done, "paper")


def test_the_log_has_the_time_of_the_complete_runs(paper, tmp_path, monkeypatch):
    monkeypatch.setattr(room, "read_paper", lambda name: paper)
    for run, seconds in zip(planned_runs(paper, tmp_path), (100.0, 3600.0), strict=False):
        write_result(run.path, run.case).close()
        with h5py.File(run.path, "r+") as file:
            file["provenance"].attrs["wall_time"] = seconds
            checksums = Checksums.read(file)
            checksums.take_one(file, "provenance")
            checksums.write(file)
    messages = []
    room.validate("paper", folder=tmp_path, start=False, log=messages.append)
    assert "2 of 3 runs are complete; they took 1:01:40 in all, one after the other" in messages


def test_stored_results_are_evaluated_without_a_run(marched, tmp_path):
    done = room.validate("paper", folder=tmp_path, start=False, log=lambda line: None)
    assert not marched and all(finding.trouble.startswith("not run") for finding in done.findings)
    assert done.undrawn == [f"figure {number} not drawn: none of its runs is complete" for number in (1, 2)]


def test_the_command_prints_the_table_and_says_what_makes_a_missing_row(tmp_path):
    reply = CliRunner().invoke(
        app, ["validate", "saimm2025", "--stored", "--only", "motor-limit-560", "--to", str(tmp_path)]
    )
    assert reply.exit_code == 0
    assert (
        "6.45 N m" in reply.output
        and "not run. Do: nutamill validate saimm2025 --only pellets-560rpm" in reply.output
    )
    assert (tmp_path / "comparison.md").read_text().count("\n") == 2 + len(read_paper("saimm2025").rows)


# ------------------------------------------------------------------------------------------------------------
# figures


def test_published_numbers_stand_at_their_own_speeds_over_the_centrifugal_number(paper, tmp_path):
    runs = planned_runs(paper, tmp_path)
    measured = {
        Key.of("empty", speed * RPM, "force"): number(force, 2.0)
        for speed, force in ((600.0, 450.0), (700.0, 620.0))
    }
    figure = draw_over_speed(paper.figures[0], paper, runs, measured)
    drawn = {
        line.get_marker(): line.get_xydata()
        for line in figure.axes[0].lines
        if line.get_linestyle() == "None"
    }
    ours = figure.axes[0].containers[0].lines[0].get_xydata()
    assert ours[:, 1] == pytest.approx([450.0, 620.0])
    # lambda = L12 w^2 / g: 21.4 at 700 rpm in the paper
    assert ours[:, 0] == pytest.approx([0.039 * (600 * RPM) ** 2 / 9.81, 21.36], rel=1e-3)
    assert drawn["x"][0] == pytest.approx([ours[0, 0], 660.0])
    assert [marks[0, 1] for marker, marks in drawn.items() if marker == "o"] == [600.0]


def test_particles_are_seen_in_chamber_axes_and_coloured_by_world_height(run):
    # a chamber turned upside down about x: what is 20 mm above its floor is 20 mm lower in the world
    snapshot = {
        "positions": np.array([[0.03, 0.0, -0.35], [0.0, 0.01, -0.34]]),
        "radii": np.array([0.0025, 0.0025]),
        "chamber_floor": np.array([0.0, 0.0, -0.33]),
        "chamber_attitude": np.array([0.0, 1.0, 0.0, 0.0]),
    }
    with write_result(run.path, run.case, snapshots=[(0.5, snapshot)]) as result:
        figure = draw_particles(result, positions=(0.0,))
    balls = figure.axes[0].collections[0]
    assert np.allclose(
        balls.get_offsets(), [[30.0, 20.0], [0.0, 10.0]]
    )  # the nearer, at chamber y = -10 mm, is drawn last
    assert np.allclose(balls.get_array(), [-350.0, -340.0])


def test_the_table_fits_a_narrow_terminal_row_by_row(paper):
    from nutamill.studies.papers.compare import NOTHING, _finding
    from nutamill.studies.papers.table import narrow_lines

    findings = [_finding(row, [NOTHING] * len(row.needs)) for row in paper.rows]
    lines = narrow_lines(findings, paper, 80)
    assert max(map(len, lines)) <= 80
    assert lines[1].startswith("crank-pin force, empty, 700 rpm")
    assert lines[2].startswith("  experiment 600 N, ")
