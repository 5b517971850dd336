"""The page of a run holds its numbers, its pictures and its moving charge, and needs nothing else."""

import base64
import html
import re
import shutil

import pytest

from nutamill.analysis.power import PowerSplit
from nutamill.base.errors import CaseError, ResultError
from nutamill.case import load_case
from nutamill.case.differences import swept_axis
from nutamill.result import Result, open_result
from nutamill.view import report
from nutamill.view.figures.motion import draw_steady_values
from nutamill.view.figures.named import caption_of
from nutamill.view.figures.run import draw_run
from nutamill.view.renderer import opengl_trouble
from nutamill.view.report import report_page, write_report


@pytest.fixture(autouse=True)
def _flat(request, monkeypatch):
    """Pictures in three dimensions take seconds: only the test of them has one."""
    if "external" not in request.keywords:
        monkeypatch.setattr(report, "_machine_picture", lambda result: "")


@pytest.mark.external
def test_a_report_begins_with_a_picture_of_the_machine(filmed, unfilmed):
    pytest.importorskip("pyvista", reason='needs the extra "view"')
    page = report_page([filmed.path])
    if opengl_trouble():
        pytest.skip("needs OpenGL")
    picture = page.index('alt="the machine and its charge"')
    assert picture < page.index("crank-pin force (N)")
    assert page[picture:].split('src="')[1].startswith("data:image/png;base64,iVBOR")
    assert 'alt="the machine' not in report_page([unfilmed.path])


def test_numbers_of_a_report_are_rounded_and_zero_has_no_sign(filmed, monkeypatch):
    split = PowerSplit(600.0, {"joints": 600.01, "coupling": -0.01}, -0.001)
    monkeypatch.setattr(report, "power_split", lambda result: split)
    monkeypatch.setattr(Result, "provenance", property(lambda self: {"wall_time": 100.97840734199997}))
    page = report_page([filmed.path])
    assert "-0.00<" not in page and "<td>wall_time</td><td>101</td>" in page


def test_page_of_a_run_holds_means_ledger_figures_motion_and_case(filmed):
    page = report_page([filmed.path])
    assert "crank-pin force (N)" in page
    # the film: 700 + 20 cos(2 angle) N over whole turns of 105 samples; the trapezoid of a cosine is exact to
    # 20 (2 pi/52)^2 / 12
    mean = float(re.search(r"crank-pin force \(N\)</td><td class=\"number\">([\d.]+)", page)[1])
    assert mean == pytest.approx(700.0, abs=0.1)
    assert re.search(r"pellet-pellet</td><td class=\"number\">540</td><td class=\"number\">100\.00", page)
    assert (
        page.count("data:image/png;base64,") == 3
    )  # run, power, orbit: this film has no statistics of impacts
    inner = html.unescape(re.search(r'srcdoc="(.*?)"></iframe>', page, re.DOTALL)[1])
    assert '<canvas id="scene">' in inner
    assert "[chamber]" in page
    assert "seed" in page


def test_page_asks_the_network_for_nothing(filmed):
    page = report_page([filmed.path])
    assert not re.findall(r'(?:src|href)="(?!data:)[^"]', page)
    assert "http" not in page.replace("http-equiv", "").replace("http://www.w3.org", "")


def test_run_without_snapshots_is_reported_without_motion(unfilmed):
    page = report_page([unfilmed.path])
    assert "<iframe" not in page
    assert "crank-pin force (N)" in page


def test_several_runs_share_one_table_and_one_figure_over_speed(filmed, film, tmp_path):
    page = report_page([filmed.path, film(tmp_path / "second.h5", snapshots=0)])
    assert page.count("<tr><td>second</td>") == 1
    assert page.count('alt="means of the runs"') == 1


def test_a_run_of_too_few_turns_is_not_called_steady_and_has_no_interval(film, tmp_path):
    """0.5 s at 60 rad/s are 4.77 turns, of which four are whole; 2 s are 19."""
    short = report_page([film(tmp_path / "short.h5", snapshots=0)])
    assert "too few turns at the last speed for a test of steadiness: 4, needs 5" in short
    assert "plain mean of 4 turns, without an interval" in short
    assert "95 %" not in short and "±" not in short and "steady mean" not in short
    long = report_page([film(tmp_path / "long.h5", snapshots=0, seconds=2.0)])
    assert (
        "steady since t = " in long
        and "steady mean and 95 % interval" in long
        and "too few turns" not in long
    )


@pytest.mark.parametrize(
    ("shakes", "caption"),
    [
        (
            True,
            "crank-pin force, driveshaft torque, horizontal acceleration, vertical acceleration over the run",
        ),
        (False, "crank-pin force, driveshaft torque over the run"),
    ],
)
def test_the_caption_of_a_run_names_the_panels_that_are_drawn(film, tmp_path, shakes, caption):
    with open_result(film(tmp_path / "a.h5", snapshots=0, shakes=shakes)) as result:
        assert caption_of("run", draw_run(result)) == caption


@pytest.mark.parametrize(
    ("changes", "label", "values"),
    [
        (
            [("drive.speed=500 rpm",), ("drive.speed=600 rpm", "run.seed=2", "drive.ramp=35 rpm/s")],
            "drive.speed (rpm)",
            [500.0, 600.0],
        ),
        ([("chamber.ribs=0",), ("chamber.ribs=12",)], "chamber.ribs", [0.0, 12.0]),
        ([("chamber.ribs=0",), ("chamber.ribs=12", "drive.speed=500 rpm")], None, None),
        ([("mechanism.mounting=rigid",), ("mechanism.mounting=flexible",)], None, None),
        ([("run.seed=1",), ("run.seed=2",)], None, None),
        (
            [("drive.speed=500 rpm",), ("drive.speed=600 rpm",), ("drive.speed=500 rpm", "run.seed=2")],
            None,
            None,
        ),
    ],
)
def test_runs_are_joined_by_a_line_only_if_they_differ_in_one_number(changes, label, values):
    axis = swept_axis([load_case("numill", texts) for texts in changes])
    assert (axis.label, axis.values) == (label, pytest.approx(values)) if label else axis is None


@pytest.mark.parametrize(("ribs", "joined"), [("0", True), ("12", False)])
def test_unrelated_runs_are_drawn_as_points(film, tmp_path, monkeypatch, ribs, joined):
    drawn = []

    def draw(*given, **options):
        drawn.append(draw_steady_values(*given, **options))
        return drawn[-1]

    monkeypatch.setattr(report, "draw_steady_values", draw)
    first = film(tmp_path / "a.h5", snapshots=0, changes=("drive.speed=500 rpm",))
    page = report_page(
        [first, film(tmp_path / "b.h5", snapshots=0, changes=("drive.speed=600 rpm", f"chamber.ribs={ribs}"))]
    )
    assert {line.get_linestyle() for line in drawn[0].axes[0].get_lines() if line.get_marker() == "o"} == (
        {"-"} if joined else {"None"}
    )
    assert ("over drive.speed (rpm);" in page) == joined


def test_folder_of_a_sweep_is_reported_with_its_table_pictures_and_runs(filmed, tmp_path):
    folder = tmp_path / "speeds"
    folder.mkdir()
    shutil.copy(filmed.path, folder / "speeds-10.h5")
    shutil.copy(filmed.path, folder / "speeds-9.h5")
    (folder / "table.csv").write_text(
        "drive.speed,state,file,force [N],force half width 95 % [N],force last seconds [N],lag [rad]\n"
        "700 rpm,complete,speeds-10.h5,717.3,4.31,716,nan\n723 rpm,waiting,speeds-9.h5,nan,nan,nan,nan\n"
    )
    (folder / "table.png").write_bytes(b"picture")
    page = report_page([folder])
    assert page.index(base64.b64encode(b"picture").decode()) < page.index("<td>700 rpm</td>")
    assert "<th>force (N)</th>" in page
    assert "<td>700 rpm</td><td>complete</td><td>717.3 ± 4.3</td></tr>" in page
    assert "<td>723 rpm</td><td>waiting</td><td>–</td></tr>" in page
    assert "lag" not in page.split("<h2>Runs")[0]  # a column without any number
    assert base64.b64encode(b"picture").decode() in page
    assert page.index("speeds-9.h5") < page.index("speeds-10.h5")
    assert "<td>seed</td>" in page


def test_folder_of_a_comparison_is_reported_with_its_table(tmp_path):
    (tmp_path / "comparison.md").write_text(
        "| row | ours |\n|---|---|\n| force | 1 & 2 N |\n\n| not | this |\n|---|---|\n| 1 | 2 |\n"
    )
    page = report_page([tmp_path])
    assert "<td>force</td><td>1 &amp; 2 N</td></tr>" in page
    assert "not" not in page[page.index("<td>force") : page.index("<h2>Citation")]


def test_folder_without_a_table_or_a_result_is_refused(filmed, tmp_path):
    bare = tmp_path / "bare"
    bare.mkdir()
    with pytest.raises(CaseError, match="neither a table nor a result"):
        report_page([bare])
    with pytest.raises(CaseError, match="one folder, or results only"):
        report_page([bare, filmed.path])


def test_name_cannot_smuggle_markup_into_the_page(film, tmp_path):
    assert "<b>" not in report_page([film(tmp_path / "<b>.h5", snapshots=0)])


def test_no_result_and_a_file_that_is_none_are_refused(tmp_path):
    with pytest.raises(CaseError, match="at least one result"):
        write_report([], tmp_path / "a.html")
    (tmp_path / "a.h5").write_text("no")
    with pytest.raises(ResultError, match="is no result file"):
        write_report([tmp_path / "a.h5"], tmp_path / "a.html")
    assert not (tmp_path / "a.html").exists()
