"""Scenario files: find one by its name, and read it.

A file may begin with `extends = "slow_leader"`: it then inherits that scenario's tables, and its
own keys override them. That scenario must not extend a third. Tables are merged key by key; any
other value, lists such as `[[script]]` included, replaces the inherited one as a whole. Title and
description are not inherited.
"""

import json
from pathlib import Path
from typing import Any

import msgspec

from sim.errors import InputError
from sim.scenario import Scenario
from sim.toml_input import convert, merged, nearest, parse_toml, read_toml, shown, unknown_name
from sim.world import World, load_world, world_from_doc, world_names

HERE = Path(__file__).resolve().parent
SCENARIOS = (  # folders of folders of scenarios: the robot's own, and those of exercises beside it
    (HERE / "scenarios", "*/*.toml"),
    (HERE.parent / "grader" / "exercises", "*/scenarios/*.toml"),
)
EXTENDS = "extends"
LIST = "course list --scenarios"
_NOT_INHERITED = ("title", "description")
_MAY_BE_INFINITE = (
    "script.goal", "script.odom", "script.w", "raw.linear_x", "raw.angular_z", "raw.others",
    "node.models", "bench.fill", "bench.patches.range",
)  # fmt: skip


def scenario_names() -> dict[str, Path]:
    """Return all scenarios that come with the course: name → file, sorted by name.

    Raises
    ------
    InputError
        Two files have the same name.
    """
    names: dict[str, Path] = {}
    found = (path for folder, pattern in SCENARIOS for path in folder.glob(pattern))
    for path in sorted(found, key=lambda path: (path.stem, path)):
        if other := names.get(path.stem):
            raise InputError(f"two scenarios are called '{path.stem}': {other} and {path}")
        names[path.stem] = path
    return names


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Return a scenario by its name (`demo_wall`) or from a file (`mine/wall.toml`).

    Raises
    ------
    InputError
        There is no such scenario, or its file is wrong.
    """
    path = _find(name_or_path)
    scenario = scenario_from_toml(read_toml(path), str(path))
    return msgspec.structs.replace(scenario, name=path.stem)


def scenario_from_toml(text: str, where: str) -> Scenario:
    """Return the scenario in a TOML text; `where` names the text in errors.

    Raises
    ------
    InputError
        The text is not a scenario, or what it extends is none.
    """
    doc = _parse(text, where)
    return _scenario(_extended(doc, where) if EXTENDS in doc else doc, where)


def scenario_to_json(scenario: Scenario) -> str:
    """Return the scenario, its world included, as JSON (with NaN and Infinity, as Python does)."""
    return json.dumps(msgspec.to_builtins(scenario))


def scenario_from_json(text: str) -> Scenario:
    """Return the scenario that `scenario_to_json` wrote.

    Raises
    ------
    InputError
        The text is not such JSON.
    """
    try:
        doc = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"scenario: not valid JSON: {error}") from None
    if not isinstance(doc, dict):
        raise InputError("scenario: expected a JSON object")
    return _scenario(doc, "scenario")


def _find(name_or_path: str | Path) -> Path:
    text = str(name_or_path)
    if isinstance(name_or_path, Path) or text.endswith(".toml") or "/" in text:
        return Path(name_or_path)
    if path := _named(text):
        return path
    raise unknown_name("scenario", text, scenario_names(), LIST)


def _named(name: str) -> Path | None:
    """Return the file of the course's scenario of that name, if there is one."""
    found = [
        path
        for folder, pattern in SCENARIOS
        for path in folder.glob(pattern.replace("*.toml", f"{name}.toml"))
    ]
    return found[0] if len(found) == 1 else None


def _parse(text: str, where: str) -> dict[str, Any]:
    doc = parse_toml(text, where)
    if "name" in doc:
        raise InputError(f"{where}: unknown key 'name': the name of a scenario is that of its file")
    return doc


def _extended(doc: dict[str, Any], where: str) -> dict[str, Any]:
    """Return the tables of the scenario that `doc` extends, overridden by those of `doc`."""
    own = {key: value for key, value in doc.items() if key != EXTENDS}
    base = _base(doc[EXTENDS], where)
    inherited = {key: value for key, value in base.items() if key not in _NOT_INHERITED}
    return merged(inherited, own)


def _base(name: Any, where: str) -> dict[str, Any]:
    """Return the tables of a scenario, by its name; it must be valid and extend none."""
    if not isinstance(name, str):
        raise InputError(f"{where}: {EXTENDS} = {shown(name)}: expected a scenario's name")
    at = f'{where}: {EXTENDS} = "{name}"'
    path = _named(name) if "/" not in name else None
    if path is None:
        raise InputError(f"{at}: no scenario is called that{nearest(name, scenario_names(), LIST)}")
    base = _parse(read_toml(path), str(path))
    if EXTENDS in base:
        what = "itself" if base[EXTENDS] == name else f"'{base[EXTENDS]}'"
        raise InputError(f"{at}: '{name}' extends {what}; expected a scenario that extends none")
    _scenario(base, str(path))  # its own mistakes are not those of `where`
    return base


def _scenario(doc: dict[str, Any], where: str) -> Scenario:
    """Resolve the world first: it is a name or a table, and has errors of its own."""
    if "world" not in doc:
        raise InputError(
            f"{where}: missing key 'world' (a world's name, or a table; `extends` inherits one)"
        )
    world = _world(doc["world"], where)
    empty = {**doc, "world": {}}
    scenario = convert(empty, Scenario, where, may_be_infinite=_MAY_BE_INFINITE)
    return msgspec.structs.replace(scenario, world=world)


def _world(value: Any, where: str) -> World:
    if not isinstance(value, str | dict):
        raise InputError(f"{where}: world = {value}: expected a world's name or a table")
    if isinstance(value, dict):
        return world_from_doc(value, where, at=("world",))
    if value not in world_names():
        hint = nearest(value, world_names())
        raise InputError(f'{where}: world = "{value}": no world is called that{hint}')
    return load_world(value)
