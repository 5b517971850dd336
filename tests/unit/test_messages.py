"""Texts of messages that no other test provokes: what is wrong, and what to do."""

from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

import nutamill
from nutamill.analysis.load_paths import joint_reaction
from nutamill.analysis.measured_comparison import low_pass
from nutamill.analysis.measured_import import import_test
from nutamill.analysis.mounts import chamber_clearance
from nutamill.analysis.orders import sensor_orders
from nutamill.analysis.replay import chosen_snapshots
from nutamill.analysis.rods import yoke_rods
from nutamill.analysis.spectra import spectrum
from nutamill.base.errors import CaseError, DamagedError, ResultError, StepError
from nutamill.case import load_case
from nutamill.charge.assembly import charge
from nutamill.charge.filling import relax
from nutamill.charge.filling.fill_walls import _scattered
from nutamill.charge.laws.oscillator import damping_ratio_from_restitution
from nutamill.charge.walls.mesh import closed_mesh
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.cli import app
from nutamill.result import Recorder, archive, open_result
from nutamill.result.checksums import COPIES
from nutamill.studies import fit, workers
from nutamill.studies.member import Task
from nutamill.studies.papers.figures import draw_figure
from nutamill.studies.papers.library import parse_paper, read_paper
from nutamill.studies.papers.quantities import QUANTITIES
from nutamill.studies.papers.runs import planned_runs
from nutamill.studies.validate import write_tables
from nutamill.view.figures.motion import draw_histories

DEEP = Surface("floor", SurfaceKind.PLANE, 0, 0, origin=(0.0, 0.0, 10.0))
BALLS = {"positions": np.zeros((1, 3)), "radii": np.ones(1), "materials": np.zeros(1, int)}


@pytest.mark.parametrize(
    ("act", "error", "text"),
    [
        (lambda: nutamill.nothing, AttributeError, "module 'nutamill' has no attribute 'nothing'"),
        (lambda: low_pass(np.zeros(100), 100.0, 80.0), CaseError, "must lie between 0 and 50 Hz, half the"),
        (lambda: spectrum(np.zeros(5), 100.0), CaseError, "needs 32 samples, got 5"),
        (lambda: damping_ratio_from_restitution(1.5, False), ValueError, r"must be in \(0, 1\], got 1.5"),
        (
            lambda: closed_mesh("m", np.zeros((3, 2)), np.zeros((1, 3)), "outside", 1.0),
            CaseError,
            r"must be triangles, got arrays of shape \(3, 2\)",
        ),
        (
            lambda: charge(**BALLS, densities=[1.0], pair_laws={}, surfaces=[], n_bodies=1, precision="half"),
            CaseError,
            'must be "single" or "double", got \'half\'',
        ),
        (
            lambda: _scattered(np.random.default_rng(1), 5, [DEEP], np.zeros(3), np.ones(3), 1.0),
            CaseError,
            "no room among the walls. Check the position and unit of the meshes",
        ),
    ],
)
def test_a_call_that_cannot_be_done_is_refused(act, error, text):
    with pytest.raises(error, match=text):
        act()


def test_a_packing_that_is_not_reached_is_given_up(monkeypatch):
    monkeypatch.setattr(relax, "SWEEPS", 3)
    monkeypatch.setattr(relax, "INERTIAL_SWEEPS", 3)
    x = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    with pytest.raises(CaseError, match="no random packing after 6 sweeps"):
        relax.relaxed(x, np.full(2, 0.1), lambda x, sweep: 1.0, crowded=False)


@pytest.fixture(scope="module")
def run(film, tmp_path_factory):
    """Half a second of a mill on rigid mounts, with 20 snapshots."""
    with open_result(film(tmp_path_factory.mktemp("run") / "a.h5")) as result:
        yield result


@pytest.mark.parametrize(
    ("act", "error", "text"),
    [
        (lambda result: joint_reaction(result, "hinge"), CaseError, "its reaction is not recorded"),
        (
            lambda result: chamber_clearance(result, (0.1, 0.4), 0.2, "floor"),
            CaseError,
            'must be of the "frame" or the "ground", got',
        ),
        (
            lambda result: chamber_clearance(result, (np.nan, 0.4), 0.2),
            CaseError,
            r"radii and depth must be positive, got ring \(nan, 0.4\) m and opening 0.2 m",
        ),
        (
            lambda result: sensor_orders(result, "mount_1_travel_x"),
            CaseError,
            "must be recorded, this run did not",
        ),
        (
            lambda result: draw_histories(result, ["mount_1_travel_x"]),
            CaseError,
            "must be recorded, this run did not",
        ),
        (
            lambda result: QUANTITIES["resonance_time"].measure(result, 1.0),
            ResultError,
            "has rigid mounts and passes no resonance",
        ),
        (lambda result: result.snapshots[20], IndexError, "snapshot 20: the result holds 20"),
    ],
)
def test_a_reading_that_a_result_does_not_have_is_refused(run, act, error, text):
    with pytest.raises(error, match=text):
        act(run)


def test_rods_that_are_not_six_are_counted(run):
    with pytest.raises(CaseError, match="must be six, the case has"):
        yoke_rods(run)


def written(path, names=("time",), snapshot=None):
    """Write a complete result of these series, all zero but the time."""
    recorder = Recorder.create(path, load_case("numill").to_toml(), {}, list(names), 100.0)
    rows = np.zeros((200, len(names)))
    rows[:, 0] = np.arange(200) / 100.0
    recorder.append(rows)
    if snapshot:
        recorder.snapshot(1.0, snapshot)
    recorder.state("complete")
    recorder.close()
    return path


def test_a_closed_result_is_not_read(tmp_path):
    result = open_result(written(tmp_path / "a.h5"))
    result.close()
    with pytest.raises(ResultError, match=r"has been closed\. Open it again"):
        _ = result.provenance


@pytest.mark.parametrize("quantity", ["charge_radial", "momentum_gap"])
def test_a_quantity_of_the_charge_needs_one(tmp_path, quantity):
    with (
        open_result(written(tmp_path / "a.h5")) as result,
        pytest.raises(ResultError, match=r"has no charge\. Run a configuration with"),
    ):
        QUANTITIES[quantity].measure(result, 1.0)


def test_snapshots_without_sizes_are_not_drawn(tmp_path):
    snapshot = {
        "positions": np.zeros((2, 3), np.float32),
        "body_positions": np.zeros((1, 3)),
        "body_attitudes": np.zeros((1, 4)),
    }
    path = written(tmp_path / "a.h5", ("time", "crank_angle"), snapshot)
    with (
        open_result(path) as result,
        pytest.raises(ResultError, match="must keep the radii of the particles"),
    ):
        chosen_snapshots(result)


# ---- damaged results


def without_checksums(path):
    """Make a result one of format 1, whose content is not compared with checksums."""
    with h5py.File(path, "r+") as file:
        for name in COPIES:
            del file[name]
        file.attrs["format_version"] = 1


def replaced(name, make):
    """Return a change of a file: the object `name` is deleted, and `make` puts something else there."""

    def change(file):
        del file[name]
        make(file)

    return change


def unreadable_attribute(file):
    del file.attrs["format"]
    scalar = h5py.h5s.create(h5py.h5s.SCALAR)
    h5py.h5a.create(file.id, b"format", h5py.h5t.UNIX_D32LE, scalar)


ANGLE = "series/crank_angle"
DAMAGE = [
    (replaced("provenance", lambda file: file.create_dataset("provenance", data=1.0)), "it is no group"),
    (replaced("case", lambda file: None), "it is missing"),
    (replaced(ANGLE, lambda file: file.create_group(ANGLE)), "it is no dataset"),
    (
        replaced(ANGLE, lambda file: file.create_dataset(ANGLE, data=np.zeros(200, [("a", "f8")]))),
        "neither numbers nor text",
    ),
    (lambda file: file[ANGLE].resize((10,)), r"it must hold 200 numbers, its shape is \(10,\)"),
    (
        lambda file: file["series"].attrs.__setitem__("names", "time"),
        "its attribute names must list the series",
    ),
    (
        lambda file: file["snapshots/time"].__setitem__(0, np.nan),
        "it holds times that are no numbers",
    ),
    (
        lambda file: file["snapshots/positions"].resize(0, axis=0),
        r"it needs 1 moments, its shape is \(0, 2, 3\)",
    ),
    (unreadable_attribute, r"its root attributes are damaged \("),
    (
        lambda file: file.create_group("a/b/c/d/e/f/g/h/i/j"),
        r"its groups cannot be listed \(.* stands in more than",
    ),
]


@pytest.mark.parametrize(("change", "text"), DAMAGE)
def test_damage_is_named(tmp_path, change, text):
    path = written(tmp_path / "a.h5", ("time", "crank_angle"), {"positions": np.zeros((2, 3), np.float32)})
    without_checksums(path)
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises((DamagedError, ResultError), match=text), open_result(path) as result:
        _ = result.case_text, result.provenance, result.series, result.snapshots[0]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda file: file["series"].attrs.modify("new", 1), "its attributes differ from their checksum"),
        (
            replaced(ANGLE, lambda file: file.create_dataset(ANGLE, data=np.zeros(200, "i8"))),
            r"it must hold <f8 \(200,\), got <i8 \(200,\)",
        ),
    ],
)
def test_content_that_differs_from_its_checksum_is_named(tmp_path, change, text):
    path = written(tmp_path / "a.h5", ("time", "crank_angle"))
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(DamagedError, match=text), open_result(path) as result:
        _ = result.series
    done = CliRunner().invoke(app, ["verify", str(path)])
    assert "is damaged. Copy it again, or run the case again" in " ".join(done.output.split())


def test_a_size_beyond_the_memory_is_damage(tmp_path, monkeypatch):
    def exhausted(thing):
        raise MemoryError

    with open_result(written(tmp_path / "a.h5")) as result:
        monkeypatch.setattr(archive, "plain_attributes", exhausted)
        with pytest.raises(DamagedError, match="it claims more memory than there is"):
            _ = result.provenance


def test_a_record_has_its_columns_once_and_time_first(tmp_path):
    with pytest.raises(CaseError) as refused:
        Recorder.create(tmp_path / "a.h5", "", {}, ["crank_angle", "crank_angle"], 1.0)
    assert "must begin with time" in str(refused.value)
    assert "must be named once, is named twice" in str(refused.value)
    recorder = Recorder.create(tmp_path / "b.h5", "", {}, ["time"], 1.0)
    with pytest.raises(ValueError, match="1 columns, one per name, got shape"):
        recorder.append(np.zeros((3, 2)))
    recorder.close()


# ---- measured tests


@pytest.mark.parametrize(
    ("name", "content", "mapping", "text"),
    [
        (
            "test.mat",
            b"MATLAB 7.3 MAT-file",
            'rate = "100 Hz"\n[channel.driveshaft_torque]\ncolumn = "M"\nunit = "N m"',
            "needs a MAT file of version 7 or earlier, got version 7.3",
        ),
        (
            "test.csv",
            b"t,M\n0,1\n1,1\n",
            'time = "t"\n[channel.largest_pair_overlap]\ncolumn = "M"\nunit = "N"',
            'must be "1", got "N"',
        ),
    ],
)
def test_a_measured_file_that_is_not_read_is_refused(tmp_path, name, content, mapping, text):
    (tmp_path / name).write_bytes(content)
    (tmp_path / "map.toml").write_text(mapping)
    with pytest.raises(CaseError, match=text):
        import_test(tmp_path / name, tmp_path / "map.toml", tmp_path / "out.h5")


def test_channels_whose_clocks_do_not_meet_are_refused(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    parts = [
        nptdms.ChannelObject("a", name, np.ones(10), {"wf_increment": 0.1, "wf_start_offset": start})
        for name, start in (("M", 0.0), ("F", 100.0))
    ]
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        writer.write_segment(parts)
    (tmp_path / "map.toml").write_text(
        '[channel.driveshaft_torque]\ncolumn = "M"\nunit = "N m"\n'
        '[channel.crank_pin_force_resultant]\ncolumn = "F"\nunit = "N"'
    )
    with pytest.raises(CaseError, match="its channels have no time in common"):
        import_test(tmp_path / "a.tdms", tmp_path / "map.toml", tmp_path / "out.h5")


# ---- studies

PAPER = """
schema = 1
short = "Paper"
citation = "A. Author, A paper, 2026"
[configurations.empty]
title = "empty"
set = ["charge.kind=none"]
speeds = ["600 rpm"]
[[rows]]
id = "force"
quantity = "force"
configuration = "empty"
speed = "600 rpm"
source = "Table 1"
[[figures]]
number = "1"
title = "Run-up"
form = "transient"
configuration = "empty"
speed = "600 rpm"
"""


def test_a_speed_that_a_configuration_does_not_have_is_refused():
    with pytest.raises(CaseError, match="quick must be among speeds, got 700 rpm"):
        parse_paper(
            PAPER.replace('speeds = ["600 rpm"]', 'speeds = ["600 rpm"]\nquick = ["700 rpm"]'), "p.toml"
        )


def test_a_figure_of_a_run_that_is_missing_names_it(tmp_path):
    paper = parse_paper(PAPER, "p.toml")
    with pytest.raises(ResultError, match="empty-600rpm is missing"):
        draw_figure(paper.figures[0], paper, planned_runs(paper, tmp_path), {})


def test_the_short_table_does_not_go_into_a_file_that_is_no_text(tmp_path):
    (tmp_path / "README.md").write_bytes(b"\xff\xfe\x00")
    done = SimpleNamespace(findings=[], paper=read_paper("mca2026"))
    with pytest.raises(CaseError, match="is not a text file"):
        write_tables(tmp_path / "README.md", done, "mca2026")


def test_a_fit_without_a_number_ends(tmp_path):
    case = load_case("numill", ["mechanism.mounting=rigid", "charge.kind=none"])
    target = fit.Target(99, case, 1.0, 0.1, "natural frequency 99", "Hz")
    with pytest.raises(StepError, match="fit: natural frequency 99 has no steady mean"):
        fit.computed([{}], [target], tmp_path, lambda: None)


def test_the_exit_code_of_a_silent_process_is_reported(monkeypatch):
    monkeypatch.setattr(workers, "PROGRAM", "sys.exit(7)")
    task = Task("run", "", "a", "a.h5")
    with pytest.raises(workers.WorkerError, match="its process ended with code 7"):
        workers.LocalProcesses(1).submit(task).result()


def test_a_scheduler_that_does_not_answer_is_named(monkeypatch):
    distributed = pytest.importorskip("distributed")

    def refused(*_, **__):
        raise OSError("refused")

    monkeypatch.setattr(distributed, "Client", refused)
    with pytest.raises(CaseError, match='no scheduler answers at "tcp://mill:8786": refused'):
        workers.cluster_client("tcp://mill:8786", None)
