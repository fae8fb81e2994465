"""What a wrapper does to the messages, or to one number of them, on their way to or from a node.

Each function goes as source text into the file of a node (`grader.authoring.mutate.wrappers`),
after `Operator`, so it needs nothing but the two. On messages it returns those to pass on, on
numbers the number to put in the place of another. `t` is the node's time [s].
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any


class Operator:
    """A change with one amount, which remembers what came before."""

    def __init__(self, amount: float, change: Callable[[Any, Any, float], Any]) -> None:
        """Take how many messages, how many seconds, which factor, limit, step or part."""
        self.amount = amount
        self.change = change
        self.count = 0
        self.since = -math.inf
        self.last: Any = None
        self.kept: list[Any] = []

    def __call__(self, value: Any, t: float) -> Any:
        """Return what takes the place of a message or a number."""
        return self.change(self, value, t)


# --- on messages ----------------------------------------------------------------------------------


def late(op: Operator, message: Any, t: float) -> list[Any]:
    """Passes each message on only when so many others have come."""
    op.kept.append(message)
    return [op.kept.pop(0)] if len(op.kept) > op.amount else []


def one_in(op: Operator, message: Any, t: float) -> list[Any]:
    """Passes on the first of so many messages."""
    op.count += 1
    return [message] if op.count % op.amount == 1 else []


def drops_one_in(op: Operator, message: Any, t: float) -> list[Any]:
    """Loses one of so many messages."""
    op.count += 1
    return [] if op.count % op.amount == 0 else [message]


def old_one_in(op: Operator, message: Any, t: float) -> list[Any]:
    """Repeats the message before in the place of one of so many."""
    op.count += 1
    old, op.last = op.last, message
    return [old] if op.count % op.amount == 0 else [message]


def holds(op: Operator, message: Any, t: float) -> list[Any]:
    """Repeats a message in the place of those that come within so many seconds of it."""
    if t - op.since >= op.amount:
        op.since, op.last = t, message
    return [op.last]


def at_most_every(op: Operator, message: Any, t: float) -> list[Any]:
    """Drops what comes within so many seconds of the last message that was passed on."""
    if t - op.since < op.amount:
        return []
    op.since = t
    return [message]


def ignores_first(op: Operator, message: Any, t: float) -> list[Any]:
    """Ignores the first messages."""
    op.count += 1
    return [] if op.count <= op.amount else [message]


def ignores_after(op: Operator, message: Any, t: float) -> list[Any]:
    """Ignores everything after so many messages."""
    op.count += 1
    return [message] if op.count <= op.amount else []


def deaf_after(op: Operator, message: Any, t: float) -> list[Any]:
    """Ignores everything that comes so many seconds after the first message."""
    op.last = t if op.last is None else op.last
    return [message] if t - op.last < op.amount else []


def latches(op: Operator, message: Any, t: float) -> list[Any]:
    """Keeps the first message for good, and repeats it in the place of every other."""
    op.last = message if op.last is None else op.last
    return [op.last]


def twice(op: Operator, message: Any, t: float) -> list[Any]:
    """Passes each message on twice."""
    return [message, message]


def reorders(op: Operator, message: Any, t: float) -> list[Any]:
    """Swaps each message with the one after it."""
    op.kept.insert(0, message)
    both, op.kept = (op.kept, []) if len(op.kept) == 2 else ([], op.kept)
    return both


def only_newer(op: Operator, message: Any, t: float) -> list[Any]:
    """Drops a message whose stamp is not newer than every one before it."""
    stamp = (message.header.stamp.sec, message.header.stamp.nanosec)
    if stamp <= (op.last or (0, 0)):
        return []
    op.last = stamp
    return [message]


def expires(op: Operator, message: Any, t: float) -> list[Any]:
    """Says something empty when nothing has come for so many seconds (see `hears`)."""
    return [message]


# --- on numbers -----------------------------------------------------------------------------------


def times(op: Operator, number: float, t: float) -> float:
    """Multiplies: another unit, another sign, a wrong gain."""
    return number * op.amount


def plus(op: Operator, number: float, t: float) -> float:
    """Adds an offset."""
    return number + op.amount


def clips(op: Operator, number: float, t: float) -> float:
    """Clips to plus and minus a limit."""
    return max(-op.amount, min(op.amount, number))


def nan_is(op: Operator, number: float, t: float) -> float:
    """Takes a certain number for NaN."""
    return op.amount if math.isnan(number) else number


def quantises(op: Operator, number: float, t: float) -> float:
    """Rounds to steps."""
    return round(number / op.amount) * op.amount if math.isfinite(number) else number


def dead_band(op: Operator, number: float, t: float) -> float:
    """Takes small numbers for zero."""
    return 0.0 if abs(number) < op.amount else number


def sticks(op: Operator, number: float, t: float) -> Any:
    """Changes only by more than a band: hysteresis."""
    if op.last is None or not abs(number - op.last) <= op.amount:
        op.last = number
    return op.last


def low_pass(op: Operator, number: float, t: float) -> Any:
    """Takes a part of the new number and the rest of the last one."""
    if op.last is None or not math.isfinite(op.last):
        op.last = number
    op.last += op.amount * (number - op.last) if math.isfinite(number) else number
    return op.last


def falls_at_most(op: Operator, number: float, t: float) -> float:
    """Falls by at most a step from message to message: a gentle stop."""
    if op.last is not None:
        number = max(number, op.last - op.amount)
    op.last = number
    return number


def rises_at_most(op: Operator, number: float, t: float) -> float:
    """Rises by at most a step from message to message."""
    if op.last is not None:
        number = min(number, op.last + op.amount)
    op.last = number
    return number


def least_of(op: Operator, number: float, t: float) -> Any:
    """Takes the smallest of the last numbers."""
    op.kept = [*op.kept, number][-int(op.amount) :]
    return min(op.kept)


def zero_for(op: Operator, number: float, t: float) -> float:
    """Stays at zero for so many seconds once it is there."""
    if abs(number) < 1e-9 and t - op.since >= op.amount:
        op.since = t
    return 0.0 if t - op.since < op.amount else number


def not_zero_for(op: Operator, number: float, t: float) -> Any:
    """Goes to zero only when zero has been asked for during so many seconds."""
    if abs(number) >= 1e-9:
        op.since, op.last = t, number
    return op.last if t - op.since < op.amount else number
