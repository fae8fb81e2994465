"""How a program died, in the student's terms: the place, its own lines, and the values there.

`account` writes what `grader.recording.deaths` reads::

    in the callback of /scan
    agent.py, line 58, in choose_speed
        if distance < 0.5:
        distance = None
    TypeError: '<' not supported between instances of 'NoneType' and 'float'
    try: …

Values are told for the reader only: the program made them, so they prove nothing. No `__repr__` of
the program's own is called; it could do anything.
"""

from __future__ import annotations

import array
import linecache
import math
import re
import traceback
from collections.abc import Iterator
from pathlib import Path
from types import (
    CodeType,
    FrameType,
    FunctionType,
    MemberDescriptorType,
    MethodType,
    ModuleType,
    TracebackType,
)
from typing import Any

from grader.advice import hints
from grader.advice.message_words import field_of
from grader.advice.plain_words import plain_words
from rclpy_virtual_time import Advice

MAX_FRAMES = 4
MAX_VALUES = 6  # of a frame
MAX_VALUE = 60  # [characters]
MAX_SOURCE = 160  # [characters] of a line
MAX_ITEMS = 4  # of a list
MAX_NAME = 100  # [characters]
MAX_CHAIN = 8  # exceptions that followed one another
MAX_SAID = 400  # [characters] of an exception's text
RCLPY = ("rclpy", "executors.py")
NAMES = re.compile(r"(?<![\w.\"'])[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*")
SIGNATURES = " The following argument types are supported:"  # of C++, pages of them
SILENT = (ModuleType, FunctionType, MethodType, type, CodeType)
MISSING = object()
NO_RESPONSE = "a service's callback has to end with `return response`, on every path"
WRONG_FIELD = (
    "a field of the response has another type than it should: a bool, a number or a str; a dict "
    "becomes a text with json.dumps(…)"
)
FIT = (
    "fit(features, speeds): first the table with one row of five for each example, then the column "
    "of what they should give, as many numbers as the table has rows"
)
SETTING = (
    "a setting of the model itself is wrong, not the data: name the settings where you make it, "
    "as in hidden_layer_sizes=(64, 64)"
)
NO_RESULT = (
    "result() is None until the answer has come: use it in a function that is given, by its name "
    "and without brackets, to future.add_done_callback(…); or ask future.done() first"
)

Line = tuple[FrameType, int]


def account(error: BaseException, folder: Path) -> str:
    """Describe an exception: where, what lines of files in `folder` led to it, and what to try."""
    frames = list(_frames(error.__traceback__))
    inner = _since_callback(frames)
    own = [(frame, line) for frame, line in inner if _is_in(frame, folder)]
    entity = _entity_of(frames)
    place = _place(frames, entity, own)
    lines = [f"in {place}"]
    for frame, line in reversed(own[-MAX_FRAMES:]):
        lines += _told(frame, line)
    if not own and entity is not None:
        lines += _callback(entity)
    lines.append(_said(error))
    if words := _advice(error, place, own):
        lines.append(f"try: {words}")
    return "\n".join(lines)


def first_of(error: BaseException) -> BaseException:
    """Return the first exception, where `finally:` raised another on the way out.

    `finally: node.stop()` meets the very mistake that ended a callback, and would hide where.
    """
    for _ in range(MAX_CHAIN):
        before = error.__context__
        if not isinstance(before, Exception) or error.__suppress_context__:
            break
        if not _is_on_the_way_out(error, before):
            break
        error = before
    return error


def _is_on_the_way_out(error: BaseException, before: BaseException) -> bool:
    """Return whether an exception was raised in the `finally:` that another passed through."""
    left = {id(frame) for frame, _ in _frames(before.__traceback__)}
    shared = [(frame, line) for frame, line in _frames(error.__traceback__) if id(frame) in left]
    return bool(shared) and _block(*shared[-1]).startswith("finally")


def _block(frame: FrameType, line: int) -> str:
    """Return the head of the block in which a line stands."""
    source = [linecache.getline(frame.f_code.co_filename, n) for n in range(1, line + 1)]
    if not source:
        return ""
    depth = _indent(source[-1])
    above = (text for text in reversed(source[:-1]) if text.strip() and _indent(text) < depth)
    return next(above, "").strip()


def _indent(text: str) -> int:
    return len(text) - len(text.lstrip())


def account_of_syntax(error: SyntaxError) -> str:
    """Describe a line that Python can't read."""
    lines = ["in the start-up"]
    if error.filename and error.lineno:
        lines.append(f"{Path(error.filename).name}, line {error.lineno}, in <module>")
        if source := (error.text or "").strip()[:MAX_SOURCE]:
            lines.append(f"    {source}")
    lines.append(traceback.format_exception_only(error)[-1].strip()[:MAX_SAID])  # "did you mean"
    if words := plain_words(error):
        lines.append(f"try: {words}")
    return "\n".join(lines)


def _advice(error: BaseException, place: str, own: list[Line]) -> str:
    if not own and isinstance(error, TypeError) and place.startswith("the service"):
        return _advice_on_service(str(error))
    if own and isinstance(error, ValueError) and ".fit(" in _lines_before(*own[-1], count=0):
        if isinstance(error, TypeError):  # scikit-learn's InvalidParameterError is both
            return SETTING
        return FIT if " contains " not in str(error) else plain_words(error)
    if own and "NoneType" in str(error) and ".result()" in _lines_before(*own[-1]):
        return NO_RESULT
    line = _lines_before(*own[-1], count=0) if own else ""
    space = own[-1][0].f_locals if own else {}
    nothing = _nothing(error, *own[-1]) if own else ""
    return _surroundings(error) or nothing or field_of(error, space) or plain_words(error, line)


def _nothing(error: BaseException, frame: FrameType, line: int) -> str:
    """Name the None in a line, if an operator met it."""
    if not isinstance(error, TypeError) or "NoneType" not in str(error):
        return ""
    text = _lines_before(frame, line, count=0)
    told = [value.partition(" = ") for value in _values(frame, text)]
    names = [name for name, _, is_ in told if is_ == "None"]
    if len(names) != 1 or "not callable" in str(error):
        return ""
    if f"{names[0]} is not None" in text and " or " in text:
        return (
            f"here {names[0]} is None, and what follows `or` is computed just then: brackets say "
            "what belongs together, `a and (b or c)`"
        )
    return (
        f"here {names[0]} is None: ask `if {names[0]} is None` before. If it never should be, does "
        "what made it `return` a value on every path, and has the first message come?"
    )


def _advice_on_service(said: str) -> str:
    """Explain a callback that can't be called, or a response that can't be sent."""
    if "positional argument" in said:
        return (
            "a service's callback takes two arguments: def detect_callback(self, request, response)"
        )
    return WRONG_FIELD if said.strip() else NO_RESPONSE  # None makes pybind11 raise without words


def _surroundings(error: BaseException) -> str:
    """Return advice on an exception that comes from the node's surroundings."""
    try:
        return hints.hint(error)
    except Exception:  # the exception is the program's own, and may be anything
        return ""


def _since_callback(frames: list[Line]) -> list[Line]:
    """Leave out the frames before the callback: main() and rclpy.spin()."""
    outer = [i for i, (frame, _) in enumerate(frames) if _is_executors(frame)]
    return frames[outer[-1] + 1 :] if outer else frames


def _frames(trace: TracebackType | None) -> Iterator[Line]:
    while trace is not None:
        yield trace.tb_frame, trace.tb_lineno
        trace = trace.tb_next


def _is_in(frame: FrameType, folder: Path) -> bool:
    return Path(frame.f_code.co_filename).is_relative_to(folder)


def _is_executors(frame: FrameType) -> bool:
    """Return whether an executor runs there (and not: is imported there)."""
    code = frame.f_code
    return Path(code.co_filename).parts[-2:] == RCLPY and code.co_name != "<module>"


def _entity_of(frames: list[Line]) -> Any:
    """Return the subscription, timer, service or client that was called back."""
    for frame, _ in reversed(frames):
        if _is_executors(frame) and frame.f_code.co_name == "handler":
            return frame.f_locals.get("entity")
    return None


def _place(frames: list[Line], entity: Any, own: list[Line]) -> str:
    """Name the callback that was running, or the start-up."""
    if entity is not None:
        return _entity(entity)
    if any(_is_executors(frame) for frame, _ in frames):
        return "a callback"
    names = [frame.f_code.co_name for frame, _ in own]
    return "the constructor" if "__init__" in names else "the start-up"


def _callback(entity: Any) -> list[str]:
    """Return the head of a callback, for an exception raised after it."""
    code = getattr(getattr(entity, "callback", None), "__code__", None)
    if code is None:
        return []
    source = linecache.getline(code.co_filename, code.co_firstlineno).strip()[:MAX_SOURCE]
    head = f"{Path(code.co_filename).name}, line {code.co_firstlineno}, in {code.co_name}"
    return [head, f"    {source}"] if source else [head]


def _lines_before(frame: FrameType, line: int, count: int = 4) -> str:
    """Return a line and the lines before it."""
    file = frame.f_code.co_filename
    return "".join(linecache.getline(file, n) for n in range(max(1, line - count), line + 1))


def _entity(entity: Any) -> str:
    """Name the entity of a callback; of a destroyed node, entities have no names."""
    name = str(getattr(entity, "_course_name", ""))[:MAX_NAME]
    words = {
        "Subscription": f"the callback of {name}" if name else "the callback of a topic",
        "Timer": f"a timer ({name})" if name else "a timer",
        "Service": f"the service {name}" if name else "a service",
        "Client": f"the answer of the service {name}" if name else "the answer of a service",
    }
    return words.get(type(entity).__name__, "a callback")


def _told(frame: FrameType, line: int) -> list[str]:
    """Return the lines about a frame."""
    code = frame.f_code
    source = linecache.getline(code.co_filename, line).strip()[:MAX_SOURCE]
    told = [f"{Path(code.co_filename).name}, line {line}, in {code.co_name}"]
    if source:
        told.append(f"    {source}")
    if values := _values(frame, source):
        told.append(f"    {', '.join(values)}")
    return told


def _values(frame: FrameType, source: str) -> list[str]:
    """Return the values of the names in a line, such as `speed` and `self.pose.x`."""
    told: dict[str, str] = {}
    for path in NAMES.findall(source):
        first, *rest = path.split(".")
        if first not in frame.f_locals:
            continue
        name, value = first, frame.f_locals[first]
        for attribute in rest:
            found = _attribute(value, attribute)
            if found is MISSING:
                break
            name, value = f"{name}.{attribute}", found
        if name != "self" and not isinstance(value, SILENT):
            told[name] = f"{name} = {value_words(value)}"
    return list(told.values())[:MAX_VALUES]


def _attribute(owner: Any, name: str) -> Any:
    """Return an attribute without calling anything; fields of messages lie under `_name`."""
    fields = getattr(type(owner), "_fields", ())
    if isinstance(owner, tuple) and name in fields:
        return tuple.__getitem__(owner, fields.index(name))
    for key in (name, f"_{name}"):
        try:
            inside = object.__getattribute__(owner, "__dict__")
        except AttributeError:
            inside = {}
        if key in inside:
            return inside[key]
        slot = type(owner).__dict__.get(key)
        if isinstance(slot, MemberDescriptorType):
            try:
                return slot.__get__(owner)
            except AttributeError:
                continue
    return MISSING


def value_words(value: Any) -> str:
    """Return a value in few characters, without calling any code of the program's."""
    try:
        words = _words(value, depth=1)
    except Exception:
        words = f"<{type(value).__name__}>"
    words = " ".join(words.split())
    return words if len(words) <= MAX_VALUE else words[: MAX_VALUE - 1] + "…"


def _words(value: Any, depth: int) -> str:
    kind = type(value)
    if value is None or kind in (bool, float, complex):
        return repr(value)
    if kind is int:
        return repr(value) if value.bit_length() < 200 else "a huge int"
    if kind in (str, bytes):
        return repr(value[:MAX_VALUE])
    if kind in (list, tuple, set, frozenset, dict):
        return _items(value, depth)
    if kind is array.array:
        return _numbers(list(value), f"array of {len(value)}")
    if kind.__module__ == "numpy":
        if hasattr(value, "shape") and kind.__name__ == "ndarray":
            return _numbers(value.ravel().tolist(), f"array {value.shape} of {value.dtype}")
        return f"{kind.__name__}({value})"
    return f"<{kind.__name__}>"


def _items(value: Any, depth: int) -> str:
    size = f"{type(value).__name__} of {len(value)}"
    if not depth or len(value) > MAX_ITEMS:
        flat = [x for x in value if type(x) in (int, float)] if type(value) is not dict else []
        return _numbers(flat, size) if flat and len(flat) == len(value) else size
    if type(value) is dict:
        inner = [f"{_words(k, 0)}: {_words(v, 0)}" for k, v in value.items()]
        return "{" + ", ".join(inner) + "}"
    return f"[{', '.join(_words(item, 0) for item in value)}]"


def _numbers(numbers: list[Any], size: str) -> str:
    usable = [x for x in numbers if isinstance(x, int | float) and not math.isnan(x)]
    if not usable:
        return size
    lost = len(numbers) - len(usable)
    return f"{size}, {min(usable):.3g} … {max(usable):.3g}" + (f", {lost} NaN" if lost else "")


def _said(error: BaseException) -> str:
    """Return Python's own words in one line."""
    try:
        text = "".join(traceback.format_exception_only(error))
    except Exception:
        text = type(error).__name__
    return Advice.steady(" ".join(text.split()).partition(SIGNATURES)[0])[:MAX_SAID]
