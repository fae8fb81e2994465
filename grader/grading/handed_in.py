"""Grade other people's files, on a fork server kept warm between submissions.

`course autograde` and nbgrader both grade through this module. Nothing a submission does raises
anything but `GraderError`, and no error is ever the student's fault.
"""

import atexit
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from grader.course.exercises import Exercise
from grader.course.students import Seed
from grader.course.submission import find_submission
from grader.errors import GraderError, InputError
from grader.grading.grading import grade_submission
from grader.launchers import launcher_pool
from rclpy_virtual_time import ForkServer, PracticeServer, fresh_folder

MAX_REASON = 600  # [characters]

_one_at_a_time = threading.Lock()
_forkservers = launcher_pool(most=1)
atexit.register(_forkservers.close)


def launcher_here() -> ForkServer | PracticeServer:
    """Return what starts nodes on this machine.

    Raises GraderError: no node can run here at all.
    """
    with _one_at_a_time:
        try:
            return _forkservers.of()
        except InputError as error:
            raise GraderError(str(error)) from None


def isolation_problem() -> str:
    """Say why other people's code should not run on this machine; "" if it may.

    Raises GraderError: no node can run here at all.
    """
    return launcher_here().foreign_code


def grade_files(
    exercise: Exercise,
    files: Mapping[str, bytes],
    *,
    seed: Seed | None = None,
    field: bool = False,
    bags: Path | None = None,
    trust: bool = False,
) -> dict[str, Any]:
    """Grade one submission; return the JSON object of `course grade`.

    Raises GraderError: the submission could not be judged; the message is one line.

    Parameters
    ----------
    files
        Contents by their place in the node's folder: at least one file of the exercise, or a
        package, and what comes along.
    bags
        Where every trial is saved.
    trust
        Run the code even where isolation is too weak.
    """
    with _one_at_a_time:
        try:
            forkserver = _forkservers.of(exercise.libraries)
            if not trust and (problem := forkserver.foreign_code):
                raise GraderError(problem)
            with fresh_folder() as folder:
                for name, data in files.items():
                    (folder / name).parent.mkdir(parents=True, exist_ok=True)
                    (folder / name).write_bytes(data)
                first, *others = exercise.files
                main = next((name for name in exercise.files if name in files), "")
                place = folder / main  # of a package, the folder
                grading = grade_submission(
                    exercise,
                    find_submission(place, first, others),
                    forkserver,
                    file=main or first,
                    field=field,
                    seed=seed,
                    bags=bags,
                )
                if grading.faults:
                    _forkservers.close()  # the fault may be theirs, and would be the next one's
                return grading.as_dict()
        except Exception as error:
            _forkservers.close()  # its state is unknown
            raise GraderError(reason_of(error)) from error


def reason_of(error: Exception) -> str:
    """Say in one line why a submission could not be judged."""
    known = isinstance(error, GraderError | InputError)
    text = str(error) if known else f"the grader failed ({type(error).__name__}: {error})"
    return " ".join(text.split())[:MAX_REASON]
