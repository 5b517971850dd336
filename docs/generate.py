"""Pages of the site that are written from the code: keys of a case, recorded quantities, commands, laws and
their tests, gallery.
"""

import ast
import inspect
import re
from pathlib import Path


def write_pages(root: Path, folder: Path) -> None:
    """Write all generated pages into `folder`."""
    folder.mkdir(exist_ok=True)
    pages = {
        "case": case_page(),
        "fields": fields_page(),
        "commands": commands_page(),
        "api": api_page(),
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
        "A quantity is text with a unit. `nutamill explain KEY` prints the same for one key, with its value.",
        "",
    ]
    for name, table in _tables(schema).items():
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


def _tables(schema: dict) -> dict[str, dict]:
    """Return the tables of a case by the heading that a file gives them, ``[chamber.rib]``."""
    tables = {"Keys at the top": schema}
    waiting = [("", schema)]
    seen = set()
    while waiting:
        above, table = waiting.pop(0)
        for key, part in table["properties"].items():
            listed = part.get("type") == "array" or ("anyOf" in part and "items" in str(part["anyOf"][0]))
            named = part.get("additionalProperties")
            for reference in re.findall(r"#/\$defs/(\w+)", str(part)):
                inner = schema["$defs"][reference]
                if "properties" not in inner or reference in seen:
                    continue
                seen.add(reference)
                path = f"{above}{key}" + (".NAME" if isinstance(named, dict) else "")
                tables[f"`[[{path}]]`" if listed else f"`[{path}]`"] = inner
                waiting.append((f"{path}.", inner))
    return tables


def _kind(part: dict) -> str:
    """What a key takes, in words."""
    choices = part.get("enum") or [inner.get("const") for inner in part.get("anyOf", []) if "const" in inner]
    if choices:
        return ", ".join(f"`{choice}`" for choice in choices)
    if "$ref" in part:
        return "a table"
    kinds = [part.get("type")] + [
        inner.get("type") or inner.get("$ref", "").split("/")[-1] for inner in part.get("anyOf", [])
    ]
    words = {"string": "text", "number": "number", "integer": "whole number", "array": "list"}
    words["boolean"] = "yes or no"
    names = [name for kind in kinds if kind for name in (kind if isinstance(kind, list) else [kind])]
    known = [words.get(name, "a table") for name in names if name != "null"]
    text = " or ".join(dict.fromkeys(known)) or "any"
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
    """Every command with its arguments and options, and what its exit code means."""
    from typer.main import get_command

    from nutamill.base.errors import ExitCode
    from nutamill.cli import app

    lines = ["# Commands", "", "`nutamill COMMAND -h` prints the same.", ""]
    for name, command in get_command(app).commands.items():
        lines += [f"## nutamill {name}", "", _cell(command.help or ""), "", "| | |", "|---|---|"]
        for one in command.params:
            if one.param_type_name == "argument":
                word = one.metavar or one.name.upper()
            else:
                word = ", ".join(sorted(one.opts, key=len)) + (f" {one.metavar}" if one.metavar else "")
            lines.append(f"| `{word.replace('|', ' or ')}` | {_cell(one.help or '')} |")
        lines += [
            f"| `{inner}` | {_cell(sub.help)} |" for inner, sub in getattr(command, "commands", {}).items()
        ]
        lines.append("")
    lines += ["## Exit codes", "", "All commands return the same code for the same kind of outcome.", ""]
    lines += ["| code | meaning |", "|---|---|"]
    lines += [f"| {code.value} | {code.meaning} |" for code in ExitCode]
    return "\n".join(lines)


def api_page() -> str:
    """Every name of the public face with its signature and its documentation."""
    import nutamill

    lines = ["# Public names", "", "`import nutamill as nm`; all else is inner and may change.", ""]
    for name in nutamill.__all__:
        if name.startswith("_"):
            continue
        thing = getattr(nutamill, name)
        try:
            signature = str(inspect.signature(thing)) if callable(thing) else ""
        except ValueError:
            signature = ""
        signature = re.sub(r"nutamill\.[\w.]*\.(\w+)", r"\1", signature).replace("'", "")
        if (isinstance(thing, type) and issubclass(thing, Exception)) or "pydantic" in str(
            type(thing)
        ).lower():
            signature = ""
        text = inspect.getdoc(thing) or ""
        if name == "view":
            from nutamill.view.inline import inline_view

            signature, text = str(inspect.signature(inline_view)), inspect.getdoc(inline_view)
        lines += [
            f"## nm.{name}",
            "",
            "```python",
            f"nm.{name}{signature}",
            "```",
            "",
            "```text",
            text,
            "```",
            "",
        ]
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
    """Return every example with its own description, its code and its picture, small pictures first."""
    lines = [
        "# Gallery",
        "",
        "Every example checks itself against a closed form, another method or a pinned number.",
    ]
    paths = sorted((root / "examples").glob("*.py"), key=lambda path: (path.stem != FIRST, path.stem))
    small, sections = [], []
    for path in paths:
        text = path.read_text(encoding="utf-8")
        heading, _, rest = (ast.get_docstring(ast.parse(text)) or path.stem).partition("\n")
        title = path.stem.replace("_", " ").capitalize()
        picture = root / "docs/pictures" / f"{path.stem}.png"
        sections += [f"## {title}", "", heading, "", rest.strip(), ""]
        if picture.is_file():
            small.append(f"[![{title}](../pictures/{path.stem}.png)](#{title.lower().replace(' ', '-')})")
            sections += [f"![{heading}](../pictures/{path.stem}.png)", ""]
        sections += [f"`examples/{path.name}`", "", "```python", text.strip(), "```", ""]
        printed = root / "docs/printed" / f"{path.stem}.txt"
        if printed.is_file():
            sections += ["It prints:", "", "```text", printed.read_text(encoding="utf-8").rstrip(), "```", ""]
    rows = [small[k : k + 4] for k in range(0, len(small), 4)]
    lines += [
        "",
        "| | | | |",
        "|---|---|---|---|",
        *("| " + " | ".join(row + [""] * (4 - len(row))) + " |" for row in rows),
    ]
    return "\n".join([*lines, "", *sections])
