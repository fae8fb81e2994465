"""A failure says when: its replay opens there."""

import ast

from grader.course.exercises import ROOT

# A wrong end of a topic is wrong all the time; a training has no robot; and who answered too few
# scans has a check that says why.
GRADER = ROOT / "grader"
WITHOUT = {
    ("wiring.py", "require_end"),
    ("wiring.py", "_fail_missing"),
    ("callbacks.py", "quick"),
    ("words.py", "logs"),
}
TRAINING = "ml_velocity/test_training.py"


def test_a_failure_with_an_expectation_has_a_moment() -> None:
    """What has no `expected` is no mistake of a student: a scenario that ended too early."""
    lacking = []
    files = [file for room in ("checks", "exercises") for file in (GRADER / room).rglob("*.py")]
    for file in sorted(files):
        name = file.relative_to(GRADER).as_posix().partition("/")[2]
        for function in ast.walk(ast.parse(file.read_text("utf-8"))):
            if not isinstance(function, ast.FunctionDef) or (name, function.name) in WITHOUT:
                continue
            for call in ast.walk(function):
                if not isinstance(call, ast.Call) or ast.unparse(call.func) != "fail":
                    continue
                given = {keyword.arg for keyword in call.keywords}
                if "expected" in given and name != TRAINING and not {"at", "recording"} <= given:
                    lacking.append(f"{name}:{call.lineno} fails without a moment")
    assert lacking == []
