"""What the page has to know of an exercise before a Python runs there: its checks and scenarios."""

import ast
import os
from collections.abc import Iterator, Sequence
from typing import Any

import pytest

from grader.course.exercises import Exercise
from grader.course.submission import LAUNCH
from grader.drive.race import rules_of, unit_of
from grader.errors import GraderError
from grader.exercises import contract_of
from grader.grading.grading import UNUSED_PLUGINS, grade
from grader.grading.plugin import UNAVAILABLE
from grader.trial.page import PageTrials
from sim.messages import typestore
from sim.scenario_files import load_scenario, scenario_names


class _Marks:
    """Reads the marks of an exercise's core checks, and runs none."""

    def __init__(self) -> None:
        self.by_check: dict[str, dict[str, Any]] = {}

    def pytest_configure(self, config: pytest.Config) -> None:
        config.addinivalue_line("markers", "check: one check")

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        for item in items:
            mark = item.get_closest_marker("check")
            if mark is not None and not mark.kwargs.get("field"):
                self.by_check[item.name.removeprefix("test_")] = mark.kwargs
        items.clear()

    def scenarios_of(self, check: str) -> list[str]:
        """Return what a check asks for, after what the checks ask for that it needs."""
        mark = self.by_check[check]
        needed = [name for need in mark.get("needs", ()) for name in self.scenarios_of(need)]
        return list(dict.fromkeys([*needed, *mark["scenarios"]]))


class _Prepared(PageTrials):
    """No recordings; notes the order in which the grader would make them."""

    scenarios: Sequence[str] = ()

    def prepare(self, scenarios: Sequence[str]) -> None:
        self.scenarios = scenarios


def plan(exercise: Exercise) -> dict[str, Any]:
    """Return the exercise's JSON object for the page.

    Its checks are in the order of the tasks; its scenarios in that of the grader's trials, on which
    a cause can depend that says what came first.

    Raises GraderError: its checks can't be read.
    """
    marks, file = _Marks(), exercise.files[0]
    settings = (f"--rootdir={exercise.judge}", f"--config-file={os.devnull}")
    options = ("--import-mode=importlib", "--assert=plain", "--capture=sys")
    unused = (option for name in UNUSED_PLUGINS for option in ("-p", f"no:{name}"))
    files = map(str, exercise.judge.glob("test_*.py"))  # or pytest looks at each scenario
    pytest.main([*files, *settings, *options, *unused], plugins=[marks])
    if not marks.by_check:
        raise GraderError(f"{exercise.judge}: expected core checks, found none")
    trials = _Prepared([])
    checks = [
        {
            "id": check.id,
            "title": check.title,
            "points": check.max_points,
            "task": check.task,
            "hint": check.hint,
            "scenarios": [] if check.outcome == UNAVAILABLE else marks.scenarios_of(check.id),
        }
        for check in grade(exercise, trials, file=file).checks
    ]
    scenarios = [load_scenario(name) for name in trials.scenarios]
    threaded = {each.name for each in scenarios if each.program or _is_threaded(exercise)}
    for check in checks:  # whether it is judged also where a page has no threads
        check["alone"] = check["scenarios"] != [] and threaded.isdisjoint(check["scenarios"])
    known = [name for name, path in scenario_names().items() if exercise.judge in path.parents]
    of_field = [name for name in known if "_field" in name and not trials.lacks([name], ())]
    return {
        "number": exercise.number,
        "slug": exercise.slug,
        "title": exercise.title,
        "files": list(exercise.files),
        "points": exercise.max_points,
        "checks": checks,
        "scenarios": {each.name: each.title for each in scenarios},
        "first": next(each.name for each in scenarios if not each.node.stand_in),  # to drive in
        "field": {name: load_scenario(name).title for name in of_field},
        "race": {name: load_scenario(name).title for name in contract_of(exercise).race},
        "unit": unit_of(exercise),  # of the race's figures
        "rules": rules_of(exercise),
        "here": sum(check["points"] for check in checks if check["scenarios"]),  # points in a page
        "alone": sum(check["points"] for check in checks if check["alone"]),  # without threads
    }


def _is_threaded(exercise: Exercise) -> bool:
    """Return whether the skeleton starts threads or several programs, whatever the scenario."""
    texts = [(exercise.folder / name).read_text("utf-8") for name in exercise.files]
    return exercise.files[0].endswith(LAUNCH) or "MultiThreadedExecutor" in "".join(texts)


def methods(node: str) -> dict[str, str]:
    """Return what may follow `self.`, each with what has it; `node` is the source of rclpy.node."""
    classes = [part for part in ast.parse(node).body if isinstance(part, ast.ClassDef)]
    functions = next(part for part in classes if part.name == "Node").body
    names = [part.name for part in functions if isinstance(part, ast.FunctionDef)]
    return {name: "Node" for name in names if not name.startswith("_")}


def fields(exercise: Exercise) -> dict[str, str]:
    """Return the fields of an exercise's messages, each with what has it."""
    found: dict[str, str] = {}
    for topic in exercise.topics:
        for name, owner in _fields(topic.type):
            found.setdefault(name, owner)
    return found


def _fields(type_: str) -> Iterator[tuple[str, str]]:
    """Yield the fields of a message, and those of the messages in it, each with its message."""
    for name, description in typestore().fielddefs[type_][1]:
        yield name, type_.rpartition("/")[2]
        for inner in _messages(description):
            yield from _fields(inner)


def _messages(description: Any) -> Iterator[str]:
    """Yield the type of message in a field's description: (kind, content), perhaps of its items."""
    if isinstance(description, str) and description in typestore().fielddefs:
        yield description
    elif isinstance(description, tuple):
        for part in description:
            yield from _messages(part)
