"""A context: one participant in the graph, and what the command line says."""

from __future__ import annotations

import os
from collections.abc import Sequence

from . import logging, machine, signals
from .arguments import parse
from .enums import RCL_DEFAULT_DOMAIN_ID
from .errors import RCLError
from .graph import Participant
from .handles import Destroyable


class Context(Destroyable):
    """What `rclpy.init` makes."""

    def __init__(self, args: Sequence[str], domain_id: int) -> None:
        if domain_id == RCL_DEFAULT_DOMAIN_ID:
            domain_id = int(os.environ.get("ROS_DOMAIN_ID") or 0)
        self._domain_id = domain_id
        self.arguments = parse(args)
        self.participant = Participant(domain_id)
        self._alive = True
        signals.contexts.append(self)

    def get_domain_id(self) -> int:
        """Return the domain."""
        return self._domain_id

    def ok(self) -> bool:
        """Return whether it was not shut down."""
        return self._alive

    def shutdown(self) -> None:
        """Shut it down."""
        if not self._alive:
            raise RCLError("failed to shutdown: rcl_shutdown already called on the given context")
        self._alive = False
        signals.contexts.remove(self)
        self.participant.leave()
        machine.changed()

    def _destroy(self) -> None:
        if self._alive:
            self.shutdown()


def configure_logging(context: Context) -> None:
    """Take the log levels of a context's command line: rclpy_logging_configure."""
    logging.configure(context.arguments)
