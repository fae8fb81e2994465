"""Skeletons are the solutions without the answers, and always in step with them."""

import ast
import textwrap
from pathlib import Path

import pytest

from grader.course.skeletons import ROOT, skeletons, strip_solution
from sim.errors import InputError


def strip(text: str) -> str:
    return strip_solution(textwrap.dedent(text), "agent.py")


def test_a_block_gives_way_to_its_skeleton_part() -> None:
    source = """\
    def f():
        ### BEGIN SOLUTION
        secret = 42

        return secret
        ### SKELETON
        # # TODO(task 1): think.
        # if True:
        #     return None
        ### END SOLUTION
    """
    assert strip(source) == (
        "def f():\n    # TODO(task 1): think.\n    if True:\n        return None\n"
    )


def test_a_block_without_skeleton_part_becomes_a_todo() -> None:
    source = "x = 0\n### BEGIN SOLUTION\nx = 42\n### END SOLUTION\nprint(x)\n"
    assert strip(source) == "x = 0\n# TODO: your code\nprint(x)\n"


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("a\n### BEGIN SOLUTION\nb\n", "agent.py, line 2: BEGIN SOLUTION is never closed"),
        ("a\n### END SOLUTION\n", "agent.py, line 2: END SOLUTION without"),
        (
            "### BEGIN SOLUTION\n### BEGIN SOLUTION\n### END SOLUTION\n",
            "line 2: BEGIN SOLUTION inside",
        ),
        ("### SKELETON\n", "line 1: SKELETON belongs"),
        (
            "### BEGIN SOLUTION\n### SKELETON\n### SKELETON\n### END SOLUTION\n",
            "line 3: SKELETON belongs",
        ),
        (
            "### BEGIN SOLUTION\n### SKELETON\nx = 1\n### END SOLUTION\n",
            "line 3: expected a comment below ###",
        ),
        ("## BEGIN SOLUTION\n", "line 1: '## BEGIN SOLUTION' looks like a marker"),
        ("### END_SOLUTION\n", "looks like a marker"),
        ("x = 1\n", "agent.py: no ### BEGIN SOLUTION block"),
    ],
)
def test_errors_name_file_and_line(source: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        strip(source)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


ALL = list(skeletons())


@pytest.mark.parametrize(
    ("path", "text"), ALL, ids=[p.relative_to(ROOT).as_posix() for p, _ in ALL]
)
def test_every_skeleton_is_in_step_and_complete(path: Path, text: str) -> None:
    assert path.read_text(encoding="utf-8") == text, "run python -m grader.course.skeletons"
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name != "__init__":
            assert ast.get_docstring(node), f"{node.name} in {path.name} has no docstring"
    assert "TODO(task " in text
    assert "SOLUTION" not in text
