"""What a notebook shows: cases, sheets, results, campaigns, progress; and the committed notebook."""

import os
import sys
import types
from pathlib import Path

import numpy as np
import pytest

import nutamill as nm
from nutamill.analysis.steady_table import label_of, mean_text
from nutamill.analysis.values import Reading
from nutamill.base.steady import Estimate
from nutamill.case import load_case
from nutamill.notebook import runs
from nutamill.notebook.live import in_notebook, progress_html
from nutamill.result import open_result
from nutamill.simulation.progress_report import Progress
from nutamill.studies.axes import Member
from nutamill.studies.sweep import Campaign
from nutamill.studies.table import Outcome, dataset
from nutamill.studies.validate import Comparison

TORQUE = Reading("driveshaft_torque")


@pytest.fixture
def long(film, tmp_path):
    """A run of twenty turns, so that there is a test of steadiness."""
    with open_result(film(tmp_path / "long.h5", snapshots=2, seconds=2.0)) as result:
        yield result


@pytest.fixture
def empty_mill():
    return load_case("numill", ["charge.kind=none", "mechanism.mounting=rigid"])


def test_a_case_shows_its_title_and_every_value_with_its_unit(empty_mill):
    page = empty_mill._repr_html_()
    assert "<b>numill-2026 with charge.kind = none, mechanism.mounting = rigid</b>" in page.replace(
        "&quot;", ""
    )
    assert "no warnings" in page and "700 rpm" in page and "<summary>materials</summary>" in page


def test_a_machine_of_listed_parts_shows_how_many_it_has():
    page = load_case("piston")._repr_html_()
    assert "<summary>bodies (" in page and "springs" in page


def test_a_text_of_a_case_is_no_html():
    page = load_case("numill", ['title="<b>bold</b>"'])._repr_html_()
    assert "<b>bold" not in page and "&lt;b&gt;bold" in page


def test_a_check_sheet_shows_its_verdict_its_warnings_and_a_row_for_each_heading(empty_mill):
    page = nm.check(empty_mill.with_("run.threads", 999))._repr_html_()
    assert "ok, 1 warning" in page and "warning: run.threads: asks for 999 threads" in page
    assert all(f">{head}</td>" in page for head in ("machine", "time step", "forecast"))


def test_a_result_shows_verdict_means_with_intervals_and_a_picture(long):
    page, means = long._repr_html_(), nm.steady(long)
    assert "complete; steady since t = " in page
    assert all(f">{text}</td>" in page for row in means.rows() for text in row)
    assert 'src="data:image/png;base64,' in page


def test_a_result_of_few_turns_shows_no_interval_and_says_why(filmed):
    page = filmed._repr_html_()
    assert "too few turns at the last speed for a test of steadiness: 4, needs 5" in page
    assert "plain mean of 4 turns, without an interval" in page and "±" not in page


def test_steady_prints_the_means_that_were_asked_for_with_their_units(long):
    means = nm.steady(long, "driveshaft_torque", "swing driveshaft_torque")
    first, *lines = str(means).split("\n")
    assert first.startswith("steady since")
    assert lines[0].split("  ")[0] == "driveshaft torque (N m)"
    assert means.means[Reading("driveshaft_torque", "swing")].mean == pytest.approx(1.0, rel=0.01)
    assert lines[1].startswith("driveshaft torque, swing (N m)")


def test_an_interval_finer_than_anyone_reads_is_not_shown():
    assert mean_text(Estimate(706.1, 1.6e-6, 706.1, 9, True)) == "706.1"
    assert mean_text(Estimate(706.1, 1.6, 706.1, 9, True)) == "706.1 ± 1.6"


def test_plot_gives_a_figure_that_a_notebook_shows(filmed):
    assert nm.plot(filmed, "power")._repr_png_()[:4] == b"\x89PNG"


def test_view_is_the_page_within_a_frame_and_prints_what_it_is(filmed):
    view = nm.view(filmed, frames=2)
    frame = view._repr_html_()
    assert frame.startswith('<iframe srcdoc="&lt;!') and "<script" not in frame
    assert "A notebook shows it, nm.write_view writes it to a file" in repr(view)


def outcome(speed, torque, state="complete"):
    member = Member({"drive.speed": speed}, load_case("numill", [f"drive.speed={speed}"]))
    values = {} if torque is None else {TORQUE: Estimate(torque, 0.1, torque, 9, True)}
    values |= {Reading("charge_phase_lag"): Estimate(np.nan, np.nan, np.nan, 0, False)} if values else {}
    return Outcome(member, Path("run.h5"), state, values)


def test_a_sweep_shows_a_row_for_each_run_and_no_empty_column():
    outcomes = [outcome("300 rpm", 5.0), outcome("500 rpm", 7.0), outcome("700 rpm", None, "failed: blow-up")]
    table = dataset(outcomes, {"drive.speed": [1, 2, 3]}, [TORQUE])
    page = Campaign(table, outcomes, Path("sweeps/numill"))._repr_html_()
    assert "2 of 3 runs ended" in page and "failed: blow-up" in page
    assert "5 ± 0.1" in page and label_of(TORQUE) in page and "phase lag" not in page
    assert 'src="data:image/png;base64,' in page


def test_a_comparison_shows_its_rows_and_what_is_lacking(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = nm.validate("saimm2025", folder=tmp_path, start=False, log=str)
    page = Comparison(done.paper, done.findings[:2], [], [], [])._repr_html_()
    assert "0 of 2 rows have a result" in page and "not run. Do: nutamill validate saimm2025" in page


PROGRESS = Progress(
    "steady",
    1.25,
    13.0,
    0.5,
    0.1,
    60.0,
    90.0,
    700.0,
    9.0,
    690.0,
    2.0,
    np.nan,
    np.nan,
    0.01,
    0.05,
    0.0,
    10,
    3e-6,
    1,
)


def test_progress_shows_bar_time_left_and_readings_and_escapes_the_title():
    page = progress_html("<mill>", PROGRESS)
    assert "&lt;mill&gt;" in page and "width:50.0%" in page and ", left 0:01:30" in page
    assert "1.250 of 13 s" in page and "700 N, mean 690 N" in page and ">9 N m<" in page
    assert ", left" not in progress_html("<mill>", PROGRESS, ended=True)


def test_settling_shows_its_share_only():
    page = progress_html("mill", PROGRESS._replace(phase="settle", time_left=np.nan, crank_pin_force=np.nan))
    assert "the charge comes to rest" in page and "13 s" not in page


class Handle:
    """What IPython gives to show something again."""

    def __init__(self, shown):
        self.shown = [shown]

    def update(self, more):
        self.shown.append(more)


def test_a_run_in_a_notebook_shows_its_progress_unless_the_caller_does(monkeypatch, empty_mill):
    handles, asked = [], []

    def display(first, display_id):
        handles.append(Handle(first))
        return handles[-1]

    shell = types.SimpleNamespace(kernel=object())
    fake = types.SimpleNamespace(get_ipython=lambda: shell)
    shown = types.SimpleNamespace(display=display, HTML=str)
    monkeypatch.setitem(sys.modules, "IPython", fake)
    monkeypatch.setitem(sys.modules, "IPython.display", shown)

    def march(case, to, progress, log, again, trust_fmu):
        asked.append(progress)
        log("compiling kernels")
        progress(PROGRESS)

    monkeypatch.setattr(runs.runs, "run", march)
    assert in_notebook()
    runs.run(empty_mill)
    runs.run(empty_mill, progress=lambda report: None, log=str)
    pages = handles[0].shown
    assert len(handles) == 1 and "compiling kernels" in pages[1] and "width:50.0%" in pages[-1]
    assert ", left" in pages[-2] and ", left" not in pages[-1]


def test_a_script_is_no_notebook():
    assert not in_notebook()


NOTEBOOK = Path(__file__).parents[2] / "examples" / "first_steps.ipynb"


def test_the_committed_notebook_runs_to_its_end(tmp_path):
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "commit it without outputs"
    env = {"JUPYTER_PLATFORM_DIRS": "1", "IPYTHONDIR": str(tmp_path / "ipython")}
    client = nbclient.NotebookClient(
        notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}, kernel_name="python3"
    )
    client.execute(env={**os.environ, **env})
    shown = [output for cell in notebook.cells for output in cell.get("outputs", []) if "data" in output]
    pages = "\n".join("".join(output["data"].get("text/html", "")) for output in shown)
    assert "steady since" in pages and "at speed" in pages and "<iframe" in pages
    assert any("image/png" in output["data"] for output in shown)
