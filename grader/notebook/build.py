"""Write the course's notebooks: the prose of `notebooks/text`, filled in from other sources.

Each notebook is an assignment of nbgrader's by itself: `notebooks/text/NAME/NAME.md` is its text
(jupytext, MyST). Prose and experiments are written there. The rest has its source elsewhere and is
filled in here:

- the first cell: `grader.notebook.bootstrap`
- the contract and the hints of an exercise: `exercises/*/README.md` and `hints.md`
- `%%node` cells: `solutions/*`, with their markers; nbgrader's release leaves the skeletons
- the points of `check(…)` cells: the judge
- the questions of the quiz and their mark schemes: the rubrics of `lessons/quiz.md`

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
from grader.course.generated import still_in, write_or_check
from grader.course.promises import without_promises
from grader.errors import GraderError
from grader.nbgrader.cells import Wanted, definition, wanted
from grader.nbgrader.points import points_of
from grader.notebook.bootstrap import BOOTSTRAP

NOTEBOOKS = ROOT / "notebooks"
TEXTS = NOTEBOOKS / "text"
SOURCES = NOTEBOOKS / "source"
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
QUIZ_PLACES = ("question", "answer")
ANSWER = "Three to six sentences are expected."
# nbgrader keeps such a part for the grader: students never get it, formgrader shows it
MARK_SCHEME = """\
{question}

<!-- BEGIN MARK SCHEME -->

**Mark scheme** (students don't get it)

{rubric}

<!-- END MARK SCHEME -->
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
        A notebook does not ask for each check of its exercises exactly once.
    """
    names = all_notebooks()
    if not names:
        raise GraderError(f"{TEXTS}: no notebooks here; run this in a full checkout")
    for name in names:
        notebook = built(text_of(name))
        yield text_of(name), as_text(notebook)
        yield source_of(name), nbformat.writes(notebook, indent=1) + "\n"


def all_notebooks() -> list[str]:
    """Return the names of the notebooks, in order; each is an assignment of that name."""
    return sorted(path.stem for path in TEXTS.glob("*/*.md"))


def text_of(name: str) -> Path:
    """Return where a notebook's text is."""
    return TEXTS / name / f"{name}.md"


def source_of(name: str) -> Path:
    """Return where the instructor's notebook is."""
    return SOURCES / name / f"{name}.ipynb"


def built(path: Path) -> NotebookNode:
    """Return the instructor's notebook of a text, with everything filled in."""
    text = path.read_text("utf-8")
    found = jupytext.reads(text, MYST).cells
    cells = [_filled(cell, path.name) for cell in found if _place(cell) not in QUIZ_PLACES]
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
    """Return a notebook as text that does not depend on jupytext's version."""
    plain = nbformat.from_dict({**notebook, "metadata": {"kernelspec": KERNEL}})
    text: str = jupytext.writes(plain, MYST)
    _, _, body = text.removeprefix("---\n").partition("\n---\n")
    return HEADER + body.lstrip("\n")


def asked_by(notebook: NotebookNode) -> dict[str, Wanted]:
    """Return the checks that each test cell asks for, by its grade_id."""
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
    """Return the cell with the content that comes from elsewhere."""
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
            raise GraderError(f"{name}: a cell comes from an unknown place, {other!r}")
    return made


def _graded(cell: NotebookNode) -> None:
    """Fill in a `%%node` cell or a test cell, and nbgrader's metadata of it."""
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
            still = still_in(lacking[0], asked.exercise)
            raise GraderError(f"{asked.exercise} has no check {lacking[0]!r}{still}")
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
    """Make sure that every check with points of each exercise is in exactly one cell."""
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
    return _standing_alone(_deeper(without_promises(found[1])))


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
    """Return Markdown without links to files that students don't get."""
    return re.sub(r"(?<!!)\[([^\]]+)\]\((?!https?:|#)[^)]+\)", r"\1", text)


def _quiz() -> list[NotebookNode]:
    """Return two cells for each question: the question, and its answer."""
    cells = []
    for number, part in enumerate(QUIZ.read_text("utf-8").split("\n## ")[1:], start=1):
        paragraphs = [text.strip() for text in part.split("\n\n")]
        asked = "\n\n".join(text for text in paragraphs[1:] if text.startswith("*"))
        rubric = next(text for text in paragraphs if text.startswith("| Points"))
        points = sum(int(n) for n in re.findall(r"(?m)^\| (\d+) \|", rubric))
        heading = paragraphs[0].partition("·")[2].strip()
        text = f"## Question {number} · {heading} ({points} points)\n\n{asked}"
        question = v4.new_markdown_cell(MARK_SCHEME.format(question=text, rubric=rubric).strip())
        question.metadata[PLACE] = "question"
        question.metadata["nbgrader"] = _about(
            f"quiz-{number}-question", grade=False, solution=False
        )
        answer = v4.new_markdown_cell(ANSWER)
        answer.metadata[PLACE] = "answer"
        answer.metadata["nbgrader"] = _about(
            f"quiz-{number}", grade=True, solution=True, points=points
        )
        cells += [question, answer]
    return cells


def _identity(cell: NotebookNode, taken: set[str]) -> str:
    """Return an id for the cell that doesn't change when other cells come and go."""
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
