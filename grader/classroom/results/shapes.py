"""The shapes of a program: what is left of it without names, values, layout and order.

A shape is a statement's head or an expression, or what follows what in a block. Those of a part
that is moved, renamed or cut into functions stay the same. All of it runs in the reader's cell.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator, Sequence

from grader.link.cell import Refused

MOST = 5_000  # shapes of a program; the longest one here has 284
LEAST = 4  # nodes: smaller expressions are everybody's
TURNED = {ast.Gt: ast.Lt, ast.GtE: ast.LtE}  # a > b is b < a
BLOCKS = (ast.stmt, ast.ExceptHandler, ast.match_case)

Statement = tuple[int, int, int]  # its head's shape, its head's first line and last


def shapes_of(sources: Sequence[bytes]) -> list[list[int]]:
    """Return the shapes of several files, each in order.

    Raises Refused: one has more than MOST, and SyntaxError, whatever else no Python raises.
    """
    found = [shapes(source) for source in sources]
    if max(map(len, found), default=0) > MOST:
        raise Refused(f"more than {MOST:,} different statements and expressions")
    return found


def shapes(source: bytes) -> list[int]:
    return sorted(_Reader(source).shapes)


def statements(sources: Sequence[bytes]) -> list[list[Statement]]:
    return [sorted(_Reader(source).heads, key=lambda head: head[1:]) for source in sources]


class _Reader:
    """Reads a program from its leaves to its root."""

    def __init__(self, source: bytes) -> None:
        self.shapes: set[int] = set()
        self.heads: list[Statement] = []
        self._read(ast.parse(source))

    def _read(self, node: ast.AST) -> tuple[int, int]:
        """Return the nodes that a shape has, and the shape."""
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return self._read(node.operand)
        if isinstance(node, ast.Name | ast.arg):
            return 1, _shape("name")
        if isinstance(node, ast.Constant):
            return 1, _shape(type(node.value).__name__)
        parts = [self._read(part) for part in _parts(node) if not isinstance(part, BLOCKS)]
        size = 1 + sum(size for size, _ in parts)
        shape = _shape(type(node).__name__, *(part for _, part in parts))
        inner = [each for each in ast.iter_child_nodes(node) if isinstance(each, BLOCKS)]
        if size >= LEAST and isinstance(node, ast.expr | ast.stmt):
            self.shapes.add(shape)
        if isinstance(node, ast.stmt | ast.ExceptHandler):
            end = inner[0].lineno - 1 if inner and hasattr(inner[0], "lineno") else node.end_lineno
            self.heads.append((shape, node.lineno, max(node.lineno, end or 0)))
        before = shape
        for each in inner:
            if not _says_nothing(each):
                _, after = self._read(each)
                self.shapes.add(_shape(before, after))
                before = after
        return size, shape


def _parts(node: ast.AST) -> Iterator[ast.AST]:
    """Return a node's parts but those that say nothing, comparisons with < turned one way."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in TURNED:
        yield from (node.comparators[0], TURNED[type(node.ops[0])](), node.left)
    else:
        yield from (
            each for each in ast.iter_child_nodes(node) if not isinstance(each, ast.expr_context)
        )


def _says_nothing(node: ast.AST) -> bool:
    """Tell whether a statement is `pass`, or a text that stands alone."""
    alone = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return alone or isinstance(node, ast.Pass)


def _shape(*parts: str | int) -> int:
    digest = hashlib.blake2b(repr(parts).encode(), digest_size=8).digest()
    return int.from_bytes(digest, "big", signed=True)
