"""The pitfalls' pages and replays: what is made is up to date, and true."""

from __future__ import annotations

import difflib
import math
import re
from pathlib import Path

import numpy as np
import pytest
from pitfall_runs import BY_NAME, EVERY, Runs, each_node, each_pitfall

from grader.authoring.pitfalls import (
    FOLDER,
    FRAME,
    MADE,
    NODES,
    PITFALLS,
    Pitfall,
    drive,
    made,
    main,
    replay,
)
from grader.course.exercises import ROOT, find_exercise
from grader.drive import scenario_for
from grader.errors import InputError
from grader.link.hosts import ForkServer

LARGEST = 600_000  # [bytes] of a replay


QUOTED = [Path(mutant).name for pitfall in PITFALLS for mutant in pitfall.caught]


def page_of(pitfall: Pitfall) -> str:
    return (FOLDER / f"{pitfall.name}.md").read_text("utf-8")


# --- the pages ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "pitfall",
    [
        pytest.param(
            pitfall,
            id=pitfall.name,
            marks=() if pitfall.exercise == "obstacle_avoidance" else pytest.mark.long,
        )
        for pitfall in PITFALLS
    ],
)
def test_what_is_made_is_up_to_date(forkserver: ForkServer, pitfall: Pitfall) -> None:
    for file, text in made(forkserver, [pitfall]):
        assert file.read_text("utf-8") == text, (
            f"{file.name}: run `python -m grader.authoring.pitfalls --made`"
        )


def test_there_is_no_more_than_the_pages_show() -> None:
    nodes = {node for _, node in EVERY}
    assert len(set(QUOTED)) == len(QUOTED)  # their texts have different names
    assert {file.stem for file in NODES.glob("*.py")} == nodes
    files = {f"{node}.frame.txt" for node in nodes} | {f"{name}.grade.txt" for name in QUOTED}
    files |= {f"{pitfall.name}.diff" for pitfall in PITFALLS}
    assert {file.name for file in MADE.iterdir()} == files
    assert {file.stem for file in FOLDER.glob("*.md")} == {"index", *BY_NAME}


@each_pitfall
def test_a_page_shows_all_of_its_parts(pitfall: Pitfall) -> None:
    page = page_of(pitfall)
    parts = [f"made/{node}.frame.txt" for node in pitfall.nodes]
    parts += [f"made/{Path(mutant).name}.grade.txt" for mutant in pitfall.caught]
    parts += [f"made/{pitfall.name}.diff", f"nodes/{pitfall.name}_wrong.py", pitfall.right]
    parts += [f"replays/{name}" for name in FRAME]
    assert [part for part in parts if part not in page] == []
    for checks in pitfall.caught.values():
        assert all(f"`{check}`" in page for check in checks)
    assert f"course grade {find_exercise(pitfall.exercise).number} " in page
    assert f"--scenario {pitfall.scenario}" in page


@each_pitfall
def test_the_emphasised_lines_are_those_that_change(pitfall: Pitfall) -> None:
    found = re.search(r":emphasize-lines: ([\d,-]+)", page_of(pitfall))
    assert found
    emphasised = set()
    for part in found[1].split(","):
        first, _, last = part.partition("-")
        emphasised |= set(range(int(first), int(last or first) + 1))
    before, after = (
        (NODES / f"{node}.py").read_text("utf-8").splitlines()
        for node in (f"{pitfall.name}_wrong", pitfall.right)
    )
    changes = difflib.SequenceMatcher(None, before, after, autojunk=False).get_opcodes()
    gone = {
        n + 1 for tag, i, j, _, _ in changes if tag in ("replace", "delete") for n in range(i, j)
    }
    # Where lines only come in, the one that they guard or that does without them is shown.
    assert gone <= emphasised
    assert all(before[n - 1].strip() for n in emphasised)
    assert len(emphasised) <= len(gone) + 1


@each_node
def test_nodes_import_nothing_but_ros_numpy_and_the_library(pitfall: Pitfall, node: str) -> None:
    source = (NODES / f"{node}.py").read_text("utf-8")
    imported = set(re.findall(r"^(?:from|import) (\w+)", source, re.MULTILINE))
    known = {"math", "pickle", "numpy", "rclpy", "geometry_msgs", "nav_msgs", "sensor_msgs"}
    assert imported <= known
    compile(source, node, "exec")


def test_the_table_of_clamps_is_true() -> None:
    rows = re.findall(r"^\| `(.+?)` \| `(\S+)` \|$", page_of(BY_NAME["nan_through_clip"]), re.M)
    assert len(rows) == 4
    for expression, result in rows:
        value = eval(expression, {"np": np, "speed": math.nan})
        assert str(float(value)) == result, expression


def test_the_commands_name_checks_nodes_and_scenarios_that_exist() -> None:
    commands = [
        line
        for pitfall in PITFALLS
        for line in page_of(pitfall).splitlines()
        if line.startswith("course ")
    ]
    assert len(commands) >= 2 * len(PITFALLS)
    for line in commands:
        file = next(word for word in line.split() if word.endswith(".py"))
        if line.startswith("course drive"):
            assert (NODES / file).is_file()
        else:
            assert file in find_exercise(line.split()[2]).files
        if scenario := re.search(r"--scenario (\S+)", line):
            scenario_for(scenario[1])
        for check in re.findall(r"--only (\w+)", line):
            slug = find_exercise(line.split()[2]).slug
            checks = (ROOT / "grader" / "exercises" / slug).glob("test_*.py")
            assert any(f"def test_{check}(" in file.read_text("utf-8") for file in checks)


# --- replays --------------------------------------------------------------------------------------


@each_node
def test_a_replay_is_small_and_names_no_machine(runs: Runs, pitfall: Pitfall, node: str) -> None:
    html = replay(pitfall, runs.of(pitfall.name, node))
    assert len(html.encode()) < LARGEST
    assert str(ROOT) not in html
    assert "site-packages" not in html
    assert "dist-packages" not in html


def test_two_runs_give_the_same_replay(runs: Runs, forkserver: ForkServer) -> None:
    pitfall = BY_NAME["left_right_swapped"]
    node = "left_right_swapped_wrong"
    again = replay(pitfall, drive(pitfall, node, forkserver))
    assert again == replay(pitfall, runs.of(pitfall.name, node))


@pytest.mark.parametrize("arguments", [[], ["--chekc"], ["a", "b"]])
def test_other_arguments_are_refused(arguments: list[str]) -> None:
    with pytest.raises(InputError, match="expected a folder"):
        main(arguments)
