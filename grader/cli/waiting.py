"""What is shown while a grading runs: how many runs are over, and how many checks have passed."""

from __future__ import annotations

import sys
import threading
from types import TracebackType

from rich.live import Live
from rich.spinner import Spinner
from rich.text import Text

from grader.report.terminal import Console
from grader.trial.progress import LEFT_OUT, TRIAL, Step


class Waiting:
    """Is called with the steps of a grading: a line that changes, or one for each finished run.

    They go to stderr: stdout has the result.
    """

    def __init__(self, title: str, console: Console | None = None, *, quiet: bool = False) -> None:
        """Take what is graded; `quiet`: no lines but on a terminal, for those who parse JSON."""
        self._quiet = quiet
        # this very stderr: while the checks run, pytest has put another in its place
        self._console = console or Console(file=sys.stderr, highlight=False)
        self._title = title
        self._lock = threading.Lock()  # steps come from several threads
        self._checks: dict[str, str] = {}  # outcomes
        self._spinner = Spinner("line", Text(f"{title}: getting ready"))  # ASCII for any terminal
        self._live = Live(
            self._spinner, console=self._console, transient=True,
            refresh_per_second=8, redirect_stdout=False, redirect_stderr=False,
        )  # fmt: skip

    def __enter__(self) -> Waiting:
        if self._console.is_terminal:
            self._live.start(refresh=True)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._live.stop()

    def __call__(self, step: Step) -> None:
        """Note a step."""
        with self._lock:
            if step.what != TRIAL:
                if step.name in self._checks:  # the grading is made again: the machine stalled
                    self._checks.clear()
                self._checks[step.name] = step.outcome
                return
            if step.outcome in ("", LEFT_OUT):
                return
            line = f"{self._title}: run {step.done} of {step.of} is over ({step.name})"
            text = Text(line + self._counts())
        if self._console.is_terminal:
            self._spinner.update(text=text)
        elif not self._quiet:
            self._console.print(text, soft_wrap=True)

    def _counts(self) -> str:
        outcomes = list(self._checks.values())
        passed, failed = outcomes.count("pass"), outcomes.count("fail")
        parts = [f"{passed} checks passed" if passed != 1 else "1 check passed"] if passed else []
        parts += [f"{failed} failed"] if failed else []
        return f"; {', '.join(parts)}" if parts else ""
