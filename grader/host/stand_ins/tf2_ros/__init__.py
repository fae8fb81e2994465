"""A stand-in for the package tf2_ros, which has no wheel.

Here are `Buffer` with `lookup_transform` and `can_transform`, the listener and the broadcasters.
Not here: `Buffer.transform` of stamped messages (tf2_geometry_msgs), lookups through a fixed frame,
the asynchronous ones, `BufferClient` and `BufferServer`.
"""

from .buffer import Buffer
from .ends import StaticTransformBroadcaster, TransformBroadcaster, TransformListener
from .exceptions import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)

__all__ = [
    "Buffer",
    "ConnectivityException",
    "ExtrapolationException",
    "InvalidArgumentException",
    "LookupException",
    "StaticTransformBroadcaster",
    "TimeoutException",
    "TransformBroadcaster",
    "TransformException",
    "TransformListener",
]
