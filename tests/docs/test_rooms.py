"""docs/architecture.md draws the rooms as import-linter knows them, and leaves none out."""

import re
import tomllib

from documents import ROOT

PAGE = (ROOT / "docs/architecture.md").read_text("utf-8")


def test_the_drawing_has_the_layers_of_the_contract() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    (layers,) = (one["layers"] for one in contracts if one.get("containers") == ["grader"])
    lines = PAGE.partition("<!-- rooms: begin")[2].partition("<!-- rooms: end")[0].splitlines()
    floors = [{room.strip() for room in line.split("│")[1:-1]} for line in lines if "│" in line]
    assert floors == [set(re.split(r"\s*[|:]\s*", layer)) for layer in layers]


def test_every_room_has_a_sentence() -> None:
    described = re.findall(r"(?m)^\| `(\w+)` \| .+\. \|$", PAGE)
    folder = ROOT / "grader"
    there = {path.name for path in folder.iterdir() if (path / "__init__.py").is_file()}
    there |= {path.stem for path in folder.glob("*.py")} - {"__init__"}
    assert sorted(described) == sorted(there)
