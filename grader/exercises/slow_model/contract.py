"""The oracle of slow_model: what each command may be, by the scans and by what the model said."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import groupby

import numpy as np

from grader.checks.braking import braking, model_says_go
from grader.checks.case import Case, exactly
from grader.checks.contract import Contract, Survived
from grader.checks.predictions import max_speed, predictions
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
TICK, SILENT, BACK = (
    "tick",
    "silent",
    "back",
)  # tags: all commands, those without scans, those after
TOO_LATE = frozenset({"slow", "hangs"})  # tags of scans that the model takes too long for

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


def cases(recording: Recording) -> tuple[Case, ...]:
    """Return an occasion for each command, and one for each that comes while a scan is held.

    A command is the newest answer of the model, unless that is too old. A scan that a bench repeats
    for a while has its own prediction in force from LATEST_STOP on.
    """
    return (*_ticks(recording), *_held(recording))


@lru_cache(maxsize=8)
def answers(recording: Recording) -> tuple[Answer, ...]:
    """Return what the model said of which scan: the newest that fits, of those that had come."""
    said, limit = predictions(recording), max_speed(recording.scenario)
    found = [
        Answer(each.scan, each.scan.t, each.scan.t, math.nan) for each in said if blind(each.scan)
    ]
    for call in calls(recording):
        asked, speed = call.asked / 1e9, _number(call, limit)
        there = [each for each in said if each.scan.t <= asked]
        if there:
            about = next((each for each in reversed(there) if each.allows(speed)), there[-1])
            found.append(Answer(about.scan, asked, call.answered / 1e9, speed))
    return tuple(sorted(found, key=lambda answer: answer.asked))


def unexplained(recording: Recording) -> float | None:
    """Return when the model was first asked about the features of no scan that had come [s]."""
    said, limit = predictions(recording), max_speed(recording.scenario)
    for call in calls(recording):
        speed, asked = _number(call, limit), call.asked / 1e9
        there = [each for each in said if each.scan.t <= asked and not blind(each.scan)]
        if there and not math.isnan(speed) and not any(each.allows(speed) for each in there):
            return asked
    return None


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
    for t, speed in zip(twists.t.tolist(), twists.linear_x.tolist(), strict=True):
        tags = {TICK} | ({BACK} if t >= back else {SILENT} if last and t > last.t else set())
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
        case = Case(begin + LATEST_STOP, f"“{spec.label}”", frozenset(spec.tags), {SPEED: right})
        during = np.flatnonzero((twists.t >= case.at) & (twists.t < end))
        for i in during.tolist():
            speed = float(twists.linear_x[i])
            yield replace(case, at=float(twists.t[i]), said={SPEED: speed})
        if not len(during):
            earlier = twists.linear_x[twists.t < end].tolist()
            yield replace(case, said={SPEED: earlier[-1]} if earlier else {}, count=0)


def _number(call: Inference, limit: float) -> float:
    """Return what a call said, clipped [m/s]; NaN if it raised, or said no number."""
    said = call.said[0] if call.said and not call.failed else math.nan
    return min(max(said, 0.0), limit) if math.isfinite(said) else math.nan
