"""Scenario files: find one by its name, and read it.

A file may begin with `extends = "slow_leader"`: it then inherits that scenario's tables, and its
own keys override them. That scenario must not extend a third. Tables are merged key by key; any
other value, lists such as `[[script]]` included, replaces the inherited one as a whole. Title and
description are not inherited.

A scenario with a `bench` has an empty world and no odometry where it says nothing of them. An entry
of its bench or script may stand for several; see `sim.scenario_lists`.

`[robot] name = "turtlebot3_burger"` has the limits that `sim.scenario.ROBOTS` has of that
name; other keys of the table override them.

A table `[matrix]` makes several scenarios of one file: `[matrix.onnx]` in `format_raises.toml` is
`format_raises_onnx`, with these keys over the file's own. The file itself is none then.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from sim.errors import InputError
from sim.scenario import ROBOTS, Scenario
from sim.scenario_lists import events_of, scans_of
from sim.toml_input import convert, merged, nearest, parse_toml, read_toml, shown, unknown_name
from sim.world import World, load_world, world_from_doc, world_names

HERE = Path(__file__).resolve().parent
SCENARIOS = (  # folders of folders of scenarios: the robot's own, and those of exercises beside it
    (HERE / "scenarios", "*/*.toml"),
    (HERE.parent / "grader" / "exercises", "*/scenarios/*.toml"),
)
EXTENDS, MATRIX = "extends", "matrix"
BENCH_DEFAULTS = {
    "world": {"description": "Nothing: the bench says what the lidar sees."},
    "odometry": {"enabled": False},
}
LIST = "course list --scenarios"
_NOT_INHERITED = ("title", "description")
_MAY_BE_INFINITE = (
    "script.goal", "script.odom", "script.w", "raw.linear_x", "raw.angular_z", "raw.others",
    "node.models", "bench.fill", "bench.patches.range",
)  # fmt: skip


def scenario_names() -> dict[str, Path]:
    """Return all scenarios that come with the course: name → file, sorted by name.

    Raises InputError: two have the same name, or a file's matrix is none.
    """
    names: dict[str, Path] = {}
    found = (path for folder, pattern in SCENARIOS for path in folder.glob(pattern))
    for path in sorted(found, key=lambda path: (path.stem, path)):
        for name in _names_in(path):
            if other := names.get(name):
                raise InputError(f"two scenarios are called '{name}': {other} and {path}")
            names[name] = path
    return dict(sorted(names.items()))


def names_of(stem: str, doc: Mapping[str, Any]) -> list[str]:
    """Return the names of the scenarios in a file of that stem: its own, or those of its matrix."""
    return [f"{stem}_{cell}" for cell in doc[MATRIX]] if MATRIX in doc else [stem]


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Return a scenario by its name (`demo_wall`) or from a file (`mine/wall.toml`).

    Raises InputError: there is no such scenario, or its file is wrong.
    """
    path = _find(name_or_path)
    name = str(name_or_path) if _is_name(name_or_path) else path.stem
    doc = _tables_in(path, name)
    scenario = _scenario(_extended(doc, str(path)) if EXTENDS in doc else doc, str(path))
    return msgspec.structs.replace(scenario, name=name)


def tables_of(name: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the tables of a file that is a scenario once more, and all it has then.

    The scenario is one of the course's, by its name, or one of somebody's own, by its path.

    Raises InputError: no scenario is called that.
    """
    path = _find(name)
    doc = _tables_in(path, name)
    if not _is_name(name) and EXTENDS not in doc:  # a file of somebody's own
        return doc, doc
    if EXTENDS in doc:
        return doc, {**_extended(doc, str(path)), "title": doc["title"]}
    return {**{key: doc[key] for key in _NOT_INHERITED if key in doc}, EXTENDS: name}, doc


def scenario_from_toml(text: str, where: str) -> Scenario:
    """Return the scenario in a TOML text; `where` names the text in errors.

    Raises InputError: the text is not a scenario, or what it extends is none.
    """
    doc = _parse(text, where)
    return _scenario(_extended(doc, where) if EXTENDS in doc else doc, where)


def scenario_to_json(scenario: Scenario) -> str:
    """Return the scenario, its world included, as JSON (with NaN and Infinity, as Python does)."""
    return json.dumps(msgspec.to_builtins(scenario))


def scenario_from_json(text: str) -> Scenario:
    """Return the scenario that `scenario_to_json` wrote.

    Raises InputError: the text is not such JSON.
    """
    try:
        doc = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"scenario: not valid JSON: {error}") from None
    if not isinstance(doc, dict):
        raise InputError("scenario: expected a JSON object")
    return _scenario(doc, "scenario")


def _is_name(name_or_path: str | Path) -> bool:
    text = str(name_or_path)
    return not (isinstance(name_or_path, Path) or text.endswith(".toml") or "/" in text)


def _find(name_or_path: str | Path) -> Path:
    text = str(name_or_path)
    if not _is_name(name_or_path):
        return Path(name_or_path)
    if path := _named(text):
        return path
    raise unknown_name("scenario", text, scenario_names(), LIST)


def _named(name: str) -> Path | None:
    """Return the file of the course's scenario of that name, if there is one."""
    parts = name.split("_")
    stems = ["_".join(parts[:count]) for count in range(len(parts), 0, -1)]  # its own file first
    for stem in stems:
        found = [
            path
            for folder, pattern in SCENARIOS
            for path in folder.glob(pattern.replace("*.toml", f"{stem}.toml"))
            if name in _names_in(path)
        ]
        if found:
            return found[0] if len(found) == 1 else None
    return None


def _names_in(path: Path) -> list[str]:
    """Return the names of the scenarios in a file: its own, or those of its matrix."""
    text = read_toml(path)
    if f"[{MATRIX}" not in text:
        return [path.stem]
    doc = _parse(text, str(path))
    if not isinstance(doc.get(MATRIX), dict) or not doc[MATRIX]:
        raise InputError(f"{path}: {MATRIX}: expected at least one cell, such as [{MATRIX}.onnx]")
    return names_of(path.stem, doc)


def _tables_in(path: Path, name: str) -> dict[str, Any]:
    """Return the tables of the scenario of that name in a file."""
    cell = name.removeprefix(f"{path.stem}_") if path.stem != name else ""
    return _cell(_parse(read_toml(path), str(path)), cell, path)


def _cell(doc: dict[str, Any], cell: str, path: Path) -> dict[str, Any]:
    """Return the tables of one cell of a file's matrix; of a file without one, its own."""
    if MATRIX not in doc:
        return doc
    cells = doc[MATRIX]
    if cell not in cells:
        raise InputError(
            f"{path}: it is several scenarios ({', '.join(_names_in(path))}); name one of them"
        )
    return merged({key: value for key, value in doc.items() if key != MATRIX}, cells[cell])


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
    base = _tables_in(path, name)
    if EXTENDS in base:
        what = "itself" if base[EXTENDS] == name else f"'{base[EXTENDS]}'"
        raise InputError(f"{at}: '{name}' extends {what}; expected a scenario that extends none")
    _scenario(base, str(path))  # its own mistakes are not those of `where`
    return base


def _scenario(doc: dict[str, Any], where: str) -> Scenario:
    """Resolve the world first: it is a name or a table, and has errors of its own."""
    if "bench" in doc:
        bench = scans_of(doc["bench"], f"{where}: bench")
        doc = {**BENCH_DEFAULTS, **doc, "bench": bench}
    if "script" in doc:
        doc = {**doc, "script": events_of(doc["script"], f"{where}: script")}
    if "world" not in doc:
        raise InputError(
            f"{where}: missing key 'world' (a world's name, or a table; `extends` inherits one)"
        )
    world = _world(doc["world"], where)
    robot = _robot(doc.get("robot", {}), where)
    empty = {**doc, "robot": robot, "world": {}}
    scenario = convert(empty, Scenario, where, may_be_infinite=_MAY_BE_INFINITE)
    return msgspec.structs.replace(scenario, world=world)


def _robot(value: Any, where: str) -> Any:
    """Return a robot's table with the limits of the robot that it names, if any."""
    if not isinstance(value, dict) or "name" not in value:
        return value
    name = value["name"]
    if not isinstance(name, str) or name not in ROBOTS:
        hint = nearest(str(name), ROBOTS)
        raise InputError(f"{where}: robot.name = {shown(name)}: no robot is called that{hint}")
    return {**ROBOTS[name], **{key: each for key, each in value.items() if key != "name"}}


def _world(value: Any, where: str) -> World:
    if not isinstance(value, str | dict):
        raise InputError(f"{where}: world = {value}: expected a world's name or a table")
    if isinstance(value, dict):
        return world_from_doc(value, where, at=("world",))
    if value not in world_names():
        hint = nearest(value, world_names())
        raise InputError(f'{where}: world = "{value}": no world is called that{hint}')
    return load_world(value)
