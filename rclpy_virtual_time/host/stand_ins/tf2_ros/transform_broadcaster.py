"""Where tf2_ros has its `TransformBroadcaster`."""

from .ends import TransformBroadcaster

__all__ = ["TransformBroadcaster"]
