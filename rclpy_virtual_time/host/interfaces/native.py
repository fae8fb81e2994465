"""Messages for rcl and Fast DDS: the C structs and functions that rosidl would have generated.

For C, a message is an address. What is in it stays in Python: CDR on the way out, an object of its
class on the way in.
"""

from __future__ import annotations

import ctypes
import functools
import sys
import traceback
from collections.abc import Iterable
from ctypes import Structure, c_bool, c_char, c_char_p, c_size_t, c_uint8, c_void_p, py_object
from typing import Any

from rosidl_parser import definition as idl

from rclpy_portable import cdr

from . import definitions
from .layouts import (
    About,
    Callbacks,
    Code,
    Create,
    Description,
    Destroy,
    Field,
    FieldType,
    FromPy,
    Handle,
    Hash,
    Individual,
    MaxSize,
    Member,
    Members,
    Sequence,
    Size,
    String,
    Support,
    ToPy,
)  # fmt: skip

FASTRTPS = b"rosidl_typesupport_fastrtps_c"
INTROSPECTION = b"rosidl_typesupport_introspection_c"
INTROSPECTED = {  # rosidl_typesupport_introspection_c/field_types.h
    "float": 1, "double": 2, "boolean": 6, "octet": 7, "uint8": 8, "int8": 9, "uint16": 10,
    "int16": 11, "uint32": 12, "int32": 13, "uint64": 14, "int64": 15,
}  # fmt: skip
STRING, WSTRING, MESSAGE = 16, 17, 18
PLACE = c_char * 16  # what C gets for a message
STEPS = tuple(1 << bit for bit in reversed(range(31)))  # [B]; their sum is any size below 2 GiB

_kept: list[Any] = []  # C holds pointers to these, for as long as the process lives
_alive: dict[int, list[Any]] = {}  # messages that rclpy holds, by their addresses: [place, content]


@functools.cache
def capsules(name: str, cls: Any, wanted: tuple[str, ...]) -> dict[str, Any]:
    """Return the five capsules that rclpy asks a message's class for, by their names.

    Parameters
    ----------
    name
        The type: "tf2_msgs/msg/TFMessage".
    cls
        Its class.
    wanted
        The names.
    """
    if _is_portable():  # it reads classes, not capsules
        return {each: each for each in wanted}

    def create() -> int:
        place = PLACE()
        _alive[ctypes.addressof(place)] = [place, None]
        return ctypes.addressof(place)

    def destroy(address: int) -> None:
        _alive.pop(address, None)

    def convert_from_py(message: Any, address: int) -> bool:
        try:
            _alive[address][1] = cdr.serialize(message)[len(cdr.HEADER) :]
        except Exception:
            traceback.print_exc()  # rclpy's own error, which follows, doesn't say why
            return False
        return True

    def convert_to_py(address: int) -> Any:
        return _alive[address][1]

    support = _support(name, cls)
    functions: dict[str, Any] = {
        "_CREATE_ROS_MESSAGE": Create(create),
        "_DESTROY_ROS_MESSAGE": Destroy(destroy),
        "_CONVERT_FROM_PY": FromPy(convert_from_py),
        "_CONVERT_TO_PY": ToPy(convert_to_py),
    }
    _kept.extend((*functions.values(), support))
    found = {each: _capsule(ctypes.cast(f, c_void_p).value) for each, f in functions.items()}
    return {**found, "_TYPE_SUPPORT": _capsule(ctypes.addressof(support))}


def _is_portable() -> bool:
    from builtin_interfaces.msg import Time  # noqa: PLC0415

    metaclass: Any = type(Time)
    if metaclass._TYPE_SUPPORT is None:
        metaclass.__import_type_support__()
    return isinstance(metaclass._TYPE_SUPPORT, str)


def _support(name: str, cls: Any) -> Support:
    """Return the type support for Fast DDS."""
    position, jump, write = _cdr_functions()

    def serialize(address: int, stream: int) -> bool:
        data = _alive[address][1]
        write(stream, data, len(data))
        return True

    def deserialize(stream: int, address: int) -> bool:
        # It doesn't tell its size, but refuses to go further.
        at, size = position(stream), sum(step for step in STEPS if jump(stream, step))
        data = ctypes.string_at(at, size)
        try:
            _alive[address][1] = cdr.deserialize(cdr.HEADER + data, cls)
        except RuntimeError as error:
            print(error, file=sys.stderr)
            return False
        return True

    def size(address: int) -> int:
        return len(_alive[address][1])

    def max_size(bounds: Any) -> int:
        bounds[0] = 0  # ROSIDL_TYPESUPPORT_FASTRTPS_UNBOUNDED_TYPE
        return 0

    package, _, short = name.split("/")
    callbacks = Callbacks(
        f"{package}::msg".encode(), short.encode(),
        Code(serialize), Code(deserialize), Size(size), MaxSize(max_size),
    )  # fmt: skip
    type_hash = Hash(1, (c_uint8 * 32)(*definitions.rihs01(name, cls)))
    about = [About(_constant(each)) for each in (type_hash, _description(name, cls), Sequence())]
    supports: dict[bytes, Support] = {}

    def handle(support: int, identifier: bytes) -> int | None:
        found = supports.get(identifier)
        return None if found is None else ctypes.addressof(found)

    kept = [Handle(handle), *about]
    _kept.extend((callbacks, *kept))
    functions = [ctypes.cast(function, c_void_p) for function in kept]
    for identifier, data in ((FASTRTPS, callbacks), (INTROSPECTION, _members(name, cls))):
        supports[identifier] = Support(identifier, ctypes.addressof(data), *functions)
    return supports[FASTRTPS]


# --- what Fast DDS reads to describe the type to others ------------------------------------------


@functools.cache
def _members(name: str, cls: Any) -> Members:
    package, _, short = name.split("/")
    members = [_member(*each) for each in definitions.fields_of(cls)]
    array = _kept_array(Member, members)
    found = Members(
        f"{package}__msg".encode(), short.encode(), len(members), ctypes.sizeof(PLACE), False,
        ctypes.addressof(array),
    )  # fmt: skip
    _kept.append(found)
    return found


def _member(name: str, kind: Any) -> Member:
    element = definitions.element_of(kind)
    type_id, bound, nested = STRING, 0, None
    if isinstance(element, idl.NamespacedType):
        type_id = MESSAGE
        nested = ctypes.addressof(_nested(definitions.name_of(element)))
    elif isinstance(element, idl.BasicType):
        type_id = INTROSPECTED[element.typename]
    else:
        type_id = WSTRING if isinstance(element, idl.AbstractWString) else STRING
        bound = element.maximum_size if element.has_maximum_size() else 0
    bounded = isinstance(kind, idl.BoundedSequence)
    count = kind.size if isinstance(kind, idl.Array) else kind.maximum_size if bounded else 0
    return Member(name.encode(), type_id, bound, nested, False, kind is not element, count, bounded)


@functools.cache
def _nested(name: str) -> Support:
    """Return the support of a message within a message; only its members are read."""
    package, _, short = name.split("/")
    cls = definitions.class_of(idl.NamespacedType([package, "msg"], short))
    members = _members(name, cls)
    found = Support(INTROSPECTION, ctypes.addressof(members))
    found.handle = ctypes.cast(_itself, c_void_p)
    _kept.append(found)
    return found


def _introspected(support: int, identifier: bytes) -> int | None:
    return support if identifier == INTROSPECTION else None


_itself = Handle(_introspected)


# --- what ~/get_type_description tells ------------------------------------------------------------


def _description(name: str, cls: Any) -> Description:
    others = [_individual(*each) for each in definitions.referenced(cls).items()]
    return Description(_individual(name, cls), _sequence(_kept_array(Individual, others)))


def _individual(name: str, cls: Any) -> Individual:
    fields = []
    for field, kind in definitions.fields_of(cls):
        *numbers, nested = definitions.field_type(kind)
        fields.append(Field(_string(field), FieldType(*numbers, _string(nested)), _string("")))
    return Individual(_string(name), _sequence(_kept_array(Field, fields)))


# --- C -------------------------------------------------------------------------------------------


def _cdr_functions() -> tuple[Any, Any, Any]:
    """Return Cdr's get_current_position(), jump(size_t), serialize_array(const char *, size_t)."""
    library = ctypes.CDLL("libfastcdr.so.2")
    position = library["_ZN8eprosima7fastcdr3Cdr20get_current_positionEv"]
    position.restype, position.argtypes = c_void_p, [c_void_p]
    write = library["_ZN8eprosima7fastcdr3Cdr15serialize_arrayEPKcm"]
    write.restype, write.argtypes = c_void_p, [c_void_p, c_char_p, c_size_t]
    jump = library["_ZN8eprosima7fastcdr3Cdr4jumpEm"]
    jump.restype, jump.argtypes = c_bool, [c_void_p, c_size_t]
    return position, jump, write


def _constant(thing: Structure) -> Any:
    _kept.append(thing)
    address = ctypes.addressof(thing)
    return lambda support: address


def _kept_array(kind: Any, things: Iterable[Any]) -> Any:
    things = list(things)
    array = (kind * len(things))(*things)
    _kept.append(array)
    return array


def _sequence(array: Any) -> Sequence:
    return Sequence(ctypes.addressof(array), len(array), len(array))


def _string(text: str) -> String:
    data = text.encode()
    _kept.append(data)
    return String(data, len(data), len(data) + 1)


def _capsule(address: int | None) -> Any:
    new = ctypes.pythonapi.PyCapsule_New
    new.restype, new.argtypes = py_object, [c_void_p, c_char_p, c_void_p]
    return new(address, None, None)
