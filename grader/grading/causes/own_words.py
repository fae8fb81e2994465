"""A cause that the node itself names: an error of Python's that it logs, or a thread dies of."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

import msgspec

from grader.advice.plain_words import words_for
from grader.advice.slips import said_in
from grader.course.exercises import Exercise
from grader.grading.causes.cause import ByName, Cause, Failed, sentences
from rclpy_virtual_time import LogLine

OFTEN = 3  # times in a trial: once may be a model of ours that raises
AT_ONCE = 0.05  # [s]
MAX_LINE = 240  # [characters]
# What a slip leads to
SLIPS = re.compile(
    r"\b(TypeError|AttributeError|NameError|UnboundLocalError|IndexError|KeyError"
    r"|ZeroDivisionError|InvalidArgument|ValueError|RuntimeError|ModuleNotFoundError)\b"
)
MANY_THINGS = re.compile(r"RuntimeError|ModuleNotFoundError")  # slips only where a rule fits
ON_PURPOSE = re.compile(r"the model can't say|the model says|no model")  # our models' own words
DEAD_THREAD = "Exception in thread "  # Python's own words
FRAME = re.compile(r'File "(?P<file>[^/"\n]{1,100})", line (?P<line>\d{1,6}), in (?P<function>\S+)')
ENDS_WITH = re.compile(r"[A-Z]\w*(Error|Exception|Iteration|Interrupt)\b.*")
NAMED = re.compile(r"\b([A-Z]\w*(?:Error|Exception|Argument))\b")
SHAPE = re.compile(r"shape|rank|dimension|2D array|1D array|features|reshape|not defined|attribute")


def slip_in_file(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return the first slip in the program's source, as its host saw it.

    Of a node that died, only a slip in its traceback, or in a function called there.
    """
    log = (line for recording in trials.values() for line in recording.log)
    said = (line.text for line in log if line.level == "stderr")
    where = failed[0].where
    for slip in filter(None, map(said_in, said)):
        if where and f"line {slip.line} " not in where and f"{slip.text.split()[0]}(" not in where:
            continue
        return Cause(
            sentences(f"Line {slip.line}: {slip.text}"), failed[0].kind,
            explains=tuple(check.id for check in failed), check=failed[0].id,
        )  # fmt: skip
    return None


def logged_error(exercise: Exercise, failed: Sequence[Failed], trials: ByName) -> Cause | None:
    """Return the slip that the node logs again and again in the trial that failed first."""
    check = failed[0]
    log = _log_of(check, trials)
    if cause := _dead_thread(check, log):
        same = [c.id for c in failed if _dead_thread(c, _log_of(c, trials))]
        return msgspec.structs.replace(cause, explains=tuple(same))
    for text, times in _slips(log).most_common(1):
        if times >= OFTEN and _is_slip(text):
            line = " ".join(text.split())[:MAX_LINE]
            seen = f"The node logs this error {times} times in {check.scenario}: {line}"
            same = [c.id for c in failed if _slips(_log_of(c, trials))[text] >= OFTEN]
            return Cause(seen + _advice(text), check.kind, explains=tuple(same), check=check.id)
    for said in log:  # once, but just when it failed
        if check.time is None or abs(said.t - check.time) > AT_ONCE or not _slips([said]):
            continue
        if advice := _advice(said.text):
            seen = f"At {said.t:.2f} s, where the check failed, the node logs: "
            text = f"{seen}{' '.join(said.text.split())[:MAX_LINE]}{advice}"
            return Cause(text, check.kind, explains=(check.id,), check=check.id)
    return None


def _is_slip(text: str) -> bool:
    """Return whether an error that is logged again and again comes from a slip."""
    if "ValueError" in text:
        return SHAPE.search(text) is not None
    return MANY_THINGS.search(text) is None or plain_words_on(text) != ""


def _log_of(check: Failed, trials: ByName) -> Sequence[LogLine]:
    recording = trials.get(check.scenario or "")
    return () if recording is None else recording.log


def _slips(log: Sequence[LogLine]) -> Counter[str]:
    """Return how often each line was logged that names a slip."""
    return Counter(
        line.text
        for line in log
        if line.level in ("error", "fatal", "warn")
        and SLIPS.search(line.text)
        and not ON_PURPOSE.search(line.text)
    )


def _dead_thread(check: Failed, log: Sequence[LogLine]) -> Cause | None:
    """Return the exception that a thread of the node died of, with its innermost line."""
    where = ""
    begun = False
    for line in log:
        text = line.text.strip()
        if line.level != "stderr":
            continue
        begun = begun or text.startswith(DEAD_THREAD)
        if begun and (frame := FRAME.match(text)):
            where = f"line {frame['line']} of {frame['file']}, in {frame['function']}"
        elif begun and (said := ENDS_WITH.match(text)):
            seen = f"A thread of the node died at {line.t:.2f} s, and with it its work: {said[0]}"
            seen = f"{seen[:MAX_LINE].rstrip('.')}{_advice(text)}"
            return Cause(seen, check.kind, where, check=check.id)
    return None


def _advice(text: str) -> str:
    words = plain_words_on(text)
    return sentences(f". Perhaps: {words}") if words else ""


def plain_words_on(line: str) -> str:
    """Return what to try about the exception that a line of the log names; "" if unknown."""
    match = NAMED.search(line)
    return words_for([match[1]], line) if match else ""
