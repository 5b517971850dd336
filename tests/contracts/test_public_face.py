"""The public face: `import nutamill as nm` is all that an example needs, and every name of it is used."""

import ast
import pathlib
import re

import nutamill as nm

ROOT = pathlib.Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


def test_an_example_imports_nothing_of_the_package_but_its_face():
    inner = {}
    for path in EXAMPLES:
        body = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        names = [node.module for node in body if isinstance(node, ast.ImportFrom)]
        inner[path.name] = [name for name in names if name.startswith("nutamill")]
    assert not {name: modules for name, modules in inner.items() if modules}


def test_every_public_name_is_there():
    assert [name for name in nm.__all__ if getattr(nm, name, None) is None] == []


def test_every_public_name_is_used_in_an_example_or_a_page():
    pages = [
        ROOT / "README.md",
        *(ROOT / "docs").glob("*.md"),
        *(ROOT / "docs" / "guides").glob("*.md"),
        *EXAMPLES,
    ]
    text = "\n".join(path.read_text(encoding="utf-8") for path in pages)
    errors = {name for name in nm.__all__ if name.endswith("Error")}
    unused = {name for name in nm.__all__ if not re.search(rf"\b{name}\b", text)}
    assert not unused - errors - {"__version__"}
