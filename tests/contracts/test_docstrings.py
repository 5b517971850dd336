"""Summary lines of docstrings: imperative, and one plain sentence after another instead of a semicolon.

Ruff's rule D401 refuses verbs in another form; it does not know that ``"Names of the mills"`` is no sentence.
"""

import ast
import pathlib
import re
from collections.abc import Iterator

import nutamill

PACKAGE = pathlib.Path(nutamill.__file__).parent

VERBS = set(
    re.findall(
        r"\w+",
        """
        Add Answer Append Apply Assemble Balance Begin Book Bring Build Call Check Choose Close Collect
        Combine Commit Compare Compile Compute Continue Copy Count Create Cut Decide Declare Deliver
        Describe Detect Do Draw Enter Estimate Fill Film Find Finish Fit Format Give Hold Identify Import
        Join Keep Kick Kill Lay List Load Log Make March Mark Measure Merge Minimise Move Note Open Parse
        Plan Print Publish Put Raise Read Record Refuse Reject Remove Rename Render Replace Report
        Reserve Reset Return Rotate Run Sample Save Select Serve Set Settle Show Simulate Solve Sort
        Split Start Stop Store Submit Subtract Sum Summarise Take Test Track Turn Update Verify Wait
        Write Yield
        """,
    )
)
"""First words of summary lines; a new verb is added here."""

PROPERTIES = {"property", "cached_property", "computed_field"}


def summaries() -> Iterator[tuple[str, bool, str]]:
    """Yield place, whether it is a property, and the first paragraph of the docstring of each function."""
    for path in sorted(PACKAGE.rglob("*.py")):
        file = path.relative_to(PACKAGE).as_posix()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and (text := ast.get_docstring(node)):
                marks = {getattr(mark, "id", getattr(mark, "attr", "")) for mark in node.decorator_list}
                first = " ".join(text.split("\n\n")[0].split())
                yield f"{file}:{node.name}", bool(marks & PROPERTIES), first


def test_every_summary_begins_with_a_verb():
    wrong = [
        f"{where}: {summary}"
        for where, is_property, summary in summaries()
        if not is_property and summary.split()[0].strip(".,:;") not in VERBS
    ]
    assert not wrong, "\n".join(["begin with a verb of `VERBS`:", *wrong])


def test_no_summary_goes_on_after_a_semicolon():
    wrong = [f"{where}: {summary}" for where, _, summary in summaries() if "; " in summary]
    assert not wrong, "\n".join(["write two sentences, or one:", *wrong])
