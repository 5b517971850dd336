"""The series of a result as one table: CSV for spreadsheets, Parquet for pandas and other libraries."""

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from nutamill.base.atomic_file import check_writable, replace_file, write_whole
from nutamill.base.errors import ResultError, missing_extra
from nutamill.result import Result

CSV, PARQUET = (".csv",), (".parquet",)
"""Ends of the names of the files."""
DIGITS = "%.9g"
"""Form of a number in a CSV file."""


def write_csv(result: Result, path: str | Path, series: Sequence[str] = ()) -> Path:
    """Write series as CSV, one row for each sample, and return the path.

    The first line holds the names with their units, ``driveshaft_torque [N m]``; numbers are in SI.

    Parameters
    ----------
    series : names of the series, all if empty; the time is always the first column

    Raises
    ------
    CaseError : a name that does not end with .csv
    ResultError : a series that the result does not hold, or the file cannot be written
    """
    path = Path(path)
    check_writable(path, CSV)
    columns = _columns(result, series)
    units = {name: result.series[name].attrs.get("units", "1") for name in columns}
    text = io.StringIO()
    text.write(",".join(f"{name} [{units[name]}]" for name in columns) + "\n")
    np.savetxt(text, np.column_stack(list(columns.values())), fmt=DIGITS, delimiter=",")
    return write_whole(path, text.getvalue())


def write_parquet(result: Result, path: str | Path, series: Sequence[str] = ()) -> Path:
    """Write series as Parquet, one row for each sample, and return the path.

    Each column carries its ``units`` and ``long_name`` as metadata.  Parameters and errors are those of
    `write_csv`, and NotInstalledError without pyarrow.
    """
    path = Path(path)
    check_writable(path, PARQUET)
    columns = _columns(result, series)
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as fault:
        raise missing_extra(f"{path}: a Parquet file", "pyarrow", "parquet") from fault
    fields = [
        pyarrow.field(
            name,
            pyarrow.from_numpy_dtype(values.dtype),
            metadata={key: str(result.series[name].attrs.get(key, "")) for key in ("units", "long_name")},
        )
        for name, values in columns.items()
    ]
    arrays = [pyarrow.array(values) for values in columns.values()]
    table = pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields))

    def fill(part: Path) -> None:
        pyarrow.parquet.write_table(table, part)

    replace_file(path, fill, room=table.nbytes, start=b"")
    return path


def _columns(result: Result, series: Sequence[str]) -> dict[str, np.ndarray]:
    """Return the columns of the table by name, the time first."""
    known = [str(name) for name in result.series.data_vars]
    for name in series:
        if name not in known:
            raise ResultError(
                f"{result.path}: has no series {name}. `nutamill info fields` lists all series."
            )
    chosen = ["time", *(name for name in (series or known) if name != "time")]
    return {name: result.series[name].values for name in chosen}
