"""Test files of every kind come in with their units and clocks, and lie over a run."""

import math

import numpy as np
import pytest
from typer.testing import CliRunner

from nutamill import cli
from nutamill.analysis.measured_comparison import compare, comparison_lines, low_pass
from nutamill.analysis.measured_import import import_test
from nutamill.analysis.measured_mapping import load_mapping
from nutamill.base.errors import CaseError, MillError
from nutamill.result import open_result
from nutamill.view.figures.measured import draw_comparison

RATE = 2000.0
TIME = np.arange(2000) / RATE
TORQUE = 9.9 + np.sin(2 * 60.0 * TIME)
FORCE = 770.0 + 20.0 * np.cos(2 * 60.0 * TIME)
MAPPING = """
time = "t"
speed = "60 rad/s"
[channel.driveshaft_torque]
column = "Mz"
unit = "N mm"
sensor = "torque flange"
[channel.crank_pin_force_resultant]
column = "F"
unit = "kN"
factor = -1.0
"""
UNCLOCKED = MAPPING.replace('time = "t"\n', "")


def mapping(folder, text=MAPPING):
    path = folder / "map.toml"
    path.write_text(text)
    return path


def write_csv(folder):
    path = folder / "test.csv"
    rows = [
        f"{t:.6f};{1e3 * torque:.6f};{-1e-3 * force:.9f}"
        for t, torque, force in zip(TIME, TORQUE, FORCE, strict=True)
    ]
    path.write_text("bench 3, test 12\nt;Mz;F\n" + "\n".join(rows) + "\n")
    return path, 'skip = 1\nseparator = ";"' + MAPPING


def write_mat(folder):
    from scipy.io import savemat

    path = folder / "test.mat"
    savemat(path, {"t": TIME, "data": np.column_stack([1e3 * TORQUE, -1e-3 * FORCE])})
    return path, MAPPING.replace('"Mz"', '"data(1)"').replace('"F"', '"data(2)"')


def write_tdms(folder):
    nptdms = pytest.importorskip("nptdms", reason='needs npTDMS, of the extra "daq"')
    path = folder / "test.tdms"
    clock = {"wf_increment": 1 / RATE, "wf_start_offset": 0.0}
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject("bench", "Mz", 1e3 * TORQUE, clock),
                nptdms.ChannelObject("bench", "F", -1e-3 * FORCE, clock),
            ]
        )
    return path, UNCLOCKED.replace('"F"', '"bench/F"')


def write_uff(folder):
    pyuff = pytest.importorskip("pyuff", reason='needs pyuff, of the extra "daq"')
    path = folder / "test.uff"
    for name, values in (("Mz", 1e3 * TORQUE), ("F", -1e-3 * FORCE)):
        given = {
            "id1": name,
            "func_type": 1,
            "ord_data_type": 4,
            "num_pts": len(TIME),
            "abscissa_spacing": 1,
            "abscissa_inc": 1 / RATE,
        }
        empty = pyuff.prepare_58(id1=name, return_full_dict=True)
        fields = {key: "NONE" if key[:2] == "id" or key[-3:] in ("lab", "ame") else 0 for key in empty}
        fields |= given | {"type": 58, "binary": 0, "data": values, "x": TIME}
        pyuff.UFF(str(path)).write_sets(fields, "add")
    return path, UNCLOCKED


@pytest.mark.external
def test_a_spectrum_in_a_uff_file_is_refused_as_no_record_over_time(tmp_path):
    pyuff = pytest.importorskip("pyuff", reason='needs pyuff, of the extra "daq"')
    path, text = write_uff(tmp_path)
    given = pyuff.UFF(str(path)).read_sets(1)
    given |= {"ord_data_type": 5, "data": given["data"] * (1.0 + 1.0j)}
    pyuff.UFF(str(path)).write_sets(given, "overwrite")
    with pytest.raises(CaseError, match="F: must be a record over time, got complex numbers"):
        import_test(path, mapping(tmp_path, text), tmp_path / "m.h5")


@pytest.mark.parametrize(
    "write",
    [
        write_csv,
        write_mat,
        pytest.param(write_tdms, marks=pytest.mark.external),
        pytest.param(write_uff, marks=pytest.mark.external),
    ],
)
def test_file_of_each_kind_comes_in_with_its_units_signs_and_clock(tmp_path, write):
    path, text = write(tmp_path)
    with open_result(import_test(path, mapping(tmp_path, text), tmp_path / "m.h5")) as test:
        assert test.state == "measured"
        assert test.rate == pytest.approx(RATE, rel=1e-6)
        # the texts of CSV and UFF hold six digits and more
        assert np.abs(test.series["driveshaft_torque"].values - TORQUE).max() < 2e-6 * 11
        assert np.abs(test.series["crank_pin_force_resultant"].values - FORCE).max() < 1e-6 * 790
        assert np.abs(test.series["crank_angle"].values - 60.0 * test.series["time"].values).max() < 1e-6
        assert "torque flange" in test.provenance["sensor driveshaft_torque"]


def test_run_and_test_are_averaged_alike_and_the_error_is_that_of_the_run(filmed, tmp_path):
    """The film: 9 + sin N m and 700 + 20 cos N; the test: 9.9 and 770.  Whole turns to a sample: 1/100 of the
    swing at most.
    """
    path, text = write_csv(tmp_path)
    with open_result(import_test(path, mapping(tmp_path, text), tmp_path / "m.h5")) as test:
        rows = {row.name: row for row in compare(filmed, test, 3.0)}
        torque, force = rows["driveshaft_torque"], rows["crank_pin_force_resultant"]
        assert (torque.run, torque.test) == pytest.approx((9.0, 9.9), abs=0.01)
        assert (force.run, force.test) == pytest.approx((700.0, 770.0), abs=0.2)
        assert torque.error == pytest.approx(9.0 / 9.9 - 1.0, abs=2e-3)
        assert (torque.run_rms, torque.test_rms) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)), abs=0.01)
        assert "-9.1 %" in comparison_lines(list(rows.values()))[1] + comparison_lines(list(rows.values()))[2]
        draw_comparison(filmed, test, list(rows), 3.0, 100.0).savefig(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 10_000


def test_run_in_the_place_of_a_test_is_refused(filmed):
    with pytest.raises(CaseError, match="is a run, not measured data"):
        compare(filmed, filmed, 3.0)


def test_show_of_a_test_gives_the_means_of_its_channels_and_report_says_what_it_is(tmp_path, monkeypatch):
    path, text = write_csv(tmp_path)
    import_test(path, mapping(tmp_path, text), tmp_path / "m.h5")
    monkeypatch.chdir(tmp_path)
    shown = CliRunner().invoke(cli.app, ["show", "m.h5"]).stdout
    assert (
        f"driveshaft_torque          mean {TORQUE.mean():.4g}, r.m.s. about it {TORQUE.std():.4g} N m"
        in shown
    )
    refused = CliRunner().invoke(cli.app, ["report", "m.h5"])
    assert (refused.exit_code, refused.stderr.split(". ")[0]) == (
        2,
        "m.h5: holds measured data, not the result of a run",
    )


def test_filter_keeps_what_is_slow_in_its_place_and_takes_what_is_fast():
    """Butterworth of fourth order, forth and back: 1/(1 + (f/f_c)^8); at a fifth and at five times the
    cut-off 2.6e-6 is lost and left."""
    slow, fast = np.sin(math.tau * 10.0 * TIME), np.sin(math.tau * 250.0 * TIME)
    passed = low_pass(slow + fast, RATE, 50.0)[400:-400]
    assert np.abs(passed - slow[400:-400]).max() < 1e-4  # and what the bilinear transform bends
    with pytest.raises(CaseError, match="half the rate"):
        low_pass(slow, RATE, 1000.0)


def test_clock_of_the_test_is_moved_by_the_offset(tmp_path):
    path, text = write_csv(tmp_path)
    with open_result(
        import_test(path, mapping(tmp_path, 'offset = "-0.25 s"\n' + text), tmp_path / "m.h5")
    ) as test:
        assert test.series["time"].values[0] == pytest.approx(-0.25)


@pytest.mark.parametrize(
    ("wrong", "right", "says"),
    [
        (
            '"N mm"',
            '"Nmm2"',
            r'map\.toml.*channel\.driveshaft_torque\.unit: unknown unit "N mm2"\. Did you mean "N mm"',
        ),
        ('"kN"', '"J"', r'"1 J" is an energy, this needs a force'),
        ("driveshaft_torque]", "driveshaft_torqe]", r'no such name\. Did you mean "driveshaft_torque"'),
        ("sensor =", "senser =", r'map\.toml:\d+: .*unknown key\. Did you mean "sensor"'),
    ],
)
def test_mapping_with_a_fault_says_where_and_what_to_write(tmp_path, wrong, right, says):
    with pytest.raises(CaseError, match=says):
        load_mapping(mapping(tmp_path, MAPPING.replace(wrong, right)))


def test_column_that_is_missing_and_place_that_is_no_number_are_named(tmp_path):
    path, text = write_csv(tmp_path)
    with pytest.raises(CaseError, match=r'column Mzz: is not in the file.*Did you mean "Mz"'):
        import_test(path, mapping(tmp_path, text.replace('"Mz"', '"Mzz"')), tmp_path / "m.h5")
    lines = path.read_text().splitlines()
    lines[5] = lines[5].split(";")[0] + ";n/a;1"
    path.write_text("\n".join(lines))
    with pytest.raises(CaseError, match="column Mz: must hold numbers, row 4 of 2000 does not"):
        import_test(path, mapping(tmp_path, text), tmp_path / "m.h5")
    assert not (tmp_path / "m.h5").exists()


def test_times_that_do_not_rise_and_no_times_at_all_are_refused(tmp_path):
    path, text = write_csv(tmp_path)
    with pytest.raises(CaseError, match=r'needs times.*rate = "4800 Hz"'):
        import_test(path, mapping(tmp_path, text.replace('time = "t"\n', "")), tmp_path / "m.h5")
    path.write_text(path.read_text().replace("\n0.002000;", "\n0.000100;"))
    with pytest.raises(CaseError, match="times do not rise after sample 4"):
        import_test(path, mapping(tmp_path, text), tmp_path / "m.h5")


@pytest.mark.parametrize("ending", [".tdms", ".uff", ".mat", ".xls"])
def test_damaged_file_and_unknown_kind_are_refused(tmp_path, ending):
    path = tmp_path / f"test{ending}"
    path.write_bytes(b"no such thing\n" * 5)
    with pytest.raises((CaseError, MillError), match=r"test\.(tdms|uff|mat|xls)"):
        import_test(path, mapping(tmp_path, UNCLOCKED), tmp_path / "m.h5")


@pytest.mark.parametrize("separator", ["", ";;", "\\n"])
def test_a_separator_that_is_not_one_character_is_refused(tmp_path, separator):
    with pytest.raises(CaseError, match="separator: must"):
        load_mapping(mapping(tmp_path, f'separator = "{separator}"' + MAPPING))


def test_a_csv_file_with_an_open_quote_is_refused(tmp_path):
    path = tmp_path / "test.csv"
    path.write_text('t,Mz,F\n0,"' + "1,2\n" * 50_000)  # a cell longer than the reader takes
    with pytest.raises(CaseError, match=r"must be a whole \.csv file"):
        import_test(path, mapping(tmp_path), tmp_path / "a.h5")


def test_a_record_too_short_for_the_filter_is_refused():
    assert len(low_pass(np.ones(16), 100.0, 10.0)) == 16
    with pytest.raises(CaseError, match="--filter: needs 16 samples, got 15"):
        low_pass(np.ones(15), 100.0, 10.0)
