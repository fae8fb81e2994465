"""The oracle of slow_model: what each command may be, and what predict has to be asked."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import dropwhile, pairwise

import numpy as np

from grader.checks.case import Case, among, exactly
from grader.checks.contract import Contract
from grader.checks.predictions import (
    TOLERANCE,
    braking,
    max_speed,
    model_found,
    model_says_go,
    predictions,
)
from grader.models.features import possible_features
from grader.recording import Inference, Recording, Scan

PERIOD = 0.05  # [s] of the control loop
MAX_AGE = 0.6  # [s] of the scan behind a command; an older one means 0.0 ...
EDGE = 0.05  # [s] ages this near to the limit may fall on either side
LATEST_STOP = MAX_AGE + EDGE  # [s] ... by the next tick
UNSEEN = PERIOD + 0.005  # [s] for which an answer may not have reached the control loop
ROUNDED = 0.005 + 1e-9  # [m/s] what two digits change at most
LEAST_RATE = 3.0  # [Hz] of new predictions
# that, and p95 of the age of the scan behind a command [s]
USUAL_LIDAR, SLOW_LIDAR, FIVE_HZ = (LEAST_RATE, 0.58), (2.4, 0.6), 5.0
WAITS_FOR_ONE_MORE = 0.1  # [s] a worker that waits for a new scan, when that one is lost
AT_ONCE = 0.06  # [s] a tick and a little
SOON = 0.3  # [s] in which a node that asks at all does so: the sign of life in other checks
ARRIVAL = 0.02  # [s] what happens this shortly before may be seen or not
SPEED, UNDER_WAY, NEWER = "linear.x", "calls still under way", "newer scans"
FEATURES, WAIT, ASKED = "features", "seconds to the next call", "seconds until predict is called"
A_SCANS = "a scan's"
RATE, AGE = "new predictions per second", "seconds from scan to command (p95)"

CONTRACT = Contract(period=PERIOD, free=model_says_go, nodes=(braking("slow", seconds=0.2),))


@dataclass(frozen=True)
class Answer:
    """What the model said of a scan; of a blind one, which no model needs to see, at once."""

    scan: Scan
    asked: float  # [s]
    answered: float  # [s]
    speed: float  # [m/s], clipped; NaN: no number
    known: bool = True  # it can be what the model says of this scan


def cases(recording: Recording) -> tuple[Case, ...]:
    """Return an occasion for each command, each call of predict, and each scan that finds it idle.

    A command is the newest answer of the model, or 0.0 if that is too old. Its tags are `tick`, and
    `start` before the first answer, `silent` in a silence of the lidar, `back` after it.
    """
    return (*_ticks(recording), *_calls(recording), *_idle(recording))


@lru_cache(maxsize=8)
def answers(recording: Recording) -> tuple[Answer, ...]:
    """Return what the model said of which scan: the newest that fits, of those that had come."""
    if model_found(recording.scenario) is None:
        return ()
    scans, limit = recording.scans(), max_speed(recording.scenario)
    said = list(zip(scans, predictions(recording), strict=True))
    found = [Answer(scan, scan.t, scan.t, math.nan) for scan in scans if blind(scan)]
    for call in calls(recording):
        asked, speed = call.asked / 1e9, _number(call, limit)
        there = [(scan, right) for scan, right in said if scan.t <= asked]
        if there:
            fits = [scan for scan, right in there if among(speed, right, TOLERANCE)]
            about = (fits or [there[-1][0]])[-1]
            known = bool(fits) or (math.isnan(speed) and among(0.0, there[-1][1], TOLERANCE))
            found.append(Answer(about, asked, call.answered / 1e9, speed, known))
    return tuple(sorted(found, key=lambda answer: answer.asked))


def calls(recording: Recording) -> list[Inference]:
    """Return the calls of predict, in their order; those of the start-up don't count."""
    found = [i for i in recording.inferences if i.method == "predict" and i.asked >= 0]
    return sorted(found, key=lambda call: call.asked)


def in_force(said: Sequence[Answer], t: float, slack: float) -> list[Answer]:
    """Return the answers that a command at `t` [s] can rest on: the newest one, and the one before
    if that came only just now.
    """
    numbers = [each for each in said if each.answered <= t and not math.isnan(each.speed)]
    seen = sum(each.answered <= t - UNSEEN - slack for each in numbers)
    return numbers[max(seen - 1, 0) :]


def right_speeds(said: Sequence[Answer], t: float, slack: float) -> set[float]:
    """Return the speeds [m/s] that are right at a time [s]."""
    rest, edge = in_force(said, t, slack), EDGE + slack
    ages = [t - each.scan.stamp for each in rest]
    speeds = {each.speed for each, age in zip(rest, ages, strict=True) if age <= MAX_AGE + edge}
    unseen = not rest or rest[0].answered > t - UNSEEN - slack
    refused = [each for each in said if math.isnan(each.speed) and each.answered <= t]
    if (
        unseen
        or max(ages) > MAX_AGE - edge
        or any(each.scan.t > rest[0].scan.t for each in refused)  # a newer one has no prediction
    ):
        speeds.add(0.0)
    return speeds


def blind(scan: Scan) -> bool:
    """Return whether a sector may have no usable reading."""
    return bool(np.isnan(possible_features(scan)).any())


def silence(recording: Recording) -> tuple[float, float]:
    """Return when the lidar falls silent, and when it comes back or the run ends [s]."""
    end = recording.duration_s
    begin, back = next(iter(recording.scenario.faults.blackout), (end, end))
    return begin, min(back, end)


def _ticks(recording: Recording) -> Iterator[Case]:
    """Yield each command; how many new predictions there are; and how old their scans are (p95)."""
    said, twists, slack = answers(recording), recording.twists(), recording.slack
    first = min((each.answered for each in said), default=math.inf)
    last, back = silence(recording)
    behind = []  # when each command came, and the scan behind it [s]; -inf: it is no prediction
    for t, speed in zip(twists.t.tolist(), twists.linear_x.tolist(), strict=True):
        right = {SPEED: exactly(*sorted(right_speeds(said, t, slack)))}
        tags = {"tick", "back" if t >= back else "silent" if t > last else "tick"}
        tags |= {"start"} if t < first else set()
        tags |= {"zero"} if right[SPEED] == exactly(0.0) else set()
        what, rest = f"the command at {t:.2f} s", in_force(said, t, slack)
        if rest:
            what += f", {t - rest[-1].scan.stamp:.2f} s after the scan of the newest prediction"
        yield Case(t, what, frozenset(tags), right, {SPEED: speed})
        scans = [each.scan.t for each in rest if abs(each.speed - speed) <= ROUNDED]
        behind.append((t, max(scans, default=-math.inf)))
    behind = list(dropwhile(lambda pair: pair[1] == -math.inf, behind))
    begin = behind[0][0] if behind else 0.0
    new = len({scan for _, scan in behind}) / max(recording.duration_s - begin, LATEST_STOP)
    ages = sorted(t - scan for t, scan in behind) or [math.inf]
    p95 = ages[math.ceil(0.95 * len(ages)) - 1]
    least, oldest = SLOW_LIDAR if recording.scenario.lidar.rate == FIVE_HZ else USUAL_LIDAR
    oldest += WAITS_FOR_ONE_MORE * (recording.scenario.faults.scan_loss > 0)
    what = f"the commands from {begin:.2f} s on"
    yield Case(begin, what, frozenset({"rate"}), {RATE: ((least, math.inf),)}, {RATE: new})
    yield Case(begin, what, frozenset({"age"}), {AGE: ((0.0, oldest),)}, {AGE: p95})


def _calls(recording: Recording) -> Iterator[Case]:
    """Yield whether each call of predict comes alone, and about the features of the newest scan."""
    for before, call in pairwise(calls(recording)):
        at, busy = call.asked / 1e9, float(call.asked < before.answered)
        what = f"predict was called at {at:.3f} s"
        yield Case(at, what, frozenset({"alone"}), {UNDER_WAY: exactly(0.0)}, {UNDER_WAY: busy})
    arrived, near = recording.times("/scan"), ARRIVAL + recording.slack
    for each in answers(recording):
        what, at = f"predict was called at {each.asked:.3f} s", each.asked
        newer = float(((arrived > each.scan.t) & (arrived <= at - near)).sum())
        yield Case(at, what, frozenset({"newest"}), {NEWER: exactly(0.0)}, {NEWER: newer})
        right, given = {FEATURES: frozenset({A_SCANS})}, A_SCANS if each.known else "no scan's"
        yield Case(at, what, frozenset({"known"}), right, {FEATURES: given})


def _idle(recording: Recording) -> Iterator[Case]:
    """Yield how long each scan that finds the model idle waits; others may be kept or dropped."""
    asked = np.array([call.asked for call in calls(recording)]) / 1e9
    ended = np.array([call.answered for call in calls(recording)]) / 1e9
    back = silence(recording)[1]
    for scan in recording.scans():
        before = int(np.searchsorted(asked, scan.t))
        busy = before and ended[:before].max() > scan.t - ARRIVAL - recording.slack
        if not busy and not blind(scan):
            wait = float(asked[before] if before < len(asked) else recording.duration_s) - scan.t
            what, late = f"a scan came at {scan.t:.2f} s", ["back"] * (scan.t >= back)
            for field, tags, most in ((WAIT, ["idle", *late], AT_ONCE), (ASKED, ["soon"], SOON)):
                right = {field: ((0.0, most + recording.slack),)}
                yield Case(scan.t, what, frozenset(tags), right, {field: wait})


def _number(call: Inference, limit: float) -> float:
    """Return what a call said, clipped [m/s]; NaN if it raised, or said no number."""
    said = call.said[0] if call.said and not call.failed else math.nan
    return min(max(said, 0.0), limit) if math.isfinite(said) else math.nan
