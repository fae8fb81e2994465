"""Probe classifiers: what does a detection server do with its model? The answers to /detect tell.

As in `probes`, the judge pickles them and the student's node unpickles them. Each has `predict(X)`
and `predict_proba(X)` for X of shape (n, 5), features in the order of `grader/models/features.py`,
and nothing else that a node may rely on.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

SURE, UNSURE = 0.9, 0.4  # of Describes: confidence near and far
CERTAIN = 3.0  # [m] nearer than this, Numbers has no doubt
PER_METRE = 0.04  # [1/m] confidence lost with distance
SHARES = (0.4, 1.0, 0.6)  # how the classes share the probability; the second is the greatest
# what FailsAt does where [m]
PREDICT_RAISES = {1: RuntimeError, 11: TypeError}
PROBA_RAISES = {2: RuntimeError, 12: IndexError}
PROBA_SAYS = {3: np.nan, 4: np.inf, 5: np.array([np.nan, 0.6, 0.3])}


class Describes:
    """Which features arrived? The label spells them; the confidence depends on the first.

    `predict` takes `seconds`.
    """

    def __init__(self, seconds: float = 0.0) -> None:
        self.seconds = seconds

    def predict(self, features: Any) -> Array:
        """Return (n,) labels: the five features [m] in words."""
        rows = self._rows(features)
        return np.array([" ".join(f"{number:.4f}" for number in row) for row in rows])

    def predict_proba(self, features: Any) -> Array:
        """Return (n, 3) probabilities; the greatest is the second."""
        greatest = np.clip(SURE - PER_METRE * self._rows(features)[:, :1], UNSURE, SURE)
        rest = 1.0 - greatest
        return np.hstack([SHARES[0] * rest, greatest, SHARES[2] * rest])

    def _rows(self, features: Any) -> Array:
        rows = np.array(features, dtype=float)
        if rows.ndim != 2 or rows.shape[1] != 5:
            raise ValueError(f"expected features of shape (n, 5), got {rows.shape}")
        return rows


class Numbers(Describes):
    """Labels that are numbers (int64), probabilities in float32: as much a classifier as any."""

    def predict(self, features: Any) -> Array:
        """Return (n,) labels: the distance ahead in whole metres."""
        return np.rint(self._rows(features)[:, 0]).astype(np.int64)

    def predict_proba(self, features: Any) -> Array:
        """Return (n, 3) probabilities; nearer than `CERTAIN` the second is 1."""
        near = self._rows(features)[:, :1] < CERTAIN
        said = np.where(near, [0.0, 1.0, 0.0], super().predict_proba(features))
        return said.astype(np.float32)


class CountsLoads(Describes):
    """How often was the model loaded? The label says it; loading takes a while."""

    load_seconds = 0.08
    loads = 1  # the judge counts them

    def predict(self, features: Any) -> Array:
        """Return (n,) times the number of loads so far, in words."""
        return np.array([f"load {self.loads}"] * len(self._rows(features)))


class FailsAt(Describes):
    """Does the server outlive its model? It fails in its own way at each of several distances."""

    def predict(self, features: Any) -> Array:
        """Return (n,) labels, or raise."""
        kind = PREDICT_RAISES.get(self._distance(features))
        if kind is not None:
            raise kind("the model can't say anything about these features")
        return super().predict(features)

    def predict_proba(self, features: Any) -> Array:
        """Return (n, 3) probabilities, which may not be numbers, or raise."""
        distance = self._distance(features)
        if distance in PROBA_RAISES:
            raise PROBA_RAISES[distance]("the model can't say how sure it is")
        if distance in PROBA_SAYS:
            return np.full((len(features), 3), PROBA_SAYS[distance])
        return super().predict_proba(features)

    def _distance(self, features: Any) -> int:
        return round(float(self._rows(features)[0, 0]))
