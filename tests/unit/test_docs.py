"""The documentation site says what the code says, and its examples are short and name what there is."""

import ast
import importlib
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import nutamill as nm
from nutamill.base.errors import ExitCode
from nutamill.base.library import library_file
from nutamill.case import load_case
from nutamill.design.dialects import dialect_lines
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
    assert all(f"## nutamill {name}\n" in pages["commands"] for name in ("run", "view", "import", "report"))
    assert "| `-o, --to FILE` | Result file; else" in pages["commands"]
    assert all(f"## nm.{name}\n" in pages["api"] for name in nm.__all__ if name != "__version__")
    assert "## `[chamber.rib]`" in pages["case"] and "DrawnMechanism" not in pages["case"]
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


def test_the_gallery_begins_with_a_small_picture_of_each_example_that_has_one(pages):
    top = pages["gallery"].split("\n## ")[0]
    drawn = [path.stem for path in EXAMPLES if (ROOT / "docs/pictures" / f"{path.stem}.png").is_file()]
    assert drawn and all(f"(../pictures/{name}.png)](#" in top for name in drawn)


def test_the_readme_is_short_enough_to_be_read():
    words = [
        word for word in (ROOT / "README.md").read_text(encoding="utf-8").split() if re.search(r"\w", word)
    ]
    assert len(words) <= 900


def test_every_page_and_picture_that_the_readme_names_is_there():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    named = re.findall(r"\]\(([^):#]+)\)|src=\"([^\"]+)\"", text)
    assert [name for pair in named for name in pair if name and not (ROOT / name).exists()] == []


def test_the_worked_translation_is_what_the_program_prints():
    lines = "\n".join(dialect_lines(load_case("numill").machine))
    page = (ROOT / "docs/guides/coming-from.md").read_text(encoding="utf-8")
    printed = re.findall(r"^(?:pair_coeff|PFC|Rocky|LIGGGHTS| {10})(.+)$", page, re.MULTILINE)
    assert len(printed) == 6 and all(text.strip() in lines for text in printed)


def test_the_law_of_the_guide_is_a_law_of_a_clone_and_meets_its_closed_form(tmp_path):
    """The three steps of the page, done in a copy of the package, and its script as plain Python."""
    page = (ROOT / "docs/guides/contact-law.md").read_text(encoding="utf-8")
    law, entry, name, script = (block.partition("\n")[2] for block in page.split("```")[1::2])
    package = tmp_path / "nutamill"
    shutil.copytree(ROOT / "src/nutamill", package, ignore=shutil.ignore_patterns("__pycache__"))
    (package / "charge/laws/viscous_rolling.py").write_text(law, encoding="utf-8")
    line, family = entry.splitlines()
    literal, reads = name.splitlines()
    for file, changes in (
        ("charge/laws/composition.py", {"    viscous_film,\n": f"    viscous_film,\n{line}\n"}),
        ("case/contact_laws.py", {}),
    ):
        text = (package / file).read_text(encoding="utf-8")
        changes = changes or {
            next(row for row in text.splitlines() if row.startswith("Rolling =")): literal,
            '        "type_a": frozenset': f'{reads}\n        "type_a": frozenset',
        }
        if "composition" in file:
            given = next(row for row in text.splitlines() if row.startswith("ROLLING ="))
            changes[given] = family.replace("...", given.partition("{")[2].rstrip("}"))
        for old, new in changes.items():
            assert text.count(old) == 1
            text = text.replace(old, new)
        (package / file).write_text(text, encoding="utf-8")
    script += 'nm.load_case("numill").with_(**{"contact.rolling": "viscous"})\nprint(nm.__file__)\n'
    done = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    assert str(tmp_path) in done.stdout


def test_the_titles_in_the_top_bar_of_the_site_fit_one_line():
    """The bar shows four of them, and 40 letters are half of a page of 1400 pixels."""
    pages = re.search(
        r"```{toctree}.*?\n\n(.*?)```", (ROOT / "docs/index.md").read_text(encoding="utf-8"), re.S
    )
    titles = []
    for entry in pages[1].split("\n")[:4]:
        title, _, _ = entry.partition(" <")
        file = ROOT / f"docs/{entry}.md"
        titles.append(
            file.read_text(encoding="utf-8").splitlines()[0].strip("# ") if file.exists() else title
        )
    assert len(" ".join(titles)) <= 40, titles


def test_the_worked_case_file_has_the_contact_of_the_numill():
    page = (ROOT / "docs/guides/coming-from.md").read_text(encoding="utf-8")
    given = tomllib.loads(re.search(r"```toml\n(.*?)```", page, re.DOTALL)[1])["contact"]
    pair = given.pop("pairs")["steel-steel"]
    keys = {f"contact.{key}": value for key, value in given.items()}
    wall = {"contact.pairs.steel-acrylic.normal_stiffness": "15748 N/m"}
    keys |= {f"contact.pairs.steel-steel.{key}": value for key, value in pair.items()} | wall
    changed = dialect_lines(load_case("numill").with_(keys).machine)
    assert next(line for line in changed if "pair_coeff" in line) == next(
        line for line in dialect_lines(load_case("numill").machine) if "pair_coeff" in line
    )


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


def test_the_tables_of_the_guide_to_machines_are_those_of_the_package():
    guide = (ROOT / "docs/guides/build-your-own-machine.md").read_text(encoding="utf-8")
    box, balls, drive, gear = re.findall(r"```toml\n(.*?)```", guide, re.DOTALL)
    damper, empty, filled = load_case("particle-damper"), *map(nm.Machine.from_toml, (box, box + balls))
    for part in ("bodies", "joints", "springs", "run"):
        assert getattr(empty, part) == getattr(filled, part) == getattr(damper, part), part
    for part in ("walls", "regions", "charge", "materials", "contact"):
        assert getattr(filled, part) == getattr(damper, part), part
    tumbling, planetary = (library_file(name).read_text() for name in ("tumbling-mill", "planetary-mill"))
    assert tomllib.loads(drive)["drives"] == tomllib.loads(tumbling)["drives"]
    assert tomllib.loads(gear)["gears"] == tomllib.loads(planetary)["gears"][:1]
    sheet = "\n".join(nm.check(empty).lines())
    printed = re.search(r"```\n(bodies.*?)```", guide, re.DOTALL)
    assert printed and all(line in sheet for line in printed.group(1).splitlines())
