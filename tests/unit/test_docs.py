"""The documentation site says what the code says, and its examples are short and name what there is."""

import ast
import importlib
import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from nutamill.base.errors import ExitCode
from nutamill.result.fields import SERIES, SNAPSHOT

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


@pytest.fixture
def pages(tmp_path):
    """The generated pages, by name."""
    spec = importlib.util.spec_from_file_location("generate", ROOT / "docs/generate.py")
    generate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generate)
    generate.write_pages(ROOT, tmp_path / "generated")
    return {page.stem: page.read_text(encoding="utf-8") for page in (tmp_path / "generated").iterdir()}


def test_reference_names_every_recorded_quantity_and_every_key(pages):
    assert all(f"`{field.name}`" in pages["fields"] for field in (*SERIES, *SNAPSHOT))
    assert all(
        f"`{key}`" in pages["case"]
        for key in ("crank_radius", "tangential_ratio", "snapshots", "shear_stiffness")
    )
    assert all(f"`nutamill {name}`" in pages["commands"] for name in ("run", "view", "import", "report"))
    assert "## hertz" in pages["laws"]
    assert all(f"| {code.value} | {code.meaning} |" in pages["commands"] for code in ExitCode)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_is_short_says_what_it_does_and_imports_what_there_is(path):
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    assert len(text.splitlines()) < 60
    assert ast.get_docstring(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            assert all(hasattr(importlib.import_module(node.module), alias.name) for alias in node.names)


@pytest.mark.external
def test_site_builds_without_a_warning(tmp_path):
    for name in ("sphinx", "myst_parser", "pydata_sphinx_theme"):
        pytest.importorskip(name, reason='needs the extra "docs"')
    build = [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "--keep-going",
        "-q",
        "-b",
        "html",
        str(ROOT / "docs"),
        str(tmp_path / "site"),
    ]
    outcome = subprocess.run(build, capture_output=True, text=True, timeout=300)
    assert outcome.returncode == 0, outcome.stderr
    assert (tmp_path / "site/generated/gallery.html").stat().st_size > 5000
