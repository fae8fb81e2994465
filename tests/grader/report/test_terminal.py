import io
from typing import Any

import payloads
import pytest
from rich.console import Console

from grader.report import terminal
from grader.report.facts import in_order
from grader.report.terminal import ROWS, readable, render_terminal


def check(outcome: str = "pass", **parts: Any) -> dict[str, Any]:
    title = "Between 0.5 m and 1.0 m the robot drives at 0.15 m/s."
    return payloads.check("slow_zone", title, outcome) | parts


def failure(**parts: Any) -> dict[str, Any]:
    said = {"message": "The robot drove on.", "expected": "0.15 m/s", "actual": "0.50 m/s"}
    more = {"time": 3.21, "help": "Look at the boundary.", "scenario": "bench"}
    return check("fail", **said) | more | parts


def grading(*checks: dict[str, Any], **parts: Any) -> dict[str, Any]:
    return {
        "exercise": "obstacle_avoidance", "file": "agent.py", "tier": 1, "max_score": 100,
        "score": sum(c["points"] for c in checks), "field_ready": None, "checks": list(checks),
        **parts,
    }  # fmt: skip


def render(
    graded: dict[str, Any],
    width: int = 80,
    encoding: str = "utf-8",
    *,
    everything: bool = False,
    **options: Any,
) -> str:
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = Console(file=stream, width=width, legacy_windows=False, **options)
    render_terminal(graded, console, everything=everything)
    stream.flush()
    stream.seek(0)
    return stream.read()


def words(text: str) -> str:
    return " ".join(text.split())


@pytest.mark.parametrize("width", [40, 200])
def test_no_line_is_wider_than_the_terminal(width: int) -> None:
    long = failure(message="word " * 100, expected="x" * 300)
    shown = render(grading(check(), long, failure(kind="field")), width=width)
    assert max(map(len, shown.splitlines())) <= width


def test_a_failure_says_all_that_is_known() -> None:
    where = {"where": "line 3, in f:  go(None)", "log": "1.00 s  hello"}
    shown = words(render(grading(failure(**where)), everything=True))
    assert "✗ FAIL Between 0.5 m and 1.0 m the robot drives at 0.15 m/s. 0/10" in shown
    assert (
        "The robot drove on. expected 0.15 m/s actual 0.50 m/s when 3.21 s in bench "
        "code line 3, in f: go(None) log 1.00 s hello next Look at the boundary."
    ) in shown


def test_the_cause_stands_last_whatever_was_said() -> None:
    hint = {"title": "Task 2. Hint 1", "anchor": "hints.md#task-2", "text": "Not index 0."}
    cause = {"text": "It looks back.\x1b[31m", "where": "line 3", "kind": "core", "hint": hint}
    shown = words(render(grading(failure(), cause=cause)))
    assert "Cause It looks back. Line line 3 Seen expected 0.15 m/s; actual" in shown
    assert "Hint Task 2. Hint 1 (hints.md#task-2) Score" in shown
    assert shown.index("FAIL") < shown.index("Cause") < shown.index("Score")
    assert "\x1b" not in shown
    assert "It looks" not in render(grading(failure(), cause=None))


@pytest.mark.parametrize("width", [40, 80])
def test_from_the_cause_to_the_prompt_no_more_rows_than_a_terminal_has(width: int) -> None:
    long = "word " * 300
    hint = {"title": long, "anchor": "hints.md#task-2", "text": ""}
    said = failure(message=long, expected=long, actual=long, help=long, log=long, where=long)
    many = [failure(id=f"other_{i}", title=long, message=long) for i in range(15)]
    for cause in (None, {"text": long, "where": long, "kind": "core", "hint": hint}):
        graded = grading(said, *many, cause=cause, cap=long, provisional=True, notes=[long])
        lines = render(graded, width).rstrip("\n").split("\n")
        (first,) = (i for i, line in enumerate(lines) if line.startswith(" Cause"))
        assert len(lines) - first <= ROWS
        assert sum("other_" in line for line in lines) == len(many)  # one line each


def test_the_first_failing_task_comes_first_and_all_else_follows() -> None:
    mixed = [check(id="a", task=1), failure(id="b", task=0), failure(id="c", task=3)]
    mixed += [failure(id="d", task=2), check("skip", id="e", task=2), check(id="f", kind="field")]
    assert "".join(each["id"] for each in in_order(mixed)) == "dcbeaf"
    shown = render(grading(*mixed, cause={"text": "It is.", "kind": "core", "check": "c"}))
    assert shown.index("task 2, d") < shown.index("b: ") < shown.index("task 3, c")


def test_outcomes_can_be_told_without_colour() -> None:
    outcomes = ("pass", "fail", "skip", "error", "inconclusive", "unheard-of")
    shown = render(grading(*(check(outcome) for outcome in outcomes)))
    for word in ("pass", "FAIL", "skip", "ERROR", "unsure"):
        assert word in shown
    assert "\x1b" not in shown


def test_score_and_field_line() -> None:
    assert "Score 10 / 100" in words(render(grading(check())))
    assert "not run" in render(grading(check()))
    assert "field-ready: works" in render(grading(check(), field_ready=True))
    field = (check(kind="field"), failure(kind="field"))
    assert "1 of 2 field checks" in render(grading(*field, field_ready=False))


def test_what_could_not_be_judged_is_not_counted() -> None:
    why = "skipped: PyTorch is not installed here; pip install torch"
    absent = [check("unavailable", message=why) for _ in range(2)]
    unsure = check("error"), check("inconclusive")
    shown = words(render(grading(check(), *unsure, *absent), width=120, everything=True))
    assert "10 of 10 points" in shown
    assert "0/10" not in shown.replace("10/10", "")
    assert (shown.count(why), shown.count("skip ")) == (1, 2)
    assert "20 more points are about libraries that are not installed here" in shown


def test_student_text_is_only_text() -> None:
    hostile = "[red]x[/red] [/] \x1b[31mred\x1b[0m \x1b]0;title\x07bell\x07 \u202eback\x9b2J {0}"
    shown = render(grading(failure(title=hostile, message=hostile)), force_terminal=True)
    assert "[red]x[/red] [/]" in words(shown)
    for control in ("\x1b[31m", "\x1b]", "\x07", "\u202e", "\x9b", "title"):
        assert control not in shown


def test_a_word_between_colons_is_no_picture() -> None:
    printed = io.StringIO()
    terminal.Console(file=printed).print("a:x:b")
    assert printed.getvalue() == "a:x:b\n"


def test_an_ascii_terminal_a_huge_message_and_no_check_at_all() -> None:
    graded = grading(check(), failure(message="naïve \U0001f916" + "x" * 100_000), file="ä.py")
    shown = render(graded, encoding="ascii")
    assert shown.isascii()
    assert len(shown) < 5000
    assert "Score 0 / 0" in words(render({"exercise": "x", "checks": []}))


def test_what_is_drawn_over_other_lines_or_backwards_is_left_out() -> None:
    assert readable("a" + "\u0301" * 1000 + "b") == "a" + "\u0301" * 4 + "b"
    assert readable("e\u0302\u0323") == "e\u0302\u0323"  # Vietnamese
    assert readable("x\u202ey\x1b[31mz\u2028\x07") == "xyz"
