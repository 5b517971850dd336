"""The title of a changed case: the title of what it was changed from may not hold any more, so it names what
was changed.
"""

import copy
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from nutamill.case.toml.layers import Layer, merge
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
    changed: tuple[str, ...] = ()
    """Keys that were changed since, in their order."""

    def title_with(self, values: Mapping[str, Any], typed: Mapping[str, Any]) -> str:
        """Return the title of a case with these `values`, of which those `typed` are not there under the key
        that was written.
        """
        shown = []
        for key in self.changed:
            value = values.get(key, typed.get(key))
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
    return Origin(
        name,
        title,
        dict(leaves(content)),
        tuple(written_keys(layer.content for layer in layers[number + 1 :])),
    )


def written_keys(contents: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the dotted keys in these tables, each once."""
    return list(dict.fromkeys(key for content in contents for key, _ in leaves(content)))


def leaves(content: Any, above: str = "") -> list[tuple[str, Any]]:
    """Return dotted key and value of all that stands in a table and its inner tables; tables of a list by
    their number.
    """
    entries = []
    for key, value in content.items() if isinstance(content, Mapping) else enumerate(content):
        dotted = f"{above}.{key}".lstrip(".")
        tables = (
            isinstance(value, (list, tuple))
            and bool(value)
            and all(isinstance(inner, Mapping) for inner in value)
        )
        entries += leaves(value, dotted) if isinstance(value, Mapping) or tables else [(dotted, value)]
    return entries
