"""What went wrong in a drive, judged by the least that an exercise's contract promises.

A mishap is nothing that a right node could do: a touch, a death, a command beyond a limit, or a
robot that stands though its way has long been free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from grader.checks.contract import Contract, Free, Limits
from grader.checks.verbs import first_contact
from grader.errors import InputError
from grader.recording import Recording

DIES, TOUCHES, BREAKS, STANDS, LOST = "dies", "touches", "breaks", "stands", "lost"
KINDS = (DIES, TOUCHES, BREAKS, STANDS, LOST)  # the worse of two at the same time comes first
TINY = 1e-6  # [m/s], [rad/s]
TICKS = 0.1  # [s] in which a node hears of an emergency stop: two ticks
MOTION = 0.02  # [m] less than this is standing
LEAST_SCANS = 5  # that show a free way
ARRIVED = 0.55  # [m] the contract says 0.5
UNFIT = ("real_time", "missing", "unreadable")  # outcomes that say nothing about any world


@dataclass(frozen=True)
class Mishap:
    """The first mishap of a drive."""

    kind: str
    at: float  # [s]
    text: str  # "the robot touches it"


def mishap_of(recording: Recording, contract: Contract) -> Mishap | None:
    """Return the first mishap of a drive, if any.

    Raises InputError: the node can't be driven in virtual time.
    """
    outcome = recording.outcome
    if outcome.kind in UNFIT:
        raise InputError(f"the node can't be looked at: {outcome.text}")
    if harm := harm_of(recording, contract):
        return harm
    if contract.free is None:
        return _lost(recording)
    return _stands(recording, contract.free, contract.patience)


def harm_of(recording: Recording, contract: Contract) -> Mishap | None:
    """Return the first death, touch or command beyond a limit, if any."""
    at_once = (_death(recording), _touch(recording), _excess(recording, contract))
    found = [mishap for mishap in at_once if mishap is not None]
    return min(found, key=lambda each: (each.at, KINDS.index(each.kind)), default=None)


def _death(recording: Recording) -> Mishap | None:
    outcome = recording.outcome
    if outcome.completed:
        return None
    text = outcome.text.splitlines()[0] if outcome.text else outcome.kind.replace("_", " ")
    return Mishap(DIES, outcome.at, f"the node dies: {text}")


def _touch(recording: Recording) -> Mishap | None:
    at = first_contact(recording)
    return None if at is None else Mishap(TOUCHES, at, "the robot touches it")


def _excess(recording: Recording, contract: Contract) -> Mishap | None:
    """Return the first command that no right node sends."""
    limits, twists = contract.limits, recording.twists()
    before, stopped = 0.0, _e_stop_spans(recording) if contract.heeds_e_stop else []
    for t, row in zip(twists.t.tolist(), twists.values.tolist(), strict=True):
        said = _beyond(row, before, limits)
        pressed = any(begin <= t < end for begin, end in stopped)
        if not said and pressed and any(abs(value) > TINY for value in row):
            said = "drives on in an emergency stop"
        if said:
            return Mishap(BREAKS, t, f"the node {said}")
        before = row[0]
    return None


def _beyond(row: list[float], before: float, limits: Limits) -> str:
    speed, turn = row[0], row[5]
    if not np.isfinite(row).all():
        return "sends a command that is not finite"
    if any(abs(value) > TINY for value in row[1:5]):
        return "sets a field other than linear.x and angular.z"
    if not limits.slowest - TINY <= speed <= limits.fastest + TINY:
        return f"asks for {speed:.2f} m/s"
    if abs(turn) > limits.turning + TINY:
        return f"asks for a turn of {turn:.2f} rad/s"
    if limits.rise is not None and speed > max(0.0, before) + limits.rise + TINY:
        return f"speeds up from {before:.2f} to {speed:.2f} m/s at once"
    return ""


def _e_stop_spans(recording: Recording) -> list[tuple[float, float]]:
    """Return from when to when the emergency stop was pressed, with time to hear of it [s]."""
    events = [(e.at, e.e_stop) for e in recording.scenario.script if e.e_stop is not None]
    ends = [at for at, _ in events] + [recording.scenario.duration]
    return [(at + TICKS, end) for (at, on), end in zip(events, ends[1:], strict=True) if on]


def _stands(recording: Recording, free: Free, patience: float) -> Mishap | None:
    """Return whether the robot stood to the end, though all it saw for so long was a free way."""
    since = recording.duration_s - patience
    seen = [scan for scan in recording.scans() if scan.t >= since]
    if len(seen) < LEAST_SCANS or not all(free(recording.scenario, scan) for scan in seen):
        return None
    if _way(recording, since) > MOTION:
        return None
    text = "the robot stands for ever though its way is free"
    return Mishap(STANDS, _last_motion(recording), text)


def _lost(recording: Recording) -> Mishap | None:
    """Return whether the robot never came to its last goal."""
    goals, truth = recording.goals(), recording.truth
    if not len(goals.t):
        return None
    after = truth.t / 1e9 >= goals.t[-1]
    away = np.hypot(truth.x - goals.x[-1], truth.y - goals.y[-1])[after]
    if not len(away) or away.min() <= ARRIVED:
        return None
    since = recording.duration_s - 3.0
    if _way(recording, since) <= MOTION:
        text = f"the robot stands for ever, {away[-1]:.1f} m from its goal"
        return Mishap(STANDS, _last_motion(recording), text)
    text = f"the robot never comes nearer to its goal than {away.min():.1f} m"
    return Mishap(LOST, float(truth.t[after][int(away.argmin())] / 1e9), text)


def _way(recording: Recording, since: float) -> float:
    """Return the robot's greatest distance from its place at a time [m]."""
    truth = recording.truth
    late = truth.t / 1e9 >= since
    if not late.any():
        return 0.0
    x, y = truth.x[late], truth.y[late]
    return float(np.hypot(x - x[0], y - y[0]).max())


def _last_motion(recording: Recording) -> float:
    moving = np.flatnonzero(np.abs(recording.truth.v) > TINY)
    return float(recording.truth.t[moving[-1]] / 1e9) if len(moving) else 0.0
