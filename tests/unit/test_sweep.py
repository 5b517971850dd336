"""Sweeps: what values a text stands for, which cases are made, what is run and what is left, and what the
table says.
"""

import csv
import io
import json
import os
import re
import signal
import subprocess
import sys
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from nutamill import cli
from nutamill.analysis.values import Reading, read, reading_of
from nutamill.base.errors import CaseError, StepError
from nutamill.base.steady import Estimate
from nutamill.case import load_case
from nutamill.result import Recorder, open_result
from nutamill.studies import board, member, sweep
from nutamill.studies.axes import axis_values, changed, members
from nutamill.studies.figures import draw_sweep
from nutamill.studies.member import Task, perform, state_of
from nutamill.studies.table import Outcome
from nutamill.studies.workers import LocalProcesses, WorkerError

EMPTY = [
    "charge.kind=none",
    "mechanism.mounting=rigid",
    "drive.ramp=10000 rpm/s",
    "run.until=50 ms",
    "run.checkpoint=10 ms",
]
FORCE, TORQUE = Reading("crank_pin_force_resultant"), Reading("driveshaft_torque")


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("100..700 rpm step 60 rpm", [f"{n} rpm" for n in range(100, 701, 60)]),
        ("250..750 rpm / 11", [f"{n} rpm" for n in range(250, 751, 50)]),
        ("100 rpm .. 250 rpm step 100 rpm", ["100 rpm", "200 rpm"]),
        ("0.1..0.3 step 0.1", ["0.1", "0.2", "0.3"]),
        ("1..5", ["1", "2", "3", "4", "5"]),
        ("0,12", ["0", "12"]),
        ("100, 400, 700 rpm", ["100 rpm", "400 rpm", "700 rpm"]),
        ("30 N m s/rad, 0.03 N m s/rad", ["30 N m s/rad", "0.03 N m s/rad"]),
        ("printed,343", ["printed", "343"]),
        ("700 rpm", ["700 rpm"]),
        ('[["4 mm", 0.3], ["5 mm", 0.7]]', ['[["4 mm", 0.3], ["5 mm", 0.7]]']),
        ("-1e-3..1e-3 m / 3", ["-0.001 m", "0 m", "0.001 m"]),
    ],
)
def test_text_stands_for_its_values(text, values):
    assert axis_values("key", text) == values


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "100..700 rpm",
            'sweep key: needs a step or a number of values, got "100..700 rpm". Write e.g. "100..700 '
            'rpm / 11"',
        ),
        ("700..100 rpm / 3", "must rise"),
        ("1 rev/s..700 rpm / 3", "must have one unit"),
        ("1..2 step 0", "must have a step above zero"),
        ("0..1 step 1e-9", "makes more than 10000 values"),
    ],
)
def test_range_that_makes_no_sense_is_refused(text, message):
    with pytest.raises(CaseError) as raised:
        axis_values("key", text)
    assert message in str(raised.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("300..700", 'must have a unit, got "300..700". Write e.g. "300..700 rpm / 5"'),
        ("700..300 rpm / 3", 'must rise, got "700..300 rpm / 3". Write "300..700 rpm / 3"'),
        (
            "700..300 rpm step 50 rpm",
            'must rise, got "700..300 rpm step 50 rpm". Write "300..700 rpm step 50 rpm"',
        ),
        ("300..300 rpm / 3", 'must rise, got "300..300 rpm / 3". Write "300 rpm"'),
    ],
)
def test_a_faulty_range_of_a_key_is_one_fault_with_a_cure_that_works(text, message):
    with pytest.raises(CaseError) as raised:
        axis_values("drive.speed", text)
    assert [str(fault) for fault in raised.value.faults] == [f"sweep drive.speed: {message}"]
    cure = re.search(r'"([^"]*)"$', message)[1]
    assert all(value.endswith(" rpm") for value in axis_values("drive.speed", cure))


def made(axes, *more):
    return members(
        axes,
        lambda values: load_case(
            "numill", [*EMPTY, *more, *(f"{key}={value}" for key, value in values.items())]
        ),
    )


def test_members_are_all_combinations_on_one_thread():
    runs = made({"drive.speed": ["300 rpm", "600 rpm"], "chamber.bars.mass": ["0 kg", "1 kg"]})
    assert [one.label for one in runs] == [
        f"drive.speed={speed} rpm chamber.bars.mass={mass} kg" for speed in (300, 600) for mass in (0, 1)
    ]
    assert [one.case.chamber.bars_mass for one in runs] == [0.0, 1.0, 0.0, 1.0]
    assert {one.case.run.threads for one in runs} == {1}


def test_key_that_does_not_exist_is_refused_once_with_a_suggestion():
    with pytest.raises(CaseError) as raised:
        made({"drive.sped": ["300 rpm", "600 rpm"]})
    assert str(raised.value) == '--set drive.sped: unknown key. Did you mean "speed"?'


def test_many_faults_alike_are_counted_not_listed():
    with pytest.raises(CaseError) as refused:
        members(
            {"drive.speed": [str(speed) for speed in range(400, 500)]},
            lambda values: load_case("numill", [f"drive.speed={values['drive.speed']}"]),
        )
    assert len(refused.value.faults) == 11
    assert str(refused.value.faults[-1]) == "sweep: 90 more faults like these"


def test_command_without_a_key_to_sweep_is_refused_before_any_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    reply = CliRunner().invoke(cli.app, ["sweep", "numill", "-s", "chamber.ribs=0"])
    assert (reply.exit_code, reply.stderr.split(". ")[0]) == (
        2,
        "sweep: needs a key with several values, got none",
    )


def test_same_case_twice_is_refused():
    with pytest.raises(CaseError, match=r"drive\.speed=300 rpm and drive\.speed=5 rev/s are the same case"):
        made({"drive.speed": ["300 rpm", "5 rev/s"]})


def test_substep_too_long_in_one_member_is_refused_before_any_run(tmp_path):
    case = load_case("numill", ["charge.mass=0.05 kg"])
    runs = members({"run.dt": ["3 us", "40 us"]}, lambda values: changed(case, values))
    with pytest.raises(CaseError, match=r"run\.dt=40 us: run\.dt = 40 us: a steel-steel contact lasts"):
        sweep.run_all(runs, tmp_path / "sweep", here := Here())
    assert not here.asked


class Here:
    """Workers that do what they are given at once, in this process, and remember it."""

    def __init__(self, spoil=lambda task: None):
        self.asked, self.stopped, self._spoil = [], False, spoil

    def submit(self, task):
        self.asked.append(task)
        future = Future()
        try:
            self._spoil(task)
            perform(task)
        except (Exception, KeyboardInterrupt) as error:
            future.set_exception(error)
        else:
            future.set_result(None)
        return future

    def stop(self):
        self.stopped = True


@pytest.fixture
def engine(monkeypatch):
    """The march, replaced by a writer of records whose steady means are speed squared and speed."""

    def write(case, path, state="complete", end=2.0):
        time = np.arange(round(end * 1000.0) + 1) / 1000.0
        recorder = Recorder.create(
            path,
            case.to_toml(),
            {},
            ["time", "crank_angle", "driveshaft_speed", FORCE.series, TORQUE.series],
            1000.0,
            overwrite=True,
        )  # as a run does, which has looked at the file there
        speed = np.full_like(time, case.drive.speed)
        ripple = 1.0 + 0.1 * np.sin(speed * time)
        recorder.append(np.stack([time, speed * time, speed, speed**2 * ripple, speed * ripple], axis=1))
        recorder.checkpoint(end, {"mechanism": {"position": np.zeros(3)}})
        recorder.state(state)
        recorder.close()
        return open_result(path)

    def resume(path):
        with open_result(path) as result:
            case = sweep.Case.from_toml(result.case_text)
        path.unlink()
        return write(case, path)

    monkeypatch.setattr(member, "run", write)
    monkeypatch.setattr(member, "resume", resume)
    for name in ("warm_up", "warm_up_mechanism"):
        monkeypatch.setattr(sweep, name, lambda *args, **kwargs: None)
    return write


def test_table_holds_means_over_the_swept_keys_in_si(tmp_path, engine):
    case = load_case("numill", EMPTY)
    axes = {"drive.speed": ["300 rpm", "600 rpm"], "mounts.set": ["printed", "343"]}
    runs = members(axes, lambda values: changed(case, values))
    table = sweep.dataset(sweep.run_all(runs, tmp_path, Here(), (FORCE, TORQUE)), axes, (FORCE, TORQUE))
    speed = np.array([10.0, 20.0]) * np.pi
    assert table["drive.speed"].values == pytest.approx(speed)
    assert table["drive.speed"].attrs["units"] == "rad/s"
    assert list(table["mounts.set"].values) == ["printed", "343"]
    # a trapezoid over whole turns leaves of the ripple 0.1 x (0.063 rad)^2 at most
    assert table[TORQUE.name].sel({"mounts.set": "343"}).values == pytest.approx(speed, rel=4e-4)
    assert table[FORCE.name].values[:, 0] == pytest.approx(speed**2, rel=4e-4)
    assert table[FORCE.name].attrs == {"units": "N", "long_name": "crank-pin force"}
    assert float(table[f"{FORCE.name}_half_width"].max()) < 1e-3 * speed[1] ** 2
    assert set(table["state"].values.ravel()) == {"complete"}


def test_same_call_again_runs_only_what_is_missing_and_resumes_what_was_begun(tmp_path, engine):
    runs = made({"drive.speed": ["300 rpm", "400 rpm", "500 rpm", "600 rpm"]})
    engine(runs[1].case, runs[1].case.file_in(tmp_path), "interrupted", 1.0)
    engine(runs[2].case, runs[2].case.file_in(tmp_path), "complete")
    outcomes = sweep.run_all(runs, tmp_path, first := Here(), (TORQUE,))
    assert [task.path.rsplit("/", 1)[1] for task in first.asked] == [outcomes[k].file.name for k in (0, 1, 3)]
    assert [outcome.state for outcome in outcomes] == ["complete"] * 4
    with open_result(outcomes[1].file) as result:
        assert result.reached == 2.0
    assert (
        not (again := Here()).asked
        and sweep.run_all(runs, tmp_path, again, (TORQUE,)) == outcomes
        and not again.asked
    )


def test_run_that_fails_is_named_and_the_rest_goes_on(tmp_path, engine):
    runs = made({"drive.speed": ["300 rpm", "400 rpm", "500 rpm"]})

    def spoil(task):
        if task.path == str(runs[1].case.file_in(tmp_path)):
            raise StepError("t = 0.1 s: particle 17 left the chamber")

    outcomes = sweep.run_all(runs, tmp_path, Here(spoil), (TORQUE,))
    assert [outcome.state for outcome in outcomes] == [
        "complete",
        "t = 0.1 s: particle 17 left the chamber",
        "complete",
    ]
    with (tmp_path / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["drive.speed"] for row in rows] == ["300 rpm", "400 rpm", "500 rpm"]
    assert [row["driveshaft_torque [N m]"] for row in rows][1] == "nan"
    assert float(rows[2]["driveshaft_torque [N m]"]) == pytest.approx(500 * np.pi / 30, rel=4e-4)


def test_bed_that_several_runs_share_is_settled_once_before_them_and_any_other_by_its_run(
    tmp_path, engine, monkeypatch
):
    case = load_case("numill", ["charge.mass=0.05 kg"])
    runs = members(
        {"drive.speed": ["300 rpm", "600 rpm"], "run.seed": [1, 2]}, lambda values: changed(case, values)
    )
    monkeypatch.setattr(sweep, "bed_is_cached", lambda case: False)
    monkeypatch.setattr(member, "settled_bed", lambda machine: None)
    sweep.run_all(runs, tmp_path, here := Here(), (TORQUE,))
    assert [task.work for task in here.asked] == ["settle"] * 2 + ["run"] * 4
    alone = members({"run.seed": [3, 4]}, lambda values: changed(case, values))
    sweep.run_all(alone, tmp_path / "alone", here := Here(), (TORQUE,))
    assert [task.work for task in here.asked] == ["run"] * 2


def test_interrupted_sweep_stops_its_workers_and_keeps_its_table(tmp_path, engine):
    runs = made({"drive.speed": ["300 rpm", "400 rpm"]})

    def stop(outcomes):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sweep.run_all(runs, tmp_path, here := Here(), (TORQUE,), stop)
    assert here.stopped
    assert "complete" in (tmp_path / "table.csv").read_text()


def test_file_killed_before_its_first_checkpoint_is_begun_anew(tmp_path, engine):
    case = made({"drive.speed": ["300 rpm"]})[0].case
    Recorder.create(tmp_path / "a.h5", case.to_toml(), {}, ["time"], 1000.0)
    assert state_of(tmp_path / "a.h5") == "running"
    perform(Task("run", case.to_toml(), "numill", str(tmp_path / "a.h5")))
    assert state_of(tmp_path / "a.h5") == "complete"


def test_a_sweep_in_two_processes_runs_no_module_beside_its_cases(tmp_path, monkeypatch):
    (tmp_path / "numpy.py").write_text("open('taken', 'w')", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    # an empty mill compiles no charge
    monkeypatch.setattr(sweep, "warm_up", lambda *args, **kwargs: pytest.fail("the charge is compiled"))
    case = load_case("numill", [*EMPTY, "run.until=2 ms", "run.checkpoint=1 ms"])
    axes = {"drive.speed": ["300 rpm", "600 rpm"]}
    planned = members(axes, lambda values: changed(case, values))
    outcomes = sweep.run_all(planned, tmp_path / "sweep", LocalProcesses(2))
    assert [outcome.state for outcome in outcomes] == ["complete", "complete"]
    assert not (tmp_path / "taken").exists()


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX systems")
def test_killed_process_is_named_and_leaves_the_next_task_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "nutamill.studies.workers.PROGRAM", "import os, sys; sys.stdin.readline() and os.kill(os.getpid(), 9)"
    )
    workers = LocalProcesses(1)
    killed = workers.submit(Task("run", "", "", ""))
    with pytest.raises(WorkerError, match=r"its process was killed \(SIGKILL\)"):
        killed.result()
    monkeypatch.setattr("nutamill.studies.workers.PROGRAM", "import sys; sys.stdin.readline()")
    workers.submit(Task("run", "", "", "")).result()
    workers.stop()


def test_a_process_takes_one_task_after_another_and_ends_when_stopped(tmp_path, monkeypatch):
    file = str(tmp_path / "numbers")
    program = (
        "import os; from nutamill.base.child import tasks_of_parent\n"
        f"for task in tasks_of_parent(lambda: None): open({file!r}, 'a').write(f'{{os.getpid()}} ') and "
        "print('done', flush=True)"
    )
    monkeypatch.setattr("nutamill.studies.workers.PROGRAM", program)
    workers = LocalProcesses(1)
    for _ in range(3):
        workers.submit(Task("run", "", "", "")).result()
    workers.stop()
    numbers = (tmp_path / "numbers").read_text().split()
    assert len(numbers) == 3 and len(set(numbers)) == 1
    with pytest.raises(ProcessLookupError):
        os.kill(int(numbers[0]), 0)


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX systems")
def test_stopped_workers_ask_their_processes_to_save(tmp_path, monkeypatch):
    program = (
        "import signal, sys\nsignal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})\n"
        f"open({str(tmp_path / 'begun')!r}, 'w').close()\nsignal.sigwait({{signal.SIGTERM}})\nsys.exit(130)"
    )
    monkeypatch.setattr("nutamill.studies.workers.PROGRAM", program)
    workers = LocalProcesses(1)
    first, second = workers.submit(Task("run", "", "", "")), workers.submit(Task("run", "", "", ""))
    while not (tmp_path / "begun").exists():
        pass
    workers.stop()
    with pytest.raises(WorkerError, match="interrupted, saved"):
        first.result()
    assert second.cancelled() or isinstance(second.exception(), WorkerError)


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX systems")
def test_worker_whose_campaign_has_died_saves_and_ends(tmp_path):
    case = load_case("numill", [*EMPTY, "run.until=100 s"]).with_("run.threads", 1)
    task = Task("run", case.to_toml(), "numill", str(tmp_path / "a.h5"))
    program = (
        "import nutamill.simulation.runs as m; m.warm_up = lambda *a, **k: None\nfrom "
        "nutamill.studies.member import main; main()"
    )
    process = subprocess.Popen([sys.executable, "-c", program], stdin=subprocess.PIPE, text=True)
    process.stdin.write(json.dumps(task) + "\n")
    process.stdin.flush()
    while not (tmp_path / "a.h5").exists():
        assert process.poll() is None
    process.stdin.close()  # what happens when the process at the other end is killed
    assert process.wait() in (130, -signal.SIGTERM)
    with open_result(tmp_path / "a.h5") as result:
        assert result.state in ("interrupted", "running")


def test_same_sweep_runs_on_a_dask_cluster(tmp_path, engine):
    distributed = pytest.importorskip("distributed", reason="pip install '.[cluster]'")
    case = load_case("numill", EMPTY)
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        campaign = sweep.sweep(
            case, {"drive.speed": ["300 rpm", "600 rpm"]}, tmp_path, client=client, readings=(TORQUE,)
        )
    assert campaign.table[TORQUE.name].values == pytest.approx([10 * np.pi, 20 * np.pi], rel=4e-4)
    assert [outcome.state for outcome in campaign.outcomes] == ["complete"] * 2


def test_readings_are_means_root_mean_squares_and_swings_of_turns(tmp_path, engine):
    with engine(load_case("numill", [*EMPTY, "drive.speed=600 rpm"]), tmp_path / "a.h5") as result:
        speed = 20.0 * np.pi
        asked = [
            TORQUE,
            Reading(TORQUE.series, "rms"),
            Reading(TORQUE.series, "swing"),
            Reading("mount_1_travel_x"),
        ]
        values = read(result, asked)
    # torque = speed (1 + 0.1 sin): its mean, its root mean square, half its swing
    expected = [speed, speed * np.sqrt(1.0 + 0.5 * 0.1**2), 0.1 * speed]
    assert [values[one].mean for one in asked[:3]] == pytest.approx(expected, rel=2e-3)
    assert np.isnan(values[asked[3]].mean)


def test_reading_that_does_not_exist_is_refused():
    assert reading_of("swing mount_2_travel_x") == Reading("mount_2_travel_x", "swing")
    with pytest.raises(CaseError, match='Did you mean "driveshaft_torque"'):
        reading_of("driveshaft_torqe")
    with pytest.raises(CaseError, match='must be a series, or "rms" or "swing" and a series'):
        reading_of("max driveshaft_torque")


def test_command_runs_a_sweep_file_and_prints_its_table(tmp_path, engine, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("nutamill.studies.command.LocalProcesses", lambda jobs: Here())
    (tmp_path / "speeds.toml").write_text(
        'case = "numill"\n[set]\n"charge.kind" = "none"\n"mechanism.mounting" = '
        '"rigid"\n"drive.ramp" = "10000 rpm/s"\n'
        '[sweep]\n"drive.speed" = "300..500 rpm step 100 rpm"\n"chamber.bars.mass" = ["0 kg", "1 kg"]\n'
    )
    reply = CliRunner().invoke(cli.app, ["sweep", "speeds.toml", "-s", "chamber.bars.mass=1 kg"])
    assert reply.exit_code == 0, reply.output
    assert "3 runs into sweeps/speeds" in reply.output
    assert "3 of 3  drive.speed=500 rpm" in reply.output
    assert "3 of 3 done   sweeps/speeds/table.csv   picture sweeps/speeds/table.png" in reply.output
    assert (tmp_path / "sweeps/speeds/table.png").stat().st_size > 5000


def test_command_refuses_a_wrong_sweep_file_with_its_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "speeds.toml").write_text(
        'case = "numill"\nsets = { a = 1 }\n[sweep]\n"drive.speed" = ["300 rpm"]\n'
    )
    reply = CliRunner().invoke(cli.app, ["sweep", "speeds.toml"])
    assert (reply.exit_code, reply.stderr) == (2, 'speeds.toml:2: sets: unknown key. Did you mean "set"?\n')


def outcomes_of(*states):
    """Outcomes of speeds 100, 200, ... in these states; a finished one has a torque of a hundredth of its
    speed in rpm.
    """
    runs = made({"drive.speed": [f"{100 * (k + 1)} rpm" for k in range(len(states))]})
    values = [
        {TORQUE: Estimate(k + 1.0, 0.021, k + 1.0, 9, True)} if state == "complete" else {}
        for k, state in enumerate(states)
    ]
    return [
        Outcome(one, Path(f"{k}.h5"), state, read)
        for k, (one, state, read) in enumerate(zip(runs, states, values, strict=True))
    ]


def test_live_table_shows_every_run_and_the_total():
    from rich.console import Console

    console = Console(width=140, record=True, file=io.StringIO())
    console.print(
        board.table(
            outcomes_of(
                "complete", "running, t = 0.50 of 2 s", "its process was killed (SIGKILL)", "waiting"
            ),
            (TORQUE,),
        )
    )
    screen = console.export_text()
    assert "1 of 4 done, 1 not finished" in screen
    assert next(line for line in screen.splitlines() if "100 rpm" in line).split()[1:7] == [
        "100",
        "rpm",
        "│",
        "1.000",
        "±",
        "0.021",
    ]
    assert "running, t = 0.50 of 2 s" in screen and "killed (SIGKILL)" in screen


def test_log_has_one_line_for_each_run_that_has_ended(capsys):
    with board.Board((TORQUE,)) as shown:
        shown(outcomes_of("complete", "waiting", "waiting"))
        shown(outcomes_of("complete", "running, t = 1 of 2 s", "waiting"))
        shown(outcomes_of("complete", "complete", "waiting"))
    assert capsys.readouterr().out.splitlines() == [
        "1 of 3  drive.speed=100 rpm  driveshaft torque 1.000 ± 0.021 N m  complete",
        "2 of 3  drive.speed=200 rpm  driveshaft torque 2.000 ± 0.021 N m  complete",
    ]


def test_results_of_other_kernels_are_reported(tmp_path, engine):
    runs = made({"drive.speed": ["300 rpm"]})
    sweep.run_all(runs, tmp_path, Here(), (TORQUE,))
    messages = []
    sweep.run_all(runs, tmp_path, Here(), (TORQUE,), log=messages.append)
    assert len(messages) == 1 and messages[0].startswith(
        "made by the kernels of another version"
    )  # the record here names no kernels


def test_picture_has_a_panel_for_each_reading_and_a_line_for_each_other_value(tmp_path):
    outcomes, axes = outcomes_of("complete", "complete"), {"drive.speed": ["100 rpm", "200 rpm"]}
    figure = draw_sweep(sweep.dataset(outcomes, axes, (TORQUE, FORCE)), (TORQUE, FORCE))
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "driveshaft torque\n(N m)"
    ]  # nothing was read of the force
    assert figure.axes[0].get_xlabel() == "drive.speed (rpm)"
    assert figure.axes[0].lines[0].get_xdata() == pytest.approx([100.0, 200.0])
    assert draw_sweep(sweep.dataset(outcomes[:1], {"drive.speed": ["100 rpm"]}, (TORQUE,)), (TORQUE,)) is None
