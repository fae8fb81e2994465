"""Remove from a grading what the instructor hides from students."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import PurePath
from typing import Any

from grader.recording import Recording
from grader.recording.deaths import VALUES

DETAILS = ("message", "expected", "actual", "where", "log")
FIELD_RUN = "field"  # in the names of the field checks' scenarios


def for_students(
    grading: Mapping[str, Any], file_names: Collection[str], hidden: Collection[str]
) -> dict[str, Any]:
    """Return the grading as its student may see it."""
    shown = dict(grading)
    # no paths of the instructor's machine
    shown["file"] = ", ".join(file_names) or PurePath(str(grading.get("file") or "")).name
    shown["checks"] = [
        _check(check, hidden)
        for check in grading.get("checks") or ()
        if not ("field" in hidden and check.get("kind") == "field")
    ]
    shown["recordings"] = [
        _recording(recording, hidden)
        for recording in grading.get("recordings") or ()
        if shows_run(str(recording.get("scenario")), hidden)
    ]
    shown["cause"] = _cause(grading.get("cause"), hidden)
    if "field" in hidden:
        shown["field_ready"] = None
    if hides_worlds(hidden):
        shown["notes"] = [
            *(grading.get("notes") or ()),
            "This course hides the worlds of its gradings: the report has no replays. "
            "You can drive the public scenarios with the command course drive.",
        ]
    return shown


def hides_worlds(hidden: Collection[str]) -> bool:
    """Return whether worlds, seeds and replays stay with the instructor."""
    return "worlds" in hidden or "details" in hidden


def shows_run(scenario: str, hidden: Collection[str]) -> bool:
    """Return whether students may see a scenario's run."""
    return not ("field" in hidden and FIELD_RUN in scenario.split("_"))


def runs_for_students(
    recordings: Collection[Recording], hidden: Collection[str]
) -> list[Recording]:
    """Return the recordings that the student's page may replay."""
    if hides_worlds(hidden):
        return []
    return [recording for recording in recordings if shows_run(recording.name, hidden)]


def _cause(cause: Any, hidden: Collection[str]) -> dict[str, Any] | None:
    """Return what may be told of the cause: nothing of what the node saw in a hidden world."""
    if not isinstance(cause, Mapping) or "details" in hidden:
        return None
    if "field" in hidden and cause.get("kind") == "field":
        return None
    shown = dict(cause)
    if hides_worlds(hidden):
        shown["where"] = _without_values(cause.get("where"))
    return shown


def _without_values(where: Any) -> str:
    """Return the student's lines without the values that they had."""
    lines = str(where or "").splitlines()
    return "\n".join(line.partition(VALUES)[0].rstrip() for line in lines)


def _check(check: Mapping[str, Any], hidden: Collection[str]) -> dict[str, Any]:
    shown = dict(check)
    if hides_worlds(hidden):
        shown["time"] = shown["scenario"] = None
        shown["where"], shown["log"] = _without_values(check.get("where")), ""
    if "details" in hidden and check.get("outcome") == "fail":
        shown.update(dict.fromkeys(DETAILS, ""))
        shown["message"] = "What this check saw is not published."
    return shown


def _recording(recording: Mapping[str, Any], hidden: Collection[str]) -> dict[str, Any]:
    shown = {**recording, "bag": None}
    if not hides_worlds(hidden):
        return shown
    # neither seed nor scenario: both would reveal the world
    return {key: shown[key] for key in ("duration", "outcome", "bag") if key in shown}
