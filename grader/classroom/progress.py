"""Show how far a batch is: a bar with the time left on a terminal, a line per unit elsewhere."""

from __future__ import annotations

from types import TracebackType

from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from grader.report.terminal import Console, printable


def say(console: Console, text: str) -> None:
    """Print lines that may quote what students wrote: no escape sequences, nothing unprintable."""
    for line in text.splitlines():
        console.print(printable(line, console), markup=False, highlight=False, soft_wrap=True)


class Progress:
    """Shows progress on the console."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._total = 0
        self._over: set[tuple[str, str]] = set()  # each unit counts once
        self._bar = Bar(
            BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
            TextColumn("{task.description}"), console=console, transient=True,
            disable=not console.is_terminal,
        )  # fmt: skip
        self._task = self._bar.add_task("", total=None)

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._bar.stop()

    def begin(self, total: int) -> None:
        """Show the bar: `total` units are to be graded."""
        self._total = total
        if total:
            self._bar.start()

    def done(self, student: str, exercise: str, outcome: str, *, over: bool = True) -> None:
        """Print a line for a unit that has come back; unless it is `over`, it will run again.

        One that is graded again, because the grader was not to be trusted, comes back twice.
        """
        if over:
            self._over.add((student, exercise))
            self._total = max(self._total, len(self._over))  # with some of an earlier run
        shown = "".join(c if c.isprintable() else "?" for c in student)
        line = f"{len(self._over):4}/{self._total}  {shown}  {exercise}  {outcome}"
        self.say(" ".join(line.split("\n")))
        self._bar.update(
            self._task,
            completed=len(self._over),
            total=self._total,
            description=escape(exercise),
        )

    def say(self, text: str) -> None:
        """Print a line above the bar."""
        say(self._console, text)
