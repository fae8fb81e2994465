"""From the judge's verdict to a cell's points, and to its output."""

from typing import Any

import pytest

from grader.nbgrader.cells import Wanted
from grader.nbgrader.judge import Verdict
from grader.nbgrader.late import LatePenalty
from grader.nbgrader.marks import Mark, mark_of
from grader.nbgrader.table import output_of


def check(name: str, outcome: str = "pass", points: int = 5, **more: Any) -> dict[str, Any]:
    return {
        "id": name, "title": f"Title of {name}.", "kind": "core", "max_points": points,
        "points": points if outcome == "pass" else 0, "outcome": outcome, "message": "", **more,
    }  # fmt: skip


def verdict(*checks: dict[str, Any]) -> Verdict:
    return Verdict({"checks": list(checks)})


ASKED = Wanted("obstacle_avoidance", ("a", "b"))


def test_points_are_those_of_its_own_checks() -> None:
    said = verdict(check("a"), check("b", "fail", 10), check("c", points=85))

    mark = mark_of(ASKED, said, 15.0)

    assert (mark.points, mark.by_hand) == (5.0, False)
    assert [one["id"] for one in mark.checks] == ["a", "b"]


def test_without_names_all_checks_with_points_count() -> None:
    said = verdict(check("a"), check("b", "skip"), check("f", points=0, kind="field"))

    assert mark_of(Wanted("obstacle_avoidance", ()), said, 10.0).points == 5.0


def test_points_are_scaled_to_an_instructors_own_maximum() -> None:
    assert mark_of(ASKED, verdict(check("a"), check("b", "fail")), 3.0).points == 1.5


@pytest.mark.parametrize("outcome", ["error", "inconclusive", "unavailable"])
def test_what_could_not_be_judged_is_for_a_person(outcome: str) -> None:
    some = mark_of(ASKED, verdict(check("a"), check("b", outcome)), 10.0)
    none = mark_of(ASKED, verdict(check("a", outcome), check("b", outcome)), 10.0)

    assert (some.points, some.by_hand) == (5.0, True)
    assert (none.points, none.by_hand) == (None, True)


def test_a_grader_that_failed_costs_nothing() -> None:
    mark = mark_of(ASKED, Verdict(None, problem="no host"), 10.0)

    assert (mark.points, mark.by_hand, mark.said) == (None, True, "could not be judged: no host")


def test_nothing_handed_in_is_worth_nothing() -> None:
    mark = mark_of(ASKED, Verdict(None, missing="expected a cell"), 10.0)

    assert (mark.points, mark.by_hand, mark.said) == (0.0, False, "expected a cell")


def test_checks_that_are_gone_are_for_a_person() -> None:
    mark = mark_of(Wanted("obstacle_avoidance", ("gone",)), verdict(check("a")), 10.0)

    assert (mark.points, mark.by_hand) == (None, True)


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
    ("late", "points"),
    [(0.5, None), (1, None), (1.01, 8), (25, 8), (25.01, 16), (49.01, 24), (1000, 40)],
)
def test_a_late_penalty_is_for_each_day_begun(late: float, points: float | None) -> None:
    rule = LatePenalty(per_day=10, grace_minutes=60, at_most=50)

    assert rule.late_submission_penalty("ann", 80.0, late * HOUR) == points


def test_late_work_costs_nothing_unless_the_instructor_says_so() -> None:
    assert LatePenalty().late_submission_penalty("ann", 80.0, 1000 * HOUR) is None


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
