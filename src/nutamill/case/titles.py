"""The title of a changed case: the title of what it was changed from may not hold any more, so it names what
was changed.
"""

import copy
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from nutamill.case.toml.addresses import entry_label, entry_number, is_tables
from nutamill.case.toml.layers import Layer
from nutamill.case.toml.merge import merge
from nutamill.case.toml.write import toml_value

NAMED = 5
"""Changes that a title names before it counts the rest [1]."""
LONGEST = 40
"""Characters of a value that a title shows [1]."""
ASIDE = ("title", "changed_from", "schema", "run.threads")
"""Keys that change nothing of what is simulated."""


class Origin(NamedTuple):
    """The case that a title belongs to, and what has been changed since."""

    name: str
    """Name of that case."""
    title: str
    """Its title."""
    values: dict[str, Any]
    """Its values by dotted key, as a file writes them."""
    changed: Mapping[str, Any] = {}
    """Keys that were changed since, in their order, with the values as they were written."""

    def title_with(self, values: Mapping[str, Any]) -> str:
        """Return the title of a case with these `values`.

        A value whose key the case lacks is shown as it was written.
        """
        shown = []
        for key, written in self.changed.items():
            value = values.get(key, written)
            if key not in ASIDE and value != self.values.get(key):
                text = value if isinstance(value, str) else toml_value(value)
                shown.append(f"{key} = {text}" if len(text) <= LONGEST else f"another {key}")
        if not shown:
            return self.title
        rest = f" and {len(shown) - NAMED} more" if len(shown) > NAMED else ""
        return f"{self.name} with {', '.join(shown[:NAMED])}{rest}"


def origin_of(layers: list[Layer]) -> Origin | None:
    """Return the case that the title among the layers of a file belongs to, and the keys of the layers above
    it.

    None without a title, or for one that was given together with the changes.
    """
    number = max((number for number, layer in enumerate(layers) if "title" in layer.content), default=None)
    if number is None or not isinstance(title := layers[number].content["title"], str):
        return None
    if () not in layers[number].places:  # typed after --set, with all the changes
        return None
    content, _, _ = merge(copy.deepcopy(layers[: number + 1]))
    name = Path(layers[number].places[()]).stem
    changed = {key: value for layer in layers[number + 1 :] for key, value in leaves(layer.content, content)}
    return Origin(name, title, dict(leaves(content)), changed)


def leaves(content: Any, changed: Any = None, above: str = "") -> list[tuple[str, Any]]:
    """Return dotted key and value of every entry of a table and its inner tables.

    An entry of a list of tables is addressed by its name, or by its number where it has none.

    Parameters
    ----------
    content : the tables
    changed : the tables that `content` changes, where that may address their entries by name or by number
    above : key of `content`
    """
    listed = is_tables(content)
    entries = []
    for key, value in enumerate(content) if listed else content.items():
        under = changed.get(key) if isinstance(changed, Mapping) else None
        part: str | int = key
        if listed:
            part = entry_label(content, key)
        elif is_tables(changed) and (number := entry_number(changed, key)) is not None:
            part, under = entry_label(changed, number), changed[number]
        dotted = f"{above}.{part}".lstrip(".")
        inner = isinstance(value, Mapping) or is_tables(value)
        entries += leaves(value, under, dotted) if inner else [(dotted, value)]
    return entries
