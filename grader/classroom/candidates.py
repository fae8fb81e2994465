"""Who handed in what: find every student's files and put into the queue what is new or changed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.conditions import HASHED, fingerprint, submission_hash
from grader.classroom.intake import Found, find_files, find_students
from grader.classroom.options import Options
from grader.classroom.store import Key, Store
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.students import Seed, student_key
from grader.course.submission import read_regular_file
from grader.errors import InputError


@dataclass(frozen=True)
class Candidate:
    """One student's files for one exercise, where they lie."""

    student: str
    exercise: Exercise
    found: Found
    seed: Seed | None
    conditions: str  # fingerprint of the grader that would judge them

    def read(self) -> dict[str, bytes]:
        """Return the files' contents by name.

        Raises
        ------
        OSError
            One can't be read.
        """
        return {name: read_regular_file(path) for name, path in self.found.files.items()}

    def read_if_possible(self) -> dict[str, bytes]:
        """Return the files' contents by name; none if one can't be read."""
        try:
            return self.read()
        except OSError:
            return {}

    def input_hash(self, files: Mapping[str, bytes], options: Options) -> str:
        """Return a hash of all that the grading of these files depends on."""
        submitted = submission_hash(
            self.exercise, files, seed=self.seed, field=options.field, tier=options.tier
        )
        return f"{submitted}{self.conditions}"


def enter_candidates(
    submissions: Path, scratch: Path, store: Store, options: Options, *, regrade: bool
) -> dict[Key, Candidate]:
    """Find everybody's files and queue what is new or changed.

    A changed grader counts as a change too, except where recordings are to be judged again.

    Raises
    ------
    InputError
        Nobody handed in a file of any exercise, or `submissions` can't be read.
    """
    candidates = _find_candidates(submissions, scratch, options)
    for key, candidate in candidates.items():
        problem, files = candidate.found.problem, {}
        try:
            files = candidate.read()
        except OSError as error:
            problem = f"a file that can't be read ({error.strerror})"
        input_hash = candidate.input_hash(files, options)
        store.enter(key, input_hash, problem=problem, compared=HASHED if regrade else None)
        if candidate.found.remark:
            store.note(f"{candidate.found.remark}.")
    gone = store.keep_only(candidates, {key[1] for key in candidates})
    if gone:
        store.note(f"{gone} earlier results were dropped: their students are no longer there.")
    return candidates


def _find_candidates(submissions: Path, scratch: Path, options: Options) -> dict[Key, Candidate]:
    students = find_students(submissions, scratch)
    named = [find_exercise(name) for name in options.exercises]
    exercises = {exercise.slug: exercise for exercise in named or all_exercises()}
    found = {
        (student.id, slug): find_files(student, exercise.files)
        for student in students
        for slug, exercise in exercises.items()
    }
    if not named:
        handed_in = {slug for (_, slug), each in found.items() if each.files}
        if not handed_in:
            problem = next((each.problem for each in found.values() if each.problem), "")
            raise InputError(
                f"{submissions}: none of {len(students)} students has a file of any exercise; "
                f"{students[0].id}: {problem}"
            )
        exercises = {slug: exercises[slug] for slug in exercises if slug in handed_in}
    conditions = {slug: fingerprint(exercise) for slug, exercise in exercises.items()}
    secret = options.secret
    return {
        (student, slug): Candidate(
            student,
            exercises[slug],
            each,
            None if secret is None else student_key(secret, student, slug),
            conditions[slug],
        )
        for (student, slug), each in found.items()
        if slug in exercises
    }
