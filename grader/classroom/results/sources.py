"""What everybody handed in, a folder for each student, for programs that look for copies.

Beside it lies the course's own code: what was handed out, which everybody has, and the solutions
and checks, from which somebody may have copied.
"""

import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath

from grader.course.exercises import ROOT, find_exercise

SOURCES = "sources"  # the folder
CLASS, HANDED_OUT, COURSE = "class", "handed_out", "course"  # in it, for each exercise


def write_sources(
    folder: Path, student: str, slug: str, files: Mapping[str, bytes]
) -> list[Path]:  # fmt: skip
    """Write a student's submission to an exercise, whole, in the place of an older one.

    Raises OSError: a full disk, or two files of a submission that can't lie in one folder.
    """
    own = folder / slug / CLASS / student
    shutil.rmtree(own, ignore_errors=True)
    return [_write(own, name, data) for name, data in sorted(files.items())]


def write_course(folder: Path, slugs: Iterable[str]) -> None:
    """Write the course's own code of these exercises; students' copies of it have no solutions."""
    for slug in slugs:
        exercise = find_exercise(slug)
        for name, roots in {
            HANDED_OUT: (exercise.folder,),
            f"{COURSE}/solutions": (exercise.solutions,),
            f"{COURSE}/checks": (exercise.judge,),
            f"{COURSE}/models": (ROOT / "grader" / "models",),
        }.items():
            shutil.rmtree(folder / slug / name, ignore_errors=True)
            for root in roots:
                for path in sorted(root.rglob("*.py")):
                    place = path.relative_to(root).as_posix()
                    _write(folder / slug / name, place, path.read_bytes())


def _write(folder: Path, name: str, data: bytes) -> Path:
    parts = [part for part in PurePosixPath(name).parts if part not in ("..", "/")]
    path = folder.joinpath(*parts)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path
