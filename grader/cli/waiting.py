"""What is shown while a grading runs: which runs are on, and which checks have passed."""

from __future__ import annotations

import sys
import threading
import time
from types import TracebackType

from rich.console import Console
from rich.live import Live
from rich.spinner import Spinner
from rich.table import Table
from rich.text import Text

from grader.report.terminal import printable
from grader.trial.progress import LEFT_OUT, TRIAL, Step


class Waiting:
    """Is told the steps of a grading: on a terminal a few lines that go, else one a finished run.

    They go to stderr: stdout has the result.
    """

    def __init__(self, title: str, console: Console | None = None, *, quiet: bool = False) -> None:
        """Take what is graded; `quiet`: no lines but on a terminal, for those who parse JSON."""
        self._quiet = quiet
        # this very stderr: while the checks run, pytest has put another in its place
        self._console = console or Console(file=sys.stderr, highlight=False)
        self._title = title
        self._begin = time.monotonic()
        self._lock = threading.Lock()  # steps come from several threads
        self._running: dict[str, None] = {}  # runs, in order
        self._runs = (0, 0)  # done, of
        self._checks: dict[str, str] = {}  # outcomes
        self._live: Live | None = None

    def __enter__(self) -> Waiting:
        if self._console.is_terminal:
            self._live = Live(
                get_renderable=self._lines, console=self._console, transient=True,
                refresh_per_second=8, redirect_stdout=False, redirect_stderr=False,
            )  # fmt: skip
            self._live.start(refresh=True)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def __call__(self, step: Step) -> None:
        """Note a step."""
        with self._lock:
            if step.what != TRIAL:
                if step.name in self._checks:  # the grading is made again: the machine stalled
                    self._checks.clear()
                self._checks[step.name] = step.outcome
                return
            self._runs = (step.done, step.of)
            if not step.outcome:
                self._running[step.name] = None
                return
            self._running.pop(step.name, None)
        if step.outcome == LEFT_OUT:
            return
        if self._live is None and not self._quiet:
            self._console.print(Text(self._plain(step.name)), soft_wrap=True)

    def _plain(self, ended: str) -> str:
        done, of = self._runs
        return f"{self._title}: run {done} of {of} is over ({ended}){self._counts()}"

    def _counts(self) -> str:
        passed, failed = len(self._with("pass")), len(self._with("fail"))
        parts = [f"{passed} checks passed" if passed != 1 else "1 check passed"] if passed else []
        parts += [f"{failed} failed"] if failed else []
        return f"; {', '.join(parts)}" if parts else ""

    def _with(self, outcome: str) -> list[str]:
        return [name for name, said in self._checks.items() if said == outcome]

    def _lines(self) -> Table:
        with self._lock:
            done, of = self._runs
            how = f"{done} of {of} runs" if of else "getting ready"
            seconds = time.monotonic() - self._begin
            rows = [
                ("running", ", ".join(self._running)),
                ("passed", ", ".join(self._with("pass"))),
                ("failed", ", ".join(self._with("fail"))),
            ]
        grid = Table.grid(padding=(0, 1, 0, 1))
        grid.add_column(min_width=7, no_wrap=True)
        grid.add_column(no_wrap=True, overflow="ellipsis")
        grid.add_row(self._spinner, Text(f"{self._title}: {how} ({seconds:.0f} s)"))
        for name, text in rows:
            if text:
                grid.add_row(Text(name, style="dim"), Text(printable(text, self._console)))
        return grid

    @property
    def _spinner(self) -> Spinner:
        spinner = Spinner("line")  # plain ASCII, as every terminal shows it
        spinner.start_time = 0.0
        return spinner
