"""Write the course's notebooks: the text of `notebooks/text`, and what is made from elsewhere.

`notebooks/text/lesson_3_2/*.md` are notebooks as text (jupytext, MyST). Their prose and their
experiments are written there. The rest has another home, and is put in its place here:

- the first cell: `grader.notebook.bootstrap`
- the contract and the hints of an exercise: `exercises/*/README.md` and `hints.md`
- `%%node` cells: `solutions/*`, with their marks; nbgrader's release leaves the skeletons
- the points of `check(…)` cells: the judge
- the questions of the quiz and their rubrics: `lessons/quiz.md`

`python -m grader.notebook.build` writes both the texts and `notebooks/source`, `--check` only
compares.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jupytext
import nbformat
from nbformat import NotebookNode, v4

from grader.course.exercises import ROOT, all_exercises, find_exercise
from grader.course.generated import write_or_check
from grader.errors import GraderError
from grader.nbgrader.cells import Wanted, definition, wanted
from grader.nbgrader.points import points_of
from grader.notebook.bootstrap import BOOTSTRAP

NOTEBOOKS = ROOT / "notebooks"
ASSIGNMENT = "lesson_3_2"
TEXTS = NOTEBOOKS / "text" / ASSIGNMENT
SOURCES = NOTEBOOKS / "source" / ASSIGNMENT
QUIZ = ROOT / "lessons" / "quiz.md"

MYST = "md:myst"
SCHEMA = 3  # of nbgrader's metadata
KERNEL = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
HEADER = """\
---
jupytext:
  text_representation:
    extension: .md
    format_name: myst
kernelspec:
  display_name: Python 3 (ipykernel)
  language: python
  name: python3
---

"""
PLACE = "from"  # key of a cell's metadata: where its content comes from
ASKED = ("question", "answer")  # places of the quiz's cells
ANSWER = """\
Three to six sentences are expected.

**Rubric** (this cell is the instructor's; students find an empty one)

{rubric}
"""


def main(arguments: list[str]) -> int:
    """Write the notebooks, or with `--check` compare them; 1 if one is out of step."""
    command = "python -m grader.notebook.build"
    return write_or_check(files(), command, arguments)


def files() -> Iterator[tuple[Path, str]]:
    """Yield path and content of each text and each notebook.

    Raises
    ------
    GraderError
        A notebook's checks are not those of its exercises, each once.
    """
    texts = sorted(TEXTS.glob("*.md"))
    if not texts:
        raise GraderError(f"{TEXTS}: no notebooks here; run this in a full checkout")
    for path in texts:
        notebook = built(path)
        yield path, as_text(notebook)
        yield SOURCES / f"{path.stem}.ipynb", nbformat.writes(notebook, indent=1) + "\n"


def built(path: Path) -> NotebookNode:
    """Return the instructor's notebook of a text, everything in its place."""
    text = path.read_text("utf-8")
    found = jupytext.reads(text, MYST).cells
    cells = [
        _filled(cell, path.name) for cell in found if _place(cell) not in ("question", "answer")
    ]
    if any(_place(cell) == "quiz" for cell in cells):
        cells += _quiz()
    _check_complete([cell for cell in cells if cell.cell_type == "code"], path.name)
    taken: set[str] = set()
    for cell in cells:
        cell["id"] = _identity(cell, taken)
    return v4.new_notebook(
        cells=cells, metadata={"kernelspec": KERNEL, "language_info": {"name": "python"}}
    )


def as_text(notebook: NotebookNode) -> str:
    """Return a notebook as text: the same whatever jupytext's version."""
    plain = nbformat.from_dict({**notebook, "metadata": {"kernelspec": KERNEL}})
    text: str = jupytext.writes(plain, MYST)
    _, _, body = text.removeprefix("---\n").partition("\n---\n")
    return HEADER + body.lstrip("\n")


def asked_by(notebook: NotebookNode) -> dict[str, Wanted]:
    """Return what each test cell asks for, by its grade_id."""
    found = {}
    for cell in notebook.cells:
        about = cell.metadata.get("nbgrader", {})
        asked = wanted(cell.source) if about.get("grade") and cell.cell_type == "code" else None
        if asked is not None:
            found[str(about["grade_id"])] = asked
    return found


def _place(cell: NotebookNode) -> str:
    return str(cell.metadata.get(PLACE, "")).partition(" ")[0]


def _filled(cell: NotebookNode, name: str) -> NotebookNode:
    """Return the cell with what comes from elsewhere."""
    _, _, which = str(cell.metadata.get(PLACE, "")).partition(" ")
    made = v4.new_code_cell("") if cell.cell_type == "code" else v4.new_markdown_cell("")
    made.source = cell.source
    made.metadata.update({key: cell.metadata[key] for key in (PLACE,) if key in cell.metadata})
    match _place(cell):
        case "bootstrap":
            made.source = BOOTSTRAP.rstrip("\n")
        case "contract":
            made.source = _contract(which)
        case "hints":
            made.source = _hints(which)
        case "" | "quiz":
            _graded(made)
        case other:
            raise GraderError(f"{name}: a cell comes from {other!r}, which is unknown")
    return made


def _graded(cell: NotebookNode) -> None:
    """Fill in a `%%node` cell and a test cell, and what nbgrader has to know of them."""
    if cell.cell_type != "code":
        return
    if made := definition(cell.source):
        folders = [e.solutions for e in all_exercises() if made.file in e.files]
        if not folders:
            raise GraderError(f"%%node {made.file} belongs to no exercise")
        text = (folders[0] / made.file).read_text("utf-8")
        cell.source = f"%%node {made.file}\n{text}".rstrip("\n")
        name = f"node-{made.file.removesuffix('.py')}"
        cell.metadata["nbgrader"] = _about(name, grade=False, solution=True)
    elif (asked := wanted(cell.source)) is not None and asked.checks:
        known = points_of(asked.exercise)
        lacking = [check for check in asked.checks if check not in known]
        if lacking:
            raise GraderError(f"{asked.exercise} has no check {lacking[0]!r}")
        name = f"{asked.exercise}-{asked.checks[0]}"
        points = sum(known[check] for check in asked.checks)
        cell.metadata["nbgrader"] = _about(name, grade=True, solution=False, points=points)


def _about(name: str, *, grade: bool, solution: bool, points: int | None = None) -> dict[str, Any]:
    about = {
        "grade": grade,
        "grade_id": name,
        "locked": not solution,
        "schema_version": SCHEMA,
        "solution": solution,
        "task": False,
    }
    return about if points is None else {**about, "points": points}


def _check_complete(cells: list[NotebookNode], name: str) -> None:
    """Make sure that every check with points of each exercise stands in one cell."""
    asked: dict[str, list[str]] = {}
    for cell in cells:
        if "nbgrader" in cell.metadata and (want := wanted(cell.source)) is not None:
            asked.setdefault(want.exercise, []).extend(want.checks)
    for slug, checks in asked.items():
        wrong = {check for check in points_of(slug) if checks.count(check) != 1}
        if wrong:
            raise GraderError(f"{name}: not in exactly one cell: {', '.join(sorted(wrong))}")


def _contract(slug: str) -> str:
    """Return the contract from an exercise's README: topics and tasks."""
    exercise = find_exercise(slug)
    readme = (exercise.folder / "README.md").read_text("utf-8")
    found = re.search(r"(?ms)^(## .*?)(?=^## How to run it)", readme)
    if found is None:
        raise GraderError(f"exercises/{slug}/README.md: expected a part “How to run it”")
    return _standing_alone(_deeper(found[1]))


def _hints(slug: str) -> str:
    """Return an exercise's hints, folded away."""
    hints = (find_exercise(slug).folder / "hints.md").read_text("utf-8")
    _, _, body = hints.partition("\n")
    inner = _standing_alone(_deeper(_deeper(body.strip())))
    return f"<details><summary><b>Hints</b></summary>\n\n{inner}\n\n</details>"


def _deeper(text: str) -> str:
    """Return Markdown with its headings one level lower."""
    return re.sub(r"(?m)^(#+ )", r"#\1", text).strip()


def _standing_alone(text: str) -> str:
    """Return Markdown without links to files that a student's folder doesn't have."""
    return re.sub(r"(?<!!)\[([^\]]+)\]\((?!https?:|#)[^)]+\)", r"\1", text)


def _quiz() -> list[NotebookNode]:
    """Return a cell with each question and one for its answer."""
    cells = []
    for number, part in enumerate(QUIZ.read_text("utf-8").split("\n## ")[1:], start=1):
        paragraphs = [text.strip() for text in part.split("\n\n")]
        asked = "\n\n".join(text for text in paragraphs[1:] if text.startswith("*"))
        rubric = next(text for text in paragraphs if text.startswith("| Points"))
        points = sum(int(n) for n in re.findall(r"(?m)^\| (\d+) \|", rubric))
        heading = paragraphs[0].partition("·")[2].strip()
        question = v4.new_markdown_cell(
            f"## Question {number} · {heading} ({points} points)\n\n{asked}"
        )
        question.metadata[PLACE] = "question"
        answer = v4.new_markdown_cell(ANSWER.format(rubric=rubric).strip())
        answer.metadata[PLACE] = "answer"
        answer.metadata["nbgrader"] = _about(
            f"quiz-{number}", grade=True, solution=True, points=points
        )
        answer.metadata["nbgrader"]["locked"] = False
        cells += [question, answer]
    return cells


def _identity(cell: NotebookNode, taken: set[str]) -> str:
    """Return an id for the cell that stays when cells come and go around it."""
    name = cell.metadata.get("nbgrader", {}).get("grade_id") or cell.metadata.get(PLACE)
    if not name or name == "question":
        words = re.findall(r"[A-Za-z0-9]+", cell.source)[:5]
        name = "-".join([cell.cell_type, *words]).lower()
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", str(name))[:56].strip("-")
    unique, number = name, 1
    while unique in taken:
        number += 1
        unique = f"{name}-{number}"
    taken.add(unique)
    return unique


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
