"""From the validator's findings to one `Fault` each: file, line, key, what is wrong, what to write."""

import itertools
import types
import typing
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.library import similar
from nutamill.base.schema import FROM_FILE, Quantity, Table, spelled
from nutamill.case.content import text_findings
from nutamill.case.toml.addresses import Key, placed

Read = TypeVar("Read", bound=Table)
MOST_FAULTS = 50
"""Faults of one file that are listed; of the others only the number [1]."""


def checked(
    kind: type[Read],
    content: dict[str, Any],
    places: dict[Key, str],
    faults: Sequence[Fault] = (),
    from_file: bool = True,
) -> Read:
    """Return the table of this kind that `content` describes.

    Parameters
    ----------
    places : where each key stands, as `nutamill.case.toml.merge.merge` returns it
    faults : earlier faults, raised with all others
    from_file : quantities are text with a unit; otherwise SI floats are taken too

    Raises
    ------
    CaseError : every fault
    """
    if odd := list(itertools.islice(text_findings(content), MOST_FAULTS)):
        raise CaseError(
            *faults, *(Fault(placed(places, key, content), what, hint) for key, what, hint in odd)
        )
    try:
        table = kind.model_validate(content, context={FROM_FILE: from_file})
    except ValidationError as error:
        raise CaseError(*faults, *worded(error, kind, content, places)) from None
    if faults:
        raise CaseError(*faults)
    return table


def worded(
    error: ValidationError, top: type[Table], content: dict[str, Any], places: dict[Key, str]
) -> list[Fault]:
    """Return all faults of a validation, in the order of the file's tables."""
    faults = []
    details = error.errors(include_url=False)
    absent = [
        detail["loc"][0] for detail in details if detail["type"] == "missing" and len(detail["loc"]) == 1
    ]
    if len(absent) > 3:
        names = ", ".join(f"[{name}]" for name in absent)
        faults.append(
            Fault(
                placed(places, ()),
                f"lacks the tables {names}",
                'Begin the file with base = "numill" and write what differs',
            )
        )
    for number, detail in enumerate(details):
        if len(faults) >= MOST_FAULTS:
            left = len(details) - number
            return [*faults, Fault(placed(places, ()), f"{left} more fault{'s' * (left > 1)}")]
        key = tuple(detail["loc"])
        if len(absent) > 3 and key[0] in absent:
            continue
        context = detail.get("ctx", {})
        if "findings" in context:
            faults += [
                Fault(placed(places, inner, content), what, hint) for inner, what, hint in context["findings"]
            ]
            continue
        if detail["type"] == "nutamill":
            what, hint = context["what"], context["hint"]
        else:
            what, hint = _WORDS.get(detail["type"], _other)(detail, key, top, content)
        if detail["type"] == "missing" and not isinstance(key[-1], int) and _may_lack_base(top, places, key):
            hint += OR_BASE
        faults.append(Fault(placed(places, _in_file(key, top), content), what, hint))
    return faults


OR_BASE = ', or begin the file with base = "numill"'
"""Second cure of a missing key, for a file that could have a base and has none."""


def _may_lack_base(top: type[Table], places: dict[Key, str], key: Key) -> bool:
    """Return whether a base could give the missing key: in the file of a mill that has none."""
    in_file = () in places and not placed(places, key).startswith("--set")
    return in_file and "mechanism" in top.model_fields and ("base",) not in places


def fields_at(top: type[Table], key: Key) -> dict[str, Any]:
    """Return the fields of the table at a key by their name in the file, or none where no table is."""
    return _fields(_type_at(top, key))


def _fields(kind: Any) -> dict[str, Any]:
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return {field.alias or name: field for name, field in kind.model_fields.items()}
    return {}


def _type_at(top: type[Table], key: Key) -> Any:
    kind: Any = top
    for part in key:
        if (table := _bare(kind)) and typing.get_origin(table) is dict:
            kind = typing.get_args(table)[1]
            continue
        if typing.get_origin(table) is tuple and (isinstance(part, int) or _is_list_of_tables(table)):
            kind = typing.get_args(table)[0]
            continue
        field = _fields(table).get(str(part))
        if field is None:
            return None
        kind = field.annotation
    return _bare(kind)


def _is_list_of_tables(kind: Any) -> bool:
    """Return whether a type is a list of any number of tables, whose addresses are names or numbers."""
    inner = typing.get_args(kind)
    return typing.get_origin(kind) is tuple and inner[1:] == (...,) and bool(_fields(_bare(inner[0])))


def _bare(kind: Any) -> Any:
    """Return a type without its Annotated and its None."""
    while True:
        if typing.get_origin(kind) is typing.Annotated:
            kind = typing.get_args(kind)[0]
        elif isinstance(kind, types.UnionType) or typing.get_origin(kind) is typing.Union:
            kind = next(inner for inner in typing.get_args(kind) if inner is not type(None))
        else:
            return kind


def _holds_keys(field: Any) -> bool:
    """Return whether a field is a table."""
    kind = _bare(field.annotation)
    return bool(_fields(kind)) or typing.get_origin(kind) is dict


def _in_file(key: Key, top: type[Table]) -> Key:
    """Return a key without the validator's own parts, which names dict keys twice where the key itself is
    wrong.
    """
    return tuple(part for part in key if part != "[key]")


def _unknown(detail: Any, key: Key, top: type[Table], content: dict[str, Any]) -> tuple[str, str]:
    fields = fields_at(top, key[:-1])
    is_table = isinstance(detail["input"], dict)
    rivals = [name for name, field in fields.items() if _holds_keys(field) == is_table]
    homes = [name for name, field in top.model_fields.items() if key[-1] in _fields(_bare(field.annotation))]
    if homes and key[:-1] != (homes[0],):
        return "unknown key", f"It belongs in [{homes[0]}]"
    return "unknown key", similar(str(key[-1]), rivals, cutoff=0.4)


def _missing(detail: Any, key: Key, top: type[Table], content: dict[str, Any]) -> tuple[str, str]:
    if isinstance(key[-1], int):
        return "is missing", f"The list has {key[-1]} of its entries"
    field = fields_at(top, key[:-1]).get(key[-1])
    dotted = ".".join(str(part) for part in key[:-1] if isinstance(part, str))
    listed = any(isinstance(part, int) for part in key)
    if field is not None and _holds_keys(field):
        return "is missing", f"Add a table [{'.'.join(str(part) for part in key)}]"
    quantity = next((mark for mark in field.metadata if isinstance(mark, Quantity)), None) if field else None
    choices = (
        typing.get_args(_bare(field.annotation))
        if field and typing.get_origin(_bare(field.annotation)) is typing.Literal
        else ()
    )
    value = units.example(quantity.kind) if quantity else choices[0] if choices else None
    example = f'{key[-1]} = "{value}"' if value else str(key[-1])
    table = f"[[{dotted}]]" if listed else f"[{dotted}]"
    return "is missing", f"Add e.g. {example}" + (f" under {table}" if dotted else "")


def _one_of(detail: Any, key: Key, top: type[Table], content: dict[str, Any]) -> tuple[str, str]:
    if key == ("schema",):
        newer = "This version of the package reads schema 1; update it, or write schema = 1"
        return f"must be 1, got {spelled(detail['input'])}", newer
    allowed = [word.strip("'") for word in detail["ctx"]["expected"].replace(" or ", ", ").split(", ")]
    shown = ", ".join(f'"{word}"' for word in allowed)
    close = (
        similar(str(detail["input"]), allowed)
        if isinstance(detail["input"], str) and len(allowed) > 1
        else ""
    )
    what = f"must be {'one of ' if len(allowed) > 1 else ''}{shown}, got {spelled(detail['input'])}"
    return what, close if close.startswith("Did") else ""


def _table(detail: Any, key: Key, top: type[Table], content: dict[str, Any]) -> tuple[str, str]:
    names = ", ".join(fields_at(top, key))
    return f"must be a table, got {spelled(detail['input'])}", f"Its keys: {names}" if names else ""


def _list(detail: Any, key: Key, top: type[Table], content: dict[str, Any]) -> tuple[str, str]:
    if not _is_list_of_tables(_type_at(top, key)):
        return f"must be a list, got {spelled(detail['input'])}", ""
    name = ".".join(str(part) for part in key if isinstance(part, str))
    what = f"must be a list of tables, got {spelled(detail['input'])}"
    changes = isinstance(detail["input"], dict)
    return what, f"It has no entry to change yet: add a table [[{name}]]" if changes else f"Write [[{name}]]"


def _bound(words: str, limit: str) -> Callable[..., tuple[str, str]]:
    def word(detail: Any, key: Key, top: type[Table], content: dict[str, Any]) -> tuple[str, str]:
        return f"must be {words} {detail['ctx'][limit]:g}, got {spelled(detail['input'])}", ""

    return word


def _plain(words: str) -> Callable[..., tuple[str, str]]:
    def word(detail: Any, key: Key, top: type[Table], content: dict[str, Any]) -> tuple[str, str]:
        return f"must be {words}, got {spelled(detail['input'])}", ""

    return word


def _too_long(detail: Any, key: Key, top: type[Table], content: dict[str, Any]) -> tuple[str, str]:
    return f"must have {detail['ctx']['max_length']} entries, got {detail['ctx']['actual_length']}", ""


def _other(detail: Any, key: Key, top: type[Table], content: dict[str, Any]) -> tuple[str, str]:
    return f"{detail['msg'][0].lower()}{detail['msg'][1:]}, got {spelled(detail['input'])}", ""


_WORDS: dict[str, Callable[..., tuple[str, str]]] = {
    "extra_forbidden": _unknown,
    "missing": _missing,
    "literal_error": _one_of,
    "model_type": _table,
    "model_attributes_type": _table,
    "dict_type": _table,
    "greater_than": _bound("greater than", "gt"),
    "greater_than_equal": _bound("at least", "ge"),
    "less_than": _bound("less than", "lt"),
    "less_than_equal": _bound("at most", "le"),
    "finite_number": _plain("a finite number"),
    "float_type": _plain("a plain number"),
    "int_type": _plain("a whole number"),
    "int_from_float": _plain("a whole number"),
    "string_type": _plain("text"),
    "tuple_type": _list,
    "too_long": _too_long,
}
