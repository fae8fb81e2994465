"""Search a release for pieces of solutions, in files, notebook cells and pages."""

import html
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

from grader.claims.mutants import CATALOGUE, mutants
from grader.course.exercises import ROOT, SOLUTIONS, all_exercises
from grader.nbgrader.cells import definition

CHECKS = (ROOT / "grader" / "checks", ROOT / "grader" / "exercises")
FEATURES = ROOT / "grader" / "models" / "features.py"
GRADER = "grader/"  # of a release: checks belong there, and nowhere else

Shingle = tuple[str, ...]
SHINGLE = 6  # consecutive non-empty lines that nobody writes twice by chance
SIZES = (4, 5, SHINGLE)  # a solution's block may be shorter
BLOCK = re.compile(r"^\s*### (BEGIN SOLUTION|SKELETON|END SOLUTION)\s*$")
MARK = re.compile(r"^\s*### (SKELETON|(BEGIN|END) (SOLUTION|HIDDEN TESTS|MARK SCHEME))\s*$")
NUMBERS = re.compile(r'<span class="linenos">[^<]*</span>')  # line numbers of a listing
TAG = re.compile(r"<[^>]*>")
READ = (
    ".py", ".md", ".toml", ".txt", ".xml", ".cfg", ".yaml", ".rviz", ".html", ".js", ".ipynb",
)  # fmt: skip


@dataclass(frozen=True)
class Leak:
    """A file of a release that holds lines of a solution."""

    file: str
    solution: str  # its path; "" for a solution's markers
    line: str  # the first line that leaks
    earlier: bool = False  # a skeleton that builds on an earlier exercise, and gives that one away

    @property
    def of(self) -> str:
        """The exercise of the solution."""
        return PurePosixPath(self.solution).parts[1]

    def __str__(self) -> str:
        """Say it in a sentence."""
        if not self.solution:
            return f"{self.file} has the markers of a solution"
        return f"{self.file} has lines of {self.solution}, beginning with {self.line!r}"


@dataclass(frozen=True)
class _Text:
    """A file, or a cell of a notebook."""

    place: str
    lines: list[str]  # without empty ones
    exercise: str = ""  # if it is a skeleton: slug of its exercise


def leaks(folder: Path, solutions: Path = SOLUTIONS) -> list[Leak]:
    """Return where a release gives an answer away.

    Searched for: the markers of solutions and hidden tests, and any run of SHINGLE lines of a
    solution, variant or mutant that the skeletons don't have. How a node begins and ends is no
    answer: every skeleton's `main` is finished, so what it says is not searched for, even if that
    skeleton is not in the release. The checks are released, because practice needs them; a piece of
    one anywhere else in the release is a leak like any other.
    """
    given = set(_mains())
    for file in (folder / "exercises").rglob("*.py"):
        given.update(_shingles(_lines(_read(file))))
    secrets: dict[Shingle, str] = {}
    for place, program in _solutions(solutions):
        lines = _lines(program)
        for shingle in _secret_shingles(lines):
            if shingle not in given or _is_marked(lines):
                secrets.setdefault(shingle, place)
    for place, program in _checks():
        for shingle in _secret_shingles(_lines(program)):
            if shingle not in given:
                secrets.setdefault(shingle, place)
    numbers = {exercise.slug: exercise.number for exercise in all_exercises()}
    found = []
    for text in _texts(folder):
        if any(MARK.match(line) for line in text.lines):
            found.append(Leak(text.place, "", ""))
        hits = (s for size in SIZES for s in _shingles(text.lines, size) if s in secrets)
        first = {
            secrets[hit]: hit[0]
            for hit in reversed(list(hits))
            if not (text.place.startswith(GRADER) and secrets[hit].startswith(GRADER))
        }
        for source, line in sorted(first.items()):
            leak = Leak(text.place, source, line)
            earlier = numbers.get(text.exercise, 0) > numbers.get(leak.of, len(numbers))
            found.append(replace(leak, earlier=earlier))
    return found


# --- what is searched ----------------------------------------------------------------------


def _texts(folder: Path) -> Iterator[_Text]:
    """Yield every text that a reader of the release sees, in the order of the files."""
    owners = _owners()
    for file in sorted(folder.rglob("*")):
        if not file.is_file() or file.suffix not in READ:
            continue
        path = file.relative_to(folder)
        match file.suffix:
            case ".ipynb":
                yield from _cells(path.as_posix(), _read(file))
            case ".html":
                shown = html.unescape(TAG.sub("", NUMBERS.sub("", _read(file))))
                yield _Text(path.as_posix(), _lines(shown))
            case _:
                downloaded = owners.get(path.name, "") if "_downloads" in path.parts else ""
                of = path.parts[1] if path.parts[0] == "exercises" else downloaded
                yield _Text(path.as_posix(), _lines(_read(file)), of)


def _owners() -> dict[str, str]:
    """Return the slug of the exercise that each file belongs to."""
    return {file: exercise.slug for exercise in all_exercises() for file in exercise.files}


def _cells(place: str, notebook: str) -> Iterator[_Text]:
    """Yield the cells of a notebook (its JSON), with their outputs."""
    owners = _owners()
    for number, cell in enumerate(json.loads(notebook)["cells"], start=1):
        source = "".join(cell["source"])
        made = definition(source) if cell["cell_type"] == "code" else None
        shown = json.dumps(cell.get("outputs", []), indent=0)
        yield _Text(
            f"{place}, cell {number}",
            _lines(f"{source}\n{shown}"),
            owners.get(made.file, "") if made else "",
        )


def _read(file: Path) -> str:
    return file.read_text("utf-8", "replace")


def _lines(text: str) -> list[str]:
    return [line for line in (line.strip() for line in text.splitlines()) if line]


# --- what is searched for ------------------------------------------------------------------


def _solutions(folder: Path) -> Iterator[tuple[str, str]]:
    """Yield the path and the text of each solution, variant and mutant.

    A mutant is an edit of another program; it is searched for as a whole.
    """
    for file in sorted(folder.rglob("*.py")):
        yield file.relative_to(folder.parent).as_posix(), _read(file)
    for exercise in all_exercises():
        catalogue = f"{folder.name}/{exercise.slug}/{CATALOGUE}"
        for mutant in mutants(exercise, folder / exercise.slug):
            yield f"{catalogue}: {mutant.name}", mutant.text


def _checks() -> Iterator[tuple[str, str]]:
    """Yield the path and the text of each file of the checks that knows what is right."""
    for file in (*sorted(file for folder in CHECKS for file in folder.rglob("*.py")), FEATURES):
        yield file.relative_to(ROOT).as_posix(), _read(file)


def _mains() -> Iterator[Shingle]:
    """Yield the runs of lines from `def main` on, of all skeletons."""
    for exercise in all_exercises():
        for file in exercise.files:
            lines = _lines(_read(exercise.folder / file))
            start = next((n for n, line in enumerate(lines) if line.startswith("def main(")), None)
            yield from _shingles([] if start is None else lines[start:])


def _shingles(lines: list[str], size: int = SHINGLE) -> Iterator[Shingle]:
    for start in range(len(lines) - size + 1):
        yield tuple(lines[start : start + size])


def _is_marked(lines: list[str]) -> bool:
    return any(BLOCK.match(line) for line in lines)


def _secret_shingles(lines: list[str]) -> Iterator[Shingle]:
    """Yield the consecutive lines that must not be released.

    Of a reference, what stands in its solution blocks (four lines or more); of variants and
    mutants, everything but a list of imports.
    """
    if not _is_marked(lines):
        for shingle in _shingles(lines):
            if not all(line.startswith(("import ", "from ")) for line in shingle):
                yield shingle
        return
    block: list[str] | None = None
    for line in lines:
        marker = BLOCK.match(line)
        if marker is None:
            if block is not None:
                block.append(line)
        elif marker[1] == "BEGIN SOLUTION":
            block = []
        elif block is not None:
            if len(block) >= SIZES[0]:
                yield from _shingles(block, min(SHINGLE, len(block)))
            block = None
