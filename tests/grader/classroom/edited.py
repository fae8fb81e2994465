"""Edits that leave a program what it is: what somebody does who hides a copy."""

from __future__ import annotations

import ast
import builtins
import random
from collections.abc import Callable, Iterator

Edit = Callable[[ast.Module, random.Random], ast.AST]
DEAD = (
    "ready = False",
    "if False:\n    print('never')",
    "_ = 1 + 2",
    "assert True",
    "unused = None",
)
TURNED = {ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.LtE: ast.GtE, ast.GtE: ast.LtE}


def edited(source: bytes, edits: tuple[Edit, ...], seed: str) -> bytes:
    """Return the program after these edits, without comments."""
    tree, chance = ast.parse(source), random.Random(seed)
    for edit in edits:
        tree = ast.fix_missing_locations(edit(tree, chance))
    return ast.unparse(tree).encode()


def rename(tree: ast.Module, _: random.Random) -> ast.AST:
    """Give every name of the program's own another one."""
    mine = set[str]()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            mine.add(node.name)
        elif isinstance(node, ast.arg):
            mine.add(node.arg)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            mine.add(node.id)
    mine -= {"self", *dir(builtins)}
    new = {name: f"my_{number}" for number, name in enumerate(sorted(mine))}
    for node in ast.walk(tree):
        for field in ("name", "arg", "id", "attr"):
            if getattr(node, field, None) in new:
                setattr(node, field, new[getattr(node, field)])
    return tree


def reorder(tree: ast.Module, chance: random.Random) -> ast.AST:
    """Bring functions and classes into another order."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef):
            at = [i for i, each in enumerate(node.body) if hasattr(each, "body")]
            moved = chance.sample(at, len(at))
            node.body[:] = [
                node.body[moved[at.index(i)]] if i in at else each
                for i, each in enumerate(node.body)
            ]
    return tree


def dead_code(tree: ast.Module, chance: random.Random) -> ast.AST:
    """Put a line that does nothing after each second one."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.For | ast.While | ast.If | ast.Try):
            for place in range(len(node.body) - 1, 0, -2):
                node.body[place:place] = ast.parse(chance.choice(DEAD)).body
    return tree


class _Flow(ast.NodeTransformer):
    def visit_If(self, node: ast.If) -> ast.AST:
        self.generic_visit(node)
        if node.orelse:
            test = ast.UnaryOp(ast.Not(), node.test)
            return ast.If(test, node.orelse, node.body)
        return node

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        self.generic_visit(node)
        if len(node.ops) == 1 and type(node.ops[0]) in TURNED:
            turned = TURNED[type(node.ops[0])]()
            return ast.Compare(node.comparators[0], [turned], [node.left])
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Early returns become an if with else."""
        self.generic_visit(node)
        for place in range(len(node.body) - 2, -1, -1):
            each = node.body[place]
            if (
                isinstance(each, ast.If)
                and not each.orelse
                and isinstance(each.body[-1], ast.Return)
            ):
                node.body[place:] = [ast.If(each.test, each.body, node.body[place + 1 :])]
        return node


def flow(tree: ast.Module, _: random.Random) -> ast.AST:
    """Turn branches and comparisons around, and early returns into else."""
    return _Flow().visit(tree)


def split(tree: ast.Module, _: random.Random) -> ast.AST:
    """Make a helper of each method's second half (it need not run: nobody runs it)."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            for each in [each for each in node.body if isinstance(each, ast.FunctionDef)]:
                half = len(each.body) // 2
                if half:
                    (helper,) = ast.parse(f"def rest_of_{each.name}(self, value): pass").body
                    helper.body, each.body = each.body[half:], each.body[:half]
                    each.body += ast.parse(f"return self.{helper.name}(value)").body
                    node.body.append(helper)
    return tree


def edits() -> Iterator[tuple[str, tuple[Edit, ...]]]:
    """Return what is tried: each edit on a renamed copy, then all together."""
    yield "renamed", (rename,)
    for each in (reorder, dead_code, flow, split):
        yield each.__name__, (rename, each)
    yield "all", (rename, split, reorder, flow, dead_code)
