"""A program's values in a few words, without a line of its code being run.

No `__repr__`, `__eq__`, `__len__` or property of the program's is called: what is no builtin, no
array of numpy's and no object with fields is its type alone. A million entries cost as little as
ten. Types are known by their identity: comparing them could run a metaclass of the program's.
"""

from __future__ import annotations

import array
import collections
import enum
import math
import sys
import types
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import Any

import numpy as np
from rclpy.duration import Duration
from rclpy.time import Time

from .frames import MAX_NAME, Value
from .imports import host
from .wire import sendable

ENTRIES, FIELDS, DEPTH = 5, 14, 5  # of a sequence, of an object, and of what is in them
PARTS = 150  # of a value in all
CHARACTERS = 80  # of a text
MANY, MOST = 10**6, 10**60  # of a number: stamps in seconds are shown to the millisecond
LARGE = 10_000  # entries of an array whose least and greatest are not looked for
LOOKED_AT = 200  # variables, of which some are shown
ROS = ("rclpy.", "tf2_ros", "message_filters")  # modules of classes that say nothing of a program
DICTIONARIES = (dict, collections.defaultdict, collections.OrderedDict, collections.Counter)
CODE = (types.FunctionType, types.MethodType, types.BuiltinFunctionType, types.ModuleType, type)
SCAN = ("ranges", "range_min", "range_max", "angle_min", "angle_increment")
MESSAGE_FIELDS = "_fields_and_field_types"  # of a message's class

# Of a class as Python keeps it
_namespace: Any = type.__dict__["__dict__"].__get__
_mro: Any = type.__dict__["__mro__"].__get__
_name_of: Any = type.__dict__["__name__"].__get__
_nanoseconds = {id(cls): cls.nanoseconds.fget for cls in (Time, Duration)}
_left = [0]  # parts


def words(value: Any, most: int = MAX_NAME) -> str:
    """Return a value in at most so many characters."""
    _left[0] = PARTS
    try:
        text = sendable(_words(value, DEPTH))
    except Exception:  # whatever has been made of it
        text = "<?>"
    return text if len(text) <= most else f"{text[: most - 1]}…"


def values_of(variables: Iterable[tuple[Any, Any]]) -> list[Value]:
    """Return some variables in words: no nodes, ends of topics or other things of ROS, no code."""
    found: dict[str, str] = {}
    try:
        for name, value in islice(variables, LOOKED_AT):
            if type(name) is str and name[:2] != "__" and not _is_machinery(value):
                found[sendable(name)[:MAX_NAME]] = words(value)
    except RuntimeError:  # they change meanwhile: a finalizer runs
        found.clear()
    return [Value(*each) for each in islice(found.items(), Value.MOST)]


def parts_of(value: Any) -> list[Value]:
    """Return the fields of a message in words; of anything else all of it, without a name."""
    if type(of_class(value, MESSAGE_FIELDS)) is dict:
        return [*values_of(_in_order(value)), *_nearest(dict(_in_order(value)))][: Value.MOST]
    return [] if value is None else [Value("", words(value))]


def _nearest(scan: dict[str, Any]) -> list[Value]:
    """Return which reading of a LaserScan is the nearest in range; nothing of anything else."""
    found: Any = map(scan.get, SCAN)
    ranges, *bounds = found
    if type(ranges) is not array.array or ranges.typecode not in "fd":
        return []
    if not all(type(each) is float for each in bounds):
        return []
    least, most, first, step = bounds
    kept = [(r, i) for i, r in enumerate(ranges[:LARGE]) if least <= r <= most]
    if not kept:
        return [Value("nearest", f"none of {len(ranges):,} is in range")]
    nearest, i = min(kept)
    angle = (math.degrees(first + i * step) + 180.0) % 360.0 - 180.0
    where = f"{nearest:.3f} m at {round(angle, 1) + 0.0}°, ranges[{i}]"
    return [Value("nearest", f"{where}; {len(kept):,} of {len(ranges):,} are in range")]


def fields_of(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the names and values that an object keeps, of its slots and of its dictionary."""
    for cls in reversed(_mro(type(value))):
        for name, kept in list(_namespace(cls).items()):
            if type(kept) is types.MemberDescriptorType and type(name) is str:
                try:
                    yield name, kept.__get__(value)
                except AttributeError:  # it has not been set
                    continue
            elif name == "__dict__" and type(kept) is types.GetSetDescriptorType:
                items = dict.items(kept.__get__(value))
                yield from (each for each in items if type(each[0]) is str)


def of_class(value: Any, name: str) -> Any:
    """Return what a value's class has under a name; None if it has nothing."""
    namespaces = map(_namespace, _mro(type(value)))
    return next((each[name] for each in namespaces if name in each), None)


def class_name(value: Any) -> str:
    """Return the name of a value's class."""
    return sendable(_name_of(type(value)))[:MAX_NAME]


def is_beside(value: Any) -> bool:
    """Return whether a value's class is of the program's own files."""
    module = sys.modules.get(_module(type(value)))
    file = module and types.ModuleType.__getattribute__(module, "__dict__").get("__file__")
    return type(file) is str and host.is_beside(file)


def _module(cls: Any) -> str:
    name = _namespace(cls).get("__module__")
    return name if type(name) is str else ""


def _is_machinery(value: Any) -> bool:
    cls = type(value)
    of_ros = any(_module(each).startswith(ROS) for each in _mro(cls))
    return issubclass(cls, CODE) or (of_ros and id(cls) not in _nanoseconds)


def _words(value: Any, depth: int) -> str:
    _left[0] -= 1
    if _left[0] < 0 or depth < 0:
        return "…"
    return _HOW.get(id(type(value)), _object)(value, depth - 1)


def _object(value: Any, depth: int) -> str:
    """Return a message, or an object of a class of the program's own, with its fields."""
    cls, name = type(value), class_name(value)
    is_message = type(of_class(value, MESSAGE_FIELDS)) is dict
    fields = _in_order(value)
    if is_message and name == "Time":
        kept = [each for _, each in _in_order(value)]
        if len(kept) == 2 and all(type(each) is int for each in kept):
            return f"{kept[0] + kept[1] / 1e9:.3f} s"
    if cls is types.BuiltinFunctionType:
        return sendable(value.__name__)
    if issubclass(cls, enum.Enum):
        return f"{name}.{dict(fields).get('_name_')}"
    if type(names := of_class(value, "_fields")) is tuple and issubclass(cls, tuple):
        fields = zip(names, tuple.__iter__(value), strict=False)
    elif issubclass(cls, CODE) or not (is_message or is_beside(value)):
        return f"<{name}>"
    texts = [
        f"{key}={_words(each, depth)}"
        for key, each in islice(fields, FIELDS)
        if not _is_machinery(each)
    ]
    inside = is_message and depth < DEPTH - 1
    return f"{'' if inside else name}({', '.join(texts)})" if texts or is_message else f"<{name}>"


def _in_order(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the fields of an object; those of a message as its definition has them."""
    names = of_class(value, MESSAGE_FIELDS)
    if type(names) is not dict:
        return fields_of(value)
    kept = dict(fields_of(value))
    return ((name, kept[f"_{name}"]) for name in names if f"_{name}" in kept)


def _listed(values: Any, size: int, depth: int) -> str:
    """Return the first entries; of a long sequence the last two as well: a history grows there."""
    last = [values[-2], values[-1]] if len(values) == size > ENTRIES else []
    texts = [_words(each, depth) for each in islice(values, ENTRIES - len(last))]
    left = size - len(texts) - len(last)
    more = [f"… {left:,} more"] if left else []
    return ", ".join([*texts, *more, *(_words(each, depth) for each in last)])


def _text(value: Any, _: int) -> str:
    more = f"… ({len(value):,} in all)" if len(value) > CHARACTERS else ""
    return repr(value[:CHARACTERS]) + more


def _numbers(value: Any, depth: int) -> str:
    size, kind = value.size, " ".join(("x".join(map(str, value.shape)), str(value.dtype)))
    span = ""
    if 0 < size <= LARGE and value.dtype.kind in "iuf":
        finite = value[np.isfinite(value)]
        ends = [f"{each():.7g}" for each in (finite.min, finite.max)] if finite.size else []
        span = f", {' to '.join(dict.fromkeys(ends))}" if ends else ""
    return f"{kind}{span}: [{_listed(value.flat[:ENTRIES].tolist(), size, depth)}]"


def _dictionary(value: Any, depth: int) -> str:
    texts = [
        f"{_words(key, 0)}: {_words(each, depth)}"
        for key, each in islice(dict.items(value), ENTRIES)
    ]
    left = len(value) - len(texts)
    return f"{{{', '.join([*texts, f'… {left:,} more'] if left else texts)}}}"


def _in(left: str, right: str) -> Callable[[Any, int], str]:
    return lambda value, depth: f"{left}{_listed(value, len(value), depth)}{right}"


def _set(value: Any, depth: int) -> str:
    return f"{{{_listed(list(islice(value, ENTRIES)), len(value), depth)}}}"


def _float(value: float, _: int) -> str:
    return f"{value:.3f}" if MANY < abs(value) < MOST else f"{value:.7g}"


def _int(value: int, _: int) -> str:
    return str(value) if abs(value) < MOST else f"<int of {value.bit_length()} bits>"


def _time(value: Any, _: int) -> str:
    return f"{class_name(value)}({_nanoseconds[id(type(value))](value) / 1e9:.3f} s)"


_HOW: dict[int, Callable[[Any, int], str]] = {
    id(type(None)): lambda *_: "None",
    id(bool): lambda value, _: str(value),
    id(int): _int,
    id(float): _float,
    **dict.fromkeys(map(id, (str, bytes, bytearray)), _text),
    **dict.fromkeys(_nanoseconds, _time),
    **dict.fromkeys(map(id, np.sctypeDict.values()), lambda value, n: _words(value.item(), n)),
    id(np.ndarray): _numbers,
    id(array.array): lambda value, depth: _numbers(np.asarray(value), depth) if value else "[]",
    **dict.fromkeys(map(id, (list, collections.deque)), _in("[", "]")),
    id(tuple): _in("(", ")"),
    **dict.fromkeys(map(id, (set, frozenset)), _set),
    **dict.fromkeys(map(id, DICTIONARIES), _dictionary),
}
