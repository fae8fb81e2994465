"""What a node usually answers: a missing answer is something else than one never given."""

from __future__ import annotations

from collections import Counter

ENOUGH = 5  # events of a kind, before anything is usual
USUAL = 0.8  # part of them that is answered


class AnswerRate:
    """Counts, for each kind of event, how often the node said something before the next event.

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
        """Tell whether the node usually answers events of a kind; False as long as it is new."""
        events = self._events[kind]
        return events >= ENOUGH and self._answered[kind] >= USUAL * events
