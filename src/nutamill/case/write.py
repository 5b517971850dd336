"""Write a case as TOML: every key, units as engineers type them, the meaning of each key beside it."""

import json
import re
from typing import Any

from pydantic import BaseModel

BARE = frozenset("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-")


def written(model: BaseModel) -> str:
    """TOML text of a model; keys without a value are left out."""
    content = model.model_dump(mode="json", by_alias=True, exclude_none=True)
    return "\n".join(_table(model, content, ())).strip() + "\n"


def _table(model: Any, content: dict[str, Any], path: tuple[str, ...]) -> list[str]:
    """Lines of one table: its plain keys, then its inner tables."""
    notes = _notes(model)
    plain = {_key(key): toml_value(value) for key, value in content.items() if not isinstance(value, dict)}
    lines = []
    if path and (plain or not content):
        lines += ["", f"[{'.'.join(_key(part) for part in path)}]"]
    width = max(map(len, plain), default=0)
    for key, text in plain.items():
        note = notes.get(key, "")
        pair = f"{key:{width}} = {text}"
        lines.append(f"{pair:<{width + 26}}  # {note}" if note else pair)
    for key, value in content.items():
        if isinstance(value, dict):
            inner = model[key] if isinstance(model, dict) else getattr(model, key)
            lines += _table(inner, value, (*path, key))
    return lines


def _notes(model: Any) -> dict[str, str]:
    """Meaning of each key, on one line; without the SI unit, for the value beside it shows its own."""
    if not isinstance(model, BaseModel):
        return {}
    fields = type(model).model_fields.items()
    texts = {field.alias or name: " ".join((field.description or "").replace("`", "").split()) for name, field in fields}
    return {key: re.sub(r" \[[^\]]*\]", "", text) for key, text in texts.items()}


def _key(name: str) -> str:
    return name if name and set(name) <= BARE else _text(name)


def toml_value(value: Any) -> str:
    """A value as TOML writes it on one line."""
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
