"""One cause for a failed grading: what this recording shows, and what to ask of the code.

Each says what was seen and when, with any seed; what may lie behind it is a question. The first
that fits is given, and none where there is no evidence:

1. `own_words`: a line that can't mean what it says (`grader.advice.slips`); its host logs it.
2. `ends`: the node died, hung, never spun, or is not wired. That explains itself.
3. `rhythm`: a callback waits for good, or takes as long as the commands are late.
4. `commands`: there are none, or they are garbage, backwards, in a wrong field, too seldom.
5. `exercise`: what the exercise's own `causes.py` sees, such as the beams that a node reacts to.
6. `rhythm` again: bursts of commands, early and late ones, two for each scan.
7. `answers`: late by a scan, silent where nothing is new, kept, filtered, from two publishers.
8. `own_words`: an error of Python's that the node logs again and again.
9. `commands` again: the node only ever stands, and its log or its model shows more.
10. `several`: checks of several tasks fail on one answer, so no check's own help is meant.

It explains; it never decides anything.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence

from grader.course.exercises import Exercise
from grader.grading.causes.answers import cause_of_answers
from grader.grading.causes.cause import Cause, Failed
from grader.grading.causes.commands import cause_of_commands, cause_of_standing
from grader.grading.causes.ends import cause_of_end
from grader.grading.causes.exercise import cause_of_exercise
from grader.grading.causes.own_words import logged_error, slip_in_file
from grader.grading.causes.rhythm import cause_of_rhythm, kept_waiting
from grader.grading.causes.several import cause_of_several
from grader.recording import Recording

LOOKS = (
    slip_in_file,
    cause_of_end,
    kept_waiting,
    cause_of_commands,
    cause_of_exercise,
    cause_of_rhythm,
    cause_of_answers,
    logged_error,
    cause_of_standing,
    cause_of_several,
)


def find_cause(
    exercise: Exercise, failed: Sequence[Failed], recordings: Sequence[Recording]
) -> Cause | None:
    """Return the cause of these failures; None if the recordings show none.

    Parameters
    ----------
    failed
        The checks that failed, in order, at least one.
    recordings
        All trials.
    """
    by_name = {recording.name: recording for recording in recordings}
    for look in LOOKS:
        with contextlib.suppress(Exception):  # one that stumbles over a number leaves the others
            if cause := look(exercise, failed, by_name):
                return cause
    return None
