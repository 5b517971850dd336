"""A case and its check sheet in a notebook."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from nutamill.case import Case, Machine
from nutamill.case.titles import leaves
from nutamill.case.toml.write import toml_value
from nutamill.notebook.html import folded, heading, table, warnings_html

if TYPE_CHECKING:
    from nutamill.design.machine_sheet import MachineSheet
    from nutamill.design.preflight import Preflight

OPEN = ("drive", "drives", "charge", "run")
"""Tables that are shown unfolded: what most users change."""
INDENT = 10
"""Width of the first column of a check sheet [characters]."""


def case_html(case: Case | Machine) -> str:
    """Return title, warnings and every value of a case, table by table."""
    content = case.model_dump(mode="json", by_alias=True, exclude_none=True)
    aside = ("title", "changed_from", "schema")
    tables = {key: value for key, value in content.items() if key not in aside and value not in ({}, [])}
    count = len(case.warnings)
    verdict = f"{count} warning{'s' * (count != 1)}" if count else "no warnings"
    folds = "".join(
        folded(_summary(key, value), table(_rows(value)), key in OPEN)
        for key, value in tables.items()
        if isinstance(value, (Mapping, list))
    )
    return heading(case.title or case.name, verdict, not count) + warnings_html(case.warnings) + folds


def sheet_html(sheet: "Preflight | MachineSheet") -> str:
    """Return what is known of a case before a run: its lines as a table."""
    first, *lines = sheet.lines()
    warnings = [line.strip() for line in lines if line.startswith("  warning:")]
    rows = [(line[:INDENT].strip(), line[INDENT:]) for line in lines if not line.startswith("  warning:")]
    title, _, verdict = first.rpartition(": ")
    sheet_table = table(rows).replace('<td style="', '<td style="white-space:pre;font-family:monospace;')
    return heading(title, verdict, not warnings) + warnings_html(warnings) + sheet_table


def _summary(key: str, value: Any) -> str:
    """Return the name of a table, and of a list of tables how many there are."""
    return f"{key} ({len(value)})" if isinstance(value, list) else key


def _rows(value: Any) -> list[tuple[str, str]]:
    """Return dotted key and value, as a file writes them, of all that is in a table."""
    content = value if isinstance(value, Mapping) else dict(enumerate(value))
    return [(key, inner if isinstance(inner, str) else toml_value(inner)) for key, inner in leaves(content)]
