"""Results of checks and submissions as a test wants them, stored as a class's are."""

from typing import Any

import classes
import payloads

from grader.classroom.results.options import ResultOptions
from grader.classroom.results.scores import book_of, mark_of
from grader.classroom.row import StoredResult
from grader.lms.book import Book, Task
from grader.lms.gradescope import results_json

OBSTACLES = "obstacle_avoidance"


def check(id_: str, outcome: str, points: float = 10, **parts: Any) -> dict[str, Any]:
    return payloads.check(id_, f"The robot does {id_}.", outcome, max_points=points) | parts


def result(student: str, *checks: dict[str, Any], **parts: Any) -> StoredResult:
    judged = [c for c in checks if c["outcome"] not in ("error", "inconclusive", "unavailable")]
    grading = {
        "exercise": OBSTACLES,
        "file": "/home/prof/in/agent.py",
        "score": sum(c["points"] for c in checks),
        "max_score": sum(c["max_points"] for c in judged),
        "field_ready": None,
        "checks": list(checks),
        "recordings": [],
        "versions": {"python": "3.11.2"},
    }
    return classes.stored(student, OBSTACLES, grading if checks else None, **parts)


def book(results: list[StoredResult], **options: Any) -> Book:
    """The class as the gradebooks see it."""
    return book_of(results, ResultOptions(**options))


def for_gradescope(results: list[StoredResult], tasks: list[Task]) -> Any:
    """One student's results.json."""
    handed_in = [one for one in results if one.state != "not handed in" or one.amended]
    return results_json([mark_of(one) for one in handed_in], tasks)
