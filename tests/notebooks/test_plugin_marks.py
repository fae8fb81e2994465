"""From the judge's verdict to a cell's points, and to its output."""

from typing import Any

import payloads
import pytest

from grader.nbgrader.cells import Wanted
from grader.nbgrader.judge import Verdict
from grader.nbgrader.late import LatePenalty
from grader.nbgrader.marks import Mark, mark_of
from grader.nbgrader.table import output_of


def check(name: str, outcome: str = "pass", points: int = 5, **more: Any) -> dict[str, Any]:
    return payloads.check(name, f"Title of {name}.", outcome, max_points=points) | more


def verdict(*checks: dict[str, Any]) -> Verdict:
    return Verdict({"checks": list(checks)})


ASKED = Wanted("obstacle_avoidance", ("a", "b"))


NO_HOST = Verdict(None, problem="no host")
FIELD = check("f", points=0, kind="field")
UNJUDGED = ("error", "inconclusive", "unavailable")


@pytest.mark.parametrize(
    ("said", "asked", "most", "points", "by_hand"),
    [
        # of its own checks only
        (verdict(check("a"), check("b", "fail", 10), check("c")), "ab", 15.0, 5.0, False),
        (verdict(check("a"), check("b", "skip"), FIELD), "", 10.0, 5.0, False),  # all with points
        (verdict(check("a"), check("b", "fail")), "ab", 3.0, 1.5, False),  # an instructor's maximum
        *((verdict(check("a"), check("b", one)), "ab", 10.0, 5.0, True) for one in UNJUDGED),
        *((verdict(check("a", one), check("b", one)), "ab", 10.0, None, True) for one in UNJUDGED),
        (NO_HOST, "ab", 10.0, None, True),
        (verdict(check("a")), "z", 10.0, None, True),  # a check that is gone
    ],
)
def test_the_points_of_a_cell(
    said: Verdict, asked: str, most: float, points: float | None, by_hand: bool
) -> None:
    mark = mark_of(Wanted("obstacle_avoidance", tuple(asked)), said, most)
    assert (mark.points, mark.by_hand) == (points, by_hand)


def test_why_nothing_was_judged_is_said() -> None:
    assert mark_of(ASKED, NO_HOST, 10.0).said == "could not be judged: no host"


def test_what_students_wrote_is_escaped() -> None:
    evil = "<script>alert(1)</script>\x1b[31m"
    bad = check("a", "fail", message=evil, expected=evil, actual=evil, help=evil, scenario=evil,
                time=1.0)  # fmt: skip
    data = output_of(Mark(0.0, False, (bad,), said=evil), 5.0, [evil]).data
    assert "<script>" not in data["text/html"]
    assert data["text/html"].count("&lt;script&gt;") == 7
    assert "\x1b" not in data["text/html"] + data["text/plain"]


def test_the_output_says_what_the_terminal_says() -> None:
    bad = check("a", "fail", message="too fast", expected="0.5 m/s", actual="0.7 m/s", time=2.5,
                scenario="avoid_wall", help="Look at the border.")  # fmt: skip
    data = output_of(Mark(5.0, True, (bad, check("b"))), 10.0).data
    assert data["text/plain"].split("\n") == [
        "5 / 10 points",
        "A person has to look at this one before it counts.",
        "✗ FAIL    Title of a.  0/5",
        "          too fast",
        "          expected: 0.5 m/s",
        "          actual: 0.7 m/s",
        "          when: 2.50 s in avoid_wall",
        "          next: Look at the border.",
        "✓ pass    Title of b.  5/5",
    ]


HOUR = 60 * 60.0  # [s]


@pytest.mark.parametrize(
    ("late", "points"), [(1, None), (1.01, 8), (25, 8), (25.01, 16), (1000, 40)]
)
def test_a_late_penalty_is_for_each_day_begun(late: float, points: float | None) -> None:
    rule = LatePenalty(per_day=10, grace_minutes=60, at_most=50)
    assert rule.late_submission_penalty("ann", 80.0, late * HOUR) == points
    assert LatePenalty().late_submission_penalty("ann", 80.0, late * HOUR) is None


def test_the_cause_stands_above_the_checks_of_a_cell_in_which_one_failed() -> None:
    cause = {"text": "The node <b>stands</b>.", "where": "line 3 of agent.py"}
    said = Verdict({"checks": [check("a"), check("b", "fail"), check("c")], "cause": cause})
    failed = output_of(mark_of(ASKED, said, 10.0), 10.0).data
    passed = output_of(mark_of(Wanted("obstacle_avoidance", ("a",)), said, 5.0), 5.0).data
    assert failed["text/plain"].split("\n")[1:3] == [
        "Cause: The node <b>stands</b>.", "Line: line 3 of agent.py",
    ]  # fmt: skip
    assert "<strong>Cause</strong> The node &lt;b&gt;stands" in failed["text/html"]
    assert "Cause" not in passed["text/plain"] + passed["text/html"]
