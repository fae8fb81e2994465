"""What a wrapper does to the messages, or to one number of them, on their way to or from a node.

Each class goes as source text into the file of a node (`grader.authoring.mutate.wrappers`), after
`Operator`, so it needs nothing but the two. An operator on messages returns those to pass on; one
on numbers returns the number to put in the place of another. `t` is the node's time [s].
"""

from __future__ import annotations

import math
from typing import Any


class Operator:
    """Has one amount, and remembers what came before."""

    def __init__(self, amount: float = 0) -> None:
        """Take how many messages, how many seconds, which factor, limit, step or part."""
        self.amount = amount
        self.count = 0
        self.since = -math.inf
        self.last: Any = None
        self.kept: list[Any] = []


# --- on messages ----------------------------------------------------------------------------------


class Late(Operator):
    """Passes each message on only when so many others have come."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.kept.append(message)
        return [self.kept.pop(0)] if len(self.kept) > self.amount else []


class OneIn(Operator):
    """Passes on the first of so many messages."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.count += 1
        return [message] if self.count % self.amount == 1 else []


class DropsOneIn(Operator):
    """Loses one of so many messages."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.count += 1
        return [] if self.count % self.amount == 0 else [message]


class OldOneIn(Operator):
    """Repeats the message before in the place of one of so many."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.count += 1
        old, self.last = self.last, message
        return [old] if self.count % self.amount == 0 else [message]


class Holds(Operator):
    """Repeats a message in the place of those that come within so many seconds of it."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        if t - self.since >= self.amount:
            self.since, self.last = t, message
        return [self.last]


class AtMostEvery(Operator):
    """Drops what comes within so many seconds of the last message that was passed on."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        if t - self.since < self.amount:
            return []
        self.since = t
        return [message]


class IgnoresFirst(Operator):
    """Ignores the first messages."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.count += 1
        return [] if self.count <= self.amount else [message]


class IgnoresAfter(Operator):
    """Ignores everything after so many messages."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.count += 1
        return [message] if self.count <= self.amount else []


class DeafAfter(Operator):
    """Ignores everything that comes so many seconds after the first message."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.last = t if self.last is None else self.last
        return [message] if t - self.last < self.amount else []


class Latches(Operator):
    """Keeps the first message for good, and repeats it in the place of every other."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.last = message if self.last is None else self.last
        return [self.last]


class Twice(Operator):
    """Passes each message on twice."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        return [message, message]


class Reorders(Operator):
    """Swaps each message with the one after it."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.kept.insert(0, message)
        both, self.kept = (self.kept, []) if len(self.kept) == 2 else ([], self.kept)
        return both


class OnlyNewer(Operator):
    """Drops a message whose stamp is not newer than every one before it."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        stamp = (message.header.stamp.sec, message.header.stamp.nanosec)
        if stamp <= (self.last or (0, 0)):
            return []
        self.last = stamp
        return [message]


class Expires(Operator):
    """Says something empty when nothing has come for so many seconds (see `hears`)."""

    @property
    def silence(self) -> float:
        """After so long [s]."""
        return self.amount

    def __call__(self, message: Any, t: float) -> list[Any]:
        return [message]


# --- on numbers -----------------------------------------------------------------------------------


class Times(Operator):
    """Multiplies: another unit, another sign, a wrong gain."""

    def __call__(self, number: float, t: float) -> float:
        return number * self.amount


class Plus(Operator):
    """Adds an offset."""

    def __call__(self, number: float, t: float) -> float:
        return number + self.amount


class Clips(Operator):
    """Clips to plus and minus a limit."""

    def __call__(self, number: float, t: float) -> float:
        return max(-self.amount, min(self.amount, number))


class NanIs(Operator):
    """Takes a certain number for NaN."""

    def __call__(self, number: float, t: float) -> float:
        return self.amount if math.isnan(number) else number


class Quantises(Operator):
    """Rounds to steps."""

    def __call__(self, number: float, t: float) -> float:
        return round(number / self.amount) * self.amount if math.isfinite(number) else number


class DeadBand(Operator):
    """Takes small numbers for zero."""

    def __call__(self, number: float, t: float) -> float:
        return 0.0 if abs(number) < self.amount else number


class Sticks(Operator):
    """Changes only by more than a band: hysteresis."""

    def __call__(self, number: float, t: float) -> Any:
        if self.last is None or not abs(number - self.last) <= self.amount:
            self.last = number
        return self.last


class LowPass(Operator):
    """Takes a part of the new number and the rest of the last one."""

    def __call__(self, number: float, t: float) -> Any:
        if self.last is None or not math.isfinite(self.last):
            self.last = number
        self.last += self.amount * (number - self.last) if math.isfinite(number) else number
        return self.last


class FallsAtMost(Operator):
    """Falls by at most a step from message to message: a gentle stop."""

    def __call__(self, number: float, t: float) -> float:
        if self.last is not None:
            number = max(number, self.last - self.amount)
        self.last = number
        return number


class RisesAtMost(Operator):
    """Rises by at most a step from message to message."""

    def __call__(self, number: float, t: float) -> float:
        if self.last is not None:
            number = min(number, self.last + self.amount)
        self.last = number
        return number


class LeastOf(Operator):
    """Takes the smallest of the last numbers."""

    def __call__(self, number: float, t: float) -> Any:
        self.kept = [*self.kept, number][-int(self.amount) :]
        return min(self.kept)


class ZeroFor(Operator):
    """Stays at zero for so many seconds once it is there."""

    def __call__(self, number: float, t: float) -> float:
        if abs(number) < 1e-9 and t - self.since >= self.amount:
            self.since = t
        return 0.0 if t - self.since < self.amount else number


class NotZeroFor(Operator):
    """Goes to zero only when zero has been asked for during so many seconds."""

    def __call__(self, number: float, t: float) -> Any:
        if abs(number) >= 1e-9:
            self.since, self.last = t, number
        return self.last if t - self.since < self.amount else number
