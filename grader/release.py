"""Make what students get: lessons, skeletons, the robot and the grader, and no answers.

What goes in is named here, so that a new file stays with the instructor until somebody decides.
Before anything is handed out, the release is searched for pieces of every solution.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from grader.errors import GraderError, InputError
from grader.exercises import ROOT, SOLUTIONS, all_exercises

# The grader's rooms for instructors and contributors; students' `course` does without.
INSTRUCTORS = (
    "batch", "gradebook_plugin", "results", "release.py", "build.py",
    "catalogue.py", "fairness.py", "listings.py", "pitfalls.py", "proof.py", "skeletons.py",
)  # fmt: skip
KEPT = {
    "sim": (".py", ".toml"),
    "grader": (".py", ".xml", ".js", ".css", ".html"),
    "exercises": (".py", ".md", ".toml"),
    "lessons": (".md", ".png", ".svg"),
    "docs/students": (".md", ".png", ".svg"),
}
SINGLE = ("LICENSE", "LICENSE-lessons.md", "constraints.txt")
PRIVATE = re.compile(
    r"(?i)(^|[_\-.])(secrets?|hidden|solutions?|mutants?|variants?|private)([_\-.]|$)"
)
QUIZ = "lessons/quiz.md"  # its tables are the rubric

Shingle = tuple[str, ...]
SHINGLE = 6  # lines in a row, without empty ones, that nobody writes twice by chance
SIZES = (4, 5, SHINGLE)  # a solution's block may be shorter
BLOCK = re.compile(r"^\s*### (BEGIN SOLUTION|SKELETON|END SOLUTION)\s*$")
STAMP = (2020, 1, 1, 0, 0, 0)  # of every file in the archive: the same release, the same bytes

README = """\
# Bridging Python agents with rclpy: for students

Write ROS 2 nodes in Python and let them drive a mock robot. You need Linux on x86_64 and Python
3.11 to 3.13; no robot and no ROS installation.

    python3 -m venv .venv
    . .venv/bin/activate
    pip install --constraint constraints.txt --editable '.[ros,ml]'
    course list

Take a copy of a skeleton, work on it, and ask the grader as often as you like:

    cp exercises/obstacle_avoidance/obstacle_avoidance_agent.py my_agent.py
    course grade obstacle_avoidance my_agent.py --report report.html
    course drive my_agent.py --scenario avoid_cart --report drive.html

Each folder in `exercises/` has a README with the contract and the points, and hints.

| # | Exercise | What it is about |
|---|---|---|
{rows}

The worlds in which you are graded in the end may be others than those in `sim/scenarios/`, and as
hard. Code: Apache-2.0 (`LICENSE`). Lesson text: CC BY 4.0 (`LICENSE-lessons.md`).
"""


@dataclass(frozen=True)
class Leak:
    """A file of a release that has lines of a solution."""

    file: str
    solution: str  # path of the solution; "" for its markers
    line: str  # the first of them
    earlier: bool = False  # a skeleton that builds on an exercise before it, which it gives away

    def __str__(self) -> str:
        """Say it in a sentence."""
        if not self.solution:
            return f"{self.file} has the markers of a solution"
        return f"{self.file} has lines of {self.solution}, from {self.line!r} on"


def release(
    folder: Path,
    *,
    exercises: Collection[str] = (),
    archive: bool = False,
    root: Path = ROOT,
) -> list[Leak]:
    """Write the students' material into `folder`; return which skeletons give earlier answers away.

    Parameters
    ----------
    folder
        Must not exist, or be empty.
    exercises
        Only these (slugs); without any, all.
    archive
        Make `FOLDER.zip` beside it too, the same bytes each time; `pip install` takes either.

    Raises
    ------
    InputError
        `folder` (or the archive) is already there.
    GraderError
        A piece of a solution was about to be handed out.
    """
    packed = folder.with_name(folder.name + ".zip")
    _check_free(folder, packed if archive else None)
    files = contents(exercises, root)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".release-") as name:
        staged = Path(name) / "course"
        for path, data in files.items():
            target = staged / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
        found = leaks(staged, root / SOLUTIONS.name)
        wrong = [leak for leak in found if not leak.earlier]
        if wrong:
            raise GraderError(f"nothing was released: {wrong[0]}" + _and_more(len(wrong) - 1))
        if archive:
            _pack(files, packed, folder.name)
        if folder.is_dir():
            folder.rmdir()  # empty, as was checked
        shutil.move(staged, folder)
    return found


def contents(exercises: Collection[str] = (), root: Path = ROOT) -> dict[str, bytes]:
    """Return every file of a release by its path, in order."""
    known = [exercise.slug for exercise in all_exercises()]
    left_out = {slug for slug in known if exercises and slug not in exercises}
    found = {path: (root / path).read_bytes() for path in SINGLE if (root / path).is_file()}
    for room, suffixes in KEPT.items():
        for file in _walk(root / room):
            path = file.relative_to(root).as_posix()
            if file.suffix in suffixes and _is_public(path, left_out):
                found[path] = file.read_bytes()
    if QUIZ in found:
        found[QUIZ] = questions(found[QUIZ].decode("utf-8")).encode()
    found["pyproject.toml"] = _pyproject((root / "pyproject.toml").read_text("utf-8")).encode()
    found["README.md"] = _readme(left_out).encode()
    return dict(sorted(found.items()))


def questions(quiz: str) -> str:
    """Return the quiz without its rubric: headings and what is asked (in italics)."""
    kept = []
    for paragraph in quiz.split("\n\n"):
        text = paragraph.strip()
        if text.startswith(("#", "*")):
            kept.append(text)
    return "\n\n".join(kept) + "\n"


def leaks(folder: Path, solutions: Path = SOLUTIONS) -> list[Leak]:
    """Return where a release gives an answer away.

    Searched for: solution markers, and any run of SHINGLE lines of a solution that the skeletons
    don't have.
    """
    given = set[Shingle]()
    for file in (folder / "exercises").rglob("*.py"):
        given.update(_shingles(_lines(file)))
    secrets: dict[Shingle, str] = {}
    for file in sorted(solutions.rglob("*.py")):
        place = file.relative_to(solutions.parent).as_posix()
        for shingle in _secret_shingles(file):
            if shingle not in given or _is_marked(file):
                secrets.setdefault(shingle, place)
    numbers = {exercise.slug: exercise.number for exercise in all_exercises()}
    found = []
    for file in sorted(folder.rglob("*")):
        if not file.is_file() or file.suffix not in (".py", ".md", ".toml", ".txt"):
            continue
        place, lines = file.relative_to(folder).as_posix(), _lines(file)
        if any(BLOCK.match(line) for line in lines):
            found.append(Leak(place, "", ""))
        hits = (s for size in SIZES for s in _shingles(lines, size) if s in secrets)
        first = {secrets[hit]: hit[0] for hit in reversed(list(hits))}
        found += [
            Leak(place, source, line, _builds_on(place, source, numbers))
            for source, line in sorted(first.items())
        ]
    return found


def _builds_on(place: str, source: str, numbers: Mapping[str, int]) -> bool:
    """Tell whether this is the skeleton of a later exercise than the one whose solution it has."""
    of, own = PurePosixPath(source).parts[1], PurePosixPath(place).parts
    if own[0] != "exercises" or own[1] not in numbers or of not in numbers:
        return False
    return numbers[own[1]] > numbers[of]


# --- what goes in --------------------------------------------------------------------------


def _walk(folder: Path) -> Iterator[Path]:
    """Yield regular files below a folder, in order; nothing hidden, cached or linked."""
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.name.startswith((".", "__pycache__")) or path.is_symlink():
            continue
        if path.is_dir():
            if path.name not in ("build", "dist") and path.suffix != ".egg-info":
                yield from _walk(path)
        elif path.is_file():
            yield path


def _is_public(path: str, left_out: set[str]) -> bool:
    parts = PurePosixPath(path).parts
    if parts[0] != "grader" and not left_out.isdisjoint(parts):
        return False  # checks stay: those of one exercise use another's
    if parts[0] == "grader" and not {*INSTRUCTORS}.isdisjoint(parts):
        return False
    return not any(PRIVATE.search(part) for part in parts)


def _pyproject(text: str) -> str:
    """Return the students' pyproject.toml: without our tools' settings."""
    kept = re.split(r"(?m)^(?=\[)", text)
    ours = ("[tool.ruff", "[tool.mypy", "[[tool.mypy", "[tool.pytest")
    return "".join(part for part in kept if not part.startswith(ours))


def _readme(left_out: Collection[str]) -> str:
    rows = [
        f"| {exercise.number} | [{exercise.slug}](exercises/{exercise.slug}/README.md) "
        f"| {exercise.summary} |"
        for exercise in all_exercises()
        if exercise.slug not in left_out
    ]
    return README.format(rows="\n".join(rows))


# --- what must not -------------------------------------------------------------------------


def _lines(file: Path) -> list[str]:
    text = file.read_text("utf-8", "replace")
    return [line for line in (line.strip() for line in text.splitlines()) if line]


def _shingles(lines: list[str], size: int = SHINGLE) -> Iterator[Shingle]:
    for start in range(len(lines) - size + 1):
        yield tuple(lines[start : start + size])


def _is_marked(file: Path) -> bool:
    return any(BLOCK.match(line) for line in _lines(file))


def _secret_shingles(file: Path) -> Iterator[Shingle]:
    """Yield the runs of lines that nobody may hand out.

    Of a reference, what stands in its solution blocks (four lines or more); of variants and
    mutants, everything.
    """
    if not _is_marked(file):
        yield from _shingles(_lines(file))
        return
    block: list[str] | None = None
    for line in _lines(file):
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


# --- files ---------------------------------------------------------------------------------


def _check_free(folder: Path, packed: Path | None) -> None:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder}: expected a folder that is new or empty; choose another")
    if packed is not None and packed.exists():
        raise InputError(f"{packed}: is already there; remove it or choose another folder")


def _pack(files: dict[str, bytes], target: Path, top: str) -> None:
    part = target.with_name(target.name + ".part")
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            entry = zipfile.ZipInfo(f"{top}/{path}", STAMP)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
    os.replace(part, target)  # noqa: PTH105


def _and_more(n: int) -> str:
    return f" (and {n} more)" if n > 0 else ""
