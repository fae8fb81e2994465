"""What `course grade` shows while it runs: on a terminal, and in a log."""

import io
import sys

import pytest
from rich.console import Console

from grader.cli.waiting import Waiting
from grader.trial.progress import CHECK, LEFT_OUT, TRIAL, Step

STEPS = [
    Step(TRIAL, 0, 3, "avoid_wall"),
    Step(TRIAL, 0, 3, "avoid_cart"),
    Step(TRIAL, 1, 3, "avoid_wall", "completed"),
    Step(CHECK, 1, 5, "wiring", "pass"),
    Step(CHECK, 2, 5, "slow_zone", "fail"),
    Step(TRIAL, 2, 3, "avoid_cart", "hung"),
    Step(TRIAL, 3, 3, "avoid_store", LEFT_OUT),
]


def shown(steps: list[Step], *, terminal: bool) -> str:
    console = Console(file=io.StringIO(), width=80, force_terminal=terminal, color_system=None)
    with Waiting("Exercise 1, agent.py", console) as waiting:
        for step in steps:
            waiting(step)
        if terminal:
            console.print(waiting._spinner)
    return console.file.getvalue()  # type: ignore[attr-defined]


def test_a_log_gets_a_line_for_each_run_that_is_over() -> None:
    assert shown(STEPS, terminal=False).splitlines() == [
        "Exercise 1, agent.py: run 1 of 3 is over (avoid_wall)",
        "Exercise 1, agent.py: run 2 of 3 is over (avoid_cart); 1 check passed, 1 failed",
    ]


def test_lines_are_seen_while_checks_run_which_capture_stderr(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with Waiting("Exercise 1, agent.py") as waiting, monkeypatch.context() as checks:
        checks.setattr(sys, "stderr", io.StringIO())
        waiting(STEPS[2])
    assert "run 1 of 3 is over" in capsys.readouterr().err


def test_a_terminal_shows_at_once_that_something_goes_on_and_then_how_far_it_is() -> None:
    assert "Exercise 1, agent.py: getting ready" in shown([], terminal=True)
    assert "run 1 of 3 is over (avoid_wall)" in shown(STEPS[:3], terminal=True)
