"""Where a run writes: a complete result is shown, nothing is overwritten unasked, two runs do not write one
file, nothing is lost.
"""

import signal
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import nutamill as nm
from nutamill import cli
from nutamill.base.atomic_file import SPARE
from nutamill.base.errors import CaseError, Interrupted, NotSteadyError, OutputError, ResultError
from nutamill.case import load_case
from nutamill.result import Recorder, open_result, recorder
from nutamill.result.one_writer import one_writer
from nutamill.simulation import runs, signals

PENDULUM = """
schema = 1

[[bodies]]
name     = "arm"
mass     = "2 kg"
inertia  = ["0.1 kg m^2", "0.1 kg m^2", "0.05 kg m^2"]
position = ["0 mm", "0 mm", "-500 mm"]
velocity = ["1 m/s", "0 m/s", "0 m/s"]
angular_velocity = ["0 rad/s", "-2 rad/s", "0 rad/s"]

[[joints]]
name     = "pin"
kind     = "revolute"
between  = ["ground", "arm"]
point    = ["0 mm", "0 mm", "0 mm"]
axis     = [0, 1, 0]

[run]
until       = "2 s"
checkpoint  = "0.5 s"
snapshots   = { rate = "2 Hz", last = "1 s" }
"""

HOLDER = """
import sys, pathlib
from nutamill.result.one_writer import one_writer
with one_writer(pathlib.Path(sys.argv[1])):
    print("locked", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def case_file(tmp_path):
    """A pendulum of 2 s, which marches in five entries, as a case file."""
    file = tmp_path / "pendulum.toml"
    file.write_text(PENDULUM)
    return file


@pytest.fixture
def case(case_file, monkeypatch):
    """The same as a case; every entry of its march reports."""
    monkeypatch.setattr("nutamill.simulation.progress.PAUSE", 0.0)
    return load_case(case_file)


@pytest.fixture
def path(tmp_path):
    """A result file in a folder of its own."""
    return tmp_path / "results" / "a.h5"


def interrupt(progress):
    """Ask the run to stop at the first report of its march."""
    if progress.phase != "settle":
        signal.raise_signal(signal.SIGINT)


def stopped(case, path):
    """Leave a run of `case` at `path` that was interrupted."""
    with pytest.raises(Interrupted):
        nm.run(case, path, progress=interrupt)


def numbers(path):
    """State and all series of a result file."""
    with open_result(path) as result:
        return result.state, result.series.drop_attrs()


def same(one, other):
    """Whether two files hold the same run, and it is complete."""
    (state, series), (other_state, other_series) = numbers(one), numbers(other)
    return state == other_state == "complete" and series.identical(other_series)


def names(folder):
    """Names of all files in a folder, the hidden ones too."""
    return sorted(file.name for file in folder.iterdir())


def test_the_same_run_twice_returns_the_complete_result_and_leaves_the_file(case, path):
    nm.run(case, path).close()
    before, heard = path.stat(), []
    with nm.run(case, path, log=heard.append) as result:
        assert result.reached == pytest.approx(2.0)
    assert heard == [f"{path} is complete already. Make it anew with --again."]
    assert path.stat() == before


def test_the_same_command_twice_shows_the_summary_twice_and_exits_with_0(case_file, monkeypatch):
    monkeypatch.chdir(case_file.parent)
    first, second = (CliRunner().invoke(cli.app, ["run", case_file.name]) for _ in range(2))
    assert (first.exit_code, second.exit_code) == (0, 0), second.output
    notice, *summary = second.stdout.splitlines()[1:]
    assert notice.endswith(".h5 is complete already. Make it anew with --again.")
    assert summary == first.stdout.splitlines()[-len(summary) :]
    assert summary[0].startswith("t = ") or len(summary) > 2


def test_picture_that_cannot_be_written_is_reported_after_the_summary(case_file, monkeypatch):
    monkeypatch.chdir(case_file.parent)
    (case_file.parent / "a.png").mkdir()
    reply = CliRunner().invoke(cli.app, ["run", case_file.name, "--to", "a.h5"])
    assert reply.exit_code == 4, reply.output
    assert "energy ledger closes" in reply.stdout
    assert reply.stderr.startswith("a.png: cannot be written, the system reports")


def test_complete_result_of_other_kernels_is_returned_and_called_so(case, path, monkeypatch):
    nm.run(case, path).close()
    monkeypatch.setattr(runs, "kernel_digest", lambda: "0" * 64)
    heard = []
    nm.run(case, path, log=heard.append).close()
    assert "made by other kernels than this version has" in heard[0]


def test_complete_result_is_returned_from_a_folder_that_cannot_be_written(case, path, monkeypatch):
    nm.run(case, path).close()

    def refused(path):
        raise OutputError(f"{path}: cannot be written")

    monkeypatch.setattr(runs, "one_writer", refused)
    nm.run(case, path).close()
    nm.resume(path).close()


def test_run_again_keeps_the_old_file_until_the_new_one_is_whole(case, path):
    nm.run(case, path).close()
    before, during = path.stat(), []
    nm.run(
        case, path, again=True, progress=lambda progress: during.append((path.stat(), numbers(path)[0]))
    ).close()
    assert during
    assert all((state, whole) == (before, "complete") for state, whole in during)
    assert path.stat().st_ino != before.st_ino
    assert numbers(path)[0] == "complete"
    assert names(path.parent) == ["a.h5"]


def test_run_again_that_is_stopped_leaves_both_files_and_names_them(case, path):
    nm.run(case, path).close()
    before, heard = path.read_bytes(), []
    with pytest.raises(Interrupted) as stop:
        nm.run(case, path, progress=interrupt, log=heard.append, again=True)
    new = path.with_name("a.again.h5")
    assert stop.value.path == new
    assert heard == [f"{path} is unchanged, the new run so far is in {new}"]
    assert path.read_bytes() == before
    nm.resume(new).close()
    assert same(path, new)


def test_incomplete_result_is_not_overwritten_and_the_message_says_how_to_go_on(case, path):
    stopped(case, path)
    with pytest.raises(ResultError) as raised:
        nm.run(case, path)
    message = str(raised.value)
    assert f"{path}: is incomplete, it ends at " in message
    assert (
        f" s of 2 s (interrupted). Continue it with: nutamill resume {path}. Or begin anew with --again."
        in message
    )
    nm.run(case, path, again=True).close()
    assert numbers(path)[0] == "complete"


def test_result_of_another_case_is_not_overwritten_unless_it_is_asked_for(case, path):
    nm.run(case, path).close()
    other = case.with_("run.until", 1.0)
    with pytest.raises(
        ResultError, match=r"holds another case\. Choose another file with --to, or replace it with --again"
    ):
        nm.run(other, path)
    with nm.run(other, path, again=True) as result:
        assert result.reached == pytest.approx(1.0)


@pytest.mark.parametrize("again", [False, True])
def test_file_that_is_no_result_is_never_overwritten(case, path, again):
    path.parent.mkdir()
    path.write_text("my notes")
    with pytest.raises(
        ResultError, match="No run replaces this file: choose another with --to, or remove it"
    ):
        nm.run(case, path, again=again)
    assert path.read_text() == "my notes"


def test_file_of_a_run_that_was_killed_before_its_first_save_is_begun_anew(case, path):
    Recorder.create(path, case.to_toml(), {"kernel_digest": ""}, ["time"], 1000.0)
    with pytest.raises(ResultError, match="Run the case again"):
        nm.resume(path)
    nm.run(case, path).close()
    assert numbers(path)[0] == "complete"


def test_run_that_never_became_steady_says_so_again(path, tmp_path, monkeypatch):
    mill = load_case("numill", ["mechanism.mounting=rigid", "charge.kind=none", "run.until=steady"])
    empty = Recorder.create(path, mill.to_toml(), {"kernel_digest": ""}, ["time"], 1000.0)
    empty.append(np.arange(4.0)[:, None])
    empty.state("not steady: fewer than 5 whole turns at full speed")
    empty.close()
    for ask in (lambda: nm.run(mill, path), lambda: nm.resume(path)):
        with pytest.raises(
            NotSteadyError, match=r"not steady after 3 s: fewer than 5 whole turns at full speed\. Go on with"
        ):
            ask()


def test_two_runs_do_not_write_one_file(case, path):
    stopped(case, path)
    with one_writer(path):
        for act in (
            lambda: nm.run(case, path),
            lambda: nm.run(case, path, again=True),
            lambda: nm.resume(path),
        ):
            with pytest.raises(ResultError, match="is being written by another run"):
                act()
    nm.resume(path).close()
    assert names(path.parent) == ["a.h5"]


def test_lock_is_seen_by_another_process_and_dies_with_its_own(path):
    holder = subprocess.Popen(
        [sys.executable, "-P", "-c", HOLDER, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert holder.stdout.readline() == b"locked\n"
    with pytest.raises(ResultError, match="is being written by another run"), one_writer(path):
        pass
    holder.kill()
    holder.communicate()
    with one_writer(path):
        pass
    assert names(path.parent) == []


def test_python_without_sqlite_runs_without_a_lock(case, path, monkeypatch):
    monkeypatch.setitem(sys.modules, "sqlite3", None)
    nm.run(case, path).close()
    assert names(path.parent) == ["a.h5"]


def test_result_that_is_deleted_during_the_run_is_written_anew_with_all_it_held(case, path, monkeypatch):
    whole = path.with_name("whole.h5")
    nm.run(case, whole).close()
    monkeypatch.setattr(recorder, "FIRST_PAUSE", 0.0)
    monkeypatch.setattr(recorder, "COMMIT_SHARE", np.inf)
    deleted = []

    def delete(progress):
        if progress.time > 1.0 and not deleted:
            deleted.append(numbers(path)[1].sizes["time"])
            path.unlink()

    nm.run(case, path, progress=delete).close()
    assert deleted[0] > 1
    assert same(path, whole)


def test_result_that_is_deleted_where_its_content_goes_with_it_is_reported(case, path, monkeypatch):
    monkeypatch.setattr(recorder, "DELETED_STAYS", False)
    with pytest.raises(ResultError, match="was deleted or moved during the run"):
        nm.run(case, path, progress=lambda progress: path.unlink(missing_ok=True))


def test_run_that_has_ended_is_resumed_to_its_result_and_to_a_later_end_given_as_text(case, path):
    nm.run(case.with_("run.until", 1.0), path).close()
    before, heard = path.stat(), []
    nm.resume(path, log=heard.append).close()
    assert heard == [f"{path} has ended, at 1 s. For a later end: nutamill resume {path} --until TIME"]
    assert path.stat() == before
    nm.resume(path, until="2000 ms").close()
    nm.run(case, path.with_name("whole.h5")).close()
    assert same(path, path.with_name("whole.h5"))


@pytest.mark.parametrize(
    ("until", "message"), [("20", "needs a unit"), ("2 m", "s"), (float("nan"), "not a finite time, got nan")]
)
def test_end_that_is_no_time_is_refused(until, message, path):
    with pytest.raises(CaseError, match=f"--until: .*{message}"):
        nm.resume(path, until=until)


def test_run_takes_a_name_or_a_file_and_refuses_what_is_no_case(case_file, path, monkeypatch):
    with nm.run(str(case_file), path) as result:
        assert result.reached == pytest.approx(2.0)
    ran = []
    monkeypatch.setattr(runs, "run_to", lambda case, *args: ran.append(case))
    monkeypatch.setattr(runs, "ended_result", lambda path: None)
    nm.run("numill", path.with_name("b.h5"))
    assert ran == [load_case("numill")]
    with pytest.raises(CaseError, match="case: not a case, the name of a mill, or a case file, got dict"):
        nm.run({"drive.speed": "500 rpm"}, path)


def test_too_little_room_is_reported_before_the_charge_settles(path, monkeypatch):
    mill = load_case("numill", ["charge.mass=2 kg"])
    monkeypatch.setattr(runs, "warm_up", lambda *args: pytest.fail("the kernels were compiled first"))
    monkeypatch.setattr(
        "nutamill.base.atomic_file.shutil.disk_usage",
        lambda folder: type("Usage", (), {"free": SPARE + 1000})(),
    )
    with pytest.raises(
        OutputError,
        match=r"saving needs 1\d\.\d MB, 16\.8 MB are free, and a reserve of 16\.8 MB must stay free",
    ):
        nm.run(mill, path)


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_each_signal_to_end_stops_a_run_and_saves_it(name, case, path):
    number = getattr(signal, name, None) or pytest.skip("the system has no such signal")

    def end(progress):
        if progress.phase != "settle":
            signal.raise_signal(number)

    with pytest.raises(Interrupted):
        nm.run(case, path, progress=end)
    with open_result(path) as result:
        assert result.state == "interrupted"
        assert result.checkpoint().time == result.reached > 0


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="the system has no such signal")
def test_hang_up_that_was_switched_off_does_not_stop_a_run(case, path):
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        nm.run(case, path, progress=lambda progress: signal.raise_signal(signal.SIGHUP)).close()
    finally:
        signal.signal(signal.SIGHUP, before)
    assert numbers(path)[0] == "complete"


def test_system_without_the_posix_signals_runs_and_is_stopped(case, path, monkeypatch):
    for name in ("SIGHUP", "SIGUSR1"):
        monkeypatch.delattr(signal, name, raising=False)
    assert signals.checkpoint_signal() is None
    stopped(case, path)
    nm.resume(path).close()
    assert numbers(path)[0] == "complete"
