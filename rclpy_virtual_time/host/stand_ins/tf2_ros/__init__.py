"""A stand-in for the package tf2_ros, which has no wheel.

Here are `Buffer` with its lookups and `transform` (of the types of tf2_geometry_msgs), the
listener and the broadcasters. Not here: `BufferClient`, `BufferServer` and the service
`tf2_frames`.
"""

import sys

from .buffer import Buffer
from .buffer_interface import (
    BufferInterface,
    ConvertRegistration,
    TransformRegistration,
    TypeException,
    convert,
)
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
    "BufferInterface",
    "ConnectivityException",
    "ConvertRegistration",
    "ExtrapolationException",
    "InvalidArgumentException",
    "LookupException",
    "StaticTransformBroadcaster",
    "TimeoutException",
    "TransformBroadcaster",
    "TransformException",
    "TransformListener",
    "TransformRegistration",
    "TypeException",
    "convert",
]

print(
    "tf2_ros: pip has no package of it, so this is a stand-in, without BufferClient and "
    "BufferServer; `source /opt/ros/…/setup.bash` before the start brings ROS's own",
    file=sys.stderr,
)
