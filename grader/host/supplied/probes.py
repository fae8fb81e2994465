"""Models that tell the judge, through `/cmd_vel` alone, what a node does with its model.

They are pickled by the judge (grader.models.files) and unpickled by the student's node. Each has
`predict(X)` for X of shape (n, 5), features in the order of EXERCISES.md: front minimum, mean and
standard deviation, left minimum, right minimum. None of them is clever; each answers one question.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_loads = 0  # of models that count them, in this process
_calls = 0  # of predict, in this process
_inside = 0  # calls of Alone.predict at this moment
_overlapped = False  # two of them have been inside at once


class Echo:
    """Which feature went where? Predicts feature `feature`, times `scale`, plus `offset`."""

    def __init__(self, feature: float = 0, scale: float = 1.0, offset: float = 0.0) -> None:
        self.feature = int(feature)
        self.scale = scale
        self.offset = offset

    def predict(self, features: Any) -> Floats:
        """Return (n,) predictions [m/s]."""
        rows = np.asarray(features, dtype=float)
        if rows.ndim != 2 or rows.shape[1] != 5:
            raise ValueError(f"expected features of shape (n, 5), got {rows.shape}")
        answer: Floats = self.offset + self.scale * rows[:, self.feature]
        return answer


class Constant:
    """What is done with this prediction? `value` may be NaN, infinite, too large or negative."""

    def __init__(self, value: float) -> None:
        self.value = value

    def predict(self, features: Any) -> Floats:
        """Return (n,) times the value [m/s]."""
        return np.full(len(features), self.value)


class Raising:
    """Does the node outlive a model that raises, from call `first` to before call `last`?"""

    def __init__(self, first: float = 0, last: float = 1e9, value: float = 0.3) -> None:
        self.first, self.last, self.value = first, last, value

    def predict(self, features: Any) -> Floats:
        """Return (n,) times the value [m/s], or raise."""
        global _calls  # noqa: PLW0603
        _calls += 1
        if self.first <= _calls - 1 < self.last:
            raise RuntimeError("the model can't say anything about these features")
        return np.full(len(features), self.value)


class Sequence:
    """One prediction per call, in this order, over and over."""

    def __init__(self, values: tuple[float, ...]) -> None:
        self.values = values

    def predict(self, features: Any) -> Floats:
        """Return (n,) times the next value [m/s]."""
        global _calls  # noqa: PLW0603
        value = self.values[_calls % len(self.values)]
        _calls += 1
        return np.full(len(features), value)


class ByDistance:
    """One prediction per distance: `values[i]` where the front minimum is about i metres.

    It takes `seconds`, or `seconds[i]` where there are several. However often a node asks (some
    warm their model up), the same scan gives the same answer.
    """

    def __init__(self, values: tuple[float, ...], seconds: float | tuple[float, ...] = 0.0) -> None:
        self.values = values
        self.seconds = seconds if isinstance(seconds, tuple) else (seconds,)

    def predict(self, features: Any) -> Floats:
        """Return (n,) values [m/s]."""
        nearest = np.rint(np.asarray(features, dtype=float)[:, 0]).astype(int)
        time.sleep(self.seconds[int(np.clip(nearest[0], 0, len(self.seconds) - 1))])
        values = np.asarray(self.values, dtype=float)
        answer: Floats = values[np.clip(nearest, 0, len(values) - 1)]
        return answer


class RaisesNear:
    """Does the node outlive a model that raises? It does so below `distance` of front minimum."""

    def __init__(self, distance: float, value: float = 0.3, seconds: float = 0.0) -> None:
        self.distance, self.value, self.seconds = distance, value, seconds

    def predict(self, features: Any) -> Floats:
        """Return (n,) times the value [m/s], or raise."""
        time.sleep(self.seconds)
        if (np.asarray(features, dtype=float)[:, 0] < self.distance).any():
            raise RuntimeError("the model can't say anything about these features")
        return np.full(len(features), self.value)


class CountsLoads:
    """How often was the model loaded? Takes `seconds` to unpickle; predicts loads times `scale`."""

    def __init__(self, seconds: float = 0.08, scale: float = 0.1) -> None:
        self.seconds, self.scale = seconds, scale

    def __setstate__(self, state: dict[str, float]) -> None:
        global _loads  # noqa: PLW0603
        self.__dict__.update(state)
        _loads += 1
        time.sleep(self.seconds)

    def predict(self, features: Any) -> Floats:
        """Return (n,) times the number of loads so far, scaled [m/s]."""
        return np.full(len(features), _loads * self.scale)


class Weighted:
    """Are all features right, and in order? Predicts their weighted sum, after `seconds`."""

    def __init__(
        self, weights: tuple[float, ...], offset: float = 0.0, seconds: float = 0.0
    ) -> None:
        self.weights, self.offset, self.seconds = weights, offset, seconds

    def predict(self, features: Any) -> Floats:
        """Return (n,) predictions [m/s]."""
        rows = np.array(features, dtype=float)  # as they were at the start
        if rows.ndim != 2 or rows.shape[1] != len(self.weights):
            raise ValueError(
                f"expected features of shape (n, {len(self.weights)}), got {rows.shape}"
            )
        time.sleep(self.seconds)
        answer: Floats = self.offset + rows @ np.asarray(self.weights, dtype=float)
        return answer


class Alone:
    """One inference at a time? Predicts `alone`, and `overlap` for good once two overlapped."""

    def __init__(self, seconds: float = 0.2, alone: float = 0.2, overlap: float = 0.45) -> None:
        self.seconds, self.alone, self.overlap = seconds, alone, overlap

    def predict(self, features: Any) -> Floats:
        """Return (n,) times one of the two values [m/s]."""
        global _inside, _overlapped  # noqa: PLW0603
        _inside += 1
        _overlapped |= _inside > 1
        time.sleep(self.seconds)
        _inside -= 1
        return np.full(len(features), self.overlap if _overlapped else self.alone)


class Slow:
    """Sleeps `seconds` (or one of several, in turn), then answers as Echo does."""

    def __init__(
        self,
        seconds: float | tuple[float, ...] = 0.2,
        feature: float = 0,
        scale: float = 1.0,
        offset: float = 0.0,
    ) -> None:
        self.seconds = seconds if isinstance(seconds, tuple) else (seconds,)
        self.echo = Echo(feature, scale, offset)

    def predict(self, features: Any) -> Floats:
        """Return (n,) predictions [m/s], late."""
        global _calls  # noqa: PLW0603
        seconds = self.seconds[_calls % len(self.seconds)]
        _calls += 1
        answer = self.echo.predict(features)  # the features as they were at the start
        if seconds:  # a sleep of 0 s costs a turn of the processor, and the judge asks often
            time.sleep(seconds)
        return answer
