"""TFMessage for rcl and Fast DDS: the C structs and functions that rosidl would have generated.

Its one field is a sequence, and everything about its elements is in geometry_msgs' libraries. So
what is left to do in Python is the length before them.
"""

from __future__ import annotations

import ctypes
import functools
from ctypes import (
    POINTER,
    PYFUNCTYPE,
    Structure,
    c_bool,
    c_char_p,
    c_int32,
    c_size_t,
    c_uint8,
    c_void_p,
    py_object,
)
from typing import Any

from ._layouts import (
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
    Transform,
)  # fmt: skip

NAME = b"tf2_msgs/msg/TFMessage"
HASH = "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"  # RIHS01
FASTRTPS = b"rosidl_typesupport_fastrtps_c"
INTROSPECTION = b"rosidl_typesupport_introspection_c"
NESTED = 18  # ROS_TYPE_MESSAGE of introspection
NESTED_SEQUENCE = 145  # FIELD_TYPE_NESTED_TYPE_UNBOUNDED_SEQUENCE
MOST = 100_000  # transforms in a message
ELEMENT = "geometry_msgs__msg__TransformStamped"
NAMES = (
    "_CREATE_ROS_MESSAGE", "_CONVERT_FROM_PY", "_CONVERT_TO_PY", "_DESTROY_ROS_MESSAGE",
    "_TYPE_SUPPORT",
)  # fmt: skip
LENGTH = 4  # [B] of the number before a CDR sequence


_kept: list[Any] = []  # C holds pointers to these, for as long as the process lives


@functools.cache
def capsules(message_type: Any, element_type: Any) -> dict[str, Any]:
    """Return the five capsules that rclpy asks a message's class for, by their names.

    Parameters
    ----------
    message_type, element_type
        The classes of tf2_msgs/TFMessage and geometry_msgs/TransformStamped.
    """
    if element_type.__class__._TYPE_SUPPORT is None:
        element_type.__class__.__import_type_support__()
    element = element_type.__class__
    if isinstance(element._TYPE_SUPPORT, str):  # the portable runtime reads classes, not capsules
        return {name: name for name in NAMES}
    init, fini = _sequence_functions()
    # They need Python's lock: PYFUNCTYPE does not let it go.
    from_py = PYFUNCTYPE(c_bool, py_object, c_void_p)(_pointer(element._CONVERT_FROM_PY))
    to_py = PYFUNCTYPE(py_object, c_void_p)(_pointer(element._CONVERT_TO_PY))

    def create() -> int:
        message = Sequence()
        _alive[ctypes.addressof(message)] = message
        return ctypes.addressof(message)

    def destroy(address: int) -> None:
        message = _alive.pop(address, None)
        if message is not None:
            fini(ctypes.byref(message))

    def convert_from_py(value: Any, address: int) -> bool:
        message = Sequence.from_address(address)
        fini(ctypes.byref(message))
        transforms = value.transforms
        return bool(init(ctypes.byref(message), len(transforms))) and all(
            from_py(transform, at)
            for transform, at in zip(transforms, _elements(message), strict=True)
        )

    def convert_to_py(address: int) -> Any:
        message = Sequence.from_address(address)
        return message_type(transforms=[to_py(at) for at in _elements(message)])

    support = _support(init, fini)
    functions: dict[str, Any] = {
        "_CREATE_ROS_MESSAGE": Create(create),
        "_DESTROY_ROS_MESSAGE": Destroy(destroy),
        "_CONVERT_FROM_PY": FromPy(convert_from_py),
        "_CONVERT_TO_PY": ToPy(convert_to_py),
    }
    _kept.extend((*functions.values(), from_py, to_py, support))
    found = {name: _capsule(ctypes.cast(f, c_void_p).value) for name, f in functions.items()}
    return {**found, "_TYPE_SUPPORT": _capsule(ctypes.addressof(support))}


_alive: dict[int, Sequence] = {}  # messages that rclpy holds, by their addresses


def _elements(message: Sequence) -> range:
    """Return the addresses of a message's transforms."""
    begin = message.data or 0
    size = ctypes.sizeof(Transform)
    return range(begin, begin + message.size * size, size)


def _sequence_functions() -> tuple[Any, Any]:
    library = ctypes.CDLL("libgeometry_msgs__rosidl_generator_c.so")
    init = library[f"{ELEMENT}__Sequence__init"]
    init.restype, init.argtypes = c_bool, [c_void_p, c_size_t]
    fini = library[f"{ELEMENT}__Sequence__fini"]
    fini.restype, fini.argtypes = None, [c_void_p]
    return init, fini


def _support(init: Any, fini: Any) -> Support:
    """Return the type support for Fast DDS."""
    element = _element_support(FASTRTPS)
    of_element = ctypes.cast(element.data, POINTER(Callbacks)).contents
    serialize_length, deserialize_length = _cdr_functions()
    element_size = _library(FASTRTPS)[f"get_serialized_size_{ELEMENT}"]
    element_size.restype, element_size.argtypes = c_size_t, [c_void_p, c_size_t]

    def serialize(address: int, cdr: int) -> bool:
        message = Sequence.from_address(address)
        serialize_length(cdr, message.size)
        return all(of_element.serialize(at, cdr) for at in _elements(message))

    def deserialize(cdr: int, address: int) -> bool:
        length = c_int32()
        deserialize_length(cdr, ctypes.byref(length))
        if not 0 <= length.value <= MOST:
            return False
        message = Sequence.from_address(address)
        fini(ctypes.byref(message))
        return bool(init(ctypes.byref(message), length.value)) and all(
            of_element.deserialize(cdr, at) for at in _elements(message)
        )

    def size(address: int) -> int:
        end = LENGTH
        for at in _elements(Sequence.from_address(address)):
            end += element_size(at, end)
        return end

    def max_size(bounds: Any) -> int:
        bounds[0] = 0  # ROSIDL_TYPESUPPORT_FASTRTPS_UNBOUNDED_TYPE
        return 0

    callbacks = Callbacks(
        b"tf2_msgs::msg", b"TFMessage",
        Code(serialize), Code(deserialize), Size(size), MaxSize(max_size),
    )  # fmt: skip
    about = [About(_constant(thing)) for thing in (_hash(), _description(element), Sequence())]
    supports: dict[bytes, Support] = {}

    def handle(support: int, identifier: bytes) -> int | None:
        found = supports.get(identifier)
        return None if found is None else ctypes.addressof(found)

    kept = [Handle(handle), *about]
    _kept.extend((callbacks, *kept))
    functions = [ctypes.cast(function, c_void_p) for function in kept]
    for identifier, data in ((FASTRTPS, callbacks), (INTROSPECTION, _members())):
        supports[identifier] = Support(identifier, ctypes.addressof(data), *functions)
    return supports[FASTRTPS]


def _members() -> Members:
    """Return what Fast DDS reads to describe the type to others."""
    nested = ctypes.addressof(_element_support(INTROSPECTION))
    member = Member(b"transforms", NESTED, 0, nested, is_array=True)
    size = ctypes.sizeof(Sequence)
    members = Members(b"tf2_msgs__msg", b"TFMessage", 1, size, False, ctypes.addressof(member))
    _kept.extend((member, members))
    return members


def _library(identifier: bytes) -> ctypes.CDLL:
    return ctypes.CDLL(f"libgeometry_msgs__{identifier.decode()}.so")


def _element_support(identifier: bytes) -> Support:
    """Return the type support of TransformStamped."""
    get = _library(identifier)[f"{identifier.decode()}__get_message_type_support_handle__{ELEMENT}"]
    get.restype = POINTER(Support)
    support: Support = get().contents
    return support


def _cdr_functions() -> tuple[Any, Any]:
    """Return Cdr::serialize(int32_t) and Cdr::deserialize(int32_t &) of libfastcdr."""
    library = ctypes.CDLL("libfastcdr.so.2")
    serialize = library["_ZN8eprosima7fastcdr3Cdr9serializeEi"]
    serialize.restype, serialize.argtypes = c_void_p, [c_void_p, c_int32]
    deserialize = library["_ZN8eprosima7fastcdr3Cdr11deserializeERi"]
    deserialize.restype, deserialize.argtypes = c_void_p, [c_void_p, c_void_p]
    return serialize, deserialize


def _constant(thing: Structure) -> Any:
    _kept.append(thing)
    address = ctypes.addressof(thing)
    return lambda support: address


def _hash() -> Hash:
    return Hash(1, (c_uint8 * 32)(*bytes.fromhex(HASH)))


def _description(element: Support) -> Description:
    """Return the description that ~/get_type_description tells: ours, and those of the element."""
    get = About(element.description)
    inner = ctypes.cast(get(ctypes.addressof(element)), POINTER(Description)).contents
    inner_count = inner.referenced.size
    others = (Individual * inner_count).from_address(inner.referenced.data)
    referenced = (Individual * (1 + inner_count))(inner.type, *others)
    nested = FieldType(NESTED_SEQUENCE, 0, 0, inner.type.type_name)
    fields = (Field * 1)(Field(_string(b"transforms"), nested, _string(b"")))
    _kept.extend((inner, referenced, fields))
    return Description(Individual(_string(NAME), _sequence(fields)), _sequence(referenced))


def _sequence(array: Any) -> Sequence:
    return Sequence(ctypes.addressof(array), len(array), len(array))


def _string(text: bytes) -> String:
    _kept.append(text)
    return String(text, len(text), len(text) + 1)


def _capsule(address: int | None) -> Any:
    new = ctypes.pythonapi.PyCapsule_New
    new.restype, new.argtypes = py_object, [c_void_p, c_char_p, c_void_p]
    return new(address, None, None)


def _pointer(capsule: Any) -> int:
    get = ctypes.pythonapi.PyCapsule_GetPointer
    get.restype, get.argtypes = c_void_p, [py_object, c_char_p]
    address: int = get(capsule, None)
    return address
