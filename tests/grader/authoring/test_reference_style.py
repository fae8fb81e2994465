"""The references are the nodes that are copied most: habits that none of them may teach."""

import ast
import subprocess
import sys

import pytest

from grader.course.exercises import Exercise, all_exercises

EACH = pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)


@EACH
def test_no_name_hides_a_module_of_the_standard_library(exercise: Exercise) -> None:
    for file in exercise.files:
        nodes = list(ast.walk(ast.parse((exercise.solutions / file).read_text("utf-8"))))
        given = {n.name for n in nodes if isinstance(n, ast.FunctionDef | ast.ClassDef)}
        given |= {n.arg for n in nodes if isinstance(n, ast.arg)}
        given |= {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        assert given & sys.stdlib_module_names == set(), file


def test_no_exception_is_control_flow() -> None:
    references = [str(each.solutions / file) for each in all_exercises() for file in each.files]
    ruff = [sys.executable, "-m", "ruff", "check", "--isolated", "--select", "TRY301"]
    done = subprocess.run([*ruff, *references], check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
