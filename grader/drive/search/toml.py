"""A scenario as a short TOML file: only what differs from the defaults."""

from __future__ import annotations

import json
import math
import re
from typing import Any

import msgspec

from sim.scenario import Scenario

BARE = re.compile(r"[A-Za-z0-9_-]+")
WIDTH = 100  # [characters] of a line


def scenario_to_toml(scenario: Scenario) -> str:
    """Return the text of a file from which `load_scenario` makes this scenario."""
    doc = _changed(scenario)
    doc.pop("name", None)
    tables = {key: doc.pop(key) for key in list(doc) if isinstance(doc[key], dict)}
    lines = [f"{_key(key)} = {_value(value)}" for key, value in doc.items()]
    for name, table in ({"world": {}} | tables).items():
        lines += ["", f"[{_key(name)}]", *(_entry(key, value) for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _entry(key: str, value: Any) -> str:
    """Return a line; a long list has one for each of its items."""
    line = f"{_key(key)} = {_value(value)}"
    if len(line) <= WIDTH or not isinstance(value, list | tuple):
        return line
    items = "".join(f"    {_value(item)},\n" for item in value)
    return f"{_key(key)} = [\n{items}]"


def _changed(struct: msgspec.Struct) -> dict[str, Any]:
    """Return the fields that are not as they are by default, by their names in a file."""
    found = {}
    for field in msgspec.structs.fields(struct):
        value = getattr(struct, field.name)
        default = field.default
        if field.default_factory is not msgspec.NODEFAULT:
            default = field.default_factory()
        if default is msgspec.NODEFAULT or value != default:
            found[field.encode_name] = _plain(value)
    return found


def _plain(value: Any) -> Any:
    if isinstance(value, msgspec.Struct):
        return _changed(value)
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    return value


def _key(key: str) -> str:
    return key if BARE.fullmatch(key) else _text(key)


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")  # else as in TOML


def _value(value: Any) -> str:
    match value:
        case bool():
            return str(value).lower()
        case str():
            return _text(value)
        case float():
            return repr(value) if math.isfinite(value) else str(value)  # nan, inf, -inf
        case list():
            return f"[{', '.join(map(_value, value))}]"
        case dict():
            pairs = ", ".join(f"{_key(key)} = {_value(item)}" for key, item in value.items())
            return f"{{ {pairs} }}" if pairs else "{}"
        case _:
            return str(value)
