"""A graded class whose marks are changed."""

import csv
import functools
import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_class import grading
from made_results import check

from grader.classroom.amendments.change import Score, Whom
from grader.classroom.desk.marking import marking
from grader.classroom.queue.work import Unit, UnitResult

ANN = Whom(("ann",))
CHECKS = (check("stop_zone", "pass", 60), check("slow_zone", "fail", 30), check("blind", "pass"))
WHY = "because"


def judged(unit: Unit) -> UnitResult:
    """70 of 100 for everybody; eve's slow_zone could not be judged."""
    checks = [dict(each) for each in CHECKS]
    if unit.student == "eve":
        checks[1]["outcome"] = "inconclusive"
    most = 70 if unit.student == "eve" else 100
    return UnitResult({**grading(score=70), "max_score": most, "checks": checks})


@pytest.fixture
def graded(grade_class: Any, tmp_path: Path) -> Path:
    grade_class(judged)
    return tmp_path / "out"


@pytest.fixture
def mark(graded: Path) -> Callable[..., dict[str, str]]:
    """The function below, of this class."""
    return functools.partial(marked, graded)


def marked(out: Path, *changes: Any) -> dict[str, str]:
    """Make changes, and return everybody's points by scores.csv."""
    with marking(out) as class_:
        for change in changes:
            class_.add(change, "prof", WHY)
    return points(out)


def give(out: Path, who: str, points: float) -> None:
    """Give somebody a score, as `course marks score` does."""
    with marking(out) as class_:
        task = class_.exercise("")
        whom = class_.whom([who], "", everybody=False, task=task)
        class_.add(Score(task.slug, points, whom), "prof", WHY)


def scores(out: Path) -> dict[str, dict[str, str]]:
    text = (out / "scores.csv").read_text("utf-8-sig")
    return {row["student"]: row for row in csv.DictReader(io.StringIO(text, newline=""))}


def points(out: Path) -> dict[str, str]:
    return {student: row["points"] for student, row in scores(out).items()}


def payload(page: Path) -> dict[str, Any]:
    text = page.read_text("utf-8")
    start = text.index('id="payload">') + len('id="payload">')
    found: dict[str, Any] = json.loads(text[start : text.index("</script>", start)])
    return found
