"""The types of interfaces, from the text of their files and from their classes.

The text is read by rosidl's own parser, as colcon has it read. The format:
https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib
import io
import json
import keyword
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from rosidl_adapter import parser
from rosidl_parser import definition as idl

BASIC = {"bool": "boolean", "byte": "octet", "char": "uint8", "float32": "float",
         "float64": "double"}  # fmt: skip
BASIC |= {f"{sign}int{bits}": f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
SECTIONS: dict[str, Any] = {  # what is told apart by lines of ---, and what it is together
    "msg": (("",), None), "srv": (("_Request", "_Response"), idl.Service),
    "action": (("_Goal", "_Result", "_Feedback"), idl.Action),
}  # fmt: skip
parser.VALID_CONSTANT_NAME_PATTERN = re.compile(  # the same in linear time
    "[A-Z][A-Z0-9]*(_[A-Z0-9]+)*$"
)
FORM = "expected TYPE name, TYPE name default, or TYPE NAME=value; of messages PACKAGE/Name name"
KNOWN = "bool, byte, char, float32, float64, int8 to int64, uint8 to uint64, string, wstring"
WORDS = {  # of rosidl's errors, which quote patterns, and ours
    "invalid message name": f"there is no such type: expected {KNOWN}, or PACKAGE/Name",
    "invalid field name": "expected a name of small letters, digits and single _, such as my_field",
    "invalid constant name": "expected a constant's name in capitals; a default stands without =",
    "size of array": "expected TYPE[], TYPE[3] or TYPE[<=3] for a list",
    "index out of range": "it is indented",
}
KEYWORD = "{} is a word of Python's: colcon builds it, but nothing can import it; rename it"
MAX_VALUES = 10_000_000  # in a new message
MAX_DEPTH = 30  # messages in one another
FILLING = ("structure_needs_at_least_one_member", idl.BasicType("uint8"))  # rosidl's

# type_description_interfaces/msg/FieldType
NESTED, STRING, WSTRING, BOUNDED_STRING, BOUNDED_WSTRING = 1, 17, 18, 21, 22
TYPE_IDS = {
    "int8": 2, "uint8": 3, "int16": 4, "uint16": 5, "int32": 6, "uint32": 7, "int64": 8,
    "uint64": 9, "float": 10, "double": 11, "boolean": 15, "octet": 16,
}  # fmt: skip
ARRAY, BOUNDED, UNBOUNDED = 48, 96, 144  # are added to an element's


class FieldType(NamedTuple):
    """A field's type, as type descriptions have it."""

    type_id: int
    capacity: int = 0  # of an array or a bounded sequence
    string_capacity: int = 0
    nested_type_name: str = ""


def parse(package: str, kind: str, name: str, text: str) -> Any:
    """Return what a file defines, of rosidl_parser.definition: a Message, a Service or an Action.

    Its members have annotations: `default`, and `where` the file and the line.

    Raises ValueError: a line is not in the format; the file and the line are named.
    """
    file = f"{package}/{kind}/{name}.{kind}"
    if not parser.VALID_MESSAGE_NAME_PATTERN.fullmatch(name):
        raise ValueError(f"{file}: expected a name of letters and digits, such as MyType")
    sections: list[list[tuple[str, str]]] = [[]]
    for number, line in enumerate(text.splitlines(), 1):
        where = f"{file}, line {number}"
        if kind == "msg" or line.strip(" \t-") or "--" not in line:
            sections[-1].append((where, line))
        elif line != "---":
            raise ValueError(f"{where}: {line!r}: expected --- and nothing else")
        else:
            sections.append([])
    suffixes, make = SECTIONS[kind]
    if len(sections) != len(suffixes):
        lines = f"{len(suffixes) - 1} line{'s' * (kind == 'action')} ---"
        raise ValueError(f"{file}: expected {lines}, found {len(sections) - 1}")
    names = [idl.NamespacedType([package, kind], name + suffix) for suffix in ("", *suffixes)]
    messages = [_message(*each) for each in zip(names[1:], sections, strict=True)]
    return make(names[0], *messages) if make else messages[0]


def _message(type_: idl.NamespacedType, lines: list[tuple[str, str]]) -> idl.Message:
    found = idl.Message(idl.Structure(type_))
    members = found.structure.members
    for where, line in lines:
        try:
            with contextlib.redirect_stderr(io.StringIO()):  # it prints what it raises
                code = line.partition("#")[0]
                read = parser.parse_message_string(type_.namespaces[0], type_.name, code)
            for each in read.fields:
                if any(each.name == member.name for member in members):
                    raise ValueError(f"there is a field {each.name} already")
                if keyword.iskeyword(each.name):
                    raise ValueError(KEYWORD.format(each.name))
                member = idl.Member(_type(each.type), each.name)
                member.annotations.append(idl.Annotation("where", where))
                if (value := _value(each.type, each.default_value)) is not None:
                    member.annotations.append(idl.Annotation("default", {"value": value}))
                members.append(member)
            for each in read.constants:
                kind = parser.Type(each.type)
                constant = idl.Constant(each.name, _type(kind), _value(kind, each.value))
                found.constants.append(constant)
        except Exception as error:  # its kinds are many
            raise ValueError(f"{where}: {line.rstrip()!r}: {_said(str(error), line)}") from None
    return found


def _said(error: str, line: str) -> str:
    if error in line:
        return FORM
    return next((ours for theirs, ours in WORDS.items() if re.search(theirs, error)), error)


def _value(kind: Any, value: Any) -> Any:
    if kind.type != "byte" or value is None:
        return value
    return [bytes([each]) for each in value] if kind.is_array else bytes([value])


def _type(kind: Any) -> Any:
    element: Any
    bound, size = kind.string_upper_bound, kind.array_size
    if kind.pkg_name is not None:
        element = idl.NamespacedType([kind.pkg_name, "msg"], kind.type)
    elif kind.type == "string":
        element = idl.BoundedString(bound) if bound else idl.UnboundedString()
    elif kind.type == "wstring":
        element = idl.BoundedWString(bound) if bound else idl.UnboundedWString()
    elif kind.type in BASIC:
        element = idl.BasicType(BASIC[kind.type])
    else:  # time, duration
        raise ValueError(f"in ROS 2 it is builtin_interfaces/{kind.type.capitalize()}")
    if kind.is_upper_bound:
        return idl.BoundedSequence(element, size)
    if kind.is_array:
        return idl.Array(element, size) if size else idl.UnboundedSequence(element)
    return element


def weigh(cls: Any, known: dict[Any, int], above: tuple[Any, ...] = ()) -> int:
    """Return how many values a new message has, with those of the messages in it.

    Raises ValueError: they are too many, a type is not there, or a message is part of itself.
    Raises ModuleNotFoundError: a package is not there.
    """
    if cls in above or len(above) > MAX_DEPTH:
        names = " in ".join(each.__name__ for each in reversed((*above[-5:], cls)))
        raise ValueError(f"{cls.__module__}: part of itself, or of {MAX_DEPTH} others: {names}")
    if cls not in known:
        total = 0
        for name, kind in fields_of(cls):
            element = element_of(kind)
            where = getattr(cls, "__where__", {}).get(name, f"{cls.__module__}.{cls.__name__}")
            values = kind.size if isinstance(kind, idl.Array) else 1
            if isinstance(element, idl.NamespacedType):
                values *= weigh(_found(element, where), known, (*above, cls))
            total += values
            if total > MAX_VALUES:
                raise ValueError(f"{where}: a message of more than {MAX_VALUES:,} values")
        known[cls] = total
    return known[cls]


def _found(kind: idl.NamespacedType, where: str) -> Any:
    package = kind.namespaces[0]
    try:
        return class_of(kind)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package:
            raise
        said = f"{where}: there is no package {package} here"
        raise ModuleNotFoundError(said, name=package) from None
    except AttributeError:
        instead = "; in ROS 2 it is std_msgs/Header" if kind.name == "Header" else ""
        raise ValueError(f"{where}: {package} has no message {kind.name}{instead}") from None


def class_of(kind: Any) -> Any:
    """Return the class of a NamespacedType."""
    return getattr(importlib.import_module(".".join(kind.namespaces)), kind.name)


def type_of(cls: Any) -> idl.NamespacedType:
    """Return the type of a class that was made here."""
    return idl.NamespacedType(cls.__module__.split("."), cls.__name__)


def name_of(kind: Any) -> str:
    """Return the name of a NamespacedType: "geometry_msgs/msg/Twist"."""
    return "/".join((*kind.namespaces, kind.name))


def element_of(kind: Any) -> Any:
    """Return the type of a field's elements; its own if it has none."""
    return kind.value_type if isinstance(kind, idl.AbstractNestedType) else kind


def shown(kind: Any) -> str:
    """Return a type as `get_fields_and_field_types` has it: "sequence<double, 3>"."""
    if isinstance(kind, idl.Array):
        return f"{shown(kind.value_type)}[{kind.size}]"
    if isinstance(kind, idl.BoundedSequence):
        return f"sequence<{shown(kind.value_type)}, {kind.maximum_size}>"
    if isinstance(kind, idl.UnboundedSequence):
        return f"sequence<{shown(kind.value_type)}>"
    if isinstance(kind, idl.NamespacedType):
        return f"{kind.namespaces[0]}/{kind.name}"
    if isinstance(kind, idl.BasicType):
        return str(kind.typename)
    base = "wstring" if isinstance(kind, idl.AbstractWString) else "string"
    return f"{base}<{kind.maximum_size}>" if kind.has_maximum_size() else base


def field_type(kind: Any) -> FieldType:
    """Return a type as type descriptions have it."""
    element = element_of(kind)
    if isinstance(element, idl.NamespacedType):
        found = FieldType(NESTED, nested_type_name=name_of(element))
    elif isinstance(element, idl.BasicType):
        found = FieldType(TYPE_IDS[element.typename])
    else:
        wide = isinstance(element, idl.AbstractWString)
        if element.has_maximum_size():
            bounded = BOUNDED_WSTRING if wide else BOUNDED_STRING
            found = FieldType(bounded, string_capacity=element.maximum_size)
        else:
            found = FieldType(WSTRING if wide else STRING)
    if isinstance(kind, idl.Array):
        return found._replace(type_id=found.type_id + ARRAY, capacity=kind.size)
    if isinstance(kind, idl.BoundedSequence):
        return found._replace(type_id=found.type_id + BOUNDED, capacity=kind.maximum_size)
    return found._replace(type_id=found.type_id + UNBOUNDED * (kind is not element))


def fields_of(cls: Any) -> Iterator[tuple[str, Any]]:
    """Yield the names and types of a class's fields, ours or a generated one's."""
    if not cls.SLOT_TYPES:
        return iter([FILLING])
    return zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES, strict=True)


def referenced(cls: Any) -> dict[str, Any]:
    """Return the classes of all messages within a message, by name and in the order of names."""
    found: dict[str, Any] = {}
    for _, kind in fields_of(cls):
        element = element_of(kind)
        if isinstance(element, idl.NamespacedType) and name_of(element) not in found:
            inner = class_of(element)
            found |= {name_of(element): inner, **referenced(inner)}
    return dict(sorted(found.items()))


def rihs01(name: str, cls: Any) -> bytes:
    """Return the hash of a type, 32 bytes: REP-2016."""

    def described(name: str, cls: Any) -> dict[str, Any]:
        fields = [{"name": n, "type": field_type(t)._asdict()} for n, t in fields_of(cls)]
        return {"type_name": name, "fields": fields}

    others = [described(*each) for each in referenced(cls).items()]
    whole = {"type_description": described(name, cls), "referenced_type_descriptions": others}
    return hashlib.sha256(json.dumps(whole).encode()).digest()
