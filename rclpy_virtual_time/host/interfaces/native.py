"""Types for rcl and Fast DDS: the C structs and functions that rosidl would have generated.

For C, a message is an address. What is in it stays in Python: CDR on the way out, an object of its
class on the way in.
"""

from __future__ import annotations

import ctypes
import functools
import itertools
import sys
from collections.abc import Iterable
from ctypes import Structure, c_char, c_char_p, c_size_t, c_uint8, c_void_p, py_object
from typing import Any

from rclpy.type_support import check_for_type_support
from rosidl_parser import definition as idl

from rclpy_portable import cdr

from . import definitions
from .layouts import (
    About,
    ActionSupport,
    Callbacks,
    Code,
    Create,
    CreateEvent,
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
    ServiceCallbacks,
    ServiceSupport,
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
CDR = 24  # [words] of an eprosima::fastcdr::Cdr, at least

_kept: list[Any] = []  # C holds pointers to these, for as long as the process lives
_alive: dict[int, list[Any]] = {}  # messages that rclpy holds, by their addresses: [place, content]


@functools.cache
def capsules(name: str, cls: Any, wanted: tuple[str, ...]) -> dict[str, Any]:
    """Return the capsules that rclpy wants of the class of a message, "tf2_msgs/msg/TFMessage"."""
    if _is_portable():  # it reads classes, not capsules
        return {each: each for each in wanted}

    def destroy(address: int) -> None:
        _alive.pop(address, None)

    def convert_from_py(message: Any, address: int) -> bool:
        try:
            _alive[address][1] = cdr.serialize(message)[len(cdr.HEADER) :]
        except Exception as error:  # rclpy's own error, which follows, doesn't say why
            print(f"{type(error).__name__}: {error}", file=sys.stderr)
            return False
        return True

    def convert_to_py(address: int) -> Any:
        return _alive[address][1]

    support = _support(name, cls)
    functions: dict[str, Any] = {
        "_CREATE_ROS_MESSAGE": Create(_create),
        "_DESTROY_ROS_MESSAGE": Destroy(destroy),
        "_CONVERT_FROM_PY": FromPy(convert_from_py),
        "_CONVERT_TO_PY": ToPy(convert_to_py),
    }
    _kept.extend((*functions.values(), support))
    found = {each: _capsule(ctypes.cast(f, c_void_p).value) for each, f in functions.items()}
    return {**found, "_TYPE_SUPPORT": _capsule(ctypes.addressof(support))}


def group(name: str, cls: Any) -> Any:
    """Return the capsule that rclpy asks the class of a service or an action for."""
    if _is_portable():
        return name
    support = _action(name, cls) if hasattr(cls, "Impl") else _service(name, cls)
    return _capsule(ctypes.addressof(support))


def _create() -> int:
    place = PLACE()
    _alive[ctypes.addressof(place)] = [place, None]
    return ctypes.addressof(place)


def _is_portable() -> bool:
    from builtin_interfaces.msg import Time  # noqa: PLC0415

    metaclass: Any = type(Time)
    if metaclass._TYPE_SUPPORT is None:
        metaclass.__import_type_support__()
    return isinstance(metaclass._TYPE_SUPPORT, str)


@functools.cache
def _support(name: str, cls: Any) -> Support:
    """Return a message's type support for Fast DDS."""
    position, start, write = _cdr_functions()

    def serialize(address: int, stream: int) -> bool:
        data = _alive[address][1]
        write(stream, data, len(data))
        return True

    def deserialize(stream: int, address: int) -> bool:
        # A Cdr doesn't tell its size, but has iterators: the buffer and a place in it, or its end.
        at, buffer, words = position(stream), start(stream), (c_size_t * CDR).from_address(stream)
        end = max(place for word, place in itertools.pairwise(words) if word == buffer)
        try:
            data = ctypes.string_at(at, end - at)
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

    package, kind, short = name.split("/")
    callbacks = Callbacks(
        f"{package}::{kind}".encode(), short.encode(),
        Code(serialize), Code(deserialize), Size(size), MaxSize(max_size),
    )  # fmt: skip
    supports: dict[bytes, Any] = {}
    functions = (_handle(supports), *_about(name, cls))
    for identifier, data in ((FASTRTPS, callbacks), (INTROSPECTION, _members(name, cls))):
        supports[identifier] = Support(identifier, _address(data), *functions)
    return supports[FASTRTPS]  # type: ignore[no-any-return]


def _about(name: str, cls: Any) -> list[Any]:
    """Return the functions that tell a type's hash, its description and its sources."""
    type_hash = Hash(1, (c_uint8 * 32)(*definitions.rihs01(name, cls)))
    told = map(_address, (type_hash, _description(name, cls), Sequence()))
    return [_function(About(lambda _, at=at: at)) for at in told]


def _handle(supports: dict[bytes, Any]) -> Any:
    """Return the function that finds a type support by its identifier."""

    def handle(support: int, identifier: bytes) -> int | None:
        found = supports.get(identifier)
        return None if found is None else ctypes.addressof(found)

    return _function(Handle(handle))


@functools.cache
def _service(name: str, cls: Any) -> ServiceSupport:
    """Return a service's type support for Fast DDS. Nothing publishes what the service does."""
    package, kind, short = name.split("/")
    parts = [("Request", cls.Request), ("Response", cls.Response), ("Event", cls.Event)]
    for _, part in parts:
        check_for_type_support(part)
    messages = [_address(_support(f"{name}_{which}", part)) for which, part in parts]
    callbacks = ServiceCallbacks(f"{package}::{kind}".encode(), short.encode(), *messages[:2])
    supports: dict[bytes, Any] = {}
    none = _function(CreateEvent(lambda *_: None))
    supports[FASTRTPS] = ServiceSupport(FASTRTPS, _address(callbacks), _handle(supports), *messages,
                                        none, none, *_about(name, cls))  # fmt: skip
    return supports[FASTRTPS]  # type: ignore[no-any-return]


@functools.cache
def _action(name: str, cls: Any) -> ActionSupport:
    """Return an action's type support."""
    impl = cls.Impl
    theirs = (impl.CancelGoalService, impl.GoalStatusMessage)
    for each in (*theirs, impl.FeedbackMessage):
        check_for_type_support(each)
    goal = _address(_service(f"{name}_SendGoal", impl.SendGoalService))
    result = _address(_service(f"{name}_GetResult", impl.GetResultService))
    feedback = _address(_support(f"{name}_FeedbackMessage", impl.FeedbackMessage))
    cancel, status = (_pointer(type(each)._TYPE_SUPPORT) for each in theirs)
    found = ActionSupport(goal, result, cancel, feedback, status, *_about(name, cls))
    _kept.append(found)
    return found


# --- what Fast DDS reads to describe the type to others ------------------------------------------


@functools.cache
def _members(name: str, cls: Any) -> Members:
    package, kind, short = name.split("/")
    members = [_member(*each) for each in definitions.fields_of(cls)]
    array = _kept_array(Member, members)
    found = Members(
        f"{package}__{kind}".encode(), short.encode(), len(members), ctypes.sizeof(PLACE), False,
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
    package, kind, short = name.split("/")
    cls = definitions.class_of(idl.NamespacedType([package, kind], short))
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
    """Return Cdr's get_current_position(), get_buffer_pointer(), serialize_array(char *, …)."""
    library = ctypes.CDLL("libfastcdr.so.2")
    position = library["_ZN8eprosima7fastcdr3Cdr20get_current_positionEv"]
    start = library["_ZN8eprosima7fastcdr3Cdr18get_buffer_pointerEv"]
    for function in (position, start):
        function.restype, function.argtypes = c_void_p, [c_void_p]
    write = library["_ZN8eprosima7fastcdr3Cdr15serialize_arrayEPKcm"]
    write.restype, write.argtypes = c_void_p, [c_void_p, c_char_p, c_size_t]
    return position, start, write


def _address(thing: Structure) -> int:
    _kept.append(thing)
    return ctypes.addressof(thing)


def _function(function: Any) -> Any:
    _kept.append(function)
    return ctypes.cast(function, c_void_p)


def _pointer(capsule: Any) -> Any:
    get = ctypes.pythonapi.PyCapsule_GetPointer
    get.restype, get.argtypes = c_void_p, [py_object, c_char_p]
    return get(capsule, None)


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
