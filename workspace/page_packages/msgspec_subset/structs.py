"""What can be done with structs."""

from dataclasses import fields, replace
from typing import Any

__all__ = ["asdict", "astuple", "fields", "replace"]


def asdict(struct: Any) -> dict[str, Any]:
    """Return the values of the fields by their names."""
    return {field.name: getattr(struct, field.name) for field in fields(struct)}


def astuple(struct: Any) -> tuple[Any, ...]:
    """Return the values of the fields."""
    return tuple(getattr(struct, field.name) for field in fields(struct))
