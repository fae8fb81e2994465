"""What a wrapper does to the messages, or to one number of them, on their way to or from a node.

Each class goes as source text into the file of a node (`grader.authoring.mutate.wrappers`), so it
needs nothing but what stands in it. An operator on messages returns those to pass on; one on
numbers returns the number to put in the place of another.
"""

from __future__ import annotations

import math
from typing import Any

# --- on messages ----------------------------------------------------------------------------------


class Late:
    """Passes each message on only when so many others have come."""

    def __init__(self, messages: int) -> None:
        self.messages = messages
        self.waiting: list[Any] = []

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.waiting.append(message)
        return [self.waiting.pop(0)] if len(self.waiting) > self.messages else []


class OneIn:
    """Passes on the first of so many messages."""

    def __init__(self, messages: int) -> None:
        self.messages = messages
        self.count = 0

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.count += 1
        return [message] if self.count % self.messages == 1 else []


class DropsOneIn:
    """Loses one of so many messages."""

    def __init__(self, messages: int) -> None:
        self.messages = messages
        self.count = 0

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.count += 1
        return [] if self.count % self.messages == 0 else [message]


class OldOneIn:
    """Repeats the message before in the place of one of so many."""

    def __init__(self, messages: int) -> None:
        self.messages = messages
        self.count = 0
        self.last: Any = None

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.count += 1
        old, self.last = self.last, message
        return [old] if self.count % self.messages == 0 else [message]


class Holds:
    """Repeats a message in the place of those that come within so many seconds of it."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.since = -math.inf
        self.held: Any = None

    def __call__(self, message: Any, t: float) -> list[Any]:
        if t - self.since >= self.seconds:
            self.since, self.held = t, message
        return [self.held]


class AtMostEvery:
    """Drops what comes within so many seconds of the last message that was passed on."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.since = -math.inf

    def __call__(self, message: Any, t: float) -> list[Any]:
        if t - self.since < self.seconds:
            return []
        self.since = t
        return [message]


class IgnoresFirst:
    """Ignores the first messages."""

    def __init__(self, messages: int) -> None:
        self.left = messages

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.left -= 1
        return [] if self.left >= 0 else [message]


class IgnoresAfter:
    """Ignores everything after so many messages."""

    def __init__(self, messages: int) -> None:
        self.left = messages

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.left -= 1
        return [message] if self.left >= 0 else []


class DeafAfter:
    """Ignores everything that comes so many seconds after the first message."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.first: float | None = None

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.first = t if self.first is None else self.first
        return [message] if t - self.first < self.seconds else []


class Latches:
    """Keeps the first message for good, and repeats it in the place of every other."""

    def __init__(self) -> None:
        self.first: Any = None

    def __call__(self, message: Any, t: float) -> list[Any]:
        self.first = message if self.first is None else self.first
        return [self.first]


class Twice:
    """Passes each message on twice."""

    def __call__(self, message: Any, t: float) -> list[Any]:
        return [message, message]


class Reorders:
    """Swaps each message with the one after it."""

    def __init__(self) -> None:
        self.waiting: Any = None

    def __call__(self, message: Any, t: float) -> list[Any]:
        if self.waiting is None:
            self.waiting = message
            return []
        first, self.waiting = self.waiting, None
        return [message, first]


class OnlyNewer:
    """Drops a message whose stamp is not newer than every one before it."""

    def __init__(self) -> None:
        self.newest = (0, 0)

    def __call__(self, message: Any, t: float) -> list[Any]:
        stamp = (message.header.stamp.sec, message.header.stamp.nanosec)
        if stamp <= self.newest:
            return []
        self.newest = stamp
        return [message]


class Expires:
    """Says something empty when nothing has come for so many seconds (see `hears`)."""

    def __init__(self, seconds: float) -> None:
        self.silence = seconds

    def __call__(self, message: Any, t: float) -> list[Any]:
        return [message]


# --- on numbers -----------------------------------------------------------------------------------


class Times:
    """Multiplies: another unit, another sign, a wrong gain."""

    def __init__(self, factor: float) -> None:
        self.factor = factor

    def __call__(self, number: float, t: float) -> float:
        return number * self.factor


class Plus:
    """Adds an offset."""

    def __init__(self, offset: float) -> None:
        self.offset = offset

    def __call__(self, number: float, t: float) -> float:
        return number + self.offset


class Clips:
    """Clips to plus and minus a limit."""

    def __init__(self, limit: float) -> None:
        self.limit = limit

    def __call__(self, number: float, t: float) -> float:
        return max(-self.limit, min(self.limit, number))


class NanIs:
    """Takes a certain number for NaN."""

    def __init__(self, number: float) -> None:
        self.number = number

    def __call__(self, number: float, t: float) -> float:
        return self.number if math.isnan(number) else number


class Quantises:
    """Rounds to steps."""

    def __init__(self, step: float) -> None:
        self.step = step

    def __call__(self, number: float, t: float) -> float:
        return round(number / self.step) * self.step if math.isfinite(number) else number


class DeadBand:
    """Takes small numbers for zero."""

    def __init__(self, band: float) -> None:
        self.band = band

    def __call__(self, number: float, t: float) -> float:
        return 0.0 if abs(number) < self.band else number


class Sticks:
    """Changes only by more than a band: hysteresis."""

    def __init__(self, band: float) -> None:
        self.band = band
        self.last: float | None = None

    def __call__(self, number: float, t: float) -> float:
        if self.last is None or not abs(number - self.last) <= self.band:
            self.last = number
        return self.last


class LowPass:
    """Takes a part of the new number and the rest of the last one."""

    def __init__(self, part: float) -> None:
        self.part = part
        self.last: float | None = None

    def __call__(self, number: float, t: float) -> float:
        if self.last is None or not math.isfinite(self.last):
            self.last = number
        self.last += self.part * (number - self.last) if math.isfinite(number) else number
        return self.last


class FallsAtMost:
    """Falls by at most a step from message to message: a gentle stop."""

    def __init__(self, step: float) -> None:
        self.step = step
        self.last: float | None = None

    def __call__(self, number: float, t: float) -> float:
        if self.last is not None:
            number = max(number, self.last - self.step)
        self.last = number
        return number


class RisesAtMost:
    """Rises by at most a step from message to message."""

    def __init__(self, step: float) -> None:
        self.step = step
        self.last: float | None = None

    def __call__(self, number: float, t: float) -> float:
        if self.last is not None:
            number = min(number, self.last + self.step)
        self.last = number
        return number


class LeastOf:
    """Takes the smallest of the last numbers."""

    def __init__(self, messages: int) -> None:
        self.messages = messages
        self.last: list[float] = []

    def __call__(self, number: float, t: float) -> float:
        self.last = [*self.last, number][-self.messages :]
        return min(self.last)


class ZeroFor:
    """Stays at zero for so many seconds once it is there."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.since = -math.inf

    def __call__(self, number: float, t: float) -> float:
        if abs(number) < 1e-9 and t - self.since >= self.seconds:
            self.since = t
        return 0.0 if t - self.since < self.seconds else number


class NotZeroFor:
    """Goes to zero only when zero has been asked for during so many seconds."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.moving = -math.inf
        self.last = 0.0

    def __call__(self, number: float, t: float) -> float:
        if abs(number) >= 1e-9:
            self.moving, self.last = t, number
        return self.last if t - self.moving < self.seconds else number
