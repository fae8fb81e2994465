"""The C structs with which rosidl tells rcl and Fast DDS about types, for ctypes.

From the headers of ROS 2 Jazzy: rosidl_runtime_c/{message,service,action}_type_support_struct.h and
type_description, rosidl_typesupport_fastrtps_cpp/{message,service}_type_support.h and
rosidl_typesupport_introspection_c/message_introspection.h.
"""

from __future__ import annotations

from ctypes import (
    CFUNCTYPE,
    POINTER,
    Structure,
    c_bool,
    c_char,
    c_char_p,
    c_size_t,
    c_uint8,
    c_uint32,
    c_uint64,
    c_void_p,
    py_object,
)


class String(Structure):
    _fields_ = [("data", c_char_p), ("size", c_size_t), ("capacity", c_size_t)]


class Sequence(Structure):
    """A sequence of anything."""

    _fields_ = [("data", c_void_p), ("size", c_size_t), ("capacity", c_size_t)]


class FieldType(Structure):
    _fields_ = [
        ("type_id", c_uint8), ("capacity", c_uint64), ("string_capacity", c_uint64),
        ("nested_type_name", String),
    ]  # fmt: skip


class Field(Structure):
    _fields_ = [("name", String), ("type", FieldType), ("default_value", String)]


class Individual(Structure):
    _fields_ = [("type_name", String), ("fields", Sequence)]


class Description(Structure):
    _fields_ = [("type", Individual), ("referenced", Sequence)]


class Hash(Structure):
    _fields_ = [("version", c_uint8), ("value", c_uint8 * 32)]


class Support(Structure):
    """rosidl_message_type_support_t."""

    _fields_ = [
        ("identifier", c_char_p), ("data", c_void_p), ("handle", c_void_p),
        ("type_hash", c_void_p), ("description", c_void_p), ("sources", c_void_p),
    ]  # fmt: skip


Create = CFUNCTYPE(c_void_p)
Destroy = CFUNCTYPE(None, c_void_p)
FromPy = CFUNCTYPE(c_bool, py_object, c_void_p)
ToPy = CFUNCTYPE(py_object, c_void_p)
Code = CFUNCTYPE(c_bool, c_void_p, c_void_p)
Size = CFUNCTYPE(c_uint32, c_void_p)
MaxSize = CFUNCTYPE(c_size_t, POINTER(c_char))
About = CFUNCTYPE(c_void_p, c_void_p)
Handle = CFUNCTYPE(c_void_p, c_void_p, c_char_p)


class Callbacks(Structure):
    """message_type_support_callbacks_t of Fast DDS's type support."""

    _fields_ = [
        ("namespace", c_char_p), ("name", c_char_p), ("serialize", Code), ("deserialize", Code),
        ("size", Size), ("max_size", MaxSize), ("key_callbacks", c_void_p),
    ]  # fmt: skip


class Member(Structure):
    """rosidl_typesupport_introspection_c__MessageMember."""

    _fields_ = [
        ("name", c_char_p), ("type_id", c_uint8), ("string_upper_bound", c_size_t),
        ("members", c_void_p), ("is_key", c_bool), ("is_array", c_bool), ("array_size", c_size_t),
        ("is_upper_bound", c_bool), ("offset", c_uint32), ("default_value", c_void_p),
        ("functions", c_void_p * 6),
    ]  # fmt: skip


class Members(Structure):
    """rosidl_typesupport_introspection_c__MessageMembers."""

    _fields_ = [
        ("namespace", c_char_p), ("name", c_char_p), ("count", c_uint32), ("size", c_size_t),
        ("has_any_key", c_bool), ("members", c_void_p), ("init", c_void_p), ("fini", c_void_p),
    ]  # fmt: skip


class ServiceSupport(Structure):
    """rosidl_service_type_support_t."""

    _fields_ = [("identifier", c_char_p), *((name, c_void_p) for name in (
        "data", "handle", "request", "response", "event", "create_event", "destroy_event",
        "type_hash", "description", "sources",
    ))]  # fmt: skip


class ServiceCallbacks(Structure):
    """service_type_support_callbacks_t of Fast DDS's type support."""

    _fields_ = [("namespace", c_char_p), ("name", c_char_p), ("request", c_void_p),
                ("response", c_void_p)]  # fmt: skip


class ActionSupport(Structure):
    """rosidl_action_type_support_t."""

    _fields_ = [(name, c_void_p) for name in (
        "goal", "result", "cancel", "feedback", "status", "type_hash", "description", "sources",
    )]  # fmt: skip


CreateEvent = CFUNCTYPE(c_void_p, c_void_p, c_void_p, c_void_p, c_void_p)
