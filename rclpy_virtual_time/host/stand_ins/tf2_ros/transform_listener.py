"""Where tf2_ros has its `TransformListener`."""

from .ends import TransformListener

__all__ = ["TransformListener"]
