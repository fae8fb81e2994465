"""What a student may see of a grading: only what is named here, and of hidden trials no word.

A node in a hidden trial has seen the world that its student must not learn, and may put it into
whatever it says, raises, logs, publishes, into numbers, lines, sizes and times. So what is kept is
a list, not what is left out: which checks passed, and the judge's own texts. Every writer for
students gets its grading from here.
"""

import ast
from collections.abc import Collection, Mapping
from functools import cache
from pathlib import Path, PurePath
from typing import Any

import grader.checks
from grader.course.exercises import find_exercise
from grader.errors import InputError
from grader.recording import Recording

ANYTHING = {"field", "worlds", "details"}  # words that hide something
OF_GRADING = (
    "exercise", "tier", "score", "max_score", "raw_score", "cap", "provisional", "field_ready",
    "isolation", "practice", "versions",
)  # fmt: skip
OF_CHECK = (
    "id", "title", "kind", "points", "max_points", "outcome", "asks", "task", "hint", "waived",
)  # fmt: skip
FIELD_RUN = "field"  # in the names of the field checks' scenarios
NOT_SHOWN = "What this check saw is not published."
ENDED = {  # by the kind of the outcome
    "syntax_error": "Python cannot read the file, a syntax error: `python3 FILE` says where.",
    "exception": "The node died of an exception in a world that is not published.",
    "returned": "The node's program ended too early in a world that is not published.",
    "exited": "The node called exit() in a world that is not published.",
    "died": "The node's process ended in a world that is not published.",
    "hung": "A callback did not return in a world that is not published.",
    "slow": "The node computed for too long in a world that is not published.",
}
NOTE = (
    "This course hides the worlds of its gradings: of a check there is the outcome, and no replay. "
    "You can drive the public scenarios with the command course drive."
)


def for_students(
    grading: Mapping[str, Any], file_names: Collection[str], hidden: Collection[str]
) -> dict[str, Any]:
    """Return the grading as its student may see it; `hidden` are words of `--hide`."""
    worlds = hides_worlds(hidden)
    shown = {key: grading[key] for key in OF_GRADING if key in grading} if worlds else {**grading}
    # no paths of the instructor's machine
    shown["file"] = ", ".join(file_names) or PurePath(str(grading.get("file") or "")).name
    checks = [
        check
        for check in grading.get("checks") or ()
        if not ("field" in hidden and check.get("kind") == "field")
    ]
    runs = [run for run in grading.get("recordings") or () if shows_run(run["scenario"], hidden)]
    if hides_anything(hidden):  # the others say how the trials went
        shown["notes"] = [grading["practice"]] if grading.get("practice") else []
    if "field" in hidden:
        shown["field_ready"] = None
    if worlds:
        ends = {} if "details" in hidden else {run["scenario"]: run.get("outcome") for run in runs}
        slug = str(grading.get("exercise"))
        shown["checks"] = [_outcome_of(check, ends, slug) for check in checks]
        shown["notes"].append(NOTE)
        return shown | {"recordings": [], "cause": None}
    cause = grading.get("cause")
    of_field = isinstance(cause, Mapping) and cause.get("kind") == "field" and "field" in hidden
    return shown | {
        "checks": checks,
        "recordings": [{**run, "bag": None} for run in runs],
        "cause": None if of_field else cause,
    }


def hides_anything(hidden: Collection[str]) -> bool:
    """Return whether some trials are hidden; then no student learns how long a grading took."""
    return not ANYTHING.isdisjoint(hidden)


def hides_worlds(hidden: Collection[str]) -> bool:
    """Return whether worlds, seeds and replays stay with the instructor."""
    return "worlds" in hidden or "details" in hidden


def runs_for_students(
    recordings: Collection[Recording], hidden: Collection[str]
) -> list[Recording]:
    """Return the recordings that the student's page may replay."""
    if hides_worlds(hidden):
        return []
    return [recording for recording in recordings if shows_run(recording.name, hidden)]


def shows_run(scenario: str, hidden: Collection[str]) -> bool:
    """Return whether students may see a scenario's run."""
    return not ("field" in hidden and FIELD_RUN in str(scenario).split("_"))


def _outcome_of(check: Mapping[str, Any], ends: Mapping[str, Any], slug: str) -> dict[str, Any]:
    """Return how a check came out, in the judge's own words."""
    shown = {key: check[key] for key in OF_CHECK if key in check}
    empty = dict.fromkeys(("message", "expected", "actual", "help", "where", "log"), "")
    shown |= {**empty, "time": None, "scenario": None}
    if check.get("outcome") == "fail":
        shown["message"] = ENDED.get(str(ends.get(str(check.get("scenario")))), NOT_SHOWN)
    if check.get("help") in own_texts(slug):
        shown["help"] = check["help"]
    return shown


@cache
def own_texts(slug: str) -> frozenset[str]:
    """Return all texts that stand, word for word, in the source of an exercise's checks.

    A help may also quote the node, or say numbers; then it is none of these.
    """
    folders = [Path(folder) for folder in grader.checks.__path__]
    try:
        folders.append(find_exercise(slug).judge)
    except InputError:  # it is no longer there
        return frozenset()
    texts: set[str] = set()
    for file in (file for folder in folders for file in folder.glob("*.py")):
        nodes = ast.walk(ast.parse(file.read_text("utf-8")))
        texts.update(
            node.value
            for node in nodes
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        )
    return frozenset(texts)
