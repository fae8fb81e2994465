"""Gradescope's autograder: judge the one submission in its container, write `results.json`.

`course release DIR --gradescope` packs this with the course; `run_autograder` calls it as root, as
`python -m grader.classroom.autograder /autograder`. What a student's node must not reach (settings,
secret, results) lies in folders that are root's alone, and the results are written by this
process, the judge, after the last node has ended.

Source: Gradescope, "Autograder Specifications" and "Submission Metadata".
"""

import json
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import msgspec

from grader.classroom.amendments.marks import as_shown, is_held, tasks_of, why_held
from grader.classroom.intake.exercise_files import Found, find_files, find_sole
from grader.classroom.intake.students import take_in_one
from grader.classroom.queue.work import Unit, UnitResult, grade_unit, unjudged
from grader.classroom.results.files import write_text
from grader.classroom.results.scores import mark_of
from grader.classroom.row import GRADED, HELD, StoredResult
from grader.course.beside import MAX_BYTES
from grader.course.exercises import Exercise, find_exercise
from grader.course.students import read_secret, student_key
from grader.course.submission import MAX_SIZE, read_regular_file
from grader.errors import GraderError, InputError
from grader.grading.handed_in import launcher_here
from grader.grading.trying import why_none_runs
from grader.lms.clean import one_line
from grader.lms.gradescope import SEEN, results_json
from grader.lms.names import student_id
from grader.lms.unpack import OF_CLASS
from grader.report.echo import echo
from grader.report.page import json_text
from rclpy_virtual_time import FileReader, fresh_folder

SETTINGS = "autograder.json"  # written by grader.authoring.gradescope
SECRET = "course.secret"
OWN = 0o700  # for nobody but the user who runs this, root


@dataclass(frozen=True)
class Settings:
    """What the instructor chose when the autograder was made."""

    exercises: tuple[str, ...]  # slugs
    field: bool = False
    hide: tuple[str, ...] = ()  # words of `course autograde --hide`


def main(arguments: Sequence[str]) -> int:
    """Grade what lies in `ROOT/submission`; 1 if there is no result, and why on stdout.

    Gradescope shows stdout to instructors. Without `results.json` it tells the student that the
    autograder failed, and there is no score: what could not be judged is never a zero.
    """
    root = Path(arguments[0])
    target = root / "results" / "results.json"
    try:
        for folder in (root / "source", target.parent):  # students' nodes run as other users
            folder.mkdir(parents=True, exist_ok=True)
            folder.chmod(OWN)
        target.unlink(missing_ok=True)
        found = judged(root)
    except (GraderError, InputError, OSError) as error:
        echo(f"Nothing was graded: {error}")
        return 1
    if isinstance(found, str):
        echo(f"There is no score: {found}")
        return 1
    write_text(target, json_text(found))
    echo(f"{found['score']:g} points")
    return 0


def judged(root: Path) -> dict[str, Any] | str:
    """Return the contents of `results.json`, or why a person has to look first.

    Raises GraderError, InputError: nothing can be judged here.
    """
    if not launcher_here().guards_files:
        raise GraderError(
            "nothing keeps a node from the results here; expected to run as root, or Linux with "
            "Landlock"
        )
    settings = msgspec.json.decode((root / "source" / SETTINGS).read_bytes(), type=Settings)
    exercises = [find_exercise(slug) for slug in settings.exercises]
    secret = root / "source" / SECRET
    key = read_secret(secret) if secret.exists() else None
    name = submitter(root / "submission_metadata.json")
    results, missing, counted = [], [], []
    with fresh_folder() as room:
        student = take_in_one(root / "submission", room)
        for exercise in exercises:
            found = find_files(student, exercise.files)
            if found.problem and len(exercises) == 1:
                found = find_sole(student, exercise.files)
            counted += told(exercise, found)
            if found.problem:
                missing.append((exercise, found.problem))
                continue
            files = {
                name: read_regular_file(path, MAX_SIZE if name in found.files else MAX_BYTES)
                for name, path in found.every.items()
            }
            seed = student_key(key, name, exercise.slug) if key else None
            unit = Unit(
                name, exercise.slug, files, seed=seed, field=settings.field, bags=False, trust=True
            )
            results.append(_stored(unit, _grade(unit)))
    zero = any(result.grading is not None and not result.grading["score"] for result in results)
    if zero and (why := why_none_runs()):  # the container's, not the student's
        raise GraderError(f"no node runs here, not even a skeleton: {why}")
    held = [result for result in results if is_held(result)]
    if held:
        return f"{held[0].exercise}: {why_held(held[0]).reason}"
    return composed(results, missing, settings.hide, counted)


def told(exercise: Exercise, found: Found) -> list[str]:
    """Say which file counts, where it is not plain: it has another name, or there are others."""
    if found.problem or not (found.why or found.older or found.used[0].name != exercise.files[0]):
        return []
    others = f"; {len(found.older)} more of that name did not count" if found.older else ""
    why = f", {found.why}" if found.why else ""
    name = one_line(found.used[0].name, 100)
    return [f"{exercise.title}: {name} was graded{why}{others}"]


def composed(
    results: Sequence[StoredResult],
    missing: Sequence[tuple[Exercise, str]],
    hidden: Collection[str],
    counted: Sequence[str] = (),
) -> dict[str, Any] | str:
    """Return `results.json` of what was graded, with a failed test for what is not there.

    `counted` are sentences about the files that were graded.
    """
    tasks = tasks_of(results)
    made = results_json([mark_of(as_shown(one, hidden)) for one in results], tasks)
    if made is None:
        return "a check could not be judged"
    for exercise, problem in missing:
        title, most = exercise.title, float(exercise.max_points)
        made["output"] = f"{made['output']}\n{title}: 0 of {most:g} points; {problem}".strip()
        made["tests"].append(
            {"name": f"{title}: nothing to grade", "score": 0.0, "max_score": most,
             "status": "failed", "output": problem, **SEEN}
        )  # fmt: skip
    made["output"] = "\n".join([made["output"], *counted])
    return made | {"stdout_visibility": "hidden"}


def submitter(metadata: Path) -> str:
    """Return the student as `course autograde` names them in Gradescope's export.

    Of a group the first by Gradescope's number, the same at each submission.
    """
    try:
        return student_id(OF_CLASS.read(name_in, file=metadata, returns=str))
    except (OSError, FileReader.Refused):
        return "unnamed"  # a try run without a student


def name_in(metadata: IO[bytes]) -> str:
    users = json.load(metadata)["users"]
    first = min(users, key=lambda user: int(user["id"]))
    return str(first["name"]).encode("utf-8", "replace").decode()


def _grade(unit: Unit) -> UnitResult:
    """Grade a unit; once more if a check could not be judged."""
    result = grade_unit(unit)
    if result.grading is None or unjudged(result.grading):  # a stall of the machine may be over
        return grade_unit(unit)
    return result


def _stored(unit: Unit, result: UnitResult) -> StoredResult:
    return StoredResult(
        student=unit.student, exercise=unit.exercise, file_names=tuple(unit.files), input_hash="",
        state=HELD if result.grading is None else GRADED, grading=result.grading, recordings=None,
        wall_s=result.wall_s, attempts=1, problem=result.problem, finished="",
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
