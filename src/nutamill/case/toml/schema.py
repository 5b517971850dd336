"""The JSON schema of files that a user writes, for completion and checking in editors."""

from typing import Any

from pydantic import BaseModel

from nutamill.case.case_file import CaseFile
from nutamill.case.mill import Case


def case_schema() -> dict[str, Any]:
    """Return the schema of a case of a mill."""
    return file_schema(Case)


def file_schema(kind: type[BaseModel]) -> dict[str, Any]:
    """Return the schema of a kind of file. That of a case allows for a base.

    In a case every key is known, none is required, and single entries of a list of tables may be changed by
    name or number.  Defaults of quantities are left out, for in the file they carry a unit.
    """
    schema = kind.model_json_schema(by_alias=True)
    if issubclass(kind, CaseFile):
        schema["properties"]["base"] = {
            "type": "string",
            "description": "A published mill or another file, whose keys these override.",
        }
        _loosen(schema)
    return schema


def _loosen(part: Any) -> None:
    if isinstance(part, list):
        for inner in part:
            _loosen(inner)
    elif isinstance(part, dict):
        if "properties" in part:
            part.pop("required", None)
        if part.get("type") == "string" and not isinstance(part.get("default"), str):
            part.pop("default", None)
        for inner in part.values():
            _loosen(inner)
        entry = part.get("items")
        if part.get("type") == "array" and isinstance(entry, dict) and "$ref" in entry:
            listed = {key: part.pop(key) for key in ("type", "items")}
            part["anyOf"] = [listed, {"type": "object", "additionalProperties": entry}]
