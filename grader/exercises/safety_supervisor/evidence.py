"""What the node commanded and reported, and the verdicts that several checks share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from grader.checks.commands import FIELDS, ZERO, garbage, require_zero
from grader.checks.reading import published
from grader.checks.verdict import fail
from grader.checks.wiring import require_alive
from grader.exercises.safety_supervisor.contract import (
    AS_ASKED,
    LEVELS,
    MAX_SPEED,
    MAX_TURN_RATE,
    TOLERANCE,
    Habit,
    Tick,
    never_reverses,
    ticks,
)
from grader.recording import Recording

TOPIC = "/diagnostics"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
PASSED_ON = {"limited", "ok"}
SHORT_SILENT, LONG_SILENT = 0.2, 1.5  # [s]
SLOW_TO_GO = 0.3  # [s] that it takes a node to move again
SETTLING = 0.6  # [s] after the start, in which reasons are not judged
START = 0.25  # [s] in which the first command comes
LONGEST_REPORT_GAP = 1.1  # [s]
LEVEL_NAMES = {0: "OK", 1: "WARN", 2: "ERROR", 3: "STALE"}


@dataclass(frozen=True)
class Report:
    """One message on /diagnostics."""

    t: float  # [s]
    count: int  # statuses in it
    level: int  # of the first status; -1: there is none
    text: str  # of the first status

    @property
    def reason(self) -> str:
        """The first word of the text, if it is a reason; else an empty text."""
        match = re.match(r"\w+", self.text)
        return match[0] if match and match[0] in LEVELS else ""


def reports(recording: Recording) -> list[Report]:
    """Return what the node published on /diagnostics."""
    found = []
    for time, value in published(recording, TOPIC, DIAGNOSTICS):
        status = value.status
        level, text = (int(status[0].level), str(status[0].message)) if status else (-1, "")
        found.append(Report(time, len(status), level, text))
    return found


def require_reports(recording: Recording) -> list[Report]:
    """Return the reports; fail if there is none."""
    require_alive(recording)
    found = reports(recording)
    if not found:
        fail(
            f"not a single message came on {TOPIC}",
            expected="a DiagnosticArray when the reason changes, and every second",
            actual=f"nothing on {TOPIC}",
            at=min(LONGEST_REPORT_GAP, recording.duration_s),
            recording=recording,
            help="Publish from the control loop: when the reason is new, or the last report old.",
        )
    return found


def require_commands(
    recording: Recording,
    help: str,
    judged: Callable[[Tick], bool] = lambda tick: True,
    *,
    habit: Habit = AS_ASKED,
    forgiven: Callable[[Tick], bool] = lambda tick: False,
) -> None:
    """Fail unless the node ran to the end, with speed and turn rate right at the ticks judged.

    A speed that rises too fast, or too slowly, is as good as a right one: it has a check of its
    own. What the node commanded before it fell silent stays in force, and is judged on.
    """
    require_alive(recording)
    require_right(
        recording,
        [tick for tick in ticks(recording, silences=True, habit=habit) if judged(tick)],
        lambda tick: tick.is_right_but_for_the_rise or forgiven(tick),
        help,
    )


def require_right(
    recording: Recording, found: Sequence[Tick], right: Callable[[Tick], bool], help: str
) -> None:
    """Fail unless there are such ticks, and all of them are right."""
    if not found:
        fail(
            "no command came that could be judged",
            expected="20 Twists a second",
            actual="nothing on /cmd_vel when it was due",
            at=min(START, recording.duration_s),
            recording=recording,
            help=help,
        )
    for tick in found:
        if not right(tick):
            _fail_command(recording, tick, help)


def require_e_stop(recording: Recording) -> None:
    """Fail unless the robot stands while the button is pressed, and moves when it is not."""
    require_stops(recording, "e_stop", "Keep the last /e_stop: true holds until a false comes.")


def require_stops(recording: Recording, reason: str, help: str, habit: Habit = AS_ASKED) -> None:
    """Fail unless the robot stands for as long as this reason holds, and moves when none does.

    How it moves then is for other checks to judge; and that it is slow to move after another
    reason, too.
    """

    def is_right(tick: Tick) -> bool:
        return tick.is_right if tick.stops else tick.moves

    require_alive(recording)
    found = ticks(recording, silences=True, habit=habit)
    require_right(recording, list(_stops_and_moves(found, reason)), is_right, help)


def require_standing(recording: Recording, reason: str, help: str, habit: Habit = AS_ASKED) -> None:
    """Fail unless the robot stands while this reason alone holds: under `obstacle` it may turn.

    Whether it moves when none does, and whether it lives on, is for other checks to judge.
    """
    judged = standing(recording, reason, habit)
    if judged:
        require_right(recording, judged, stands, help)


def require_turning(recording: Recording, reason: str, help: str, habit: Habit = AS_ASKED) -> None:
    """Fail if the robot turns while this reason alone holds, and after a while no longer.

    That it pauses, as for another reason, is for other checks to judge.
    """
    right_at = math.nan  # [s]
    for tick in standing(recording, reason, habit):
        if tick.is_right:
            right_at = tick.t
        elif tick.t - right_at > LONG_SILENT:
            _fail_command(recording, tick, help)


def require_no_delay(recording: Recording, help: str, habit: Habit = AS_ASKED) -> None:
    """Fail if what the robot may do at once it does not, nor stands as after another reason."""
    judged = [
        tick
        for tick in ticks(recording, silences=True, habit=habit)
        if tick.moves and not tick.rising and tick.reasons <= PASSED_ON
    ]
    if judged:
        require_right(
            recording,
            judged,
            lambda tick: tick.is_right_but_for_the_rise or never_reverses(tick, recording),
            help,
        )


def require_moving_after(
    recording: Recording, reason: str, help: str, habit: Habit = AS_ASKED
) -> None:
    """Fail if the robot still stands when nothing has held it for a while after this reason."""
    held, since, judged = False, 0.0, []
    for tick in ticks(recording, silences=True, habit=habit):
        if tick.stops:
            held, since = held or reason in tick.stops, tick.t
        elif tick.must_move and tick.reasons <= PASSED_ON and tick.t - since > SLOW_TO_GO:
            if held:
                judged.append(tick)
            held = False
    if judged:
        require_right(recording, judged, lambda tick: tick.moves, help)


def standing(recording: Recording, reason: str, habit: Habit = AS_ASKED) -> list[Tick]:
    """Return the ticks at which this reason alone is right."""
    return [
        tick for tick in ticks(recording, silences=True, habit=habit) if tick.reasons == {reason}
    ]


def stands(tick: Tick) -> bool:
    """Tell whether the command is none to drive, and none to turn where that is not asked for."""
    return tick.is_right or (tick.reasons == {"obstacle"} and abs(tick.values[0]) <= ZERO)


def _stops_and_moves(found: Iterable[Tick], reason: str) -> Iterator[Tick]:
    """Yield the ticks at which this reason alone is right, and those at which none is any more."""
    stop, since = set[str](), 0.0
    for tick in found:
        if tick.stops:
            stop, since = tick.stops, tick.t
        late = reason in stop or tick.t - since > SLOW_TO_GO
        if tick.reasons == {reason} or (tick.must_move and late):
            yield tick


def _fail_command(recording: Recording, tick: Tick, help: str) -> None:
    speed, turn_rate = tick.values[0], tick.values[5]
    right = list(dict.fromkeys((d.reason, d.speed, d.turn_rate) for d in tick.right))
    fail(
        f"wrong command ({tick.situation.what})",
        expected=" or ".join(f"{v:.3f} m/s, {w:.2f} rad/s ({word})" for word, v, w in right),
        actual=f"{_apart(speed, 3, [v for _, v, _ in right])} m/s, "
        f"{_apart(turn_rate, 2, [w for _, _, w in right])} rad/s",
        at=tick.t,
        recording=recording,
        help=garbage(speed) or garbage(turn_rate) or _own_reason(recording, tick) or help,
    )


def _own_reason(recording: Recording, tick: Tick) -> str:
    """Say which rule the node itself names, if another one is right."""
    said = [report.reason for report in reports(recording) if report.t <= tick.t + ZERO]
    if not said or not said[-1] or said[-1] in tick.reasons:
        return ""
    right = " or ".join(sorted(tick.reasons))
    return f"Your node says {said[-1]} here, where {right} is right. Why does that rule match?"


def require_within_limits(recording: Recording) -> None:
    """Fail if linear.x or angular.z ever is out of its limits, whatever was asked for."""
    for tick in ticks(recording):
        for value, name, limit in (
            (tick.values[0], "linear.x", MAX_SPEED),
            (tick.values[5], "angular.z", MAX_TURN_RATE),
        ):
            if not abs(value) <= limit + TOLERANCE:  # never true of NaN
                fail(
                    f"{name} is out of its limits ({tick.situation.what})",
                    expected=f"|{name}| ≤ {limit}",
                    actual=f"{name} = {value:.2f}",
                    at=tick.t,
                    recording=recording,
                    help=garbage(value)
                    or "Clamp both ways, max(-limit, min(limit, value)), whatever the model asks.",
                )


def require_other_fields(recording: Recording) -> None:
    """Fail unless the four other fields are zero."""
    require_zero(
        recording, FIELDS[1:5], "Fill in a new Twist; only linear.x and angular.z are passed on."
    )


def require_reasons(
    recording: Recording,
    help: str,
    *,
    alone: bool = False,
    habit: Habit = AS_ASKED,
) -> None:
    """Fail if a report gives a wrong reason; with `alone` only where no second rule matches.

    Where the model asked for nothing before it fell silent, the commands do not show when a node
    takes it for silent, nor whether: there it is judged late, and only if it knows the rule.

    A reason is due at the second tick at which it alone is right. It is judged only where the
    commands are right: wrong ones have a check of their own.
    """
    said = require_reports(recording)
    times = np.array([report.t for report in said])
    found = ticks(recording, habit=habit)
    knows_silence = all(map(stands, standing(recording, "stale_command", habit)))
    judged = 0
    for before, tick in pairwise(found):
        clear = len(tick.reasons) == 1 and before.reasons == tick.reasons
        if tick.t <= SETTLING or not clear or not (before.is_exact and tick.is_exact):
            continue
        if alone and len(tick.matching) > 1:
            continue
        age, idle = tick.situation.command_age, not tick.situation.asks_to_move
        if idle and age > SHORT_SILENT and (age < LONG_SILENT or not knows_silence):
            continue
        judged += 1
        newest = int(np.searchsorted(times, tick.t + ZERO, side="right")) - 1
        reason = next(iter(tick.reasons))
        if newest < 0 or said[newest].reason != reason:
            text = f"“{said[newest].text[:60]}”" if newest >= 0 else f"nothing on {TOPIC} yet"
            fail(
                f"wrong reason ({tick.situation.what})",
                expected=f"a text that begins with {reason}",
                actual=text,
                at=tick.t,
                recording=recording,
                help=help,
            )
    if not judged:
        fail(
            "no right command came whose reason could be judged",
            expected="right commands first, then the reasons for them",
            actual="wrong commands",
            at=next((tick.t for tick in found if not tick.is_right), None),
            recording=recording,
            help="Get the checks of the commands right first.",
        )


def require_levels(recording: Recording) -> None:
    """Fail unless every report has the level of the reason that it gives."""
    for report in require_reports(recording):
        wanted = LEVELS.get(report.reason)
        if wanted is None or report.level == wanted:
            continue
        fail(
            f"wrong level of “{report.text[:60]}”",
            expected=f"{LEVEL_NAMES[wanted]} ({wanted})",
            actual=f"{LEVEL_NAMES.get(report.level, 'garbage')} ({report.level})",
            at=report.t,
            recording=recording,
            help="The reason decides alone: OK for ok, WARN for obstacle and limited, else ERROR."
            if report.level in LEVEL_NAMES
            else "level is a byte: assign DiagnosticStatus.OK, .WARN or .ERROR, not a number.",
        )


def require_text(recording: Recording) -> None:
    """Fail unless every report has one status whose text begins with a reason word."""
    for report in require_reports(recording):
        if report.count == 1 and report.reason:
            continue
        fail(
            f"a report with {report.count} statuses"
            if report.count != 1
            else "a report without a reason",
            expected="one status, whose message begins with one of: " + ", ".join(LEVELS),
            actual=f"{report.count} statuses" if report.count != 1 else f"“{report.text[:60]}”",
            at=report.t,
            recording=recording,
            help="status.message begins with the word itself; anything may follow after a space.",
        )


def _apart(value: float, places: int, wanted: Sequence[float]) -> str:
    """Return a number as a student should see it: never like a wanted one that it is not."""
    if not abs(value) < 1e6:
        return f"{value:.3g}"
    text = f"{value:.{places}f}"
    alike = any(value != other and text == f"{other:.{places}f}" for other in wanted)
    return f"{value:.{places + 3}g}" if alike else text
