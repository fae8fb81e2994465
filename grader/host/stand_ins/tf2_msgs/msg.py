"""TFMessage as rosidl would generate it: a list of geometry_msgs/TransformStamped.

The type has the name, the hash and the CDR of the real one, so it meets the ends of other programs.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

import rosidl_parser.definition as idl
from geometry_msgs.msg import TransformStamped

from . import _typesupport

__all__ = ["TFMessage"]


class _Metaclass(type):
    _CREATE_ROS_MESSAGE = None
    _CONVERT_FROM_PY = None
    _CONVERT_TO_PY = None
    _DESTROY_ROS_MESSAGE = None
    _TYPE_SUPPORT = None

    @classmethod
    def __import_type_support__(cls) -> None:
        for name, capsule in _typesupport.capsules(TFMessage, TransformStamped).items():
            setattr(cls, name, capsule)


class TFMessage(metaclass=_Metaclass):
    """Several transforms: what goes over /tf and /tf_static."""

    __slots__ = ("_check_fields", "_transforms")

    _fields_and_field_types: ClassVar[dict[str, str]] = {
        "transforms": "sequence<geometry_msgs/TransformStamped>"
    }
    SLOT_TYPES = (
        idl.UnboundedSequence(idl.NamespacedType(["geometry_msgs", "msg"], "TransformStamped")),
    )

    def __init__(self, *, transforms: Iterable[Any] = (), check_fields: bool = False) -> None:
        self._check_fields = check_fields
        self.transforms = list(transforms)

    @property
    def transforms(self) -> list[Any]:
        """The transforms, objects of TransformStamped."""
        return self._transforms

    @transforms.setter
    def transforms(self, value: Iterable[Any]) -> None:
        value = list(value)
        if not all(isinstance(transform, TransformStamped) for transform in value):
            raise AssertionError("The 'transforms' field must be a list of TransformStamped")
        self._transforms = value

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Return the fields and the names of their types."""
        return dict(cls._fields_and_field_types)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, TFMessage) and self.transforms == other.transforms

    __hash__ = None  # type: ignore[assignment]  # as generated messages: they can be changed

    def __repr__(self) -> str:
        return f"tf2_msgs.msg.TFMessage(transforms={self.transforms!r})"
