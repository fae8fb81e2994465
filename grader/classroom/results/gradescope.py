"""A student's results as Gradescope's autograder reads them: `results.json`.

Source: Gradescope, "Autograder Specifications", section "Output Format". The fields used here:
`score`, `execution_time`, `output`, `output_format`, `visibility`, `extra_data`, and of each test
`name`, `number`, `score`, `max_score`, `status`, `output`, `output_format`, `tags`, `visibility`.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from grader.classroom.results.clean import one_line, visible
from grader.classroom.results.marks import Check, Task, is_absent, is_held, points_of
from grader.classroom.results.withheld import for_students
from grader.classroom.row import StoredResult
from grader.report.terminal import UNJUDGED

MAX_OUTPUT = 4000  # [characters] of one test
WORDS = {
    "pass": "Passed.",
    "skip": "Skipped.",
    "unavailable": "Not counted: a library is not installed where the judge runs.",
}


def results_json(
    results: Sequence[StoredResult], tasks: Sequence[Task], hidden: Collection[str]
) -> dict[str, Any] | None:
    """Return one student's results; None while any of them is held or unfinished.

    Gradescope takes a missing score for zero, so it gets only final scores.
    """
    by_slug = {result.exercise: result for result in results}
    there = [(task, by_slug[task.slug]) for task in tasks if task.slug in by_slug]
    mine = [(task, result) for task, result in there if not is_absent(result)]
    scores = [points_of(result, task) for task, result in mine]
    final = [score for score in scores if score is not None]
    if not mine or len(final) < len(scores) or any(is_held(result) for _, result in mine):
        return None
    tests: list[dict[str, Any]] = []
    lines = []
    for number, (task, result) in enumerate(mine, start=1):
        grading = for_students(result.grading or {}, result.file_names, hidden)
        prefix = f"{task.title}: " if len(mine) > 1 else ""
        place = f"{number}." if len(mine) > 1 else ""
        tests += [
            _test(check, f"{place}{index}", prefix)
            for index, check in enumerate(grading["checks"], start=1)
        ]
        lines.append(f"{task.title}: {final[number - 1]:g} of {task.points:g} points")
        lines += result.amended.steps if result.amended else ()
    return {
        "score": round(sum(final), 2),
        "execution_time": max(1, round(sum(result.wall_s for _, result in mine))),
        "output": "\n".join(lines),
        "output_format": "text",
        "visibility": "visible",
        "tests": tests,
        "extra_data": {"exercises": [task.slug for task, _ in mine]},
    }


def _test(check: Check, number: str, prefix: str) -> dict[str, Any]:
    field = check.get("kind") == "field"
    test: dict[str, Any] = {
        "name": prefix + one_line(check.get("title") or check.get("id") or "check", 250),
        "number": number,
        "output": _output(check),
        "output_format": "text",
        "tags": ["field" if field else "core"],
        "visibility": "visible",
        "extra_data": {"check": one_line(check.get("id") or ""), "outcome": check.get("outcome")},
    }
    if check.get("outcome") not in UNJUDGED and not check.get("waived"):
        test["status"] = "passed" if check.get("outcome") == "pass" else "failed"
        if not field:
            test["score"] = float(check.get("points") or 0)
            test["max_score"] = float(check.get("max_points") or 0)
    return test


def _output(check: Check) -> str:
    lines = [WORDS.get(str(check.get("outcome")), "")]
    lines += [visible(check.get("message") or "")]
    for name, key in (("Expected", "expected"), ("Actual", "actual"), ("Look at next", "help")):
        if check.get(key):
            lines.append(f"{name}: {visible(check[key])}")
    text = "\n".join(line for line in lines if line)
    return text if len(text) <= MAX_OUTPUT else text[: MAX_OUTPUT - 1] + "…"
