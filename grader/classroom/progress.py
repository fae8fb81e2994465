"""Show how far a batch is: a line per unit, and now and then how long the rest will take."""

from __future__ import annotations

import time

from grader.report.terminal import Console, printable

EVERY = 10  # units between two estimates


def say(console: Console, text: str) -> None:
    """Print lines that may quote what students wrote: no escape sequences, nothing unprintable."""
    for line in text.splitlines():
        console.print(printable(line, console), markup=False, highlight=False, soft_wrap=True)


class Progress:
    """Shows progress on the console."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._total = 0
        self._before = 0  # units that an earlier run has graded
        self._begun = 0.0  # [s]
        self._over: set[tuple[str, str]] = set()  # each unit counts once
        self._came = 0  # gradings: a unit that is put off has one more to come

    def begin(self, total: int, before: int = 0) -> None:
        """Begin: `total` units are to be graded, and `before` are, by an earlier run."""
        self._total, self._before, self._begun = total, before, time.monotonic()
        if total and before:
            self.say(f"{before} are done or held, {total} are to be graded")

    def done(self, student: str, exercise: str, outcome: str, *, over: bool = True) -> None:
        """Print a line for a unit that has come back; unless it is `over`, it will run again.

        One that is graded again, because the grader was not to be trusted, comes back twice.
        """
        self._came += 1
        if over:
            self._over.add((student, exercise))
            self._total = max(self._total, len(self._over))  # with some of an earlier run
        shown = "".join(c if c.isprintable() else "?" for c in student)
        done, total = self._before + len(self._over), self._before + self._total
        line = f"{done:4}/{total}  {shown}  {exercise}  {outcome}{self._left()}"
        self.say(" ".join(line.split("\n")))

    def _left(self) -> str:
        """Say, now and then, how long the rest will take at this pace."""
        left = self._total - len(self._over)
        if not left or self._came % EVERY:
            return ""
        minutes = (time.monotonic() - self._begun) / self._came * left / 60
        return f"  (about {max(1, round(minutes))} min left)"

    def say(self, text: str) -> None:
        """Print a line."""
        say(self._console, text)
