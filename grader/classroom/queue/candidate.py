"""A candidate for the queue: one student's files for one exercise, where they lie."""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.options import Options
from grader.classroom.queue.conditions import submission_hash
from grader.course.beside import MAX_BYTES
from grader.course.exercises import Exercise
from grader.course.students import Seed
from grader.course.submission import read_regular_file

MOST_SHOWN = 20  # files of a student's for a person to read
LONGEST_SHOWN = 100_000  # [bytes] of each


@dataclass(frozen=True)
class Candidate:
    """One student's files for one exercise."""

    student: str
    exercise: Exercise
    files: Mapping[str, Path]  # of the exercise, by the names that it gives them
    every: Mapping[str, Path]  # all that is graded together, by its place
    readable: Mapping[str, Path]  # for a person
    seed: Seed | None
    conditions: str  # fingerprint of the grader that would judge them
    problem: str = ""  # why nothing can be graded; "" if it can
    absent: bool = False  # nothing was handed in for this exercise
    leader: str = ""  # of a group: the student who is graded for all of it

    def read(self) -> tuple[dict[str, bytes], str]:
        """Return the files' contents by name, and why nothing can be graded.

        The reason is "" if it can be, or if nothing was handed in.
        """
        try:
            files = {name: read_regular_file(path) for name, path in self.files.items()}
            more = self.every.items()
            files |= {n: read_regular_file(path, MAX_BYTES) for n, path in more if n not in files}
        except OSError as error:
            name = Path(str(error.filename)).name if error.filename else "a file"
            return {}, f"{name} can't be read ({error.strerror})"
        return files, "" if self.absent else self.problem

    def shown(self) -> dict[str, bytes]:
        """Return the first texts for a person to read; what can't be read is left out."""
        found = {}
        for name, path in list(self.readable.items())[:MOST_SHOWN]:
            with contextlib.suppress(OSError):
                found[name] = read_regular_file(path, LONGEST_SHOWN)
        return found

    def input_hash(self, files: Mapping[str, bytes], options: Options) -> str:
        """Return a hash of all that the grading of these files depends on."""
        submitted = submission_hash(self.exercise, files, seed=self.seed, field=options.field)
        return f"{submitted}{self.conditions}"
