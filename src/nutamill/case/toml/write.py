"""Write a case as TOML: every key, units as engineers type them, the meaning of each key beside it."""

import json
import re
from typing import Any

from pydantic import BaseModel

BARE = frozenset("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-")


def written(model: BaseModel) -> str:
    """Return the TOML text of a model. Keys without a value are left out."""
    content = model.model_dump(mode="json", by_alias=True, exclude_none=True)
    return "\n".join(_table(model, content, ())).strip() + "\n"


def _table(model: Any, content: dict[str, Any], path: tuple[str | int, ...]) -> list[str]:
    """Return the lines of one table: its plain keys, then its inner tables."""
    notes = _notes(model)
    plain = {
        _key(key): _value(value)
        for key, value in content.items()
        if not isinstance(value, dict) and not _is_tables(value)
    }
    lines = []
    if path and isinstance(path[-1], int):
        lines += ["", f"[[{'.'.join(_key(part) for part in path if isinstance(part, str))}]]"]
    elif path and (plain or not content):
        lines += ["", f"[{'.'.join(_key(part) for part in path if isinstance(part, str))}]"]
    width = max(map(len, plain), default=0)
    for key, text in plain.items():
        note = notes.get(key, "")
        pair = f"{key:{width}} = {text}"
        lines.append(f"{pair:<{width + 26}}  # {note}" if note else pair)
    for key, value in content.items():
        inner: Any = model[key] if isinstance(model, dict) else getattr(model, key, None)
        if isinstance(value, dict):
            lines += _table(inner, value, (*path, key))
        elif _is_tables(value):
            for number, (one, table) in enumerate(zip(inner, value, strict=True)):
                lines += _table(one, table, (*path, key, number))
    return lines


def _is_tables(value: Any) -> bool:
    return (
        isinstance(value, (list, tuple)) and bool(value) and all(isinstance(inner, dict) for inner in value)
    )


def _value(value: Any) -> str:
    """Format a value as TOML. A list of lists of lists has a line for each of them."""
    if not _is_lists(value) or not all(_is_lists(inner) for inner in value):
        return toml_value(value)
    return "\n".join(["[", *(f"  {toml_value(inner)}," for inner in value), "]"])


def _is_lists(value: Any) -> bool:
    return (
        isinstance(value, (list, tuple))
        and bool(value)
        and all(isinstance(inner, (list, tuple)) for inner in value)
    )


def _notes(model: Any) -> dict[str, str]:
    """Return the meaning of each key on one line, without the SI unit, because the value beside it shows its
    own.
    """
    if not isinstance(model, BaseModel):
        return {}
    fields = type(model).model_fields.items()
    texts = {
        field.alias or name: " ".join((field.description or "").replace("`", "").split())
        for name, field in fields
    }
    return {key: re.sub(r" \[[^\]]*\]", "", text) for key, text in texts.items()}


def _key(name: str) -> str:
    return name if name and set(name) <= BARE else _text(name)


def toml_value(value: Any) -> str:
    """Format a value as TOML on one line."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(toml_value(inner) for inner in value)}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{_key(key)} = {toml_value(inner)}' for key, inner in value.items())} }}"
    return repr(value)


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
