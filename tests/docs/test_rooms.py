"""docs/architecture.md draws the rooms as import-linter knows them, and leaves none out."""

from __future__ import annotations

import re
import tomllib

from documents import ROOT

PAGE = (ROOT / "docs/architecture.md").read_text("utf-8")
WALL = "│"


def contract() -> list[set[str]]:
    """Return the layers that `make lint` holds, top first."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (layers,) = (one["layers"] for one in contracts if one["type"] == "layers")
    return [set(re.split(r"\s*[|:]\s*", layer)) for layer in layers]


def drawing() -> list[set[str]]:
    """Return the drawn floors, top first."""
    drawn = PAGE.partition("<!-- rooms: begin")[2].partition("<!-- rooms: end")[0]
    walls = [line for line in drawn.splitlines() if WALL in line]
    return [{room.strip() for room in line.split(WALL)[1:-1]} for line in walls]


def test_the_drawing_has_the_layers_of_the_contract() -> None:
    assert drawing() == contract()


def test_the_drawing_has_a_floor_between_any_two_layers() -> None:
    """Rooms that share a floor are the ones that may not import each other."""
    lines = PAGE.partition("<!-- rooms: begin")[2].partition("<!-- rooms: end")[0].splitlines()
    drawn = [line.strip() for line in lines if re.search("[│├┌└]", line)]
    rooms = [WALL in line for line in drawn]
    assert rooms == [False, True] * len(contract()) + [False]
    assert len({len(line) - re.search("[│├┌└]", line).start() for line in drawn}) == 1  # type: ignore[union-attr]


def test_every_room_has_a_sentence() -> None:
    described = re.findall(r"(?m)^\| `(\w+)` \| (.+\.) \|$", PAGE)
    assert [room for room, _ in described] == [
        room for floor in drawing() for room in _in_order(floor)
    ]
    folder = ROOT / "grader"
    there = {path.name for path in folder.iterdir() if (path / "__init__.py").is_file()}
    there |= {path.stem for path in folder.glob("*.py")} - {"__init__"}
    assert {room for room, _ in described} == there


def _in_order(floor: set[str]) -> list[str]:
    return sorted(floor, key=lambda room: PAGE.index(f" {room} "))
