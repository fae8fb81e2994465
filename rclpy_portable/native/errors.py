"""The exceptions of rclpy's native module."""

from __future__ import annotations

import builtins


class RCLError(RuntimeError):
    """A call of rcl failed."""


class RMWError(RuntimeError):
    """A call of the middleware failed."""


class RCUtilsError(RuntimeError):
    """A call of rcutils failed."""


class RCLInvalidROSArgsError(RCLError):
    """The arguments after `--ros-args` can't be parsed."""


class UnknownROSArgsError(RuntimeError):
    """There are arguments after `--ros-args` that nobody knows."""


class NodeNameNonExistentError(RCLError):
    """There is no node of that name."""


class UnsupportedEventTypeError(RCLError):
    """The middleware doesn't know this kind of event."""


class InvalidHandle(RuntimeError):
    """Something is used after its destruction was asked for."""


class NotImplementedError(builtins.NotImplementedError):
    """The middleware can't do that."""
