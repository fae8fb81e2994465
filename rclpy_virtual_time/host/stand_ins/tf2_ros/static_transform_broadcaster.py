"""Where tf2_ros has its `StaticTransformBroadcaster`."""

from .ends import StaticTransformBroadcaster

__all__ = ["StaticTransformBroadcaster"]
