"""Show how far a batch is: a bar with the time left on a terminal, a line per unit elsewhere."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from grader.classroom.row import ABSENT, GRADED, HELD, WAITING
from grader.report.terminal import printable

if TYPE_CHECKING:
    from grader.classroom.batch import GradedClass
    from grader.classroom.candidates import Class

MOST_HELD = 20  # lines at the end


def summary(graded_class: GradedClass, out: Path) -> tuple[str, int]:
    """Return what the instructor reads at the end, and how many things wait for a person."""
    ours = [result for result in graded_class.results if not result.canary]
    held = [result for result in ours if result.state == HELD]
    graded = sum(result.state == GRADED for result in ours)
    absent = sum(result.state == ABSENT for result in ours)
    waiting = [result for result in ours if result.state == WAITING]
    counts = f"{graded} graded, {len(held)} held for a person"
    counts += f", {absent} not handed in" if absent else ""
    counts += f", {len(waiting)} not graded yet" if waiting else ""
    lines = [f"{counts}. Open {out / 'class.html'}"]
    if waiting:
        lines.append("  The same command without --regrade and --exercise grades the rest.")
    for one in held[:MOST_HELD]:
        problem = " ".join(one.problem.split())
        lines.append(f"  held: {one.student}  {one.exercise}  {problem}")
    if len(held) > MOST_HELD:
        lines.append(f"  and {len(held) - MOST_HELD} more, in the class report")
    faults = graded_class.account.summary()
    if faults:
        lines += ["Not all that was handed in was understood:", *faults]
    missing = graded_class.missing
    if missing:
        lines.append("The grader could not write all of it. Missing, as the class report says:")
        lines += [f"  missing: {each}" for each in missing[:MOST_HELD]]
    if len(missing) > MOST_HELD:
        lines.append(f"  and {len(missing) - MOST_HELD} more, in the class report")
    return "\n".join(lines), len(held) + len(waiting) + len(graded_class.account.faults)


def listing(found: Class) -> tuple[str, int]:
    """Return who handed in what, for the terminal, and how many things wait for a person."""
    by_student: dict[str, list[str]] = {}
    held: dict[str, str] = {}  # a line: the first exercise is enough
    for (student, slug), candidate in found.candidates.items():
        files = by_student.setdefault(student, [])
        if candidate.absent:
            continue
        trouble = candidate.trouble()
        files.append(f"{slug} (will be held)" if trouble else slug)
        if trouble:
            held.setdefault(f"  will be held: {student}  {' '.join(trouble.split())}", slug)
    names = {row.student: row for row in found.students}
    lines = []
    for student, slugs in sorted(by_student.items()):
        row = names.get(student)
        about = ", ".join(filter(None, (row.name, row.section) if row else ()))
        lines.append(
            f"{student}{f' ({about})' if about else ''}: {', '.join(slugs) or 'nothing handed in'}"
        )
    counts = "; ".join(f"{state}: {count}" for state, count in found.account.counts().items())
    lines.append(f"{len(by_student)} students. {counts}.")
    listed = list(held)[:MOST_HELD]
    if len(held) > MOST_HELD:
        listed.append(f"  and {len(held) - MOST_HELD} more will be held")
    text = "\n".join([*lines, *listed, *found.account.summary()])
    return text, len(held) + len(found.account.faults)


def say(console: Console, text: str) -> None:
    """Print lines that may quote what students wrote: no escape sequences, nothing unprintable."""
    for line in text.splitlines():
        console.print(printable(line, console), markup=False, highlight=False, soft_wrap=True)


class Progress(Protocol):
    """Is told how far a batch is."""

    def begin(self, total: int) -> None:
        """`total` units are to be graded."""

    def more(self, count: int) -> None:
        """So many more, of earlier runs, are graded again."""

    def done(self, student: str, exercise: str, outcome: str, *, over: bool = True) -> None:
        """A unit has come back; unless it is `over`, it will run again.

        One that is graded again, because the grader was not to be trusted, comes back twice.
        """

    def say(self, text: str) -> None:
        """Something else happened."""


class ConsoleProgress:
    """Shows progress on the console."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._total = 0
        self._over: set[tuple[str, str]] = set()  # each unit counts once
        self._bar: Bar | None = None
        self._task: Any = None

    def __enter__(self) -> ConsoleProgress:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def begin(self, total: int) -> None:
        """Show the bar."""
        self._total = total
        if self._console.is_terminal and total:
            self._bar = Bar(
                BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
                TextColumn("{task.description}"), console=self._console, transient=True,
            )  # fmt: skip
            self._bar.start()
            self._task = self._bar.add_task("", total=total)

    def more(self, count: int) -> None:
        """Make the bar longer."""
        self._total += count
        if self._bar is not None:
            self._bar.update(self._task, total=self._total)

    def done(self, student: str, exercise: str, outcome: str, *, over: bool = True) -> None:
        """Print a line."""
        if over:
            self._over.add((student, exercise))
        shown = "".join(c if c.isprintable() else "?" for c in student)
        line = f"{len(self._over):4}/{self._total}  {shown}  {exercise}  {outcome}"
        self.say(" ".join(line.split("\n")))
        if self._bar is not None:
            self._bar.update(self._task, completed=len(self._over), description=escape(exercise))

    def say(self, text: str) -> None:
        """Print a line above the bar."""
        say(self._console, text)
