"""The fields and constants of a message, from its .msg text and from its class.

The format: https://docs.ros.org/en/jazzy/Concepts/Basic/About-Interfaces.html
"""

from __future__ import annotations

import ast
import hashlib
import importlib
import json
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

from rosidl_parser import definition as idl

BASIC = {"bool": "boolean", "byte": "octet", "char": "uint8", "float32": "float",
         "float64": "double"}  # fmt: skip
BASIC |= {f"{sign}int{bits}": f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)}
LINE = re.compile(
    r"(?P<base>[\w/]+)(?:<=(?P<longest>\d+))?(?P<many>\[(?:<=)?\d*\])?"
    r"\s+(?P<name>\w+)\s*(?P<constant>=)?\s*(?P<value>.*)"
)

# type_description_interfaces/msg/FieldType
NESTED, STRING, WSTRING, BOUNDED_STRING, BOUNDED_WSTRING = 1, 17, 18, 21, 22
TYPE_IDS = {
    "int8": 2, "uint8": 3, "int16": 4, "uint16": 5, "int32": 6, "uint32": 7, "int64": 8,
    "uint64": 9, "float": 10, "double": 11, "boolean": 15, "octet": 16,
}  # fmt: skip
ARRAY, BOUNDED, UNBOUNDED = 48, 96, 144  # are added to an element's


class Field(NamedTuple):
    """One field of a message."""

    name: str
    type: Any  # of rosidl_parser.definition, as in SLOT_TYPES
    default: Any  # None: zero, empty


class FieldType(NamedTuple):
    """A field's type, as type descriptions have it."""

    type_id: int
    capacity: int = 0  # of an array or a bounded sequence
    string_capacity: int = 0
    nested_type_name: str = ""


def parse(package: str, text: str) -> tuple[list[Field], dict[str, Any]]:
    """Return the fields and the constants of a .msg file.

    Raises
    ------
    ValueError
        A line is not in the format.
    """
    fields, constants = [], {}
    for line in filter(None, (line.partition("#")[0].strip() for line in text.splitlines())):
        found = LINE.fullmatch(line)
        if found is None:
            raise ValueError(f"{line!r} is no field of a message")
        value = ast.literal_eval(found["value"].capitalize()) if found["value"] else None
        if found["constant"]:
            constants[found["name"]] = value
        else:
            fields.append(Field(found["name"], _type(package, found), value))
    return fields, constants


def _type(package: str, found: re.Match[str]) -> Any:
    base, longest, many = found["base"], int(found["longest"] or 0), found["many"]
    kind: Any
    if base in BASIC:
        kind = idl.BasicType(BASIC[base])
    elif base in ("string", "wstring"):
        kind = idl.BoundedString(longest) if longest else idl.UnboundedString()
        if base == "wstring":
            kind = idl.BoundedWString(longest) if longest else idl.UnboundedWString()
    else:
        base = "std_msgs/Header" if base == "Header" else base
        owner, _, name = base.rpartition("/")
        kind = idl.NamespacedType([owner.partition("/")[0] or package, "msg"], name)
    if many is None:
        return kind
    size = int(many.strip("[<=]") or 0)
    if "<=" in many:
        return idl.BoundedSequence(kind, size)
    return idl.Array(kind, size) if size else idl.UnboundedSequence(kind)


def class_of(kind: Any) -> Any:
    """Return the class of a NamespacedType."""
    return getattr(importlib.import_module(".".join(kind.namespaces)), kind.name)


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
