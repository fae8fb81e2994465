"""The verbs of the checks: each is one question to recordings, with one wording of its failure.

An exercise's own oracle (`cases` in its `contract.py`) says what is right; the verbs only compare.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from grader.checks.ahead import front_distance
from grader.checks.case import Case, Runs, Said, spell_allowed
from grader.checks.commands import FIELDS, ZERO, answers, garbage, spell
from grader.checks.contract import Free, Limits
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive, require_wiring
from grader.recording import Recording
from sim.messages import CMD_VEL_TOPIC

TOLERANCE = 1e-3  # of a number
UNITS = {"linear.x": "m/s", "angular.z": "rad/s"}
USUAL = 0.85  # share of answers that are the same, of a node that does not react
LEAST_WAY = 0.5  # [m] driven in at least one world
STILL = 0.05  # [m/s]
END = "publisher", CMD_VEL_TOPIC
PATIENCE = 1.5  # [s] that a robot may stand though its way is free
PUBLISH_ONCE = "Publish once at the end of the callback, whatever the message was."
KEPT_BACK = "What keeps it back: an early return, a condition, a memory that never fills?"


def wired(runs: Runs, *nodes: str) -> None:
    """Fail unless the node runs to the end, with its topics and services, in every run."""
    for recording in runs:
        require_wiring(recording, runs.exercise, *nodes)


def answers_once(runs: Sequence[Recording]) -> None:
    """Fail unless each scan is answered by exactly one command, and none comes before."""
    for recording in runs:
        require_alive(recording)
        first, commands = recording.times("/scan").min(initial=math.inf), recording.twists().t
        if len(commands) and commands[0] < first:
            fail(
                "a command came before the first scan",
                expected="silence until there is something to decide on",
                actual=f"a Twist at {commands[0]:.3f} s, the first scan at {first:.3f} s",
                at=commands[0],
                recording=recording,
                help="Publish from the scan callback only, not from a timer.",
            )
        for answer in answers(recording):
            if answer.count != 1:
                every = [e for e in recording.ends if (e.kind, e.topic) == END]
                ends = sorted({f"{e.node} ({e.process})" for e in every if answer.count > 1})
                fail(
                    f"{answer.count} commands followed {answer.what}",
                    expected="exactly one Twist for each scan",
                    actual=f"{answer.count} between this scan and the next",
                    at=answer.scan.t,
                    recording=recording,
                    help=f"{' and '.join(ends)} publish on {CMD_VEL_TOPIC}: one too many."
                    if ends[1:]
                    else "Look for a timer, a second publish(), or a return before the publish(). "
                    "A publisher made for each message loses some: others find it too late.",
                )


def follows(
    runs: Runs,
    *tags: str,
    help: str = "",
    tolerance: float = TOLERANCE,
    topic: str = CMD_VEL_TOPIC,
    explain: Callable[[Case], str] = lambda case: "",  # what a wrong answer shows, or `help`
) -> None:
    """Fail unless the node's answer is allowed in each case with one of these tags.

    Fail too if no case has a tag: a node that stopped early must not pass.
    """
    for recording in runs:
        require_alive(recording)
    found = list(runs.cases(*tags))
    for tag in tags:
        if not any(tag in case.tags for _, case in found):
            fail(f"there was no occasion to judge “{tag}”", recording=runs[0], help=help)
    for recording, case in found:
        require_allowed(recording, case, explain(case) or help, tolerance=tolerance, topic=topic)
    asked = {name for _, case in found for name in case.allowed}
    reacts(list(runs.asking(asked)))


def require_allowed(
    recording: Recording,
    case: Case,
    help: str = "",
    *,
    tolerance: float = TOLERANCE,
    topic: str = CMD_VEL_TOPIC,
) -> None:
    """Fail unless the node's answer to this case is allowed."""
    wrong = case.wrong(tolerance)
    if not wrong and (case.allowed or not case.count):
        return
    noun = "command" if topic == CMD_VEL_TOPIC else f"message on {topic}"
    said, unit = case.said.get(wrong), UNITS.get(wrong, "")
    expected = f"{wrong} = {spell_allowed(case.allowed.get(wrong, ()), unit)}"
    actual = f"{wrong} = {_shown(said, unit)}"
    if not case.allowed:
        message, expected, actual = f"a {noun} came", f"nothing on {topic}", f"{case.count} of them"
    elif not (case.said and case.count):
        message = f"no {noun} came"
        actual = f"none; the last one, {actual}, still counts" if case.said else "none"
        if topic != CMD_VEL_TOPIC:
            help = KEPT_BACK
        elif not case.count:  # a scan's answer, not a timer's command
            help = PUBLISH_ONCE
    else:
        message = f"wrong {wrong}" + (f" on {topic}" if topic != CMD_VEL_TOPIC else "")
        if isinstance(said, float) and not (help and math.isnan(said)):  # NaN may be computed
            help = garbage(said) or help
    fail(
        f"{case.what}: {message}",
        expected=expected,
        actual=actual,
        at=case.at,
        recording=recording,
        help=help,
    )


def reacts(answers: Sequence[tuple[Recording, Case]]) -> None:
    """Fail if the node nearly always says the same, though the cases call for different answers.

    Without this a node that only ever stops would pass every check that expects a stop.
    """
    bench = any(recording.scenario.bench_scans for recording, _ in answers)
    if not bench and any(case.rounded != answers[0][1].rounded for _, case in answers):
        return
    said, count = Counter[tuple[tuple[str, Said], ...]](), 0
    for number, (_, case) in enumerate(answers, 1):
        said[case.rounded] += 1
        count = max(count, said[case.rounded])
        if number - count >= (1 - USUAL) * len(answers):
            return  # whatever the rest say
    usual = said.most_common(1)[0][0] if answers else ()
    others = len(answers) - count
    wrong = [each for each in answers if replace(each[1], said=dict(usual)).wrong(TOLERANCE)]
    if not wrong or (bench and others >= (1 - USUAL) * len(wrong)):
        return
    spelled = ", ".join(f"{name} = {_shown(value)}" for name, value in usual) or "nothing"
    fail(
        f"the node says {'nearly always ' if others else ''}the same whatever it sees",
        expected="an answer that depends on what comes in",
        actual=spelled + ("" if count == len(answers) else f" in {count} of {len(answers)}"),
        at=wrong[0][1].at,
        recording=wrong[0][0],
        help="Log what you decide on. Is it the same each time? Then look at how it comes about. "
        "If not: is that what you publish, or ask for?",
    )


def every(
    recording: Recording,
    topic: str,
    period: float,
    tolerance: float,
    *,
    begin: float = 0.0,
    end: float | None = None,
    sooner: bool = False,
    help: str = "",
) -> None:
    """Fail unless messages come on a topic once a period [s], each gap within the tolerance [s].

    `sooner`: more of them may come.
    """
    require_alive(recording)
    last = recording.duration_s if end is None else end
    times = recording.times(topic)
    edges = np.concatenate(([begin], times[(times >= begin) & (times <= last)], [last]))
    gaps, slack = np.diff(edges), tolerance + recording.slack
    late = np.flatnonzero(gaps > period + slack)
    early = np.flatnonzero(gaps[1:-1] < (-math.inf if sooner else period - slack))
    if not len(late) and not len(early):
        return
    first = int(late[0]) if len(late) else int(early[0]) + 1
    spread = f" ± {1000 * tolerance:.0f} ms"
    if tolerance > period:  # a start-up, and two periods
        spread = f", no gap over {1000 * (period + tolerance):.0f} ms"
    fail(
        f"messages on {topic} do not come every {1000 * period:.0f} ms",
        expected=f"one every {1000 * period:.0f} ms{spread}",
        actual=f"{1000 * gaps[first]:.0f} ms from one to the next",
        at=edges[first],
        recording=recording,
        help=help,
    )


def only_linear_x(
    runs: Sequence[Recording], help: str = "This agent only drives straight ahead."
) -> None:
    """Fail unless there are commands, and every field of them but linear.x is zero."""
    for recording in runs:
        require_alive(recording)
        if not len(recording.twists().t):
            fail(
                "not a single Twist came on /cmd_vel",
                expected="one Twist for each scan",
                actual="nothing on /cmd_vel",
                at=first_asked(recording),
                recording=recording,
            )
        zero(recording, FIELDS[1:], help)


def zero(recording: Recording, fields: Iterable[str], help: str) -> None:
    """Fail unless these fields are zero in every command."""
    for field in fields:
        between(recording, field, 0.0, 0.0, help)


def within(recording: Recording, limits: Limits, help: str = "") -> None:
    """Fail unless every command keeps to the limits of speed and turn rate."""
    between(recording, "linear.x", limits.slowest, limits.fastest, help)
    help = help if limits.turning else "Every field but linear.x stays 0."
    between(recording, "angular.z", 0.0 - limits.turning, limits.turning, help)


def between(recording: Recording, field: str, least: float, most: float, help: str) -> None:
    """Fail unless a field is from `least` to `most` in every command."""
    require_alive(recording)
    twists = recording.twists()
    numbers = twists.values[:, FIELDS.index(field)]
    wrong = np.flatnonzero(~((numbers >= least - ZERO) & (numbers <= most + ZERO)))
    if not len(wrong):
        return
    first, unit = wrong[0], UNITS.get(field, "")
    value = float(numbers[first])
    fail(
        f"{field} is beyond its limits" if least < most else f"{field} is not zero",
        expected=f"{field} = {spell_allowed(((least, most),), unit)}",
        actual=f"{field} = {_shown(value, unit)}",
        at=twists.t[first],
        recording=recording,
        help=garbage(value) or help,
    )


def keeps_distance(runs: Sequence[Recording], clearance: float = 0.2, help: str = "") -> None:
    """Fail if the robot touched something, came nearer than `clearance` [m], or never drove."""
    for recording in runs:
        require_alive(recording)
        truth, contact = recording.truth, first_contact(recording)
        nearest = int(np.argmin(truth.clearance))
        if contact is None and truth.clearance[nearest] >= clearance:
            continue
        did = "came too near to" if contact is None else "ran into"
        fail(
            f"the robot {did} something",
            expected=f"no contact, and a clearance of at least {clearance} m",
            actual=f"{truth.clearance[nearest]:.3f} m",
            at=truth.t[nearest] / 1e9 if contact is None else contact,
            recording=recording,
            help=help or "Watch the replay from a second before: what did the lidar see?",
        )
    ways = [np.hypot(np.diff(run.truth.x), np.diff(run.truth.y)).sum() for run in runs]
    if ways and max(ways) < LEAST_WAY:
        fail(
            "the robot hardly moved, so this proves nothing",
            expected="a robot that drives where its way is free",
            actual=f"less than {LEAST_WAY} m driven in each of the worlds",
            at=first_asked(runs[0]),
            recording=runs[0],
            help="Get the checks of its speed right first.",
        )


def drives_on(runs: Sequence[Recording], free: Free, help: str = "") -> None:
    """Fail if the robot stands although its way has been free for a while."""
    for recording in runs:
        require_alive(recording)
        truth, since, count = recording.truth, None, 0
        for scan in recording.scans():
            since = (scan.t if since is None else since) if free(recording.scenario, scan) else None
            if since is None or scan.t - since < PATIENCE:
                continue
            count += 1
            speed = float(np.interp(scan.t, truth.t / 1e9, truth.v))
            if speed < STILL:
                fail(
                    f"the robot stands, though its way has been free for {scan.t - since:.1f} s",
                    expected=f"driving on: nothing is nearer than {front_distance(scan):.2f} m",
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


def first_asked(recording: Recording) -> float | None:
    """Return when the node was sent its first message [s]: where a whole run's failure is shown."""
    return recording.delivered[0].time / 1e9 if recording.delivered else None


def first_contact(recording: Recording) -> float | None:
    """Return when the robot first touched something [s]; None: never."""
    truth = recording.truth
    return float(truth.t[int(np.argmax(truth.contact))]) / 1e9 if truth.contact.any() else None


def _shown(value: Said | None, unit: str = "") -> str:
    if value is None:
        return "nothing"
    return f"“{value}”" if isinstance(value, str) else f"{spell(value)} {unit}".rstrip()
