"""Each message has a test of its text: three words of it in a row stand somewhere in the tests."""

import ast
import pathlib
import re

import nutamill

PACKAGE = pathlib.Path(nutamill.__file__).parent
TESTS = pathlib.Path(__file__).parents[1]

WORDS, LETTERS = 3, 9
"""Words in a row, and letters, that make a message known again [1]."""

UNTESTED = {
    "no terminal": "caught where it is raised",
    "is written exactly in the SI unit": "cannot happen",
    "a particle was pushed through a wall while it was placed": "seen with one mesh in thousands",
    "settling:": "a prefix of messages of the charge, which are tested",
    "nutamill": "a kind of error, not a text",
}
"""Messages without a test, and why."""


def literals(node: ast.expr, names: dict[str, list[ast.expr]]) -> list[str]:
    """Return the literal pieces of a text, also of a name that was given one in the same file."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return [node.value]
    if isinstance(node, ast.JoinedStr):
        return [part.value for part in node.values if isinstance(part, ast.Constant)]
    if isinstance(node, ast.BinOp):
        return literals(node.left, names) + literals(node.right, names)
    if isinstance(node, ast.IfExp):
        return literals(node.body, names) + literals(node.orelse, names)
    if isinstance(node, ast.Name):
        return [text for value in names.get(node.id, []) for text in literals(value, {})]
    return []


def message_of(call: ast.Call) -> ast.expr | None:
    """Return the argument of a call that is the text of a message, or None if it raises none."""
    name = getattr(call.func, "id", getattr(call.func, "attr", ""))
    if name == "Fault" and len(call.args) > 1:
        return call.args[1]
    if name == "damaged" and call.args:
        return call.args[-1]
    if (name == "refusal" or re.fullmatch(r"\w*Error", name)) and call.args:
        return call.args[0]
    return None


def messages() -> list[tuple[str, list[str]]]:
    """Return place and literal pieces of each message; pieces too short to be known again are left out."""
    rows = []
    for path in sorted(PACKAGE.rglob("*.py")):
        name = path.relative_to(PACKAGE).as_posix()
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names: dict[str, list[ast.expr]] = {}
        for node in ast.walk(tree):
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                names.setdefault(node.targets[0].id, []).append(node.value)
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and (text := message_of(node)) is not None:
                pieces = [piece for piece in literals(text, names) if len(piece.strip()) >= LETTERS]
                if pieces:
                    rows.append((f"{name}:{node.lineno}", pieces))
    return rows


def test_every_message_has_a_test_of_its_text():
    here = pathlib.Path(__file__)
    text = "\n".join(path.read_text(encoding="utf-8") for path in TESTS.rglob("*.py") if path != here)
    text = re.sub(r'"\s*f?r?"', "", text).replace("\\", "")  # neighbouring literals are one

    def known(piece: str) -> bool:
        words = piece.split()
        size = min(WORDS, len(words))
        rows = (" ".join(words[k : k + size]) for k in range(len(words) - size + 1))
        return any(len(row) >= LETTERS and row in text for row in rows)

    wrong = [
        f"{where}: {' ... '.join(pieces)}"
        for where, pieces in messages()
        if not any(known(piece) for piece in pieces)
        and not any(piece.strip() in UNTESTED for piece in pieces)
    ]
    assert not wrong, "\n".join(["provoke these in tests/unit/test_messages.py:", *wrong])
