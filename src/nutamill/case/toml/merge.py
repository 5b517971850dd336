"""From layers to one nested dict: a later layer wins, key by key, and each key has the place it came from."""

from collections.abc import Iterator, Mapping
from typing import Any

from nutamill.base.errors import CaseError, Fault
from nutamill.base.schema import spelled
from nutamill.case.content import Finding
from nutamill.case.toml.addresses import (
    Key,
    dotted,
    entry_number,
    is_tables,
    nearest,
    no_entry,
    numbered,
    placed,
)
from nutamill.case.toml.layers import Layer, copied, refuse_shape
from nutamill.case.toml.named_content import EXCLUSIVE_KEYS, EXPANSIONS


def merge(layers: list[Layer]) -> tuple[dict[str, Any], dict[Key, str], list[Fault]]:
    """Return one nested dict, the place of each key, and what is wrong with the files that the layers name,
    which are read here, and with the entries of lists that they change.
    """
    content: dict[str, Any] = {}
    places: dict[Key, str] = {}
    faults: list[Fault] = []
    for layer in layers:
        refuse_shape(layer.content, layer.places)
        for expand in EXPANSIONS:
            try:
                expand(layer)
            except CaseError as error:
                faults += error.faults
        for key, what, hint in _overlay(content, layer.content, ()):
            faults.append(Fault(placed({(): _first_place(layer.places, key)}, key), what, hint))
        places = _places_over(places, layer, content)
    return content, places, faults


def _overlay(below: dict[str, Any], above: dict[str, Any], at: Key) -> Iterator[Finding]:
    """Merge the tables of one layer into those at the key `at`, in place, and yield changes of entries that
    do not exist.
    """
    for group in EXCLUSIVE_KEYS:
        if any(key in above for key in group):
            for other in group:
                below.pop(other, None)
    if above.get("kind") in ("spheres", "none"):
        below.pop("shapes", None)
    if is_tables(above.get("part")):
        below.clear()  # parts describe the whole charge, and so does a charge of one part
    elif above and "part" not in above:
        below.pop("part", None)
    for key, value in above.items():
        under = below.get(key)
        if (
            isinstance(value, dict)
            and isinstance(under, dict)
            and "law" not in value
            and "clumps" not in value
        ):
            yield from _overlay(under, value, (*at, key))
        elif isinstance(value, dict) and isinstance(under, list) and is_tables(under):
            yield from _overlay_entries(under, value, (*at, key))
        else:
            below[key] = copied(value)


def _overlay_entries(below: list[Any], above: dict[str, Any], at: Key) -> Iterator[Finding]:
    """Lay changes of single entries over the list at the key `at`."""
    for part, value in above.items():
        number = entry_number(below, part)
        if number is None:
            yield (*at, part), *no_entry(below, dotted(at), part)
        elif isinstance(value, dict):
            yield from _overlay(below[number], value, (*at, part))
        else:
            yield (*at, part), f"must be a table, got {spelled(value)}", f"Write {dotted((*at, part))}.KEY"


def _first_place(places: dict[Key, str], key: Key) -> str:
    """Return the place of a key that stands in no table of its own: that of the first key below it."""
    below = (place for other, place in places.items() if other[: len(key)] == key)
    return places.get(key) or next(below, "") or nearest(places, key)


def _places_over(below: dict[Key, str], layer: Layer, content: dict[str, Any]) -> dict[Key, str]:
    """Return the place of each key after a layer has been merged over the others into `content`.

    What changes an entry of a list stands at the number of that entry; a list that replaces another leaves
    none of the places within it.
    """
    keys = [(key, numbered(content, key), value) for key, value in _keys(layer.content)]
    replaced = {key for _, key, value in keys if isinstance(value, (list, tuple))}
    places = {
        key: place
        for key, place in below.items()
        if not any(key[:n] in replaced for n in range(1, len(key) + 1))
    }
    own = {numbered(content, key): place for key, place in layer.places.items()}
    # a key inside an inline table has no line of its own: without this its place would be that of an earlier
    # layer
    own |= {key: place for written, key, _ in keys if (place := nearest(layer.places, written))}
    places |= own
    for key, place in own.items():
        for n in range(1, len(key)):  # a table that an override makes
            places.setdefault(key[:n], place)
    return places


def _keys(content: Mapping[Any, Any], above: Key = ()) -> Iterator[tuple[Key, Any]]:
    """Yield every key of a nested dict with its value."""
    for key, value in content.items():
        yield (*above, key), value
        inner = value if isinstance(value, dict) else dict(enumerate(value)) if is_tables(value) else {}
        yield from _keys(inner, (*above, key))
