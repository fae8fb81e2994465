"""Write the course's notebooks: the prose of `notebooks/text`, filled in from other sources.

Each notebook is an assignment of nbgrader's by itself: `notebooks/text/NAME/NAME.md` is its text
(jupytext, MyST). Prose and experiments are written there. The rest has its source elsewhere. The
text says so in a note, *(filled in: …)*, and it is filled in here:

- the first cell: `grader.notebook.bootstrap`
- the contract and the hints of an exercise: `exercises/*/README.md` and `hints.md`
- `%%node` cells: `solutions/*`, with their markers; nbgrader's release leaves the skeletons
- nbgrader's metadata of `%%node` and `check(…)` cells, with the points: the judge
- the questions of the quiz and their mark schemes: the rubrics of `lessons/quiz.md`

`python -m grader.notebook.build` writes `notebooks/source`, `--check` only sees that every text can
be filled in.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jupytext
import nbformat
from nbformat import NotebookNode, v4

from grader.course.exercises import ROOT, SOLUTIONS, all_exercises, find_exercise
from grader.course.generated import CHECK, still_in, write_or_check
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
PLACE = "from"  # key of a cell's metadata: where its content comes from
FILLED_IN = "(filled in: {})"  # a note of what comes there
# In a README: which checks hold a node to the sentence before it; readers don't see it
PROMISE = re.compile(r"\s*<!-- checks:(.*?)-->", re.DOTALL)
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
    """Write the notebooks, or with `--check` only make them; 2 if one can't be made."""
    made = (file for file in files(SOURCES) if CHECK not in arguments)
    code = write_or_check(made, "python -m grader.notebook.build", arguments)
    if not code and not arguments:
        SOURCES.touch()  # also where nothing was new: nbgrader_config.py asks how old it is
    return code


def files(folder: Path) -> Iterator[tuple[Path, str]]:
    """Yield path and content of each notebook below nbgrader's folder of sources.

    Raises GraderError: a text has something else where it is filled in, or does not ask for each
    check of its exercises exactly once.
    """
    names = all_notebooks()
    if not names:
        raise GraderError(f"{TEXTS}: no notebooks here; run this in a full checkout")
    for name in names:
        text = nbformat.writes(built(text_of(name)), indent=1) + "\n"
        yield folder / name / f"{name}.ipynb", text


def all_notebooks() -> list[str]:
    """Return the names of the notebooks, in order; each is an assignment of that name."""
    return sorted(path.stem for path in TEXTS.glob("*/*.md"))


def text_of(name: str) -> Path:
    """Return where a notebook's text is."""
    return TEXTS / name / f"{name}.md"


def built(path: Path) -> NotebookNode:
    """Return the instructor's notebook of a text, with everything filled in."""
    found = jupytext.reads(path.read_text("utf-8"), MYST).cells
    cells = [_filled(cell, path.name) for cell in found]
    if any(_place(cell) == "quiz" for cell in cells):
        cells += _quiz()
    _check_complete([cell for cell in cells if cell.cell_type == "code"], path.name)
    taken: set[str] = set()
    for cell in cells:
        cell["id"] = _identity(cell, taken)
    return v4.new_notebook(
        cells=cells, metadata={"kernelspec": KERNEL, "language_info": {"name": "python"}}
    )


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
    made = v4.new_code_cell("") if cell.cell_type == "code" else v4.new_markdown_cell("")
    made.metadata.update({key: cell.metadata[key] for key in (PLACE,) if key in cell.metadata})
    note, made.source = _filling(cell, name)
    if cell.source != note:
        raise GraderError(
            f"{name}: a cell is filled in, so what stands in it would be lost: "
            f"expected {note!r}, is {cell.source[:100]!r}; edit it where it comes from"
        )
    _graded(made)
    return made


def _filling(cell: NotebookNode, name: str) -> tuple[str, str]:
    """Return what a cell has to say in the text, and what it becomes."""
    _, _, which = str(cell.metadata.get(PLACE, "")).partition(" ")
    match _place(cell):
        case "bootstrap":
            note = f"# {FILLED_IN.format('grader/notebook/bootstrap.py')}"
            return note, BOOTSTRAP.rstrip("\n")
        case "contract":
            where = f"topics and tasks of exercises/{which}/README.md"
            return f"*{FILLED_IN.format(where)}*", _contract(which)
        case "hints":
            return f"*{FILLED_IN.format(f'exercises/{which}/hints.md')}*", _hints(which)
        case "quiz":
            note = f"\n\n*{FILLED_IN.format('questions and mark schemes of lessons/quiz.md')}*"
            prose = cell.source.removesuffix(note)
            return f"{prose}{note}", prose
        case "":
            made = definition(cell.source) if cell.cell_type == "code" else None
            return (cell.source, cell.source) if made is None else _node(made.file)
        case other:
            raise GraderError(f"{name}: a cell comes from an unknown place, {other!r}")


def _node(file: str) -> tuple[str, str]:
    """Return what the `%%node` cell of a file says in the text, and the cell with its solution.

    Where there are no solutions, as in an image for students, the skeleton takes its place.
    """
    exercise = next((each for each in all_exercises() if file in each.files), None)
    if exercise is None:
        raise GraderError(f"%%node {file} belongs to no exercise")
    there = exercise.solutions if SOLUTIONS.is_dir() else exercise.folder
    text = (there / file).read_text("utf-8")
    note = f"# {FILLED_IN.format(f'solutions/{exercise.slug}/{file}')}"
    return f"%%node {file}\n{note}", f"%%node {file}\n{text}".rstrip("\n")


def _graded(cell: NotebookNode) -> None:
    """Write nbgrader's metadata into a `%%node` cell or a test cell."""
    if cell.cell_type != "code":
        return
    if made := definition(cell.source):
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
    return _standing_alone(_deeper(PROMISE.sub("", found[1])))


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
