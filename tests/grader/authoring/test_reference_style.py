"""The references are the nodes that are copied most: habits that none of them may teach."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from grader.course.exercises import all_exercises

REFERENCES = [exercise.solutions / file for exercise in all_exercises() for file in exercise.files]
EACH = pytest.mark.parametrize("path", REFERENCES, ids=[path.stem for path in REFERENCES])
CATCH_ALL = {"Exception", "BaseException"}


def new_names(program: ast.Module) -> set[str]:
    """Return the names that a program gives: functions, classes, parameters, variables."""
    names: set[str] = set()
    for node in ast.walk(program):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.arg):
            names.add(node.arg)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
    return names


def jumps(program: ast.Module) -> Iterator[int]:
    """Yield the lines that raise an exception only to reach the handler below them."""
    for node in ast.walk(program):
        if isinstance(node, ast.Try):
            caught = [name for handler in node.handlers for name in names_of(handler)]
            for part in (inner for line in node.body for inner in ast.walk(line)):
                if isinstance(part, ast.Raise) and (CATCH_ALL | {raised(part)}) & set(caught):
                    yield part.lineno


def names_of(handler: ast.ExceptHandler) -> list[str]:
    """Return the exceptions that a handler catches."""
    if handler.type is None:
        return ["BaseException"]
    kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    return [ast.unparse(kind) for kind in kinds]


def raised(statement: ast.Raise) -> str:
    """Return the name of the exception that is raised; nothing if it is raised again."""
    what = statement.exc.func if isinstance(statement.exc, ast.Call) else statement.exc
    return "" if what is None else ast.unparse(what)


@EACH
def test_no_name_hides_a_module_of_the_standard_library(path: Path) -> None:
    found = new_names(ast.parse(path.read_text("utf-8"))) & sys.stdlib_module_names
    assert found == set()


@EACH
def test_no_exception_is_control_flow(path: Path) -> None:
    assert list(jumps(ast.parse(path.read_text("utf-8")))) == []


def test_both_habits_are_seen() -> None:
    program = ast.parse(
        "def statistics(code):\n"
        "    try:\n"
        "        if code:\n"
        "            raise ValueError('no code')\n"
        "    except (OSError, ValueError):\n"
        "        numbers = 0\n"
        "    try:\n"
        "        raise OSError\n"
        "    except Exception:\n"
        "        pass\n"
        "    try:\n"
        "        raise KeyError\n"
        "    except OSError:\n"
        "        pass\n"
    )
    assert new_names(program) & sys.stdlib_module_names == {"statistics", "code", "numbers"}
    assert list(jumps(program)) == [4, 8]
