"""Python classes of messages, as rosidl generates them.

Jazzy's own do not check a field's type before a message is sent. These check what would fail then:
text, messages and lists of messages. A wrong number becomes what it becomes on a robot.
"""

from __future__ import annotations

import array
import functools
from collections.abc import Callable, Mapping
from typing import Any

from rosidl_parser import definition as idl

from .definitions import Field, class_of, parse, shown

SUPPORT = ("_CREATE_ROS_MESSAGE", "_CONVERT_FROM_PY", "_CONVERT_TO_PY", "_DESTROY_ROS_MESSAGE",
           "_TYPE_SUPPORT")  # fmt: skip


def define(package: str, definitions: Mapping[str, str]) -> dict[str, type]:
    """Return the classes of a package's messages, by name.

    Parameters
    ----------
    package
        Its name, for example "ackermann_msgs".
    definitions
        The text of each message's .msg file, by the name of the message.

    Raises
    ------
    ValueError
        A line is not in the format.
    """
    return {name: _class(package, name, text) for name, text in definitions.items()}


def _class(package: str, name: str, text: str) -> type:
    fields, constants = parse(package, text)

    def __init__(self: Any, **values: Any) -> None:  # noqa: N807
        self._check_fields = values.get("check_fields", False)
        for field in fields:
            value = values[field.name] if field.name in values else _default(field)
            setattr(self, field.name, value)

    def __eq__(self: Any, other: object) -> bool:  # noqa: N807
        return isinstance(other, cls) and all(
            bool(_all(getattr(self, f.name) == getattr(other, f.name))) for f in fields
        )

    def __repr__(self: Any) -> str:  # noqa: N807
        values = ", ".join(f"{field.name}={getattr(self, field.name)!r}" for field in fields)
        return f"{package}.msg.{name}({values})"

    def types(_cls: Any) -> dict[str, str]:
        return dict(_cls._fields_and_field_types)

    def import_type_support(metaclass: Any) -> None:
        from . import native  # noqa: PLC0415  (it needs ROS's libraries)

        for each, capsule in native.capsules(f"{package}/msg/{name}", cls, SUPPORT).items():
            setattr(metaclass, each, capsule)

    support = dict.fromkeys(SUPPORT) | {"__import_type_support__": classmethod(import_type_support)}
    cls: Any = type(f"Metaclass_{name}", (type,), support)(name, (), {
        "__module__": f"{package}.msg",
        "__doc__": f"Message class '{name}'.",
        "__slots__": [*(f"_{field.name}" for field in fields), "_check_fields"],
        "_fields_and_field_types": {field.name: shown(field.type) for field in fields},
        "SLOT_TYPES": tuple(field.type for field in fields),
        "__init__": __init__, "__eq__": __eq__, "__repr__": __repr__,
        "__hash__": None,  # as generated messages: they can be changed
        "get_fields_and_field_types": classmethod(types),
        **constants,
        **{field.name: _property(field) for field in fields},
    })  # fmt: skip
    return cls  # type: ignore[no-any-return]


def _all(equal: Any) -> Any:
    return equal.all() if hasattr(equal, "all") else equal  # of numpy's arrays


def _property(field: Field) -> property:
    slot, convert = f"_{field.name}", _conversion(field)

    def write(self: Any, value: Any) -> None:
        setattr(self, slot, convert(value))

    return property(lambda self: getattr(self, slot), write, doc=f"Message field '{field.name}'.")


def _conversion(field: Field) -> Callable[[Any], Any]:
    """Return what makes an assigned value a field's.

    It raises AssertionError for a value that can't stand there.
    """
    kind = field.type
    if not isinstance(kind, idl.AbstractNestedType):
        return functools.partial(_checked, field=field, kind=kind)
    code = _code(kind.value_type)
    if code and isinstance(kind, idl.Array):
        return lambda value: _numpy().array(value, dtype=code)
    if code:
        return lambda value: value if isinstance(value, array.array) else array.array(code, value)

    def several(value: Any) -> list[Any]:
        if isinstance(value, (str, bytes, dict)) or not hasattr(value, "__iter__"):
            raise AssertionError(f"The '{field.name}' field must be a list")
        return [_checked(each, field=field, kind=kind.value_type) for each in value]

    return several


def _checked(value: Any, *, field: Field, kind: Any) -> Any:
    if isinstance(kind, idl.NamespacedType):
        if not isinstance(value, class_of(kind)):
            raise AssertionError(
                f"The '{field.name}' field must be a sub message of type '{kind.name}'"
            )
    elif isinstance(kind, idl.AbstractGenericString) and not isinstance(value, str):
        raise AssertionError(f"The '{field.name}' field must be of type 'str'")
    return value


def _code(kind: Any) -> str:
    """Return the code of numbers that stand in an array; "" if they stand in a list."""
    from rclpy_portable.cdr import CODES  # noqa: PLC0415

    basic = isinstance(kind, idl.BasicType) and kind.typename not in ("boolean", "octet")
    return CODES[kind.typename] if basic else ""


def _numpy() -> Any:
    import numpy  # noqa: PLC0415  (most messages have no arrays)  # noqa: ICN001

    return numpy


def _default(field: Field) -> Any:
    kind = field.type
    if field.default is not None:
        return field.default
    if isinstance(kind, idl.Array):
        return [_zero(kind.value_type) for _ in range(kind.size)]
    return [] if isinstance(kind, idl.AbstractNestedType) else _zero(kind)


def _zero(kind: Any) -> Any:
    if isinstance(kind, idl.NamespacedType):
        return class_of(kind)()
    if isinstance(kind, idl.AbstractGenericString):
        return ""
    zeros = {"boolean": False, "octet": b"\0", "float": 0.0, "double": 0.0}
    return zeros.get(kind.typename, 0)
