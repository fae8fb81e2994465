"""The pitfalls' pages and replays: what is made is up to date, and true."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from pitfall_runs import BY_NAME, EVERY, Runs, each_node, each_pitfall, long_but_1

from grader.authoring.pitfalls import FOLDER, MADE, NODES, PITFALLS, Pitfall, made, main, replay
from grader.course.exercises import ROOT, find_exercise
from grader.drive import scenario_for
from grader.errors import InputError
from rclpy_virtual_time.link.hosts import ForkServer

LARGEST = 600_000  # [bytes] of a replay


QUOTED = [Path(mutant).name for pitfall in PITFALLS for mutant in pitfall.caught]


def page_of(pitfall: Pitfall) -> str:
    return (FOLDER / f"{pitfall.name}.md").read_text("utf-8")


# --- the pages ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "pitfall", [pytest.param(p, id=p.name, marks=long_but_1(p.exercise)) for p in PITFALLS]
)
def test_what_is_made_is_up_to_date(forkserver: ForkServer, runs: Runs, pitfall: Pitfall) -> None:
    for file, text in made(forkserver, [pitfall], lambda p, node, _: runs.of(p.name, node)):
        assert file.read_text("utf-8") == text, (
            f"{file.name}: run `python -m grader.authoring.pitfalls --made`"
        )


def test_there_is_no_more_than_the_pages_show() -> None:
    nodes, replays = zip(*((node, pitfall.replay_of(node)) for pitfall, node in EVERY), strict=True)
    assert len(set(QUOTED)) == len(QUOTED)  # their texts have different names
    assert {file.stem for file in NODES.glob("*.py")} == set(nodes)
    files = {f"{name}.frame.txt" for name in replays} | {f"{name}.grade.txt" for name in QUOTED}
    files |= {f"{pitfall.name}.diff" for pitfall in PITFALLS}
    assert {file.name for file in MADE.iterdir()} == files
    assert {file.stem for file in FOLDER.glob("*.md")} == {"index", *BY_NAME}


@each_pitfall
def test_a_page_shows_all_of_its_parts(pitfall: Pitfall) -> None:
    page = page_of(pitfall)
    parts = [f"made/{pitfall.replay_of(node)}.frame.txt" for node in pitfall.nodes]
    parts += [f"made/{Path(mutant).name}.grade.txt" for mutant in pitfall.caught]
    parts += [f"made/{pitfall.name}.diff", f"nodes/{pitfall.name}_wrong.py", pitfall.right]
    assert [part for part in parts if part not in page] == []
    for checks in pitfall.caught.values():
        assert all(f"`{check}`" in page for check in checks)
    assert f"course grade {find_exercise(pitfall.exercise).number} " in page
    assert f"--scenario {pitfall.scenario}" in page


def test_the_table_of_clamps_is_true() -> None:
    rows = re.findall(r"^\| `(.+?)` \| `(\S+)` \|$", page_of(BY_NAME["nan_through_clip"]), re.M)
    assert len(rows) == 4
    for expression, result in rows:
        value = eval(expression, {"np": np, "speed": math.nan})
        assert str(float(value)) == result, expression


@each_pitfall
def test_the_commands_name_checks_nodes_and_scenarios_that_exist(pitfall: Pitfall) -> None:
    commands = re.findall(r"(?m)^course (\w+) (\S+) ?(.*)$", page_of(pitfall))
    assert len(commands) >= 2
    for verb, first, rest in commands:
        if verb == "drive":
            assert (NODES / first).is_file()
        else:
            exercise = find_exercise(first)
            assert rest.split()[0] in exercise.files
            tests = (ROOT / "grader" / "exercises" / exercise.slug).glob("test_*.py")
            source = "".join(file.read_text("utf-8") for file in tests)
            assert all(f"def test_{name}(" in source for name in re.findall(r"--only (\w+)", rest))
        for scenario in re.findall(r"--scenario (\S+)", rest):
            scenario_for(scenario)


# --- replays --------------------------------------------------------------------------------------


@each_node
def test_a_replay_is_small_and_names_no_machine(runs: Runs, pitfall: Pitfall, node: str) -> None:
    html = replay(pitfall, runs.of(pitfall.name, node))
    assert len(html.encode()) < LARGEST
    assert [word for word in (str(ROOT), "site-packages", "dist-packages") if word in html] == []


def test_other_arguments_are_refused() -> None:
    with pytest.raises(InputError, match="expected a folder"):
        main(["--chekc"])
