"""Lines of a program that can't mean what they say, as linters know them: one rule a slip.

Each is a fact about the file, whatever the node does: most have a number in flake8-bugbear, pylint
or Ruff. What may be meant, such as `x or 5` for a default, is none. The host says them on stderr,
and the judge takes no other sentence for one (`said_in`): a node may print what it likes.
"""

from __future__ import annotations

import ast
import contextlib
import difflib
import importlib
import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

MAX_SLIPS = 3
NAME = r"[\w.]{1,80}"
SAID = {  # slip: the sentence, with names for {}
    "twice": "{} defines {} in line {} and again here, and the second one counts",  # F811
    "bare": "{} is only named here: brackets call a function",  # B018
    "compares": "this compares, and nothing uses the answer: a single = gives a value",  # B015
    "nan": "nothing equals NaN, not even NaN: ask with math.isnan or math.isfinite",  # PLW0177
    "is": "`is` asks for the same object: numbers and texts are compared by ==",  # F632
    "tuple": "the comma at the end makes a tuple of the value: delete it",  # R1707
    "or": "{} stands behind `or` uncompared, and counts as true: compare it, too",  # R1726
    "uncalled": "{} has no brackets: the function itself always counts as true",  # W0126
    "hides": "self.{} gets a value here and hides the method {}: give one another name",  # E0202
    "nothing": "{} returns None only, and its result is used here: is a `return` missing?",  # E1111
    "called": "{} is called here, and its None handed over: hand it over without brackets",
    "unused": "{} defines {} here and neither calls nor returns it",  # W0612
    "misspelt": "self.{} gets a value here and is never read: is self.{} meant?",
    "once": "the default of {} is made once, when the file is read, and all calls share it",  # B008
    "spins": "spin does not return: what stands below it in __init__ is never made",
    "any": "{} is True or False, and no number: put the comparison inside",  # W0143
    "bits": "& and | bind tighter than < and >: brackets belong around the comparison",
    "field": "{} has no field {}, and takes the word in silence: is {} meant?",
    "verdict": "declare_parameter and set_parameters ask {}: it has to return "
    "SetParametersResult(successful=…, reason=…) on every path, and here it returns {}",
    "raises": "{} says no by what it returns, SetParametersResult(successful=False, reason=…): "
    "an exception ends the node",
    "unheard": "add_post_set_parameters_callback tells {} afterwards, and nobody hears what it "
    "returns: add_on_set_parameters_callback asks before",
    "sets": "{} is asked whether a value may be set, and sets one itself, which asks it again",
    "in_loop": "this return ends the loop in its first round: indent it less",
}
SENTENCE = re.compile(
    r"line (?P<line>\d+): (?P<said>"
    + "|".join(re.escape(text).replace(r"\{\}", NAME) for text in SAID.values())
    + ")"
)
NUMBERS = ("inf", "pi", "nan")
CLOCKS = ("time", "perf_counter", "perf_counter_ns", "monotonic", "time_ns", "now", "today")
HANDED = ("add_done_callback", "create_timer", "create_subscription", "create_service", "submit",
          "Thread", "Timer", "add_on_set_parameters_callback")  # fmt: skip
PARAMETERS = ("add_on_set_parameters_callback", "add_post_set_parameters_callback")
COLLECTS = ("append", "appendleft", "add", "extend", "update", "insert")
CALLABLE = {"np": ("isnan", "isfinite", "isinf", "any", "all"), "rclpy": ("ok",),
            "math": tuple(name for name in dir(math) if callable(getattr(math, name)))}  # fmt: skip
ALIKE = 0.8  # of two names
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
ORDER = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
Found = Iterator[tuple[int, str]]


def slips(source: bytes) -> list[str]:
    """Return a sentence for each slip of a program, with its line, in order; at most `MAX_SLIPS`.

    Raises SyntaxError, ValueError: Python does not accept it.
    """
    tree = _tree(source)
    looks = (
        _statements,
        _comparisons,
        _conditions,
        _functions,
        _classes,
        _loops,
        _messages,
        _asked,
    )
    try:
        found = sorted({said for look in looks for said in look(tree)})
    except RecursionError:  # a name of a thousand dots
        return []
    return [f"line {line}: {text}" for line, text in found[:MAX_SLIPS]]


def unused_imports(source: bytes) -> list[str]:
    """Return the names that a program imports at its top and then never writes again (F401).

    Raises SyntaxError, ValueError: Python does not accept it.
    """
    tree = _tree(source)
    found: dict[str, None] = {}
    for node in tree.body:
        if isinstance(node, ast.Import | ast.ImportFrom):
            for each in node.names:
                if each.asname != each.name and getattr(node, "module", "") != "__future__":
                    found[(each.asname or each.name).partition(".")[0]] = None
    texts = " ".join(node.value for node in _all(tree, ast.Constant) if isinstance(node.value, str))
    written = {node.id for node in _all(tree, ast.Name)} | set(re.findall(r"\w+", texts))
    return [name for name in found if name not in written and name != "*"]


class Slip(NamedTuple):
    """A sentence of `slips`, read again."""

    line: int
    text: str


def said_in(text: str) -> Slip | None:
    """Return the slip in a line of the log; None for other lines."""
    match = SENTENCE.fullmatch(text.strip())
    return Slip(int(match["line"]), match["said"]) if match else None


def _said(node: ast.AST, slip: str, *names: object) -> tuple[int, str]:
    return getattr(node, "lineno", 0), SAID[slip].format(*names)


@lru_cache(maxsize=4)
def _tree(source: bytes) -> ast.Module:
    return ast.parse(source)


def _all(tree: ast.AST, *kinds: type) -> Iterator[Any]:
    return (node for kind in kinds for node in _nodes(tree).get(kind, ()))


@lru_cache(maxsize=256)
def _nodes(tree: ast.AST) -> dict[type, list[ast.AST]]:
    """Return what stands in a tree, by its kind."""
    found, walk = defaultdict[type, list[ast.AST]](list), [tree]
    for node in walk:  # it grows
        found[type(node)].append(node)
        for name in node._fields:
            value = getattr(node, name, None)
            if isinstance(value, ast.AST):
                walk.append(value)
            elif isinstance(value, list):
                walk += [each for each in value if isinstance(each, ast.AST)]
    return found


def _statements(tree: ast.AST) -> Found:
    properties = {
        f.name
        for f in _all(tree, ast.FunctionDef)
        for each in f.decorator_list
        if _last(each).endswith("property")
    }  # they may be made by being named
    given = _given(tree) | {each.arg for each in _all(tree, ast.arg)} | properties
    tried = {id(each) for node in _all(tree, ast.Try) for each in node.body}
    for node in _all(tree, ast.Expr, ast.Assign):
        value = node.value
        if isinstance(node, ast.Expr) and id(node) not in tried:
            if isinstance(value, ast.Compare):
                yield _said(node, "compares")
            elif (name := _dotted(value)) and _last(value) not in given:  # else: to please a linter
                yield _said(node, "bare", name)
        elif isinstance(value, ast.Tuple) and len(value.elts) == 1:
            bare = value.col_offset == value.elts[0].col_offset  # no bracket before it
            yield from [_said(node, "tuple")] * bare


def _comparisons(tree: ast.AST) -> Found:
    for node in _all(tree, ast.Compare):
        sides = [node.left, *node.comparators]
        ordered = any(isinstance(op, ORDER) for op in node.ops)
        for op, *pair in zip(node.ops, sides, node.comparators, strict=False):
            if any(map(_is_nan, pair)) and not isinstance(op, ORDER):
                yield _said(node, "nan")
            elif any(map(_is_value, pair)) and isinstance(op, ast.Is | ast.IsNot):
                yield _said(node, "is")
        for side in sides if ordered else ():
            if isinstance(side, ast.Call) and _dotted(side.func) in ("any", "all"):
                yield _said(node, "any", _dotted(side.func))
            if isinstance(side, ast.BinOp) and isinstance(side.op, ast.BitAnd | ast.BitOr):
                yield _said(node, "bits")


def _conditions(tree: ast.AST) -> Found:
    constants = _constants(tree)
    for node in _all(tree, ast.BoolOp):
        compared = False
        for each in node.values if isinstance(node.op, ast.Or) else ():
            name = _dotted(each) or ("it" if isinstance(each, ast.Constant) else "")
            if compared and (name in constants or (name == "it" and _is_true(each))):
                yield _said(node, "or", name)
            compared = compared or isinstance(each, ast.Compare)
    methods = {part.name for each in _all(tree, ast.ClassDef) for part in _methods(each)}
    methods = {f"self.{name}" for name in methods - _given(tree)}
    known = methods | {f"{of}.{name}" for of, names in CALLABLE.items() for name in names}
    tests = [node.test for node in _all(tree, ast.If, ast.While, ast.IfExp)]
    while tests:
        test = tests.pop()
        if isinstance(test, ast.BoolOp):
            tests += test.values
        elif isinstance(test, ast.UnaryOp):
            tests.append(test.operand)
        elif _dotted(test) in known and not isinstance(getattr(math, _last(test), 0), float):
            yield _said(test, "uncalled", _dotted(test))


def _functions(tree: Any) -> Found:
    functions = list(_all(tree, *FUNCTIONS))
    names = Counter(each.name for each in functions)
    used_calls = list(_used_calls(tree))
    asked = {_last(used.func) for used, _ in used_calls}
    silent = {
        f"self.{each.name}" if isinstance(of, ast.ClassDef) else each.name
        for of in (tree, *_all(tree, ast.ClassDef))
        for each in of.body
        if isinstance(each, FUNCTIONS) and each.name in asked and names[each.name] == 1
        and _says_nothing(each)
    }  # fmt: skip
    for used, by in used_calls:
        if _dotted(used.func) in silent:
            slip = "called" if _last(getattr(by, "func", None)) in HANDED else "nothing"
            yield _said(used, slip, _last(used.func))
    for each in functions:
        for inner in each.body:
            if not isinstance(inner, FUNCTIONS) or inner.decorator_list:
                continue
            if inner.name not in {node.id for node in _all(each, ast.Name)}:
                yield _said(inner, "unused", each.name, inner.name)
        own, named = each.args.posonlyargs + each.args.args, each.args.kwonlyargs
        defaults = [*zip(own[::-1], each.args.defaults[::-1], strict=False)]
        for parameter, default in [*defaults, *zip(named, each.args.kw_defaults, strict=True)]:
            clock = isinstance(default, ast.Call) and _last(default.func) in CLOCKS
            if clock or (_is_collection(default) and parameter.arg in _collected(each)):
                yield _said(each, "once", parameter.arg)


def _classes(tree: ast.AST) -> Found:
    read = {node.attr for node in _all(tree, ast.Attribute) if isinstance(node.ctx, ast.Load)}
    for each in _all(tree, ast.ClassDef):
        lines: dict[str, int] = {}
        for part in _methods(each):
            if part.name in lines:
                yield _said(part, "twice", each.name, part.name, lines[part.name])
            lines[part.name] = part.lineno
        given = {
            part.name: [n for n in _all(part, ast.Attribute)
                        if isinstance(n.ctx, ast.Store) and _dotted(n) == f"self.{n.attr}"]
            for part in _methods(each)
        }  # fmt: skip
        for part in (part for part in each.body if getattr(part, "name", "") == "__init__"):
            for node in part.body[:-1]:
                called = getattr(getattr(node, "value", None), "func", None)
                if isinstance(node, ast.Expr) and called and _dotted(called) == "rclpy.spin":
                    yield _said(node, "spins")
        at_first = {node.attr for node in given.pop("__init__", ())}
        later = [node for nodes in given.values() for node in nodes]
        for node in _all(each, ast.Attribute):
            given_here = isinstance(node.ctx, ast.Store) and _dotted(node) == f"self.{node.attr}"
            if given_here and node.attr in lines:
                yield _said(node, "hides", node.attr, node.attr)
        only = sorted((at_first & read) - {node.attr for node in later})
        for node in later:
            if node.attr not in read | at_first:
                alike = [name for name in only if not _within(name, node.attr)]
                for near in difflib.get_close_matches(node.attr, alike, 1, ALIKE):
                    yield _said(node, "misspelt", node.attr, near)


def _loops(tree: ast.AST) -> Found:
    for node in _all(tree, ast.For):
        last = node.body[-1]
        if isinstance(last, ast.Return) and last.value is not None:
            added = {id(each.target) for each in _all(node, ast.AugAssign)}
            names = [each for each in _all(node, ast.Name) if id(each) not in added]
            anew = {each.id for each in names if isinstance(each.ctx, ast.Store)}
            if (_collected(node) - anew) & {each.id for each in _all(last.value, ast.Name)}:
                yield _said(last, "in_loop")


def _messages(tree: ast.AST) -> Found:
    """Yield the fields that a message does not have: its constructor drops them."""
    classes: dict[str, Any] = {}
    for node in _all(tree, ast.ImportFrom):
        if re.fullmatch(r"\w+\.(msg|srv)", node.module or "") and not node.level:
            with contextlib.suppress(Exception):  # the import itself will say it
                module = importlib.import_module(node.module)
                for each in node.names:
                    classes[each.asname or each.name] = getattr(module, each.name)
    for node in _all(tree, ast.Call):
        first, *rest = _dotted(node.func).split(".")
        made = classes.get(first)
        for name in rest:
            made = getattr(made, name, None)
        with contextlib.suppress(AttributeError):  # no message's class
            fields = [*made.get_fields_and_field_types()]  # type: ignore[union-attr]
            for name in (each.arg for each in node.keywords if each.arg):
                for near in difflib.get_close_matches(name, {*fields} - {name}, 1, 0.0):
                    if name not in fields:
                        yield _said(node, "field", _dotted(node.func), name, near)


def _asked(tree: ast.AST) -> Found:
    """Yield how functions answer badly that are asked, or told, about parameters."""
    functions = {each.name: each for each in _all(tree, *FUNCTIONS)}
    calls = [(_last(node.func), node) for node in _all(tree, ast.Call) if node.args]
    handed = {(to, _last(node.args[0])): node for to, node in calls if to in PARAMETERS}
    for (to, name), call in handed.items():
        own = _own(functions[name]) if name in functions else []
        returns = [node for node in own if isinstance(node, ast.Return)]
        if to == PARAMETERS[1]:
            answers = any(not _is_none(node.value) for node in returns)
            if answers and (PARAMETERS[0], name) not in handed:
                yield _said(call, "unheard", name)
            continue
        tried = {id(node) for each in own if isinstance(each, ast.Try) for node in ast.walk(each)}
        for node in own:
            if isinstance(node, ast.Return) and (what := _no_result(node.value)):
                yield _said(node, "verdict", name, what)
            elif isinstance(node, ast.Raise) and id(node) not in tried:
                yield _said(node, "raises", name)
            elif isinstance(node, ast.Call) and _dotted(node.func).startswith("self.set_param"):
                yield _said(node, "sets", name)
        if own and _falls_through(functions[name].body):
            yield _said(functions[name], "verdict", name, "nothing")


def _no_result(value: ast.AST | None) -> str:
    """Return what it is that is returned in place of a SetParametersResult; "" if it may be one."""
    if _is_none(value):
        return "None"
    truth = isinstance(value, ast.Compare) or isinstance(getattr(value, "op", None), ast.Not)
    truth = truth or isinstance(getattr(value, "value", None), bool)
    return "bool" if truth else ""


def _falls_through(body: Sequence[ast.AST]) -> bool:
    """Return whether a function may come to its end without a return."""
    last = body[-1]
    if isinstance(last, ast.If):
        return not last.orelse or _falls_through(last.body) or _falls_through(last.orelse)
    if isinstance(last, ast.With):
        return _falls_through(last.body)
    return not isinstance(last, ast.Return | ast.Raise | ast.While | ast.Try | ast.Match)


def _given(tree: ast.AST) -> set[str]:
    """Return the names of variables and attributes that are given a value."""
    named = _all(tree, ast.Name, ast.Attribute)
    return {_last(node) for node in named if isinstance(node.ctx, ast.Store)}


def _within(one: str, other: str) -> bool:
    """Return whether a name is part of another, as speed of speed_ and last_speed: both meant."""
    one, other = one.strip("_"), other.strip("_")
    return one in other or other in one


def _methods(node: ast.ClassDef) -> list[ast.FunctionDef]:
    """Return a class's methods without decorators, which may have reasons to be there twice."""
    return [p for p in node.body if isinstance(p, ast.FunctionDef) and not p.decorator_list]


def _collected(tree: ast.AST) -> set[str]:
    """Return the names of variables that are added to, by `+=` or a method."""
    calls = [node.func for node in _all(tree, ast.Call)]
    added = [f.value for f in calls if isinstance(f, ast.Attribute) and f.attr in COLLECTS]
    added += [node.target for node in _all(tree, ast.AugAssign)]
    return {node.id for node in added if isinstance(node, ast.Name)}


def _used_calls(tree: ast.AST) -> Iterator[tuple[ast.Call, ast.AST]]:
    """Yield the calls whose result is given a name, computed with or handed over, and by what."""
    for node in _all(tree, ast.Assign, ast.AnnAssign, ast.Compare, ast.BinOp, ast.Call):
        parts = [getattr(node, name, None) for name in ("value", "left", "right")]
        parts += [*getattr(node, "comparators", ()), *getattr(node, "args", ())]
        parts += [each.value for each in getattr(node, "keywords", ())]
        yield from ((part, node) for part in parts if isinstance(part, ast.Call))


def _says_nothing(function: Any) -> bool:
    """Return whether a function returns nothing, and is neither a generator nor abstract."""
    own = _own(function)
    returned = [node.value for node in own if isinstance(node, ast.Return)]
    odd = isinstance(function, ast.AsyncFunctionDef) or function.decorator_list
    odd = odd or any(isinstance(node, ast.Yield | ast.YieldFrom | ast.Raise) for node in own)
    last = function.body[-1]  # `return None` at the end, as in a skeleton, means it
    odd = odd or (isinstance(last, ast.Return) and last.value is not None)
    empty = all(isinstance(node, ast.Expr | ast.Pass) for node in function.body[:2])
    return not (odd or (empty and len(function.body) <= 2)) and all(map(_is_none, returned))


def _own(function: Any) -> list[Any]:
    """Return what stands in a function, without the functions and classes in it."""
    own: list[Any] = []
    stack = list(function.body)
    while stack:
        node = stack.pop()
        own.append(node)
        if not isinstance(node, (*FUNCTIONS, ast.Lambda, ast.ClassDef)):
            stack += ast.iter_child_nodes(node)
    return own


def _is_none(node: ast.AST | None) -> bool:
    return node is None or (isinstance(node, ast.Constant) and node.value is None)


def _constants(tree: Any) -> set[str]:
    """Return the names of a module's numbers and texts, and of those of its classes."""
    found: set[str] = set()
    for of in (tree, *_all(tree, ast.ClassDef)):
        for node in of.body:
            if isinstance(node, ast.Assign) and _is_true(node.value):
                start = f"{of.name}." if isinstance(of, ast.ClassDef) else ""
                found |= {start + each.id for each in node.targets if isinstance(each, ast.Name)}
    return found


def _is_true(node: ast.AST) -> bool:
    """Return whether this is a number or a text that counts as true."""
    return (
        isinstance(node, ast.Constant)
        and isinstance(node.value, int | float | str | bytes)
        and not isinstance(node.value, bool)
        and bool(node.value)
    )


def _is_nan(node: ast.AST) -> bool:
    name = _last(node).lower()
    if isinstance(node, ast.Call) and _dotted(node.func) == "float" and node.args:
        return isinstance(node.args[0], ast.Constant) and str(node.args[0].value).lower() == "nan"
    return name == "nan"


def _is_value(node: ast.AST) -> bool:
    """Return whether this is a number or a text, which `is` can't compare."""
    node = node.operand if isinstance(node, ast.UnaryOp) else node
    return _last(node) in NUMBERS or (
        isinstance(node, ast.Constant)
        and isinstance(node.value, int | float | str)
        and not isinstance(node.value, bool)
    )


def _is_collection(node: ast.AST | None) -> bool:
    called = _last(node.func) if isinstance(node, ast.Call) else ""
    return isinstance(node, ast.List | ast.Dict | ast.Set) or called in ("list", "dict", "deque")


def _last(node: ast.AST | None) -> str:
    """Return the last name of `a.b.c`."""
    return str(getattr(node, "attr", "") or getattr(node, "id", ""))


def _dotted(node: ast.AST) -> str:
    """Return `a.b.c` as it is written; "" if it is something else."""
    if isinstance(node, ast.Attribute):
        start = _dotted(node.value)
        return f"{start}.{node.attr}" if start else ""
    return node.id if isinstance(node, ast.Name) else ""
