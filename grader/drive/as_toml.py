"""Values as TOML, and a scenario as a short file: only what differs from the defaults."""

from __future__ import annotations

import itertools
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
    doc = _plain(msgspec.structs.replace(scenario, name=""))
    tables = {key: doc.pop(key) for key in list(doc) if isinstance(doc[key], dict)}
    lines = list(itertools.starmap(entry, doc.items()))
    for name, table in tables.items():
        lines += ["", f"[{name}]", *itertools.starmap(entry, table.items())]
    return "\n".join(lines) + "\n"


def entry(key: str, value: Any) -> str:
    """Return a line; a long list has one for each of its items."""
    line = f"{_key(key)} = {_value(value)}"
    if len(line) <= WIDTH or not isinstance(value, list):
        return line
    items = "".join(f"    {_value(item)},\n" for item in value)
    return f"{_key(key)} = [\n{items}]"


def _plain(value: Any) -> Any:
    """Return a struct as a dictionary of the fields that are not as they are by default."""
    match value:
        case msgspec.Struct():
            fields = [(each, getattr(value, each.name)) for each in msgspec.structs.fields(value)]
            return {each.encode_name: _plain(v) for each, v in fields if v != _default(each)}
        case list() | tuple():
            return [_plain(item) for item in value]
        case dict():
            return {key: _plain(item) for key, item in value.items()}
    return value


def _default(field: msgspec.structs.FieldInfo) -> Any:
    made = field.default_factory
    return field.default if made is msgspec.NODEFAULT else made()


def _key(key: str) -> str:
    return key if BARE.fullmatch(key) else _value(key)


def _value(value: Any) -> str:
    match value:
        case bool():
            return str(value).lower()
        case str():
            return json.dumps(value, ensure_ascii=False)
        case float():
            return repr(value) if math.isfinite(value) else str(value)  # nan, inf, -inf
        case list():
            return f"[{', '.join(map(_value, value))}]"
        case dict():
            return f"{{ {', '.join(f'{_key(k)} = {_value(v)}' for k, v in value.items())} }}"
    return str(value)
