"""The page of a run holds its numbers, its pictures and its moving charge, and needs nothing else."""

import html
import re

import pytest

from nutamill.errors import CaseError, ResultError
from nutamill.report import report_page, write_report


def test_page_of_a_run_holds_means_ledger_figures_motion_and_case(filmed):
    page = report_page([filmed.path])
    assert "crank-pin force (N)" in page
    # the film: 700 + 20 cos(2 angle) N over whole turns of 105 samples; the trapezoid of a cosine is exact to 20 (2 pi/52)^2 / 12
    mean = float(re.search(r"crank-pin force \(N\)</td><td class=\"number\">([\d.]+)", page)[1])
    assert mean == pytest.approx(700.0, abs=0.1)
    assert re.search(r"pellet-pellet</td><td class=\"number\">540</td><td class=\"number\">100\.00", page)
    assert page.count("data:image/png;base64,") == 3  # run, power, orbit: this film has no statistics of impacts
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
    assert page.count('alt="steady values over speed"') == 1


def test_name_cannot_smuggle_markup_into_the_page(film, tmp_path):
    assert "<b>" not in report_page([film(tmp_path / "<b>.h5", snapshots=0)])


def test_no_result_and_a_file_that_is_none_are_refused(tmp_path):
    with pytest.raises(CaseError, match="at least one result"):
        write_report([], tmp_path / "a.html")
    (tmp_path / "a.h5").write_text("no")
    with pytest.raises(ResultError, match="must be a result file"):
        write_report([tmp_path / "a.h5"], tmp_path / "a.html")
    assert not (tmp_path / "a.html").exists()
