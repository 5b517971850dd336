"""What the page asks for, and the answers: each a call of the package, and JSON or a page."""

import json
import math
import threading
from collections.abc import Callable, Mapping
from http import HTTPStatus
from importlib import resources
from typing import Any, NamedTuple

from nutamill import __version__
from nutamill.base.errors import CaseError, Fault
from nutamill.ui import cases, results
from nutamill.ui.folder import Folder
from nutamill.ui.runner import RunTask
from nutamill.ui.runs import Runs

FILES = {"": "ui.html", "ui.css": "ui.css", "ui.js": "ui.js", "ui-charts.js": "ui-charts.js"}
"""Files of `data/pages` that the page consists of, by their address."""
KINDS = {"html": "text/html", "css": "text/css", "js": "text/javascript"}
OWN = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:"
"""What the page itself may load: its own files."""
ALONE = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; frame-src 'self'"
)
"""What the page of a result may load: nothing but itself. It cannot ask this server anything."""
SAFE = "; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"


class Answer(NamedTuple):
    """What is sent back."""

    status: HTTPStatus
    """Status of HTTP."""
    kind: str
    """Type of the content."""
    body: bytes
    """Content."""
    policy: str = OWN + SAFE
    """What the content may load in a browser."""


class Answers:
    """Answers the requests about one folder.

    Parameters
    ----------
    folder : the folder
    """

    def __init__(self, folder: Folder):
        self._folder = folder
        self.runs = Runs()
        self._one = threading.Lock()
        """Held while something is computed: a check, a page of a result."""
        self._asks: dict[str, Callable[[Mapping[str, str]], Answer]] = {
            "start": self._start,
            "runs": lambda query: json_answer([run._asdict() for run in self.runs.shown()]),
            "results": lambda query: json_answer(results.listed(folder)),
            "traces": self._traces,
            "page": self._page,
        }
        self._tasks: dict[str, Callable[[dict[str, Any]], Answer]] = {
            "case": lambda task: json_answer(_sheet_json(cases.sheet(cases.asked(folder, task)))),
            "check": self._check,
            "run": self._run,
            "stop": self._stop,
            "save": lambda task: json_answer(
                {"file": cases.save_changes(folder, cases.asked(folder, task), task.get("file"))}
            ),
            "compare": self._compare,
        }

    def asked(self, name: str, query: Mapping[str, str]) -> Answer | None:
        """Return the answer to a request without a body, or None where there is nothing of this name.

        Raises
        ------
        MillError : what is asked for cannot be given
        """
        if name in FILES:
            file = resources.files("nutamill") / "data" / "pages" / FILES[name]
            return Answer(HTTPStatus.OK, KINDS[FILES[name].rpartition(".")[2]], file.read_bytes())
        return self._asks[name](query) if name in self._asks else None

    def performed(self, name: str, body: bytes) -> Answer | None:
        """Return the answer to a request with a body, or None where there is nothing of this name.

        Raises
        ------
        MillError : what is asked for cannot be done
        """
        try:
            task = json.loads(body)
        except (ValueError, RecursionError):
            task = None
        if not isinstance(task, dict):
            raise CaseError(Fault("request", "must be a table in JSON", "Reload the page"))
        return self._tasks[name](task) if name in self._tasks else None

    def _start(self, query: Mapping[str, str]) -> Answer:
        return json_answer(
            {
                "version": __version__,
                "folder": str(self._folder.root),
                "first": cases.first(),
                "cases": cases.catalogue(self._folder),
            }
        )

    def _check(self, task: dict[str, Any]) -> Answer:
        with self._one:
            return json_answer({"lines": cases.check_lines(cases.asked(self._folder, task))})

    def _run(self, task: dict[str, Any]) -> Answer:
        case = cases.loaded(cases.asked(self._folder, task))
        path = case.file_in(self._folder.results)
        shown = self._folder.name_of(path)
        work = RunTask(case.to_toml(), case.name, str(path), bool(task.get("again")))
        return json_answer({"number": self.runs.start(case.title or case.name, shown, work), "file": shown})

    def _stop(self, task: dict[str, Any]) -> Answer:
        self.runs.stop(task.get("number"))
        return json_answer({})

    def _traces(self, query: Mapping[str, str]) -> Answer:
        path = self._folder.file(query.get("file"), *results.ENDS)
        names = [name for name in query.get("series", "").split(",") if name]
        return json_answer(results.traces(path, names or None))

    def _compare(self, task: dict[str, Any]) -> Answer:
        files = task.get("files")
        paths = [
            self._folder.file(name, *results.ENDS) for name in (files if isinstance(files, list) else [])
        ]
        with self._one:
            return json_answer(results.compared(paths))

    def _page(self, query: Mapping[str, str]) -> Answer:
        path = self._folder.file(query.get("file"), *results.ENDS)
        with self._one:
            page = results.page_of(query.get("kind", ""), path)
        return Answer(HTTPStatus.OK, KINDS["html"], page.encode(), ALONE + SAFE)


def json_answer(content: Any, status: HTTPStatus = HTTPStatus.OK) -> Answer:
    """Return content as JSON. Numbers that are not finite become ``null``."""
    text = json.dumps(_finite(content), allow_nan=False, separators=(",", ":"))
    return Answer(status, "application/json", text.encode())


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: _finite(inner) for key, inner in value.items()}
    return [_finite(inner) for inner in value] if isinstance(value, (list, tuple)) else value


def _sheet_json(sheet: cases.Sheet) -> dict[str, Any]:
    return {**sheet._asdict(), "entries": [entry._asdict() for entry in sheet.entries]}
