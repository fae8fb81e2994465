"""The oracles of slow_model: what each command may be, and what predict has to be asked."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby, pairwise

import numpy as np

from grader.checks.case import Case, exactly
from grader.checks.contract import Contract, Survived
from grader.checks.predictions import braking, max_speed, model_found, model_says_go, predictions
from grader.models.features import possible_features
from grader.recording import Inference, Recording, Scan

PERIOD = 0.05  # [s] of the control loop
LONGEST_GAP = 0.075  # [s] between two commands
MAX_AGE = 0.6  # [s] of the scan behind a command; an older one means 0.0 ...
EDGE = 0.05  # [s] ages this near to the limit may fall on either side
LATEST_STOP = MAX_AGE + EDGE  # [s] ... by the next tick
LEAST_RATE = 3.0  # [Hz] of new predictions
LEAST_RATE_5_HZ = 2.4  # [Hz] with a lidar of 5 Hz
AGE_P95 = 0.58  # [s] of the scan behind a command
AGE_P95_5_HZ = 0.6  # [s] with a lidar of 5 Hz
UNSEEN = PERIOD + 0.005  # [s] for which an answer may not have reached the control loop
SILENCE = 1.0  # [s] without a scan that is more than a few lost ones
SPEED = "linear.x"
AT_ONCE = 0.06  # [s] a tick and a little
ARRIVAL = 0.02  # [s] what happens this shortly before may be seen or not
# tags: all commands, those before the first answer, those in a silence of the lidar, those after it
TICK, START, SILENT, BACK = "tick", "start", "silent", "back"
TOO_LATE = frozenset({"slow", "hangs"})  # tags of scans that the model takes too long for
ALONE, NEWEST, KNOWN, IDLE = "alone", "newest", "known", "idle"  # tags of `questions`
UNDER_WAY, NEWER, FEATURES, WAIT = (
    "calls still under way", "newer scans", "features", "seconds to the next call",
)  # fmt: skip

CONTRACT = Contract(
    period=PERIOD,
    free=model_says_go,
    nodes=(braking("slow", seconds=0.2),),
    delayed_in=("slow_wall",),
    survives=Survived(sensors=300, commands=300),
)


@dataclass(frozen=True)
class Answer:
    """What the model said of a scan; of a blind one, which no model needs to see, at once."""

    scan: Scan
    asked: float  # [s]
    answered: float  # [s]
    speed: float  # [m/s], clipped; NaN: no number
    known: bool = True  # it can be what the model says of this scan


def cases(recording: Recording) -> tuple[Case, ...]:
    """Return an occasion for each command, and one for each that comes while a scan is held.

    A command is the newest answer of the model, unless that is too old. A scan that a bench repeats
    for a while has its own prediction in force from LATEST_STOP on.
    """
    return (*_ticks(recording), *_held(recording))


@lru_cache(maxsize=8)
def answers(recording: Recording) -> tuple[Answer, ...]:
    """Return what the model said of which scan: the newest that fits, of those that had come."""
    if model_found(recording.scenario) is None:
        return ()
    said, limit = predictions(recording), max_speed(recording.scenario)
    found = [
        Answer(each.scan, each.scan.t, each.scan.t, math.nan) for each in said if blind(each.scan)
    ]
    for call in calls(recording):
        asked, speed = call.asked / 1e9, _number(call, limit)
        there = [each for each in said if each.scan.t <= asked]
        if there:
            fits = [each.scan for each in there if each.allows(speed)]
            about, known = (fits or [there[-1].scan])[-1], bool(fits) or math.isnan(speed)
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


def blind(scan: Scan) -> bool:
    """Return whether a sector may have no usable reading."""
    return bool(np.isnan(possible_features(scan)).any())


def silence(recording: Recording) -> tuple[Scan | None, float]:
    """Return the last scan before a long silence of the lidar, and when it came back [s]."""
    scans = recording.scans()
    ends = np.array([*(scan.t for scan in scans), recording.duration_s])
    gaps = np.diff(ends)
    if not len(gaps) or gaps.max() < SILENCE:
        return None, math.inf
    return scans[int(gaps.argmax())], float(ends[gaps.argmax() + 1])


def _ticks(recording: Recording) -> Iterator[Case]:
    """Yield each command: the newest answer of the model, or 0.0 if that is too old."""
    said, twists = answers(recording), recording.twists()
    last, back = silence(recording)
    first = min((each.answered for each in said), default=math.inf)
    for t, speed in zip(twists.t.tolist(), twists.linear_x.tolist(), strict=True):
        tags = {TICK} | ({BACK} if t >= back else {SILENT} if last and t > last.t else set())
        tags |= {START} if t < first else set()
        right = {SPEED: exactly(*sorted(right_speeds(said, t, recording.slack)))}
        yield Case(t, f"the command at {t:.2f} s", frozenset(tags), right, {SPEED: speed})


def right_speeds(said: Sequence[Answer], t: float, slack: float) -> set[float]:
    """Return the speeds [m/s] that are right at a time [s]."""
    rest, edge = in_force(said, t, slack), EDGE + slack
    ages = [t - each.scan.stamp for each in rest]
    speeds = {each.speed for each, age in zip(rest, ages, strict=True) if age <= MAX_AGE + edge}
    unseen = not rest or rest[0].answered > t - UNSEEN - slack
    old = any(age > MAX_AGE - edge for age in ages)
    if unseen or old or _refused(said, rest[0].scan.t, t):
        speeds.add(0.0)
    return speeds


def _refused(said: Sequence[Answer], since: float, t: float) -> bool:
    """Return whether a scan that came after `since` [s] turned out to have no prediction by `t`."""
    return any(
        math.isnan(each.speed) and each.answered <= t and each.scan.t > since for each in said
    )


def _held(recording: Recording) -> Iterator[Case]:
    """Yield each command that comes when a bench scan has been repeated for a while."""
    twists, bench = recording.twists(), recording.scenario.bench_scans
    if not bench:
        return
    pairs = zip(bench, predictions(recording), strict=False)
    holds = [next(same) for _, same in groupby(pairs, lambda pair: pair[0].label)]
    begins = [first.scan.t for _, first in holds]
    ends = [*begins[1:], recording.duration_s]
    for (spec, first), begin, end in zip(holds, begins, ends, strict=True):
        right = exactly(0.0) if TOO_LATE & set(spec.tags) else first.allowed
        tags, what = frozenset(spec.tags), f"“{spec.label}”"
        for i in np.flatnonzero((twists.t >= begin + LATEST_STOP) & (twists.t < end)):
            said = {SPEED: float(twists.linear_x[i])}
            yield Case(float(twists.t[i]), what, tags, {SPEED: right}, said)


def questions(recording: Recording) -> Iterator[Case]:
    """Yield an occasion for each call of predict, and for each scan that finds the model idle.

    A scan that comes while the model works may be kept or dropped.
    """
    for before, call in pairwise(calls(recording)):
        at, busy = call.asked / 1e9, float(call.asked < before.answered)
        what = f"predict was called at {at:.3f} s"
        yield Case(at, what, frozenset({ALONE}), {UNDER_WAY: exactly(0.0)}, {UNDER_WAY: busy})
    arrived = recording.times("/scan")
    for each in answers(recording):
        what, near = f"predict was called at {each.asked:.3f} s", ARRIVAL + recording.slack
        newer = (arrived > each.scan.t) & (arrived <= each.asked - near)
        newest, known = {NEWER: float(newer.sum())}, "a scan's" if each.known else "no scan's"
        if not math.isnan(each.speed):
            yield Case(each.asked, what, frozenset({NEWEST}), {NEWER: exactly(0.0)}, newest)
            right = {FEATURES: frozenset({"a scan's"})}
            yield Case(each.asked, what, frozenset({KNOWN}), right, {FEATURES: known})
    yield from _idle(recording)


def _idle(recording: Recording) -> Iterator[Case]:
    asked = np.array([call.asked for call in calls(recording)]) / 1e9
    ended = np.array([call.answered for call in calls(recording)]) / 1e9
    back = silence(recording)[1]
    right = {WAIT: ((0.0, AT_ONCE + recording.slack),)}
    for scan in recording.scans():
        before = int(np.searchsorted(asked, scan.t))
        busy = before and ended[:before].max() > scan.t - ARRIVAL - recording.slack
        if not busy and not blind(scan):
            wait = float(asked[before] if before < len(asked) else recording.duration_s) - scan.t
            tags = frozenset({IDLE, BACK} if scan.t >= back else {IDLE})
            yield Case(scan.t, f"a scan came at {scan.t:.2f} s", tags, right, {WAIT: wait})


def _number(call: Inference, limit: float) -> float:
    """Return what a call said, clipped [m/s]; NaN if it raised, or said no number."""
    said = call.said[0] if call.said and not call.failed else math.nan
    return min(max(said, 0.0), limit) if math.isfinite(said) else math.nan
