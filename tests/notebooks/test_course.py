"""The notebooks: made from other files, complete, and they run."""

import json
import re
from collections import Counter
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient
from nbgrader_kit import (
    FULL,
    MadeOnce,
    cell_named,
    exercises_of,
    fill,
    nbgrader,
    released,
    solution,
    source_of,
    stored,
    whole_course,
)

from grader.course.exercises import ROOT, all_exercises
from grader.course.installed import why_not
from grader.errors import GraderError
from grader.nbgrader.cells import definition
from grader.nbgrader.points import points_of
from grader.notebook import build

ALL = build.all_notebooks()
RUN = [name for name in ALL if name != "quiz"] if FULL else ["01_loop"]


@pytest.fixture(scope="module")
def course(made_once: MadeOnce) -> Path:
    return whole_course(made_once)


# --- made from elsewhere -------------------------------------------------------------------


def test_every_text_can_be_filled_in() -> None:
    for name in ALL:
        nbformat.validate(stored(name))


def test_each_exercise_has_a_notebook_of_its_number() -> None:
    made = {
        name: [d.file for c in stored(name).cells if (d := definition(c.source))] for name in ALL
    }
    for exercise in all_exercises():
        (name,) = [
            name for name, files in made.items() if not set(exercise.files).isdisjoint(files)
        ]
        assert name.startswith(f"{exercise.number:02}_")
        assert set(made[name]) == set(exercise.files)
        places = {cell.metadata.get(build.PLACE) for cell in stored(name).cells}
        assert {f"contract {exercise.slug}", f"hints {exercise.slug}"} <= places


@pytest.mark.parametrize(
    ("note", "more"),
    [
        ("# (filled in: grader/notebook/bootstrap.py)", "import grader"),
        ("tasks of exercises/obstacle_avoidance/README.md)*", "\n\nAnd one task more."),
        ("# (filled in: solutions/obstacle_avoidance/obstacle_avoidance_agent.py)", "\nx = 1"),
        ("*(filled in: exercises/obstacle_avoidance/hints.md)*", "Think first."),
    ],
)
def test_what_is_written_where_it_would_be_lost_is_an_error(
    note: str, more: str, tmp_path: Path
) -> None:
    text = build.text_of("01_loop").read_text("utf-8")
    assert text.count(note) == 1
    path = tmp_path / "01_loop.md"
    for wrong in (text.replace(note, more), text.replace(note, note + more)):
        path.write_text(wrong, "utf-8")
        with pytest.raises(GraderError, match=r"01_loop\.md: a cell is filled in.*expected '"):
            build.built(path)


def test_the_notebooks_are_made_and_only_asked_for_with_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    texts = tmp_path / "text"
    (texts / "01_loop").mkdir(parents=True)
    monkeypatch.setattr(build, "TEXTS", texts)
    monkeypatch.setattr(build, "SOURCES", tmp_path / "source")
    text = (ROOT / "notebooks/text/01_loop/01_loop.md").read_text("utf-8")
    (texts / "01_loop/01_loop.md").write_text(text, "utf-8")
    assert build.main(["--check"]) == 0
    assert not list(tmp_path.rglob("*.ipynb"))
    assert build.main([]) == 0
    made = nbformat.read(tmp_path / "source/01_loop/01_loop.ipynb", as_version=4)
    assert made == stored("01_loop")
    (texts / "01_loop/01_loop.md").write_text(text.replace(",drives_on", ""), "utf-8")
    assert build.main(["--check"]) == 2
    assert "01_loop.md: not in exactly one cell: drives_on" in capsys.readouterr().err


def test_without_solutions_there_are_skeletons(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in an image for students, which has no solutions (.dockerignore)."""
    monkeypatch.setattr(build, "SOLUTIONS", ROOT / "no_such_folder")
    made = [d for c in build.built(build.text_of("03_goal")).cells if (d := definition(c.source))]
    exercise = next(each for each in all_exercises() if each.slug == "goal_seeking")
    for one in made:
        assert one.text == (exercise.folder / one.file).read_text("utf-8")
    assert {one.file for one in made} == set(exercise.files)


def test_ids_stay_when_a_cell_is_put_between(tmp_path: Path) -> None:
    text = (build.text_of("03_goal")).read_text("utf-8")
    head, mark, tail = text.partition("## Angles wrap")
    more = f"{head}## A new part\n\nWords.\n\n```{{code-cell}}\n1 + 1\n```\n\n{mark}{tail}"
    (tmp_path / "03_goal.md").write_text(more, "utf-8")
    before = [cell.id for cell in stored("03_goal").cells]
    after = [cell.id for cell in build.built(tmp_path / "03_goal.md").cells]
    assert [name for name in after if name in before] == before
    assert len(after) == len(before) + 2


# --- complete ------------------------------------------------------------------------------


def test_every_exercise_is_in_one_notebook_with_the_judges_points() -> None:
    sums: Counter[str] = Counter()
    for name in ALL:
        notebook = stored(name)
        for grade_id, want in build.asked_by(notebook).items():
            points = cell_named(notebook, grade_id)["metadata"]["nbgrader"]["points"]
            assert points == sum(points_of(want.exercise)[check] for check in want.checks)
            sums[want.exercise] += points
    wanted = {exercise.slug: 100 for exercise in all_exercises()}
    assert sums == wanted, "each check in one `check(…)` cell of notebooks/text; make skeletons"


def test_a_check_that_is_forgotten_or_doubled_is_an_error(tmp_path: Path) -> None:
    text = (build.text_of("01_loop")).read_text("utf-8")
    path = tmp_path / "01_loop.md"
    for wrong in (text.replace(",drives_on", ""), text.replace(",drives_on", ",drives_on,blind")):
        path.write_text(wrong, "utf-8")
        with pytest.raises(Exception, match=r"not in exactly one cell: (drives_on|blind)"):
            build.built(path)
    path.write_text(text.replace("slow_zone", "slow_zon"), "utf-8")
    with pytest.raises(Exception, match="has no check 'slow_zon'"):
        build.built(path)


# --- released ------------------------------------------------------------------------------


@pytest.mark.long
def test_the_release_has_exactly_the_skeletons(course: Path) -> None:
    found = {}
    for name in ALL:
        for cell in released(course, name)["cells"]:
            made = definition(source_of(cell)) if cell["cell_type"] == "code" else None
            if made is not None:
                found[made.file] = made.text
    for exercise in all_exercises():
        for file in exercise.files:
            assert found.pop(file) == (exercise.folder / file).read_text("utf-8")
    assert not found


@pytest.mark.long
def test_the_release_gives_nothing_away(course: Path) -> None:
    for name in ALL:
        text = json.dumps(released(course, name))
        assert not re.search(
            r"(BEGIN|END) SOLUTION|### SKELETON|[Rr]ubric|MARK SCHEME|[Mm]ark scheme", text
        ), name
    assert "Mark scheme" in json.dumps(stored("quiz"))


def test_a_queues_ages_are_those_that_the_lesson_prints(capsys: pytest.CaptureFixture[str]) -> None:
    (cell,) = [cell.source for cell in stored("05_real_time").cells if "def ages(" in cell.source]
    names: dict[str, Any] = {}
    exec(cell.partition("\ntry:")[0], names)
    lesson = (ROOT / "lessons/real_time.md").read_text("utf-8")
    for depth, model_ms in ((10, 200), (5, 200), (1, 200), (1, 230)):
        names["ages"](depth, model_ms)
        printed = capsys.readouterr().out.partition("from ")[2]
        assert f"ten calls: scans {printed}" in lesson, (depth, model_ms)


@pytest.mark.long
def test_the_quiz_asks_what_the_lesson_asks(course: Path) -> None:
    quiz = (ROOT / "lessons" / "quiz.md").read_text("utf-8")
    given = released(course, "quiz")["cells"]
    text = "\n".join(source_of(cell) for cell in given)
    for question in re.findall(r"(?ms)^\*(.+?)\*$", quiz):
        assert question in text
    answers = [cell for cell in given if cell["metadata"].get("nbgrader", {}).get("grade")]
    assert [cell["metadata"]["nbgrader"]["points"] for cell in answers] == [3] * 5
    assert {source_of(cell) for cell in answers} == {"*Your answer:*"}
    rubric = [line for line in quiz.splitlines() if re.match(r"\| \d \|", line)]
    assert all(line in json.dumps(stored("quiz"), ensure_ascii=False) for line in rubric)


# --- run -----------------------------------------------------------------------------------


def run(notebook: dict[str, Any], folder: Path) -> Any:
    """Run a notebook in a fresh folder, top to bottom; an error in a cell ends it."""
    folder.mkdir(parents=True)
    found = nbformat.reads(json.dumps(notebook), as_version=4)
    where = {"metadata": {"path": str(folder)}}
    NotebookClient(found, timeout=300, kernel_name="python3", resources=where).execute()
    return found


def filled(course: Path, name: str) -> dict[str, Any]:
    files = {file: solution(e.slug, file) for e in exercises_of(name) for file in e.files}
    return fill(released(course, name), files)


def said(cell: Any) -> str:
    """Return all that a cell showed as text."""
    texts = [str(o.get("text", "") or o.get("data", {}).get("text/plain", ""))
             for o in cell.get("outputs", ())]  # fmt: skip
    return "\n".join(texts)


def complaints(notebook: Any) -> list[str]:
    return [
        f"{cell.id}: {output}"
        for cell in notebook.cells
        for output in cell.get("outputs", ())
        if output.output_type == "error" or output.get("name") == "stderr"
    ]


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")  # jupyter_client's, about its own transports
@pytest.mark.parametrize("name", RUN)
def test_with_the_solutions_every_check_passes(course: Path, tmp_path: Path, name: str) -> None:
    notebook = run(filled(course, name), tmp_path / name)
    assert complaints(notebook) == []
    for grade_id, want in build.asked_by(stored(name)).items():
        text = said(cell_named(notebook, grade_id))
        assert "FAIL" not in text
        lacks = [file for file in ("torch", "keras") if why_not([file])]
        passed, skipped = text.count("✓ pass"), text.count("skip")
        assert passed + skipped >= len(want.checks), text
        assert not skipped or lacks, text


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", RUN)
def test_with_the_skeletons_it_runs_and_fails_kindly(
    course: Path, tmp_path: Path, name: str
) -> None:
    notebook = run(released(course, name), tmp_path / name)
    assert complaints(notebook) == []
    for cell in notebook.cells:
        assert "Traceback" not in said(cell), cell.id
    for grade_id in build.asked_by(stored(name)):
        text = said(cell_named(notebook, grade_id))
        assert re.search(r"FAIL|skip    ", text), text


@pytest.mark.long
@pytest.mark.skipif(not FULL, reason="nbgrader's own validation: make notebooks")
@pytest.mark.parametrize("name", RUN)
def test_nbgraders_validation_agrees(course: Path, tmp_path: Path, name: str) -> None:
    (tmp_path / "nbgrader_config.py").write_text("c = get_config()\nc.Execute.timeout = 300\n")
    for notebook, passes in ((filled(course, name), True), (released(course, name), False)):
        path = tmp_path / f"{name}.ipynb"
        path.write_text(json.dumps(notebook), "utf-8")
        text = nbgrader(tmp_path, "validate", path.name)
        assert ("Success! Your notebook passes all the tests." in text) == passes, text
        count = len(build.asked_by(stored(name)))
        assert (f"VALIDATION FAILED ON {count} CELL(S)" in text) != passes, text
