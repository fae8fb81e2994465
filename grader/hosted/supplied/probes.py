"""Models that tell the judge, through `/cmd_vel` alone, what a node does with its model.

They are pickled by the judge (grader.models.files) and unpickled by the student's node. Each has
`predict(X)` for X of shape (n, 5), features in the order of `grader/models/features.py`: front
minimum, mean and standard deviation, left minimum, right minimum. None of them is clever; each
answers one question.

None of them counts or waits, which a student's process could undo. A model that takes time, or
whose loads count, stays with the judge (grader.models.service), and the file holds a `kept.Kept`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..raises import RAISES

Floats = NDArray[np.float64]


class Echo:
    """Which feature went where? Predicts feature `feature`, times `scale`, plus `offset`.

    It takes `seconds`.
    """

    def __init__(
        self, feature: float = 0, scale: float = 1.0, offset: float = 0.0, seconds: float = 0.0
    ) -> None:
        self.feature, self.scale, self.offset = int(feature), scale, offset
        self.seconds = seconds

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


class ByDistance:
    """One prediction per distance: `values[i]` where the front minimum is about i metres.

    It takes `seconds`, or `seconds[i]` where there are several.
    """

    def __init__(self, values: tuple[float, ...], seconds: float | tuple[float, ...] = 0.0) -> None:
        self.values = values
        self.seconds = seconds if isinstance(seconds, tuple) else (seconds,)

    def predict(self, features: Any) -> Floats:
        """Return (n,) values [m/s]."""
        values = np.asarray(self.values, dtype=float)
        answer: Floats = values[np.clip(_metres(features), 0, len(values) - 1)]
        return answer

    def takes(self, features: Floats) -> float:
        """Return how long an answer takes [s]: as long as that for its slowest row."""
        seconds = np.asarray(self.seconds, dtype=float)
        return float(seconds[np.clip(_metres(features), 0, len(seconds) - 1)].max())


class RaisesNear:
    """Does the node outlive a model that raises? It does so below `distance` of front minimum.

    `raises` names the exceptions: the first at 0 m, the second at about 1 m, the last from there.
    An answer takes `seconds`, and so does an exception, unless `raises_after` says how long [s].
    """

    def __init__(
        self,
        distance: float,
        value: float = 0.3,
        seconds: float = 0.0,
        raises: str = "RuntimeError",
        raises_after: float | None = None,
    ) -> None:
        self.distance, self.value = distance, value
        self.seconds = (seconds,) if raises_after is None else (seconds, raises_after)
        self.raises = [RAISES[name] for name in raises.split()]

    def predict(self, features: Any) -> Floats:
        """Return (n,) times the value [m/s], or raise."""
        if self._is_near(features):
            kind = self.raises[min(int(_metres(features).min()), len(self.raises) - 1)]
            raise kind("the model can't say anything about these features")
        return np.full(len(features), self.value)

    def takes(self, features: Floats) -> float:
        """Return how long an answer, or an exception, takes [s]."""
        return self.seconds[-1 if self._is_near(features) else 0]

    def _is_near(self, features: Any) -> bool:
        return bool((np.asarray(features, dtype=float)[:, 0] < self.distance).any())


class CountsLoads:
    """How often was the model loaded? Takes `seconds` to load; predicts loads times `scale`."""

    seconds = 0.0  # that an answer takes
    loads = 1  # the judge counts them

    def __init__(self, seconds: float = 0.08, scale: float = 0.1) -> None:
        self.load_seconds, self.scale = seconds, scale

    def predict(self, features: Any) -> Floats:
        """Return (n,) times the number of loads so far, scaled [m/s]."""
        return np.full(len(features), self.loads * self.scale)


class Weighted:
    """Are all features right, and in order? Predicts their weighted sum, after `seconds`."""

    def __init__(
        self, weights: tuple[float, ...], offset: float = 0.0, seconds: float = 0.0
    ) -> None:
        self.weights, self.offset, self.seconds = weights, offset, seconds

    def predict(self, features: Any) -> Floats:
        """Return (n,) predictions [m/s]."""
        rows = np.array(features, dtype=float)
        if rows.ndim != 2 or rows.shape[1] != len(self.weights):
            raise ValueError(
                f"expected features of shape (n, {len(self.weights)}), got {rows.shape}"
            )
        answer: Floats = self.offset + rows @ np.asarray(self.weights, dtype=float)
        return answer


def _metres(features: Any) -> NDArray[np.int_]:
    """Return the (n,) front minima in whole metres."""
    metres: NDArray[np.int_] = np.rint(np.asarray(features, dtype=float)[:, 0]).astype(int)
    return metres
