"""What a message's fields are, where a program sets one that is not there, or another type."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from typing import Any

TYPES = (
    "str(…) for a text, float(…), int(…) or bool(…) for a number, a list where there are several"
)
FIELD = f"a field of the message holds another type than it should: {TYPES}"


def lacks_field(kind: str, name: str, fields: Iterable[Any]) -> str:
    """Say that a message lacks a field, and name its fields."""
    there = [str(field) for field in fields if not str(field).startswith("_")]
    near = difflib.get_close_matches(name, there, n=1)
    return f"{with_article(kind)} has no {name}" + (
        f": is it {near[0]}?" if near else f"; it has {', '.join(there)}"
    )


def field_of(error: BaseException, space: Mapping[str, Any]) -> str:
    """Say which fields a message has of which one was *set* that it lacks; "" if it is no message.

    Python does not say then whose attribute it was, so it is found among a frame's variables.
    """
    match = re.match(r"'(\w+)' object has no attribute '(\w+)'", str(error))
    if not isinstance(error, AttributeError) or error.name is not None or match is None:
        return ""
    for value in space.values():
        for each in (value, *_parts(value)):
            if type(each).__name__ == match[1] and (fields := types_of(each)):
                return lacks_field(match[1], match[2], fields)
    return ""


def wrong_field(error: BaseException) -> str:
    """Say which field of a message that was published holds another type; "" if none does."""
    trace, message = error.__traceback__, None
    while trace is not None:
        message = trace.tb_frame.f_locals.get("msg", message)
        trace = trace.tb_next
    return field_that_is_wrong(message)


def field_that_is_wrong(message: Any) -> str:
    """Say which field of a message holds another type than it should; "" if none does."""
    for name, kind in types_of(message).items():
        value = getattr(message, name)
        for part in value if isinstance(value, list) else [value]:
            if said := field_that_is_wrong(part):
                return said
        try:
            type(message)(check_fields=True, **{name: value})
        except AssertionError:
            took = f"`{name}` of {type(message).__name__} takes {kind}"
            return f"{took}, and was given {value!r:.40}: {TYPES}"
    return ""


def types_of(message: Any) -> dict[str, str]:
    """Return the types of a message's fields by name; {} if it is no message."""
    fields = getattr(type(message), "_fields_and_field_types", None)
    return fields if isinstance(fields, dict) else {}


def _parts(message: Any) -> list[Any]:
    """Return the messages in a message."""
    return [getattr(message, name) for name in types_of(message)]


def with_article(noun: str) -> str:
    """Return a noun with a or an."""
    return f"{'an' if noun[:1].lower() in 'aeio' else 'a'} {noun}"
