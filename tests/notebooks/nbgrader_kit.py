"""A course in a temporary folder, nbgrader's own commands, and students who hand notebooks in."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import nbformat
from nbgrader.api import Grade, Gradebook

from grader.course.exercises import ROOT, Exercise, find_exercise
from grader.nbgrader.cells import definition
from grader.notebook.build import NOTEBOOKS, all_notebooks, asked_by, built, text_of

FULL = os.environ.get("COURSE_NOTEBOOKS") == "full"
MARKS = re.compile(r"(?ms)^ *### (?:BEGIN SOLUTION|(?:SKELETON$.*?### )?END SOLUTION)\n")
ALL = "*"  # nbgrader's commands take it for "every assignment"
MadeOnce = Callable[[str, Callable[[Path], object]], Path]  # of tests/conftest.py

Cell = dict[str, Any]

Grades = dict[tuple[str, str, str], tuple[float | None, bool]]  # student, notebook, cell


def nbgrader(folder: Path, *arguments: str, ok: bool = True, **variables: str) -> str:
    """Run an nbgrader command as a person would; return what it said.

    Its programs are not on the PATH, as in an environment that is not activated.
    """
    paths = {"JUPYTER_CONFIG_DIR": str(folder / ".jupyter"), "PATH": "/usr/bin:/bin"}
    found = subprocess.run(
        [sys.executable, "-m", "nbgrader", *arguments],
        cwd=folder,
        env={**os.environ, **paths, **variables},
        capture_output=True,
        text=True,
        timeout=1800,
        check=False,
    )
    said = found.stdout + found.stderr
    assert (found.returncode == 0) == ok, said[-6000:]
    return said


def make_course(folder: Path, notebooks: Sequence[str], extra: str = "") -> Path:
    """Copy the course with some of its notebooks, and generate the assignments."""
    for name in notebooks:
        source = folder / "source" / name / f"{name}.ipynb"
        source.parent.mkdir(parents=True)
        nbformat.write(stored(name), source)
    config = (NOTEBOOKS / "nbgrader_config.py").read_text("utf-8")
    exchange = folder / "exchange"
    exchange.mkdir()
    exchange.chmod(0o777)
    config += f"\nc.Exchange.root = {str(exchange)!r}\n"
    config += f"c.Exchange.cache = {str(folder / 'cache')!r}\n"
    (folder / "nbgrader_config.py").write_text(config + extra, "utf-8")
    nbgrader(folder, "generate_assignment", ALL)
    return folder


def whole_course(made_once: MadeOnce) -> Path:
    """Return the whole course, released."""
    return made_once("whole-course", lambda folder: make_course(folder, all_notebooks()))


@cache
def stored(name: str) -> Any:
    """Return an instructor's notebook, which nobody may change."""
    return built(text_of(name))


def exercises_of(name: str) -> list[Exercise]:
    """Return the exercises that a notebook's test cells ask for."""
    wants = asked_by(stored(name)).values()
    return [find_exercise(slug) for slug in dict.fromkeys(want.exercise for want in wants)]


def released(folder: Path, notebook: str) -> dict[str, Any]:
    """Return a notebook as students get it."""
    text = (folder / "release" / notebook / f"{notebook}.ipynb").read_text("utf-8")
    found: dict[str, Any] = json.loads(text)
    return found


def source_of(cell: Cell) -> str:
    """Return a cell's text."""
    source = cell["source"]
    return source if isinstance(source, str) else "".join(source)


def fill(notebook: dict[str, Any], files: Mapping[str, str]) -> dict[str, Any]:
    """Write files into the notebook's %%node cells."""
    for cell in notebook["cells"]:
        made = definition(source_of(cell)) if cell["cell_type"] == "code" else None
        if made is not None and made.file in files:
            cell["source"] = f"%%node {made.file}\n{files[made.file]}".rstrip("\n")
    return notebook


def cell_named(notebook: dict[str, Any], grade_id: str) -> Cell:
    """Return the cell with that nbgrader id."""
    found: Cell = next(
        cell
        for cell in notebook["cells"]
        if cell["metadata"].get("nbgrader", {}).get("grade_id") == grade_id
    )
    return found


def code(source: str, **more: Any) -> Cell:
    """Return a code cell."""
    return {
        "cell_type": "code", "source": source, "metadata": {}, "outputs": [],
        "execution_count": None, **more,
    }  # fmt: skip


def hand_in(folder: Path, student: str, notebook: str, content: dict[str, Any] | str) -> Path:
    """Put a notebook where `nbgrader collect` would put it."""
    path = folder / "submitted" / student / notebook / f"{notebook}.ipynb"
    path.parent.mkdir(parents=True, exist_ok=True)
    text = content if isinstance(content, str) else json.dumps(content)
    path.write_text(text, "utf-8")
    return path


def gradebook(folder: Path) -> Any:
    """Open the course's gradebook."""
    return Gradebook(f"sqlite:///{folder / 'gradebook.db'}")


def grades(folder: Path) -> Grades:
    """Return what the gradebook says of each grade cell."""
    with gradebook(folder) as book:
        return {
            (one.student.id, one.notebook.name, one.cell.name): (
                one.auto_score, bool(one.needs_manual_grade),
            )
            for one in book.db.query(Grade)
        }  # fmt: skip


def mark_by_hand(folder: Path, key: tuple[str, str, str], score: float) -> None:
    """Give a score as the formgrader does."""
    student, notebook, cell = key
    with gradebook(folder) as book:
        grade = book.find_grade(cell, notebook, notebook, student)
        grade.manual_score, grade.needs_manual_grade = score, False
        book.db.commit()


def marks_by_hand(folder: Path) -> list[float]:
    """Return all scores that a person gave."""
    with gradebook(folder) as book:
        marks = [one.manual_score for one in book.db.query(Grade)]
    return [mark for mark in marks if mark is not None]


def total(found: Grades, student: str, exercise: str) -> float:
    """Return a student's points in an exercise."""
    return sum(
        score or 0.0
        for (who, _, cell), (score, _) in found.items()
        if who == student and cell.startswith(f"{exercise}-")
    )


def autograded(folder: Path, student: str, notebook: str) -> Any:
    """Return the notebook that was graded."""
    return nbformat.read(folder / "autograded" / student / notebook / f"{notebook}.ipynb", 4)


def solution(exercise: str, file: str) -> str:
    """Return a reference solution without its marks: as a student would have it."""
    return MARKS.sub("", (ROOT / "solutions" / exercise / file).read_text("utf-8"))
