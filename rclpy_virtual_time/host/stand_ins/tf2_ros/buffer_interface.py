"""What every buffer has: its registrations, and `transform`."""

from typing import Any

from rclpy.duration import Duration

from .conversions import ConvertRegistration, TransformRegistration, TypeException, convert

__all__ = [
    "BufferInterface",
    "ConvertRegistration",
    "TransformRegistration",
    "TypeException",
    "convert",
]


class BufferInterface:
    """Takes stamped messages to other frames by the lookups of the class that extends it."""

    lookup_transform: Any
    lookup_transform_full: Any

    def __init__(self) -> None:
        self.registration = TransformRegistration()

    def transform(
        self,
        object_stamped: Any,
        target_frame: str,
        timeout: Duration = Duration(),  # noqa: B008
        new_type: Any = None,
    ) -> Any:
        """Return a stamped message in another frame; `import tf2_geometry_msgs` for its types.

        Raises TransformException: as `lookup_transform`; TypeException for a type that nothing is
        registered for.
        """
        do_transform = TransformRegistration().get(type(object_stamped))
        header = object_stamped.header
        found = self.lookup_transform(target_frame, header.frame_id, header.stamp, timeout)
        moved = do_transform(object_stamped, found)
        return convert(moved, new_type) if new_type else moved

    def transform_full(
        self,
        object_stamped: Any,
        target_frame: str,
        target_time: Any,
        fixed_frame: str,
        timeout: Duration = Duration(),  # noqa: B008
        new_type: Any = None,
    ) -> Any:
        """Return a stamped message in another frame at another time; raises as `transform`."""
        do_transform = TransformRegistration().get(type(object_stamped))
        header = object_stamped.header
        found = self.lookup_transform_full(
            target_frame, target_time, header.frame_id, header.stamp, fixed_frame, timeout
        )
        moved = do_transform(object_stamped, found)
        return convert(moved, new_type) if new_type else moved
