"""Single edits of a program: another comparison, another number, a statement left out.

Written by hand (docs/decisions.md): what is graded has to be a file that reads like a student's,
with one place changed and everything else as it was, comments included.
"""

from __future__ import annotations

import ast
import copy
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

from grader.authoring.claims import Claim

COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.Mod: ast.Mult,
    ast.FloorDiv: ast.Mult,
}
FACTORS = (0.5, 0.8, 1.25, 2.0)  # of a float
NOTHING = "return None"
UNTOUCHED = ("main", "__main__")  # how a program starts and ends is for other tests


@dataclass(frozen=True)
class Single:
    """One edit."""

    file: str  # of the exercise
    where: str  # the function
    old: str
    new: str
    number: int  # 1, or which of several with the same words
    text: str  # the whole program

    @property
    def name(self) -> str:
        """For tables, and for the list of the equivalent ones."""
        again = f" ({self.number})" if self.number > 1 else ""
        return f"edit {self.where}: {self.old} → {self.new}{again}"


def singles(right: Claim) -> Iterator[Claim]:
    """Return a right solution with each single edit of its nodes."""
    nodes = {file: text for file, text in right.files.items() if "rclpy" in text}
    for file, text in nodes.items():
        which = f"{file} " if len(nodes) > 1 else ""
        for edit in edits(file, text):
            yield replace(
                right,
                kind="mutant",
                stem=f"{right.stem} {which}{edit.name}",
                files={**right.files, file: edit.text},
                about=edit.name,
                field_ready=False,
            )


def edits(file: str, text: str) -> Iterator[Single]:
    """Return each single edit of a program."""
    known: Counter[tuple[str, str, str]] = Counter()
    lines = [line.encode() for line in text.splitlines(keepends=True)]
    for where, node in _nodes(ast.parse(text)):
        for new in dict.fromkeys(_others(node)):
            before, old, after = _parted(lines, node)
            edited = (before + new.encode() + after).decode()
            words = where, _short(old.decode()), _short(new)
            known[words] += 1
            yield Single(file, *words, known[words], edited)


def _nodes(tree: ast.Module) -> Iterator[tuple[str, ast.expr | ast.stmt]]:
    """Return the expressions and statements that may be edited, each with its function."""

    def visit(node: ast.AST, where: str) -> Iterator[tuple[str, ast.expr | ast.stmt]]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                if child.name not in UNTOUCHED:
                    yield from bodies(child.body, child.name)
            elif isinstance(child, ast.ClassDef):
                yield from bodies(child.body, child.name)
            elif not isinstance(child, ast.Import | ast.ImportFrom | ast.JoinedStr):
                # (what is in an f-string has no place of its own before Python 3.12)
                if isinstance(child, ast.expr | ast.stmt):
                    yield where, child
                yield from visit(child, where)

    def bodies(body: list[ast.stmt], where: str) -> Iterator[tuple[str, ast.expr | ast.stmt]]:
        yield from visit(ast.Module(body, []), where)

    main = [node for node in tree.body if isinstance(node, ast.If)]  # if __name__ == "__main__"
    yield from bodies([node for node in tree.body if node not in main], "module")


def _others(node: ast.expr | ast.stmt) -> Iterator[str]:
    """Return what may stand in the place of a node."""
    if isinstance(node, ast.expr):
        yield from _other_expressions(node)
    elif _can_go(node):
        yield "pass"
    elif isinstance(node, ast.Return) and node.value is not None and ast.unparse(node) != NOTHING:
        yield NOTHING


def _other_expressions(node: ast.expr) -> Iterator[str]:
    if isinstance(node, ast.Compare):
        for i, operator in enumerate(node.ops):
            for other in COMPARISONS[type(operator)]:
                changed = copy.deepcopy(node)
                changed.ops[i] = other()
                yield ast.unparse(changed)
    elif isinstance(node, ast.BinOp) and type(node.op) in ARITHMETIC:
        yield f"({ast.unparse(ast.BinOp(node.left, ARITHMETIC[type(node.op)](), node.right))})"
    elif isinstance(node, ast.BoolOp):
        other_op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield f"({ast.unparse(ast.BoolOp(other_op, node.values))})"
        for i in range(len(node.values)):
            rest = [value for j, value in enumerate(node.values) if j != i]
            left = ast.BoolOp(node.op, rest) if len(rest) > 1 else rest[0]
            yield f"({ast.unparse(left)})"
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield f"({ast.unparse(node.operand)})"
    elif isinstance(node, ast.Constant):
        yield from _other_constants(node.value)


def _can_go(node: ast.stmt) -> bool:
    """Return whether a statement can go: a call, a `continue`, an attribute's new value."""
    call = isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)
    assigns = isinstance(node, ast.Assign | ast.AugAssign) and not _defines(node)
    return call or assigns or isinstance(node, ast.Continue)


def _other_constants(value: object) -> Iterator[str]:
    if isinstance(value, bool):
        yield str(not value)
    elif isinstance(value, int):
        yield from (str(value + 1), str(value - 1))
    elif isinstance(value, float):
        yield from (repr(float(f"{value * f:.6g}")) for f in FACTORS) if value else ("1.0",)


def _defines(node: ast.stmt) -> bool:
    """Return whether an assignment makes a local name, without which the rest dies at once."""
    targets = node.targets if isinstance(node, ast.Assign) else []
    return any(isinstance(target, ast.Name | ast.Tuple) for target in targets)


def _parted(lines: list[bytes], node: ast.expr | ast.stmt) -> tuple[bytes, bytes, bytes]:
    """Return what stands before a node, the node, and what stands after it.

    Columns count bytes.
    """
    first, last = node.lineno - 1, (node.end_lineno or node.lineno) - 1
    begin, end = node.col_offset, node.end_col_offset
    before = b"".join(lines[:first]) + lines[first][:begin]
    after = lines[last][end:] + b"".join(lines[last + 1 :])
    text = b"".join(lines)
    return before, text[len(before) : len(text) - len(after)], after


def _short(text: str) -> str:
    words = " ".join(text.split())
    return words if len(words) <= 60 else f"{words[:57]}…"
