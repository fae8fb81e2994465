"""How often a node answers: only a node that usually answers can have missed an answer.

An answer that is missing may be the machine's fault; one that is never given is the node's way.
"""

from __future__ import annotations

from collections import Counter

ENOUGH = 5  # events of a kind before anything is called usual
USUAL = 0.8  # share of them that is answered


class AnswerRate:
    """Counts, for each kind of event, how often the node published before the next event.

    A kind is the set of topics on which the event's messages came.
    """

    def __init__(self) -> None:
        self._events: Counter[frozenset[str]] = Counter()
        self._answered: Counter[frozenset[str]] = Counter()

    def note(self, kind: frozenset[str], *, answered: bool) -> None:
        """Count an event."""
        self._events[kind] += 1
        self._answered[kind] += answered

    def answers(self, kind: frozenset[str]) -> bool:
        """Return whether the node usually answers events of a kind; False while the kind is new."""
        events = self._events[kind]
        return events >= ENOUGH and self._answered[kind] >= USUAL * events
