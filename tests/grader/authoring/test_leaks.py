"""The search for answers in what students get."""

import html
import json
import shutil
from pathlib import Path

import pytest

from grader.authoring.leaks import leaks
from grader.claims.mutants import find_mutant
from grader.course.exercises import ROOT, find_exercise
from grader.course.skeletons import strip_solution


@pytest.mark.parametrize(
    ("source", "where"),
    [
        ("obstacle_avoidance_agent.py", "grader/helper.py"),
        ("variants/spin_once_loop.py", "lessons/lesson.md"),
        ("mutants.diff: whole_circle", "sim/new.py"),
    ],
)
def test_the_search_finds_what_is_put_in(tmp_path: Path, where: str, source: str) -> None:
    lines = lines_of(f"obstacle_avoidance/{source}")
    start = next(i for i, line in enumerate(lines) if ".ranges" in line)
    target = tmp_path / where
    target.parent.mkdir(parents=True)
    target.write_text("    text\n" + "\n\n".join(lines[start - 2 : start + 8]), "utf-8")
    found = leaks(tmp_path)
    assert found
    assert not any(leak.earlier for leak in found)
    assert all(leak.solution.startswith("solutions/") for leak in found)


@pytest.mark.long
def test_checks_belong_into_the_grader_and_nowhere_else(tmp_path: Path) -> None:
    oracle = ROOT / "grader" / "exercises" / "trend_memory" / "contract.py"
    place = "grader/exercises/trend_memory/contract.py"
    here = tmp_path / place
    here.parent.mkdir(parents=True)
    here.write_bytes(oracle.read_bytes())
    assert leaks(tmp_path) == []

    (tmp_path / "hints.md").write_bytes(oracle.read_bytes())
    assert {(leak.file, leak.solution) for leak in leaks(tmp_path)} == {("hints.md", place)}


def lines_of(source: str) -> list[str]:
    """Return the lines of a solution, or of a mutant (`NAME/mutants.diff: MUTANT`)."""
    file, _, mutant = source.partition(": ")
    if mutant:
        text = find_mutant(find_exercise(file.partition("/")[0]), mutant).text
    else:
        text = (ROOT / "solutions" / file).read_text("utf-8")
    return [line for line in text.splitlines() if "###" not in line]


PAGE = '<td class="linenos"></td><div class="highlight"><pre>{}</pre></div>'
MUTANT = "goal_seeking/mutants.diff: heading_without_yaw"


def test_the_search_reads_pages_as_a_reader_does(tmp_path: Path) -> None:
    """Sphinx numbers the lines, colours the words and writes &lt; for <."""
    coloured = "\n".join(
        f'<span class="linenos">{number:2}</span><span></span><span class="n">'
        f"{html.escape(line).replace(' = ', '</span> <span class=o>=</span> <span>')}</span>"
        for number, line in enumerate(lines_of(MUTANT), start=1)
    )
    (tmp_path / "lesson.html").write_text(PAGE.format(coloured), "utf-8")
    found = leaks(tmp_path)
    assert {leak.file for leak in found} == {"lesson.html"}
    assert f"solutions/{MUTANT}" in {leak.solution for leak in found}


def test_the_search_reads_notebooks_cell_by_cell(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "exercises", tmp_path / "exercises")
    skeleton = (ROOT / "exercises/trend_memory/trend_agent.py").read_text("utf-8")
    mutant = "\n".join(lines_of(MUTANT))
    cells = [
        {"cell_type": "markdown", "source": "words"},
        {"cell_type": "code", "source": f"%%node trend_agent.py\n{skeleton}", "outputs": []},
        {"cell_type": "markdown", "source": mutant},
        {"cell_type": "code", "source": ["### BEGIN HIDDEN TESTS\n", "assert True"], "outputs": []},
    ]
    (tmp_path / "03_goal.ipynb").write_text(json.dumps({"cells": cells}), "utf-8")
    found = [leak for leak in leaks(tmp_path) if leak.file.startswith("03_goal")]
    earlier = [leak for leak in found if leak.earlier]
    assert {leak.file for leak in earlier} == {"03_goal.ipynb, cell 2"}
    assert {leak.solution.split("/")[1] for leak in earlier} == {"obstacle_avoidance"}
    wrong = [leak for leak in found if not leak.earlier]
    assert {leak.file for leak in wrong if leak.solution} == {"03_goal.ipynb, cell 3"}
    assert [leak.file for leak in wrong if not leak.solution] == ["03_goal.ipynb, cell 4"]


def test_a_skeleton_is_no_leak_and_its_solution_is(tmp_path: Path) -> None:
    source = ROOT / "solutions" / "goal_seeking" / "goal_seeking_agent.py"
    target = tmp_path / "exercises" / "goal_seeking" / source.name
    target.parent.mkdir(parents=True)
    target.write_text(strip_solution(source.read_text("utf-8")), "utf-8")
    assert leaks(tmp_path) == []
    target.write_text(source.read_text("utf-8"), "utf-8")
    assert {leak.solution for leak in leaks(tmp_path)} == {
        "",
        "solutions/goal_seeking/goal_seeking_agent.py",
    }


def test_how_a_node_begins_and_ends_is_no_answer(tmp_path: Path) -> None:
    imports = [line for line in lines_of(MUTANT) if line.startswith(("import ", "from "))]
    skeleton = (ROOT / "exercises/model_server/detection_client.py").read_text("utf-8")
    main = skeleton[skeleton.index("def main(") :]
    (tmp_path / "lesson.md").write_text("\n".join([*imports, "", main]), "utf-8")
    assert len(imports) >= 6
    assert leaks(tmp_path) == []
