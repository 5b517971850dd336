"""Optional values that a check has made sure of."""

from typing import TypeVar

__all__ = ["required"]

Value = TypeVar("Value")


def required(value: Value | None) -> Value:
    """Return a value that may be left out elsewhere, but not here: an earlier check refuses None."""
    assert value is not None
    return value
