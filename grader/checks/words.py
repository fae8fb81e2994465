"""The words of the checks: each is one question to recordings, with one wording of its failure.

    wired            the node runs, with the topics and services of its exercise
    answers_once     one command for each scan, and none before the first
    only_linear_x    every other field of a command is zero
    follows          what the node says is what its contract allows
    reacts           it doesn't say the same whatever it sees
    silent           nothing on a topic for a while
    every            a period
    within           every command within the limits
    keeps_distance   no contact, and clear of everything
    drives_on        the robot drives when its way is free
    logs             a line in the log, of a level

An exercise's own oracle (`cases` in its `contract.py`) says what is right; the words only compare.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import NoReturn

import numpy as np

from grader.checks.ahead import front_distance
from grader.checks.case import Case, Runs, spell_allowed
from grader.checks.commands import (
    garbage,
    require_one_command_each,
    require_only_linear_x,
    spell,
)
from grader.checks.contract import Limits
from grader.checks.driving import path_length, require_no_contact
from grader.checks.moments import came_to_rest, first_asked
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording, Scan
from sim.messages import CMD_VEL_TOPIC

TOLERANCE = 1e-3  # of a number
UNITS = {"linear.x": "m/s", "angular.z": "rad/s"}
USUAL = 0.85  # share of answers that are the same, of a node that does not react
LEAST_WAY = 0.5  # [m] driven in at least one world
STILL = 0.05  # [m/s]
SLACK = 1e-6  # beyond a limit
PUBLISH_ONCE = "Publish once at the end of the callback, whatever the message was."


def wired(runs: Runs, *nodes: str) -> None:
    """Fail unless the node runs to the end, with its topics and services, in every run."""
    for recording in runs:
        require_wiring(recording, runs.exercise, *nodes)


def answers_once(runs: Runs) -> None:
    """Fail unless each scan is answered by exactly one command, and none comes before."""
    for recording in runs:
        require_one_command_each(recording)


def only_linear_x(runs: Runs, help: str = "This agent only drives straight ahead.") -> None:
    """Fail unless every field of every command but linear.x is zero."""
    for recording in runs:
        require_only_linear_x(recording, help)


def follows(
    runs: Runs,
    *tags: str,
    help: str = "",
    tolerance: float = TOLERANCE,
    topic: str = CMD_VEL_TOPIC,
    explain: Callable[[Case], str] = lambda case: "",
) -> None:
    """Fail unless the node said what is allowed, on each occasion with one of these tags.

    Parameters
    ----------
    tags
        Each has to occur: of a node that does too little, nothing is known.
    tolerance
        Of numbers, in their own unit.
    topic
        On which the node says it.
    explain
        Returns what a wrong answer shows, in place of `help`.
    """
    for recording in runs:
        require_alive(recording)
    found = list(runs.cases(*tags))
    for tag in tags:
        if not any(tag in case.tags for _, case in found):
            fail(f"there was no occasion to judge “{tag}”", recording=runs[0], help=help)
    for recording, case in found:
        require_allowed(recording, case, explain(case) or help, tolerance=tolerance, topic=topic)
    for recording in runs:
        reacts(recording, [case for _, case in runs.of([recording]).cases()])


def require_allowed(
    recording: Recording,
    case: Case,
    help: str = "",
    *,
    tolerance: float = TOLERANCE,
    topic: str = CMD_VEL_TOPIC,
) -> None:
    """Fail unless the node said on this occasion what it may say."""
    wrong = case.wrong(tolerance)
    if not wrong and (case.allowed or not case.count):
        return
    noun = "command" if topic == CMD_VEL_TOPIC else f"message on {topic}"
    fails: Callable[..., NoReturn] = partial(fail, at=case.at, recording=recording)
    if not case.allowed:
        fails(
            f"{case.what}: a {noun} came",
            expected=f"nothing on {topic}",
            actual=f"{case.count} of them",
            help=help,
        )
    if not case.said:
        fails(
            f"{case.what}: there was still no {noun}",
            expected=", ".join(
                f"{name} = {spell_allowed(allowed, UNITS.get(name, ''))}"
                for name, allowed in case.allowed.items()
            ),
            actual=f"nothing on {topic}",
            help=PUBLISH_ONCE if topic == CMD_VEL_TOPIC else help,
        )
    said, unit = case.said.get(wrong), UNITS.get(wrong, "")
    shown = _shown(said) + (f" {unit}" if unit else "")
    wanted = f"{wrong} = {spell_allowed(case.allowed[wrong], unit)}"
    if not case.count:
        fails(
            f"{case.what}: no {noun} came, and the last one still counts",
            expected=wanted,
            actual=f"none; it is still {wrong} = {shown}",
            help=PUBLISH_ONCE,
        )
    fails(
        f"{case.what}: wrong {wrong}" + (f" on {topic}" if topic != CMD_VEL_TOPIC else ""),
        expected=wanted,
        actual=f"{wrong} = {shown}",
        help=_garbage(said, help) or help,
    )


def reacts(recording: Recording, cases: Sequence[Case]) -> None:
    """Fail if the node nearly always says the same, though the occasions call for different things.

    Without this a node that only ever stops would pass every check that expects a stop.
    """
    answers = [case for case in cases if case.allowed]
    said = Counter(_rounded(case) for case in answers)
    usual, count = said.most_common(1)[0] if answers else ((), 0)
    others, bench = len(answers) - count, bool(recording.scenario.bench_scans)
    if others >= (1 - USUAL) * len(answers) or (others and not bench):
        return
    wrong = [case for case in answers if _with(case, usual).wrong(TOLERANCE)]
    if not wrong or (bench and others >= (1 - USUAL) * len(wrong)):
        return
    fail(
        "the node says the same whatever it sees",
        expected="an answer that depends on what comes in",
        actual=_spelled(usual)
        + ("" if count == len(answers) else f" in {count} of {len(answers)}"),
        at=wrong[0].at,
        recording=recording,
        help="Log what you decide on. Is it the same each time? Then look at the perception. If "
        "not: does the decision use it, and do you publish the result?",
    )


def silent(
    recording: Recording, topic: str, begin: float, end: float, *, what: str, help: str = ""
) -> None:
    """Fail if anything came on a topic from `begin` up to `end` [s]."""
    require_alive(recording)
    times = recording.times(topic)
    early = times[(times >= begin) & (times < end)]
    if len(early):
        fail(
            f"{what}: something came on {topic}",
            expected=f"nothing on {topic}",
            actual=f"{len(early)} messages, the first at {early[0]:.2f} s",
            at=float(early[0]),
            recording=recording,
            help=help,
        )


def every(
    recording: Recording,
    topic: str,
    period: float,
    tolerance: float,
    *,
    begin: float = 0.0,
    end: float | None = None,
    help: str = "",
) -> None:
    """Fail unless messages come on a topic once a period [s], each gap within the tolerance [s]."""
    require_alive(recording)
    last = recording.duration_s if end is None else end
    times = recording.times(topic)
    inside = times[(times >= begin) & (times <= last)]
    edges = np.concatenate(([begin], inside, [last]))
    slack = tolerance + recording.slack
    gaps = np.diff(edges)
    late = np.flatnonzero(gaps > period + slack)
    early = np.flatnonzero(np.diff(inside) < period - slack)
    if not len(late) and not len(early):
        return
    first = int(late[0]) if len(late) else int(early[0]) + 1
    fail(
        f"messages on {topic} do not come every {1000 * period:.0f} ms",
        expected=f"one every {1000 * period:.0f} ms ± {1000 * tolerance:.0f} ms",
        actual=f"{1000 * gaps[first]:.0f} ms from one to the next",
        at=float(edges[first]),
        recording=recording,
        help=help,
    )


def within(recording: Recording, limits: Limits, help: str = "") -> None:
    """Fail unless every command keeps to the limits of speed and turn rate."""
    require_alive(recording)
    twists = recording.twists()
    for name, numbers, least, most in (
        ("linear.x", twists.linear_x, limits.slowest, limits.fastest),
        ("angular.z", twists.angular_z, -limits.turning, limits.turning),
    ):
        wrong = np.flatnonzero(~((numbers >= least - SLACK) & (numbers <= most + SLACK)))
        if len(wrong):
            value = float(numbers[wrong[0]])
            fail(
                f"{name} is beyond its limits",
                expected=f"{least:.2f} to {most:.2f} {UNITS[name]}",
                actual=f"{spell(value)} {UNITS[name]}",
                at=float(twists.t[wrong[0]]),
                recording=recording,
                help=garbage(value) or help,
            )


def keeps_distance(runs: Sequence[Recording], clearance: float = 0.2, help: str = "") -> None:
    """Fail if the robot touched something, came nearer than `clearance` [m], or never drove."""
    for recording in runs:
        require_alive(recording)
        require_no_contact(
            recording,
            "Watch the replay from a second before the contact: what did the lidar see?",
            expected=f"clearance of at least {clearance} m" if clearance else "no contact",
        )
        truth = recording.truth
        nearest = int(np.argmin(truth.clearance))
        if truth.clearance[nearest] < clearance:
            fail(
                "the robot came too near to something",
                expected=f"clearance of at least {clearance} m",
                actual=f"{truth.clearance[nearest]:.3f} m",
                at=truth.t[nearest] / 1e9,
                recording=recording,
                help=help,
            )
    if max(map(path_length, runs)) < LEAST_WAY:
        fail(
            "the robot hardly moved, so this proves nothing",
            expected="a robot that drives where its way is free",
            actual=f"less than {LEAST_WAY} m driven in each of the worlds",
            at=came_to_rest(runs[0]),
            recording=runs[0],
            help="Get the checks of its speed right first.",
        )


def drives_on(
    recording: Recording, free: Callable[[Scan], bool], *, patience: float = 1.5, help: str = ""
) -> None:
    """Fail if the robot stands although its way has been free for `patience` [s]."""
    require_alive(recording)
    truth, since, count = recording.truth, None, 0
    for scan in recording.scans():
        since = (scan.t if since is None else since) if free(scan) else None
        if since is None or scan.t - since < patience:
            continue
        count += 1
        speed = float(np.interp(scan.t, truth.t / 1e9, truth.v))
        if speed < STILL:
            distance = front_distance(scan)
            fail(
                f"the robot stands, though its way has been free for {scan.t - since:.1f} s",
                expected=f"driving on: the nearest thing ahead is {distance:.2f} m away",
                actual=f"{abs(speed):.2f} m/s",
                at=scan.t,
                recording=recording,
                help=help or "Decide again at each scan, and publish every time.",
            )
    if not count:
        fail("the way was never free for long enough to judge", recording=recording)


def logs(
    recording: Recording,
    levels: Sequence[str],
    *,
    what: str,
    begin: float = 0.0,
    end: float | None = None,
    pattern: str = "",
    help: str = "",
) -> None:
    """Fail unless a line of one of these levels (and of this pattern) was logged in that time."""
    require_alive(recording)
    last = recording.duration_s if end is None else end
    for line in recording.log:
        if line.level in levels and begin <= line.t <= last and re.search(pattern, line.text):
            return
    fail(
        f"{what}: the log does not say so",
        expected=f"a line of level {' or '.join(levels)}"
        + (f" like “{pattern}”" if pattern else ""),
        actual=f"none from {begin:.2f} s to {last:.2f} s",
        at=begin or first_asked(recording),
        recording=recording,
        help=help,
    )


def _garbage(said: float | str | None, help: str) -> str:
    """Say so if a number can only be garbage; NaN may be computed, too: then `help` is better."""
    if not isinstance(said, float) or (math.isnan(said) and help):
        return ""
    return garbage(said)


def _rounded(case: Case) -> tuple[tuple[str, float | str], ...]:
    return tuple(
        (name, round(value, 3) if isinstance(value, float) else value)
        for name, value in sorted(case.said.items())
    )


def _with(case: Case, said: tuple[tuple[str, float | str], ...]) -> Case:
    return Case(case.at, case.what, case.tags, case.allowed, dict(said))


def _spelled(said: tuple[tuple[str, float | str], ...]) -> str:
    return ", ".join(f"{name} = {_shown(value)}" for name, value in said) or "nothing"


def _shown(value: float | str | None) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, str):
        return f"“{value}”"
    return spell(value)
