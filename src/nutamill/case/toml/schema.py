"""The JSON schema of case files, for completion and checking in editors."""

from typing import Any

from nutamill.case.mill import Case


def case_schema() -> dict[str, Any]:
    """Return the schema of a file that may have a base.

    Every key is known, none is required, and single entries of a list of tables may be changed by name or
    number.

    Defaults of quantities are left out, for in the file they carry a unit.
    """
    schema = Case.model_json_schema(by_alias=True)
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
