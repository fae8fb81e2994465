"""A model that the judge keeps: the file holds its name, and every answer comes over the link.

Whatever Python of the student's process does with clocks, sleeps and counters, the answer is not
there before the model's time is over, and the judge knows when and how often it was asked.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..questions import MAX_COLUMNS, MAX_ROWS, Question, ask
from ..raises import RAISES

WRONG_SHAPE = "expected features of shape (n, 5)"  # the judge says so, of a model that wants five

Array = NDArray[Any]


class Kept:
    """Has `predict(X)` for features of shape (n, 5), as any model; nothing else of it is here."""

    def __init__(self, file: str, load: int = 0) -> None:
        self._file, self._load = file, load

    def predict(self, features: Any) -> Array:
        """Return what the model says of its features; ValueError if they are no such thing."""
        return self._ask("predict", features)

    def __reduce__(self) -> tuple[Any, ...]:
        return load, (type(self), self._file)

    def __copy__(self) -> Kept:
        return self

    def __deepcopy__(self, _: Any) -> Kept:
        return self

    def _ask(self, method: str, features: Any) -> Array:
        rows = np.array(features, dtype=float)  # as they are now
        known = rows.ndim in (1, 2) and 1 <= len(rows) <= MAX_ROWS
        if not known or not len(rows) <= rows.size <= len(rows) * MAX_COLUMNS:
            raise ValueError(f"{WRONG_SHAPE}, got {rows.shape}")
        told = ask(Question(method, self._file, self._load, len(rows), rows.tobytes()))
        if told.problem:
            got = f", got {rows.shape}" if told.problem == WRONG_SHAPE else ""
            raise RAISES.get(told.error, RuntimeError)(told.problem + got)
        if told.labels:
            return np.array(told.labels)
        return np.frombuffer(told.numbers).reshape(told.shape).astype(told.dtype)


class KeptClassifier(Kept):
    """Has `predict_proba(X)` and `classes_`, too, as every classifier of scikit-learn."""

    classes_ = np.array(["left", "ahead", "right"])  # it has words of its own for what it sees

    def predict_proba(self, features: Any) -> Array:
        """Return (n, classes) probabilities."""
        return self._ask("predict_proba", features)


def load(kind: type[Kept], file: str) -> Kept:
    """Load the model: what unpickling its file does."""
    told = ask(Question("load", file))
    if told.problem:
        raise RuntimeError(told.problem)
    return kind(file, told.load)
