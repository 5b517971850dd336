"""The series of a result as a table for other programs."""

import csv

import numpy as np
import pytest
from typer.testing import CliRunner

from nutamill import cli
from nutamill.base.errors import CaseError, ExitCode, NotInstalledError, ResultError
from nutamill.view import series_table


def test_csv_holds_the_series_with_their_units_the_time_first(filmed, tmp_path):
    path = series_table.write_csv(filmed, tmp_path / "a.csv", ["driveshaft_torque"])
    head, *rows = csv.reader(path.read_text(encoding="utf-8").splitlines())
    assert head == ["time [s]", "driveshaft_torque [N m]"]
    numbers = np.array(rows, float)
    # nine digits: half a unit of the ninth, relative to the largest leading digit
    assert np.allclose(numbers[:, 1], filmed.series["driveshaft_torque"].values, rtol=5e-9, atol=0)
    assert np.allclose(numbers[:, 0], filmed.series["time"].values, rtol=5e-9, atol=0)


def test_csv_holds_every_series_where_none_is_named(filmed, tmp_path):
    path = series_table.write_csv(filmed, tmp_path / "a.csv")
    with path.open(encoding="utf-8") as file:
        assert len(next(csv.reader(file))) == 1 + len(filmed.series.data_vars) - (
            "time" in filmed.series.data_vars
        )


def test_parquet_holds_the_same_numbers_and_their_units(filmed, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason='needs the extra "parquet"')
    path = series_table.write_parquet(filmed, tmp_path / "a.parquet", ["driveshaft_torque"])
    table = parquet.read_table(path)
    assert table.column_names == ["time", "driveshaft_torque"]
    assert table.schema.field("driveshaft_torque").metadata[b"units"] == b"N m"
    assert np.array_equal(table["driveshaft_torque"].to_numpy(), filmed.series["driveshaft_torque"].values)


def test_parquet_without_its_library_names_the_extra(filmed, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(NotInstalledError, match=r'a Parquet file needs pyarrow.*pip install "\.\[parquet\]"'):
        series_table.write_parquet(filmed, tmp_path / "a.parquet")


def test_a_series_that_the_result_lacks_is_refused(filmed, tmp_path):
    with pytest.raises(ResultError, match=r"has no series nothing\. `nutamill info fields` lists all series"):
        series_table.write_csv(filmed, tmp_path / "a.csv", ["nothing"])
    with pytest.raises(CaseError, match=r"must end with \.csv"):
        series_table.write_csv(filmed, tmp_path / "a.txt")


def test_the_command_writes_beside_the_result_and_refuses_series_for_paraview(filmed):
    reply = CliRunner().invoke(cli.app, ["export", "csv", str(filmed.path), "--series", "driveshaft_torque"])
    assert reply.exit_code == 0 and filmed.path.with_suffix(".csv").is_file()
    reply = CliRunner().invoke(cli.app, ["export", "vtkhdf", str(filmed.path), "--series", "time"])
    assert reply.exit_code == 2
    assert "--series: has no use for vtkhdf, which holds snapshots" in reply.stderr


@pytest.mark.parametrize(
    "words",
    [("export", "csv", "FILE", "-s", "a=1"), ("show", "FILE", "-s", "a=1"), ("show", "FILE", "--expanded")],
)
def test_an_option_that_a_result_cannot_obey_is_refused(filmed, words):
    given = [str(filmed.path) if word == "FILE" else word for word in words]
    reply = CliRunner().invoke(cli.app, given)
    assert reply.exit_code == ExitCode.BAD_INPUT and "has no use for" in reply.stderr
