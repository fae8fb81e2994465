"""Python classes of messages, services and actions, as rosidl generates them.

Jazzy's own do not check a field's type before a message is sent. These check what would fail then:
text, messages, lists of messages, and lists that are too long. A wrong number becomes what it
becomes on a robot, which takes a text of any length, too.
"""

from __future__ import annotations

import array
import functools
from collections.abc import Callable, Mapping
from textwrap import dedent
from typing import Any

from rosidl_parser import definition as idl

from .definitions import class_of, parse, shown, type_of

SUPPORT = ("_CREATE_ROS_MESSAGE", "_CONVERT_FROM_PY", "_CONVERT_TO_PY", "_DESTROY_ROS_MESSAGE",
           "_TYPE_SUPPORT")  # fmt: skip


def define(package: str, definitions: Mapping[str, str], kind: str = "msg") -> dict[str, Any]:
    """Return the classes of a package's interfaces, by name, with the messages that they have.

    `definitions`: the text of each file, by the name of the interface. Raises ValueError: a line is
    not in the format.
    """
    made: dict[str, Any] = {}
    add = {"msg": _made, "srv": _add_service, "action": _add_action}[kind]
    for name, text in definitions.items():
        add(made, parse(package, kind, name, dedent(text)))
    return made


def _add_service(made: dict[str, Any], service: idl.Service) -> Any:
    parts = {
        part: _made(made, getattr(service, f"{part.lower()}_message"))
        for part in ("Request", "Response", "Event")
    }
    described = {f"{part.lower()}_message": type_of(cls) for part, cls in parts.items()}
    return _add_group(made, service.namespaced_type, described, parts)


def _add_action(made: dict[str, Any], action: idl.Action) -> None:
    from action_msgs.msg import GoalStatusArray  # noqa: PLC0415  (few programs have actions)
    from action_msgs.srv import CancelGoal  # noqa: PLC0415

    parts = {
        part: _made(made, getattr(action, part.lower())) for part in ("Goal", "Result", "Feedback")
    }
    described = {part.lower(): type_of(cls) for part, cls in parts.items()}
    impl = {
        "SendGoalService": _add_service(made, action.send_goal_service),
        "GetResultService": _add_service(made, action.get_result_service),
        "FeedbackMessage": _made(made, action.feedback_message),
    }
    names = ("send_goal_service", "get_result_service", "feedback_message")
    described |= {name: type_of(cls) for name, cls in zip(names, impl.values(), strict=True)}
    impl |= {"CancelGoalService": CancelGoal, "GoalStatusMessage": GoalStatusArray}
    parts["Impl"] = type("Impl", (), impl)
    _add_group(made, action.namespaced_type, described, parts)


def _made(made: dict[str, Any], message: idl.Message) -> Any:
    name = message.structure.namespaced_type.name
    return made.get(name) or made.setdefault(name, _class(message))


def _add_group(
    made: dict[str, Any], type_: Any, described: Mapping[str, Any], parts: Mapping[str, Any]
) -> Any:
    """Make the class of a service or an action; `described`: of what rosidl says it consists."""

    def __init__(self: Any) -> None:  # noqa: N807
        raise NotImplementedError(f"{type_.name} can not be instantiated")

    def import_type_support(metaclass: Any) -> None:
        from . import native  # noqa: PLC0415  (it needs ROS's libraries)

        metaclass._TYPE_SUPPORT = native.group("/".join(type_.namespaced_name()), cls)

    support = {"_TYPE_SUPPORT": None, "__import_type_support__": classmethod(import_type_support)}
    cls: Any = type(f"Metaclass_{type_.name}", (type,), support)(type_.name, (), {
        "__module__": ".".join(type_.namespaces),
        "__init__": __init__,
        "SLOT_TYPES": tuple(described.values()),
        "get_fields_and_field_types": classmethod(lambda _: dict.fromkeys(described, "")),
        **parts,
    })  # fmt: skip
    made[type_.name] = cls
    return cls


def _class(message: idl.Message) -> type:
    type_, fields = message.structure.namespaced_type, message.structure.members
    name, module = type_.name, ".".join(type_.namespaces)

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
        return f"{module}.{name}({values})"

    def types(_cls: Any) -> dict[str, str]:
        return dict(_cls._fields_and_field_types)

    def import_type_support(metaclass: Any) -> None:
        from . import native  # noqa: PLC0415  (it needs ROS's libraries)

        whole = "/".join(type_.namespaced_name())
        for each, capsule in native.capsules(whole, cls, SUPPORT).items():
            setattr(metaclass, each, capsule)

    support = dict.fromkeys(SUPPORT) | {"__import_type_support__": classmethod(import_type_support)}
    cls: Any = type(f"Metaclass_{name}", (type,), support)(name, (), {
        "__module__": module,
        "__doc__": f"Message class '{name}'.",
        "__slots__": [*(f"_{field.name}" for field in fields), "_check_fields"],
        "_fields_and_field_types": {field.name: shown(field.type) for field in fields},
        "SLOT_TYPES": tuple(field.type for field in fields),
        "__where__": {f.name: where for f in fields for where in f.get_annotation_values("where")},
        "__init__": __init__, "__eq__": __eq__, "__repr__": __repr__,
        "__hash__": None,  # as generated messages: they can be changed
        "get_fields_and_field_types": classmethod(types),
        **{constant.name: constant.value for constant in message.constants},
        **{field.name: _property(field) for field in fields},
    })  # fmt: skip
    return cls  # type: ignore[no-any-return]


def _all(equal: Any) -> Any:
    return equal.all() if hasattr(equal, "all") else equal  # of numpy's arrays


def _property(field: idl.Member) -> property:
    slot, convert, kind = f"_{field.name}", _conversion(field), field.type
    exact, bounded = isinstance(kind, idl.Array), isinstance(kind, idl.BoundedSequence)
    size = kind.size if exact else kind.maximum_size if bounded else 0

    def write(self: Any, value: Any) -> None:
        value = convert(value)
        if size and (len(value) > size or (exact and len(value) < size)):
            wanted = f"a set or sequence with length {'' if exact else '<= '}{size}"
            raise AssertionError(f"The '{field.name}' field must be {wanted}, not {len(value)}")
        setattr(self, slot, value)

    return property(lambda self: getattr(self, slot), write, doc=f"Message field '{field.name}'.")


def _conversion(field: idl.Member) -> Callable[[Any], Any]:
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


def _checked(value: Any, *, field: idl.Member, kind: Any) -> Any:
    if isinstance(kind, idl.NamespacedType):
        if not all(hasattr(value, name) for name in class_of(kind).get_fields_and_field_types()):
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


def _default(field: idl.Member) -> Any:
    kind = field.type
    if field.has_annotation("default"):
        return field.get_annotation_value("default")["value"]
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
