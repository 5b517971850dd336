"""Pages of the site that are written from the code: keys of a case, recorded quantities, commands, laws and
their tests, gallery.
"""

import ast
import re
from pathlib import Path


def write_pages(root: Path, folder: Path) -> None:
    """Write all generated pages into `folder`."""
    folder.mkdir(exist_ok=True)
    pages = {
        "case": case_page(),
        "fields": fields_page(),
        "commands": commands_page(),
        "laws": laws_page(root),
        "gallery": gallery_page(root),
    }
    for name, text in pages.items():
        (folder / f"{name}.md").write_text(text, encoding="utf-8")


def case_page() -> str:
    """Every key of a case file, its kind and meaning, table by table."""
    from nutamill.case.toml.schema import case_schema

    schema = case_schema()
    lines = [
        "# Keys of a case file",
        "",
        "A quantity is text with a unit. `nutamill show CASE` prints every value of a case.",
        "",
    ]
    tables = {"(top)": schema} | schema.get("$defs", {})
    for name, table in tables.items():
        if "properties" not in table:
            continue
        lines += [
            f"## {name}",
            "",
            _cell(table.get("description", "").split("\n")[0]),
            "",
            "| key | value | meaning |",
            "|---|---|---|",
        ]
        lines += [
            f"| `{key}` | {_kind(part)} | {_cell(part.get('description', ''))} |"
            for key, part in table["properties"].items()
        ]
        lines.append("")
    return "\n".join(lines)


def _kind(part: dict) -> str:
    """What a key takes, in words."""
    choices = part.get("enum") or [inner.get("const") for inner in part.get("anyOf", []) if "const" in inner]
    if choices:
        return ", ".join(f"`{choice}`" for choice in choices)
    if "$ref" in part:
        return f"table {part['$ref'].split('/')[-1]}"
    kinds = [part.get("type")] + [
        inner.get("type") or inner.get("$ref", "").split("/")[-1] for inner in part.get("anyOf", [])
    ]
    text = " or ".join(str(kind) for kind in kinds if kind) or "any"
    examples = part.get("examples")
    return _cell(f'{text}, e.g. `"{examples[0]}"`' if examples else text)


def _cell(text: str) -> str:
    return " ".join(str(text).split()).replace("|", "\\|").replace("<", "&lt;")


def fields_page() -> str:
    """Every recorded quantity."""
    from nutamill.result.fields import SERIES, SNAPSHOT, STATISTICS

    lines = ["# Recorded quantities", ""]
    for heading, known in (("Series", SERIES), ("Snapshots", SNAPSHOT), ("Statistics", STATISTICS)):
        lines += [f"## {heading}", "", "| name | unit | meaning |", "|---|---|---|"]
        lines += [f"| `{field.name}` | {field.unit} | {_cell(field.meaning)} |" for field in known] + [""]
    return "\n".join(lines)


def commands_page() -> str:
    """Every command and the first lines of its help, and what its exit code means."""
    from nutamill.base.errors import ExitCode
    from nutamill.cli import app

    lines = [
        "# Commands",
        "",
        "`nutamill COMMAND --help` lists the options.",
        "",
        "| command | what it does |",
        "|---|---|",
    ]
    for command in app.registered_commands:
        name = command.name or command.callback.__name__.replace("_", "-")
        lines.append(f"| `nutamill {name}` | {_cell((command.callback.__doc__ or '').strip())} |")
    lines += ["", "## Exit codes", "", "All commands return the same code for the same kind of outcome.", ""]
    lines += ["| code | meaning |", "|---|---|"]
    lines += [f"| {code.value} | {code.meaning} |" for code in ExitCode]
    return "\n".join(lines)


def laws_page(root: Path) -> str:
    """The functions of the contact laws with what their docstrings say, and the tests that hold them."""
    lines = ["# Contact laws and their tests", ""]
    for path in sorted((root / "src/nutamill/charge/laws").glob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        known = [
            (node.name, ast.get_docstring(node))
            for node in tree.body
            if isinstance(node, ast.FunctionDef) and ast.get_docstring(node)
        ]
        if known:
            lines += [f"## {path.stem}", "", *_prose(ast.get_docstring(tree) or ""), ""]
            for name, text in known:
                lines += [f"### {name}", "", "```text", text, "```", ""]
    lines += ["## Tests", ""]
    for name in ("test_contact_laws", "test_charge_laws", "test_charge_published"):
        path = root / f"tests/verification/{name}.py"
        names = re.findall(r"^def test_(\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)
        lines += [
            f"`tests/verification/{name}.py` holds that",
            "",
            *(f"- {test.replace('_', ' ')}" for test in names),
            "",
        ]
    return "\n".join(lines)


def _prose(text: str) -> list[str]:
    return ["```text", text, "```"] if text else []


FIRST = "piston"
"""The example that the gallery begins with: what nothing but the charge drives."""


def gallery_page(root: Path) -> str:
    """Return every example with its own description, its code and its picture where there is one."""
    lines = ["# Gallery", ""]
    for path in sorted((root / "examples").glob("*.py"), key=lambda path: (path.stem != FIRST, path.stem)):
        text = path.read_text(encoding="utf-8")
        heading, _, rest = (ast.get_docstring(ast.parse(text)) or path.stem).partition("\n")
        lines += [f"## {heading.rstrip('.')}", "", rest.strip(), ""]
        picture = root / "docs/pictures" / f"{path.stem}.png"
        if picture.is_file():
            lines += [f"![{heading}](../pictures/{path.stem}.png)", ""]
        lines += [f"`examples/{path.name}`", "", "```python", text.strip(), "```", ""]
    return "\n".join(lines)
