"""A run that stops and goes on is the run that never stopped; a run that fails says why and keeps what it
has.
"""

import os
import re
import shutil
import signal

import numpy as np
import pytest

from nutamill.analysis.replay import chosen_snapshots, replay
from nutamill.base.errors import CaseError, ResultError, StepError
from nutamill.case import load_case
from nutamill.simulation import entry, march, runs
from nutamill.simulation.setup.particles import particle_count

OVERRIDES = [
    "mechanism.mounting=rigid",
    "charge.mass=0.05 kg",
    "drive.ramp=10000 rpm/s",
    "run.until=20 ms",
    "run.checkpoint=5 ms",
    "run.threads=1",
]


@pytest.fixture
def case():
    """98 pellets, 20 ms, a checkpoint every 5 ms."""
    return load_case("numill", OVERRIDES)


def bed(case, *_):
    """Return one layer of pellets on the floor: a settled bed would take longer than the run."""
    n = particle_count(case.machine)
    rows = np.arange(10) * 0.0055 - 0.02475
    places = np.stack(np.meshgrid(rows, rows, [0.240 - 0.3475]), axis=-1).reshape(-1, 3)
    return places[:n] if n else None


def quick_start(patch):
    """Begin runs with that layer, and report at every entry."""
    patch.setattr(runs, "settled_bed", bed)
    patch.setattr("nutamill.simulation.progress.PAUSE", 0.0)


@pytest.fixture(autouse=True)
def lattice(monkeypatch):
    """The tests of this file begin with one layer of pellets."""
    quick_start(monkeypatch)


@pytest.fixture(scope="module")
def whole_file(tmp_path_factory):
    """The file of the run of `case` that never stopped; it is read only."""
    path = tmp_path_factory.mktemp("whole") / "whole.h5"
    with pytest.MonkeyPatch.context() as patch:
        quick_start(patch)
        runs.run(load_case("numill", OVERRIDES), path).close()
    return path


@pytest.fixture(scope="module")
def whole(whole_file):
    """Series, last state and end of the run that never stopped."""
    return numbers(runs.open_result(whole_file))


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory):
    """The file of the same run, interrupted at its first report, and the time of that report [s]."""
    path, asked = tmp_path_factory.mktemp("parts") / "parts.h5", []

    def interrupt(progress):
        asked.append(progress.time)
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.MonkeyPatch.context() as patch:
        quick_start(patch)
        with pytest.raises(KeyboardInterrupt):
            runs.run(load_case("numill", OVERRIDES), path, while_marching(interrupt))
    return path, asked[0]


@pytest.fixture(scope="module")
def resumed(interrupted):
    """The file of the run that was interrupted and went on to its end."""
    path = shutil.copy(interrupted[0], interrupted[0].with_name("resumed.h5"))
    runs.resume(path).close()
    return path


def while_marching(act):
    """A progress callback that calls `act` at each report of the march itself."""
    return lambda progress: act(progress) if progress.phase in ("ramp", "steady") else None


@pytest.fixture
def states(monkeypatch):
    """The states that `run` builds, for a test to meddle with."""
    built, build = [], runs.build

    def keep(*args):
        model, state, scratch = build(*args)
        built.append(state)
        return model, state, scratch

    monkeypatch.setattr(runs, "build", keep)
    return built


def numbers(result):
    """All series of a result, (n_names, n_rows), and its last checkpoint as bytes."""
    with result:
        series = result.series
        checkpoint = result.checkpoint()
        bits = {
            f"{part}/{name}": array.tobytes()
            for part, arrays in checkpoint.groups.items()
            for name, array in arrays.items()
        }
        return np.vstack([series["time"], *(series[name] for name in series)]), bits, result.state


def same(one, other):
    """Bit for bit the same series and the same last state."""
    return np.array_equal(one[0], other[0]) and one[1] == other[1] and one[2] == other[2] == "complete"


class Stop(BaseException):
    """Stands for a process that dies: no handler of exceptions sees it."""


def test_run_that_is_interrupted_and_resumed_is_the_run_that_was_not(interrupted, resumed, whole):
    path, asked = interrupted
    with runs.open_result(path) as parts:
        assert parts.state == "interrupted"
        assert 0 < parts.series.sizes["time"] < whole[0].shape[1]
        assert parts.checkpoint().time == parts.series["time"][-1] == asked
    assert same(numbers(runs.open_result(resumed)), whole)
    assert whole[0].shape[1] == 97  # 20 ms at 4800 Hz, and the start


def test_run_that_is_killed_goes_on_from_its_last_checkpoint(case, whole, tmp_path, monkeypatch):
    monkeypatch.setattr("nutamill.result.recorder.FIRST_PAUSE", 0.0)
    monkeypatch.setattr("nutamill.result.recorder.COMMIT_SHARE", np.inf)

    def die(progress):
        raise Stop

    with pytest.raises(Stop):
        runs.run(case, tmp_path / "killed.h5", while_marching(die))
    with runs.open_result(tmp_path / "killed.h5") as killed:
        assert killed.state == "running"
        assert killed.checkpoint().time == pytest.approx(5e-3, abs=1e-9)
    assert same(numbers(runs.resume(tmp_path / "killed.h5")), whole)


def test_slow_run_that_is_killed_loses_no_more_than_the_longest_time_unsaved(case, tmp_path, monkeypatch):
    seldom = case.with_("run.checkpoint", 1.0)
    whole = runs.run(seldom, tmp_path / "whole.h5")
    for name, value in (("recorder.FIRST_PAUSE", 0.0), ("recorder.COMMIT_SHARE", np.inf)):
        monkeypatch.setattr(f"nutamill.result.{name}", value)
    monkeypatch.setattr(march, "LONGEST_UNSAVED", 0.0)

    def die(progress):
        if progress.time > 0.015:
            raise Stop

    with pytest.raises(Stop):
        runs.run(seldom, tmp_path / "killed.h5", while_marching(die))
    with runs.open_result(tmp_path / "killed.h5") as killed:
        # the run is entered for 10 ms at a time
        assert killed.checkpoint().time == pytest.approx(10e-3, abs=1e-9)
    times = whole.statistics["time"].values
    assert same(numbers(runs.resume(tmp_path / "killed.h5")), numbers(whole))
    with runs.open_result(tmp_path / "killed.h5") as resumed:
        assert np.array_equal(resumed.statistics["time"].values, times)


def test_statistics_of_a_run_that_was_resumed_are_those_of_the_whole_run(resumed, whole_file):
    with runs.open_result(whole_file) as whole, runs.open_result(resumed) as parts:
        one, other = whole.statistics, parts.statistics
    assert one.drop_attrs().identical(other.drop_attrs())
    assert one["time"].values == pytest.approx([0.0, 0.005, 0.010, 0.015, 0.020])
    # every one of 98 pellets was in some cell at each of 96 rows, and met the floor
    assert float(one["cell_particles"][-1].sum()) == pytest.approx(98 * 96 / 4800)
    assert float(one["impact_number"][-1].sel(pair="steel-acrylic wall", part="normal").sum()) >= 98


def test_run_without_statistics_is_the_same_run(case, whole, tmp_path):
    without = runs.run(case.with_(run__statistics=False), tmp_path / "without.h5")
    with pytest.raises(ResultError, match="holds no statistics of the charge"):
        _ = without.statistics
    assert np.array_equal(numbers(without)[0], whole[0])


def test_repeated_windows_book_their_impacts_once(tmp_path):
    # an iterated run marches a window again when its impacts move the chamber; a contact begins in every pass
    # and counts once.
    # The mounts must give, or nothing moves; booked in every pass, the impacts here would be twice as many.
    violent = load_case("numill", [*OVERRIDES, "mechanism.mounting=flexible", "drive.ramp=100000 rpm/s"])
    with runs.run(violent.with_(run__coupling="iterated"), tmp_path / "a.h5") as iterated:
        impacts = float(iterated.statistics["impact_number"][-1].sel(part="normal").sum())
        assert iterated.summary["passes"] > 1.1 * iterated.summary["windows"]
    with runs.run(violent, tmp_path / "b.h5") as staggered:
        once = float(staggered.statistics["impact_number"][-1].sel(part="normal").sum())
    # the two motions differ by the coupling's error: a tenth of the impacts is far more, and far less than
    # twice
    assert impacts == pytest.approx(once, rel=0.1)


def test_run_whose_callback_raises_keeps_what_it_has_recorded(case, tmp_path):
    def trip(progress):
        raise ValueError("the screen is gone")

    with pytest.raises(ValueError, match="the screen is gone"):
        runs.run(case, tmp_path / "a.h5", while_marching(trip))
    with runs.open_result(tmp_path / "a.h5") as partial:
        assert partial.state == "failed: the screen is gone"
        assert partial.series.sizes["time"] > 1


@pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="needs a system with SIGUSR1")
def test_signal_keeps_a_checkpoint_at_once_and_the_run_goes_on(case, tmp_path):
    seldom, path, asked, times = (
        case.with_(run__checkpoint=1.0, run__until=0.03),
        tmp_path / "a.h5",
        [],
        [],
    )

    def ask(progress):
        if asked and not times:
            with runs.open_result(path) as so_far:
                times.append(so_far.checkpoint().time)
        elif not asked:
            asked.append(progress.time)
            signal.raise_signal(signal.SIGUSR1)

    whole = numbers(runs.run(seldom, tmp_path / "whole.h5"))
    assert same(numbers(runs.run(seldom, path, while_marching(ask))), whole)
    assert times == [pytest.approx(asked[0], abs=1e-9)]


def test_an_end_before_the_checkpoint_is_refused_and_the_file_stays(whole, whole_file, tmp_path):
    path = shutil.copy(whole_file, tmp_path / "a.h5")
    with pytest.raises(CaseError, match=r"not later than the checkpoint at 0\.02 s, got 0\.01 s"):
        runs.resume(path, until=0.010)
    assert same(numbers(runs.open_result(path)), whole)


def test_a_prescribed_motion_feels_nothing_of_the_charge(case, states, tmp_path):
    runs.run(case.with_(run__coupling="prescribed"), tmp_path / "a.h5").close()
    assert not states[0].mechanism.wrench.any()
    assert not states[0].coupling.mechanism_impulse.any()
    assert states[0].coupling.charge_impulse.any()


def test_run_that_is_continued_beyond_its_end_is_the_longer_run(case, whole, tmp_path):
    runs.run(case.with_(run__until=0.010), tmp_path / "short.h5").close()
    assert same(numbers(runs.resume(tmp_path / "short.h5", until=0.020)), whole)


def test_series_do_not_depend_on_the_number_of_threads(case, whole, tmp_path):
    two = numbers(runs.run(case.with_(run__threads=2), tmp_path / "2.h5"))
    assert np.array_equal(whole[0], two[0])


def test_run_of_other_kernels_is_not_continued(whole_file, tmp_path, monkeypatch):
    old = shutil.copy(whole_file, tmp_path / "old.h5")
    monkeypatch.setattr(runs, "kernel_digest", lambda: "0" * 64)
    with pytest.raises(ResultError, match="the run was begun with other kernels"):
        runs.resume(old, until=0.030)


def test_ledger_and_interface_of_a_run_close(case, whole_file):
    # The ledger's bound is the project's, 0.1 %, of all energy that came in. Contact forces are of single
    # precision: each of the
    # 98 pellets rounds its few contacts once a substep, 2^-24 of a force; together the forces carry the
    # weight and the swing,
    # m (g t + v) with the crank's speed.
    with runs.open_result(whole_file) as result:
        series = result.series
        received = np.abs(series["motor_work"]).max() + np.ptp(series["potential_energy"].values)
        assert np.abs(series["ledger_residual"]).max() < 1e-3 * received
        momentum = 0.05 * (9.81 * 0.020 + 2 * case.drive.speed * 0.039)
        assert series["interface_impulse_defect"].max() < 98 * 2.0**-24 * momentum
        assert series["wall_contacts"].max() > 50


def failed(case, path, meddle):
    """The message of a run that fails because `meddle` spoils it while it runs, and the series left in its
    file.
    """
    with pytest.raises(StepError) as raised:
        runs.run(case, path, while_marching(meddle))
    with runs.open_result(path) as result:
        assert result.state == f"failed: {raised.value}"
        return str(raised.value), result.series


def test_pellet_whose_place_is_no_number_stops_the_run_and_is_named(case, tmp_path, states):
    def lose(_):
        charge = states[-1].charge
        charge.v[0, np.flatnonzero(charge.ids == 17)[0]] = np.nan

    message, series = failed(case, tmp_path / "lost.h5", lose)
    assert re.search(
        r"particle 17, at 0\.\d+ m/s, left the chamber, or its position is not a number", message
    )
    assert "try run.dt" in message
    assert series.sizes["time"] == 49 and np.all(
        np.isfinite(series["crank_pin_force_radial"])
    )  # 10 ms and the start


def test_pellet_that_sinks_too_deep_into_a_wall_stops_the_run_and_is_named(case, tmp_path, states):
    def shoot(_):
        charge = states[-1].charge
        charge.v[2, np.flatnonzero(charge.ids == 44)[0]] = -40.0

    message, series = failed(case, tmp_path / "deep.h5", shoot)
    # it has lost to the soft wall up to k d^2/2, d 40 % of the diameter; stopped soon after 40 %
    assert re.search(
        r'particle 44, at 3\d\.?\d* m/s, overlaps surface "floor", there at 0\.\d+ m/s, by 4', message
    )
    assert "overlap_stop" in message
    assert series.sizes["time"] >= 49


def test_state_before_a_failure_is_in_the_file_and_runs_into_the_same_failure_again(case, tmp_path, states):
    path = tmp_path / "deep.h5"

    def shoot(_):
        charge = states[-1].charge
        charge.v[2, np.flatnonzero(charge.ids == 55)[0]] = -25.0

    message, series = failed(case, path, shoot)
    bad = float(re.search(r"t = (\S+) s", message)[1])
    with runs.open_result(path) as result:
        checkpoint = result.checkpoint()
        at = checkpoint.time
        snapshot = result.snapshots[-1]
        assert result.snapshots.time[-1] == at
    # an entry is 48 rows: the state is sound, at most 10 ms old, and the pellet is where it was before it hit
    assert bad - march.ROWS_PER_ENTRY / case.run.series_rate < at < bad
    assert all(
        np.isfinite(array).all() for array in checkpoint.groups["charge"].values() if array.dtype.kind == "f"
    )
    assert snapshot["velocities"][55, 2] == pytest.approx(-25.0, abs=1e-5)
    with pytest.raises(StepError) as again:
        runs.resume(path)
    assert str(again.value) == message
    with runs.open_result(path) as result:
        assert np.array_equal(result.series["time"], series["time"])


def test_mechanism_that_is_no_longer_finite_stops_the_run(case, tmp_path, states):
    def shake(_):
        states[-1].mechanism.velocity[0, 0] = np.inf

    message, _ = failed(case.with_(charge__kind="none"), tmp_path / "inf.h5", shake)
    assert "the motion of the mechanism is not finite" in message
    assert "The last snapshot and checkpoint of the file are the state before it, at t = " in message


def test_lists_that_grow_during_a_run_do_not_change_it(case, whole, tmp_path, monkeypatch):
    grown, grow = [], entry.grow

    def count(*charge):
        grown.append(charge)
        return grow(*charge)

    monkeypatch.setattr(entry, "grow", count)
    monkeypatch.setattr("nutamill.charge.arrays.PADDING", 0)
    monkeypatch.setattr("nutamill.charge.assembly.CANDIDATES_PER_PARTICLE", 1)
    tight = numbers(runs.run(case, tmp_path / "tight.h5"))
    assert grown
    assert np.array_equal(tight[0], whole[0])


def test_snapshot_says_that_the_floor_pushes_a_resting_pellet_by_its_weight(case, tmp_path):
    """On a floor tilted by 6 deg friction (0.2) holds it.  The bounces of the start have died after 20 ms
    (thirty contact times); the force is read from velocities in single precision, with the tilt's 1 mm/s or
    so: 2^-24 x 2/dt x v x m, and a hundredth left over.
    """
    still = case.with_(drive__speed="1 rpm", drive__ramp="1 rpm/s")
    with runs.run(still, tmp_path / "rest.h5") as result:
        snapshot = result.snapshots[-1]
        weight = 7863.7 * 4 / 3 * np.pi * 0.0025**3 * 9.81
        assert np.abs(snapshot["contact_forces"] / weight - 1.0).max() < 0.02
        assert not snapshot["materials"].any()
        # the replay finds the nutation point by the bearing cross: the floor is its depth away, along the
        # chamber's axis
        pose = next(replay(result, chosen_snapshots(result, 1))).bodies["chamber"]
        assert np.allclose(pose.origin - 0.350 * pose.rotation[:, 2], snapshot["chamber_floor"], atol=1e-9)
