"""A cell that would spin a node in the kernel, and so never end, is caught before it runs.

Most often it is a node's cell without its first line, `%%node FILE.py`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from grader.course.exercises import all_exercises
from grader.notebook.cells import MAGIC
from grader.notebook.session import SESSION, imported

if TYPE_CHECKING:
    from IPython.core.interactiveshell import InteractiveShell

SPIN = "spin"  # rclpy.spin(node), executor.spin()
LATER = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)  # not run with the cell
MISSING = f"its first line, {MAGIC} {{name}}, is missing"


class SpinGuard:
    """An AST transformer of IPython's that changes nothing and refuses cells that would spin."""

    def __init__(self) -> None:
        self._spinning: set[str] = set()  # functions of earlier cells that spin

    def visit(self, tree: ast.Module) -> ast.Module:
        """Return the cell's tree.

        Raises InputRejected: running it would spin.
        """
        defined = {node.name for node in tree.body if isinstance(node, LATER[:2])}
        self._spinning = (self._spinning - defined) | _spinning(tree, self._spinning - defined)
        if _is_a_program(tree) or any(_spins(node, self._spinning) for node in _run_now(tree)):
            raise _refusal(tree)
        return tree


def register(shell: InteractiveShell) -> None:
    """Put the guard into a shell, once."""
    transformers: list[Any] = shell.ast_transformers
    if not any(isinstance(one, SpinGuard) for one in transformers):
        transformers.append(SpinGuard())


def _refusal(tree: ast.Module) -> Exception:
    from IPython.core.error import InputRejected  # noqa: PLC0415

    class WouldSpin(InputRejected):
        """The cell was not run."""

        def _render_traceback_(self) -> list[str]:
            """Return the lines that IPython shows in place of a traceback."""
            return str(self).split("\n")

    name = _file_of(tree)
    if name:
        SESSION.refused.pop(name, None)
        SESSION.refused[name] = MISSING.format(name=name)
    return WouldSpin(
        f"Not run: this cell would spin its node in the notebook itself, and never come back.\n"
        f"Is its first line missing? With “{MAGIC} {name or 'my_node.py'}” above it, the cell "
        "becomes that file, and drive() and check() run it."
    )


def _spinning(tree: ast.Module, known: set[str]) -> set[str]:
    """Return the functions of a cell that spin, or call one that does."""
    functions = [node for node in tree.body if isinstance(node, LATER[:2])]
    found = set(known)
    while more := {
        function.name
        for function in functions
        if function.name not in found and any(_spins(node, found) for node in ast.walk(function))
    }:
        found |= more
    return found


def _run_now(tree: ast.Module) -> Iterator[ast.AST]:
    """Yield what runs as the cell runs: no bodies of functions and classes."""
    todo: list[ast.AST] = list(tree.body)
    while todo:
        node = todo.pop()
        if not isinstance(node, LATER):
            yield node
            todo += ast.iter_child_nodes(node)


def _is_a_program(tree: ast.Module) -> bool:
    """Return whether a cell is a node's file as it stands: it uses ROS, and starts itself."""
    starts = any(isinstance(node, ast.If) and "__main__" in ast.dump(node.test)
                 for node in tree.body)  # fmt: skip
    return starts and "rclpy" in imported(tree)


def _spins(node: ast.AST, spinning: set[str]) -> bool:
    if isinstance(node, ast.While):  # as long as ROS, or for ever
        for_ever = isinstance(node.test, ast.Constant) or "ok" in set(_words(node.test))
        return for_ever and any(word.startswith(SPIN) for word in _words(node))
    if not isinstance(node, ast.Call):
        return False
    if isinstance(node.func, ast.Attribute):
        return node.func.attr == SPIN
    return isinstance(node.func, ast.Name) and node.func.id in {SPIN, *spinning}


def _words(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute | ast.Name):
            yield node.attr if isinstance(node, ast.Attribute) else node.id


def _file_of(tree: ast.Module) -> str:
    """Return the exercise's file that a cell must be, by its node's name or its class's."""
    words = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
    names = {node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
    stems = words | {re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower() for name in names}
    files = (file for exercise in all_exercises() for file in exercise.files)
    return next((file for file in files if file.removesuffix(".py") in stems), "")
