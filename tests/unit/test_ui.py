"""The local page: who may ask, what it can reach, what it answers; and a person's clicks in Chromium."""

import http.client
import json
import socket
import threading
import time
from pathlib import Path

import pytest
from browser import CHROMIUM, Browser
from typer.testing import CliRunner

from nutamill import cli
from nutamill.base.errors import CaseError, ExitCode
from nutamill.case import load_case
from nutamill.case.toml.form import form_of
from nutamill.design.machine_sheet import machine_sheet
from nutamill.result import Recorder, open_result
from nutamill.ui import runs as runs_room
from nutamill.ui.folder import Folder
from nutamill.ui.guard import MOST_BODY
from nutamill.ui.results import listed
from nutamill.ui.server import Server

JSON = {"Content-Type": "application/json"}
EMPTY = {"charge.kind": "none", "run.until": "20 ms", "mechanism.mounting": "rigid"}
"""Changes that leave a run of a second."""
PATIENCE = 120.0
"""Longest wait for a run on a busy machine [s]."""


@pytest.fixture
def server(tmp_path):
    """The page of an empty folder."""
    folder = tmp_path / "mills"
    folder.mkdir()
    with Server(folder) as one:
        thread = threading.Thread(target=one.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield one
        one.shutdown()
        thread.join()


def reply(server, name="", body=None, headers=None, token=None, method=None):
    """Ask the page, and return status and text."""
    connection = http.client.HTTPConnection("127.0.0.1", server.guard.port, timeout=60)
    content = json.dumps(body) if body is not None and not isinstance(body, str) else body
    given = {**(JSON if body is not None else {}), **(headers or {})}
    path = f"/{server.guard.token if token is None else token}/{name}"
    connection.request(method or ("GET" if body is None else "POST"), path, content, given)
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, text


def answered(server, name, body=None):
    status, text = reply(server, name, body)
    assert status == 200, text
    return json.loads(text)


def refused(server, name, body=None):
    status, text = reply(server, name, body)
    assert status in (400, 409), text
    return json.loads(text)["error"]


def test_the_page_is_served_on_loopback_only(server):
    assert server.server_address[0] == "127.0.0.1"
    assert server.address == f"http://127.0.0.1:{server.guard.port}/{server.guard.token}/"
    status, page = reply(server)
    assert status == 200 and "<title>nutamill</title>" in page


@pytest.mark.parametrize("token", ["", "x", "wrong" * 9])
@pytest.mark.parametrize("name", ["", "start", "ui.js", "page?kind=view&file=a.h5"])
def test_nothing_is_served_without_the_token(server, name, token):
    status, text = reply(server, name, token=token)
    assert status == 403 and "the token in the address is wrong" in text


@pytest.mark.parametrize("host", ["mill.example", "127.0.0.1", "127.0.0.1:1", "localhost.example:80", ""])
def test_a_foreign_host_is_refused(server, host):
    """A name of another site that is pointed at this machine does not reach the page."""
    status, text = reply(server, headers={"Host": host})
    assert status == 403 and "the host of the request is not this page" in text


@pytest.mark.parametrize(
    "origin", ["http://mill.example", "null", "https://127.0.0.1:{}", "http://127.0.0.1:1"]
)
def test_a_foreign_origin_is_refused(server, origin):
    headers = {"Origin": origin.format(server.guard.port)}
    for words in ({}, {"body": {"case": "numill", "changes": {}}, "name": "case"}):
        status, text = reply(server, headers=headers, **words)
        assert status == 403 and "the request comes from another page" in text
    assert reply(server, headers={"Sec-Fetch-Site": "cross-site"})[0] == 403
    assert reply(server, headers={"Origin": f"http://localhost:{server.guard.port}"})[0] == 200


def test_a_body_that_is_too_long_is_refused_unread(server):
    headers = {"Content-Length": str(MOST_BODY + 1)}
    status, text = reply(server, "case", "{}", headers)
    assert status == 413 and "the body is longer than" in text
    assert reply(server, "case", "{}", {"Content-Length": "9" * 30})[0] == 413


def test_a_body_needs_a_length_and_json(server):
    status, text = reply(server, "case", "{}", {"Content-Length": "-1"})
    assert status == 411 and "the length of the body must be given" in text
    assert reply(server, "case", "{}", {"Transfer-Encoding": "chunked"})[0] == 411
    status, text = reply(server, "case", "{}", {"Content-Type": "text/plain"})
    assert status == 415 and "the body must be JSON" in text
    for body in ("{", "[]", "3", "[" * 5000):
        assert "must be a table in JSON" in refused(server, "case", body)


def test_an_address_that_cannot_be_read_is_refused(server):
    assert refused(server, "check?" + "&".join(f"a{k}=1" for k in range(50))) == "the address cannot be read"
    with socket.create_connection(server.server_address) as one:
        host = f"127.0.0.1:{server.guard.port}"
        one.sendall(f"GET http://[x HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())
        assert one.recv(4096).startswith(b"HTTP/1.1 400")


def test_an_address_of_nothing_is_an_error(server):
    assert reply(server, "secrets")[0] == 404
    assert reply(server, "secrets", {})[0] == 404
    assert reply(server, method="PUT")[0] == 501


def test_a_page_may_load_its_own_files_only_and_a_result_nothing(server, film):
    film(server.answers._folder.root / "a.h5", snapshots=2, pellets=3)
    for name, policy in (("", "script-src 'self'"), ("page?kind=view&file=a.h5", "sandbox allow-scripts")):
        connection = http.client.HTTPConnection("127.0.0.1", server.guard.port, timeout=60)
        connection.request("GET", f"/{server.guard.token}/{name}")
        headers = connection.getresponse().headers
        connection.close()
        assert policy in headers["Content-Security-Policy"]
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert (headers["Referrer-Policy"], headers["Cache-Control"]) == ("no-referrer", "no-store")


@pytest.mark.parametrize(
    "name",
    ["../a.h5", "/etc/passwd", "results/../../a.h5", "..\\a.h5", None, 3, "a\0.h5", "link.h5", "way/a.h5"],
)
def test_no_file_outside_the_folder_is_read(server, tmp_path, name):
    """Neither by its path nor through a link."""
    (tmp_path / "a.h5").touch()
    root = server.answers._folder.root
    (root / "link.h5").symlink_to(tmp_path / "a.h5")
    (root / "way").symlink_to(tmp_path, target_is_directory=True)
    assert "is outside the folder of this page" in refused(server, "compare", {"files": [name]})
    assert answered(server, "results") == []


def test_a_file_must_be_there_and_of_its_kind(server):
    assert "is no file in the folder" in refused(server, "compare", {"files": ["a.h5"]})
    assert "must end with .toml" in refused(server, "case", {"case": "a.txt"})
    assert "must end with .h5" in refused(server, "compare", {"files": [""]})
    assert "is outside the folder" in refused(server, "case", {"case": "../a.toml"})
    assert "must be a folder" in CliRunner().invoke(cli.app, ["ui", "nowhere"]).stderr


def test_a_change_cannot_name_a_file(server, tmp_path):
    """Only keys of the form are changed, and none of them is a file."""
    (tmp_path / "speed.csv").write_text("0,0\n1,700\n")
    for key in ("drive.profile", "base", "chamber.mesh.file", "charge.shapes", "drive"):
        body = {"case": "numill", "changes": {key: str(tmp_path / "speed.csv")}}
        assert "is no key of this form" in answered(server, "case", body)["faults"][0]
        assert "is no key of this form" in refused(server, "run", body)
    for changes in ([], {"drive.speed": 3}, {"drive.speed": "9" * 2000}):
        assert "must be texts by key" in refused(server, "case", {"case": "numill", "changes": changes})


def test_machines_and_cases_of_the_folder_are_offered(server):
    root = server.answers._folder.root
    (root / "mine.toml").write_text('schema = 1\nbase = "numill"\n')
    (root / "sweep.toml").write_text('base = "numill"\n[sweep]\nx = ["1 s"]\n')
    start = answered(server, "start")
    names = [case["name"] for case in start["cases"]]
    assert start["first"] == "numill-2026" and start["first"] in names
    assert "mine.toml" in names and "sweep.toml" not in names


def test_the_form_has_units_choices_and_marks(server):
    entries = {one["key"]: one for one in answered(server, "case", {"case": "numill"})["entries"]}
    speed = entries["drive.speed"]
    assert (speed["value"], speed["mark"], speed["units"][:2]) == ("700 rpm", "published", ["rad/s", "rpm"])
    assert entries["chamber.height"]["mark"] == "fitted to a published number"
    assert entries["bearing_cross.mass"]["mark"] == "assumed"
    assert entries["charge.kind"]["choices"] == ["spheres", "clumps", "none"]
    assert entries["charge.count"]["value"] == "" and entries["run.statistics"]["choices"] == [
        "true",
        "false",
    ]
    assert not {"drive.profile", "schema", "title"} & set(entries)
    keys = {one.key for one in form_of("planetary-mill", load_case("planetary-mill"))}
    assert keys >= {"drives.motor.speed", "charge.part.0.count"} and "bodies.sun.name" not in keys


def test_faults_are_those_of_the_command_and_the_form_stays(server):
    sheet = answered(
        server, "case", {"case": "numill", "changes": {"charge.diameter": "5", "chamber.ribs": "-1"}}
    )
    assert any(fault.startswith('charge.diameter: needs a unit: write "5 mm"') for fault in sheet["faults"])
    assert any(fault.startswith("chamber.ribs: must be") for fault in sheet["faults"])
    assert len(sheet["entries"]) > 100


def test_the_sheet_is_that_of_check(server):
    lines = answered(server, "check", {"case": "piston", "changes": {"charge.count": "4"}})["lines"]
    assert lines == machine_sheet(load_case("piston", ["charge.count=4"]).machine).lines()


def test_changes_are_saved_as_a_short_case_file(server):
    changes = {"drive.speed": "500 rpm", "charge.count": "12", "contact.pairs.steel-steel.restitution": "0.6"}
    answer = answered(server, "save", {"case": "numill", "changes": changes, "file": "slow.toml"})
    file = server.answers._folder.root / answer["file"]
    saved = load_case(file)
    asked = load_case("numill", [f"{key}={value}" for key, value in changes.items()])
    assert saved.with_("title", "") == asked.with_("title", "")
    assert len(file.read_text().splitlines()) < 16
    again = {"case": "slow.toml", "changes": {}, "file": "slow.toml"}
    assert "exists already" in refused(server, "save", again)
    assert "must be a name without folders" in refused(server, "save", {**again, "file": "deep/x.toml"})
    assert "is outside the folder" in refused(server, "save", {**again, "file": "../x.toml"})


def ended(server, number):
    """Wait until a run has ended, and return it."""
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        run = next(one for one in answered(server, "runs") if one["number"] == number)
        if run["state"] not in ("running", "stopping"):
            return run
        time.sleep(0.1)
    raise AssertionError("the run goes on")


def test_a_run_reports_and_its_result_is_shown_beside_another(server):
    numbers = []
    for speed in ("500 rpm", "520 rpm"):
        changes = {**EMPTY, "drive.speed": speed}
        numbers.append(answered(server, "run", {"case": "numill", "changes": changes})["number"])
        run = ended(server, numbers[-1])
        assert run["state"] == "complete", run
    assert run["progress"]["time"] == pytest.approx(0.02) and run["file"].startswith("results/numill-")
    files = [one["file"] for one in answered(server, "results")]
    assert len(files) == 2
    traces = answered(server, f"traces?file={files[0]}")
    assert traces["traces"][0]["label"] == "crank-pin force (N)" and traces["time"][-1] == pytest.approx(0.02)
    compared = answered(server, "compare", {"files": files})
    assert compared["differences"] == [{"label": "drive.speed", "values": ["520 rpm", "500 rpm"]}]
    assert "must be recorded, this run did not" in refused(server, f"traces?file={files[0]}&series=nothing")
    status, page = reply(server, f"page?kind=report&file={files[0]}")
    assert status == 200 and "<h1>" in page
    assert "must be view or report" in refused(server, f"page?kind=secrets&file={files[0]}")
    assert "takes one result to 6" in refused(server, "compare", {"files": []})


def test_a_run_is_stopped_saved_and_goes_on(server):
    changes = {**EMPTY, "run.until": "600 s"}
    number = answered(server, "run", {"case": "numill", "changes": changes})["number"]
    assert "is being run already" in refused(server, "run", {"case": "numill", "changes": changes})
    end = time.monotonic() + PATIENCE
    while not answered(server, "runs")[0]["points"]:
        assert time.monotonic() < end
        time.sleep(0.1)
    answered(server, "stop", {"number": number})
    run = ended(server, number)
    assert run["state"] == "stopped, saved"
    with open_result(server.answers._folder.root / run["file"]) as result:
        assert result.state == "interrupted" and 0.0 < result.reached < 600.0
    assert "there is no run 99" in refused(server, "stop", {"number": 99})


def test_no_more_runs_than_cores(server, monkeypatch):
    monkeypatch.setattr(runs_room, "usable_cores", lambda: 0)
    assert "as many as this machine has cores" in refused(server, "run", {"case": "numill", "changes": EMPTY})


def test_runs_end_with_the_page(tmp_path):
    with Server(tmp_path) as one:
        thread = threading.Thread(target=one.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        answered(one, "run", {"case": "numill", "changes": {**EMPTY, "run.until": "600 s"}})
        one.shutdown()
        thread.join()
        (run,) = one.answers.runs._runs.values()
        assert run.goes_on
    assert not run.goes_on and run.shown().state == "stopped, saved"


def test_a_port_that_is_taken_is_named(server):
    reply = CliRunner().invoke(cli.app, ["ui", "--port", str(server.guard.port)])
    assert reply.exit_code == ExitCode.BAD_INPUT and "cannot be used: " in reply.stderr


def test_a_folder_lists_what_it_shows_and_nothing_hidden(tmp_path):
    for name in ("a.toml", ".b.toml", "in/c.toml", "in/deep/d.toml", ".in/e.toml"):
        (tmp_path / name).parent.mkdir(exist_ok=True, parents=True)
        (tmp_path / name).touch()
    assert sorted(Folder(tmp_path).listed(".toml")) == ["a.toml", "in/c.toml"]
    with pytest.raises(CaseError, match="must be a folder"):
        Folder(tmp_path / "a.toml")


@pytest.mark.external
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium to click in")
def test_a_person_changes_checks_runs_and_compares(server, tmp_path):
    with Browser(tmp_path) as browser:
        browser.open(server.address)
        browser.wait("document.querySelector('#sheet dt')")
        browser.write("[name='drive.speed']", "500")
        browser.wait("document.querySelector('.wrong .fault')?.textContent.includes('needs a unit')")
        assert browser.value("document.querySelector('#run').disabled")
        browser.write("[name='drive.speed']", "500 rpm")
        browser.wait("document.querySelector('#title').textContent.includes('drive.speed = 500 rpm')")
        browser.write("#find", "until")
        browser.write("[name='run.until']", "20 ms")
        for key, value in (("charge.kind", "none"), ("mechanism.mounting", "rigid")):
            browser.write("#find", key)
            browser.choose(f"[name='{key}']", value)
        browser.wait("document.querySelector('#verdict').textContent.startsWith('can be run')")
        browser.write("#name", "mine")
        browser.click("#save button")
        browser.wait("document.querySelector('#machine').value === 'mine.toml'")
        browser.click("#run")
        browser.wait("document.querySelector('.card .state')?.textContent === 'complete'")
        browser.click("#tab-results")
        browser.click("#files input")
        browser.click("#compare")
        browser.wait("document.querySelector('#means tr:nth-child(2)')")
        browser.wait("document.querySelector('#overlay').getClientRects().length > 0")
        assert browser.trouble == []
    assert load_case(server.answers._folder.root / "mine.toml").charge.parts == ()


@pytest.mark.external
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium to open the pages in")
@pytest.mark.parametrize("kind", ["view", "report"])
def test_pages_of_a_result_work_although_they_may_load_nothing(server, film, tmp_path, kind):
    film(Path(server.answers._folder.root) / "a.h5", snapshots=3, pellets=20)
    with Browser(tmp_path) as browser:
        browser.open(f"{server.address}page?kind={kind}&file=a.h5")
        drawn = "#time" if kind == "view" else "figure img"
        browser.wait(f"document.querySelector('{drawn}')")
        browser.wait("document.readyState === 'complete'")
        time.sleep(1.0)
        assert browser.trouble == []


def test_the_page_lists_results_of_both_suffixes(tmp_path):
    for name in ("a.h5", "b.hdf5"):
        Recorder.create(tmp_path / name, "", {}, ["time"], 1.0).close()
    assert sorted(row["file"] for row in listed(Folder(tmp_path))) == ["a.h5", "b.hdf5"]
