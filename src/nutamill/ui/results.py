"""Results for the page: what there is, traces, steady means side by side, and the pages of one."""

from pathlib import Path
from typing import Any

from nutamill.analysis.source import any_case_of
from nutamill.analysis.steady_table import steady
from nutamill.analysis.summary import warning_lines
from nutamill.analysis.traces import thinned, traced
from nutamill.base.errors import CaseError, Fault, MillError
from nutamill.case.titles import leaves
from nutamill.case.toml.write import toml_value
from nutamill.result import Result, open_result
from nutamill.ui.folder import Folder
from nutamill.view.report import report_page
from nutamill.view.webview import view_page

ENDS = (".h5", ".hdf5")
"""Ends of names of results."""
MOST_COMPARED = 6
"""Results that are compared at once [1]."""
ASIDE = ("title", "changed_from", "run.threads")
"""Beginnings of keys that a comparison of cases leaves out."""


def listed(folder: Folder) -> list[dict[str, Any]]:
    """Return name, title, state and end [s] of every result of the folder, the newest first."""
    rows = []
    for name in folder.listed(*ENDS):
        try:
            with open_result(folder.root / name) as result:
                title = any_case_of(result).title if result.case_text else "measured data"
                rows.append({"file": name, "title": title, "state": result.state, "end": result.reached})
        except MillError as error:
            rows.append({"file": name, "title": "", "state": str(error), "end": 0.0})
    return rows


def traces(path: Path, names: list[str] | None = None) -> dict[str, Any]:
    """Return the traces of a result, thinned to what a screen shows, and the series that there are.

    Parameters
    ----------
    path : the result file, which may still grow
    names : series; those that are drawn first if None

    Raises
    ------
    CaseError, ResultError, DamagedError : no such series, or a file that cannot be read
    """
    with open_result(path) as result:
        chosen = names or traced(result)
        fields = [result.field(name) for name in chosen]
        values = [result.series[name].values for name in chosen]
        time = result.series["time"].values
        shown = thinned(len(time), values)
        return {
            "time": time[shown].tolist(),
            "traces": [
                {"name": field.name, "label": f"{field.label} ({field.unit})", "values": one[shown].tolist()}
                for field, one in zip(fields, values, strict=True)
            ],
            "known": [str(name) for name in result.series.data_vars],
            "state": result.state,
        }


def compared(paths: list[Path]) -> dict[str, Any]:
    """Return the steady means of results side by side, their verdicts and warnings, and in what their cases
    differ.

    Raises
    ------
    CaseError : too many results, or measured data
    ResultError, DamagedError : a file that cannot be read
    """
    if not 1 <= len(paths) <= MOST_COMPARED:
        what = f"takes one result to {MOST_COMPARED}, got {len(paths)}"
        hint = "Mark fewer" if paths else "Mark one or more"
        raise CaseError(Fault("compare", what, hint))
    tables, cases, warnings, verdicts = [], [], [], []
    for path in paths:
        with open_result(path) as result:
            if not result.case_text:
                what = "holds measured data, not the result of a run"
                raise CaseError(Fault(path.name, what, "Use nutamill compare"))
            table = steady(result) if result.series.sizes["time"] else None
            cases.append(_written(result))
            tables.append(dict(table.rows()) if table is not None else {})
            verdicts.append(table.verdict if table is not None else "nothing is recorded yet")
            warnings.append(warning_lines(result) if table is not None else [])
    labels = dict.fromkeys(label for table in tables for label in table)
    keys = dict.fromkeys(key for case in cases for key in case if not key.startswith(ASIDE))
    differing = [key for key in keys if any(case.get(key) != cases[0].get(key) for case in cases)]
    return {
        "verdicts": verdicts,
        "warnings": warnings,
        "means": [{"label": label, "values": [table.get(label, "") for table in tables]} for label in labels],
        "differences": [{"label": key, "values": [case.get(key, "") for case in cases]} for key in differing],
    }


def page_of(kind: str, path: Path) -> str:
    """Return the page in which the machine turns, or the report of a result. Raise CaseError for another
    kind of page, and the errors of both.
    """
    if kind == "report":
        return report_page([path])
    if kind != "view":
        raise CaseError(Fault("page", "must be view or report", "Reload the page"))
    with open_result(path) as result:
        return view_page(result)


def _written(result: Result) -> dict[str, str]:
    """Return every value of the case of a result, as a case file writes it, by its dotted key."""
    content = any_case_of(result).model_dump(mode="json", by_alias=True, exclude_none=True)
    return {key: value if isinstance(value, str) else toml_value(value) for key, value in leaves(content)}
