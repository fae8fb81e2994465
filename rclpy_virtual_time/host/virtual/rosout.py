"""/rosout in virtual time: what nodes log, for the programs that listen to it.

rclpy's own /rosout is off in a host: it would put the machine's time on each line, and cost every
node a publisher that hardly a program listens to. Here a line becomes a message once somebody does.
"""

from __future__ import annotations

import collections
from collections.abc import Callable
from typing import Any, NamedTuple

import rclpy.node
from rcl_interfaces.msg import Log
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.qos import DurabilityPolicy, QoSProfile

TOPIC = "/rosout"
DEPTH = 1_000  # messages kept for who listens later (rcl's qos_profile_rosout_default) ...
LIFESPAN = 10 * 10**9  # [ns] ... and for how long
ENABLE, DISABLE = "--enable-rosout-logs", "--disable-rosout-logs"


class Line(NamedTuple):
    """A line that a node has logged."""

    time: Any  # rclpy.time.Time
    severity: int
    name: str
    text: str
    function: str
    file: str
    line: int

    def message(self) -> Log:
        """Return the line as a message."""
        return Log(
            stamp=self.time.to_msg(), level=int(self.severity), name=self.name, msg=self.text,
            function=self.function, file=self.file, line=self.line,
        )  # fmt: skip


class Rosout:
    """Publishes the lines of all nodes of the process, by context."""

    def __init__(
        self,
        now: Callable[[], Any],
        node_in: Callable[[Any], Any],
        before: Callable[[], None] = lambda: None,
    ) -> None:
        self._now = now
        self._before = before  # a line is logged
        self._node_in = node_in  # our node in a context
        self._contexts: dict[str, Any] = {}  # by the name of a logger that is heard
        self._children: collections.Counter[str] = collections.Counter()
        self._lines: dict[Any, collections.deque[Line]] = {}  # by context
        self._publishers: dict[Any, Any] = {}  # by context

    def install(self) -> None:
        """Listen to the loggers of rclpy, and to nodes that come and go."""
        native: Any = rclpy_implementation
        log = native.rclpy_logging_rcutils_log

        def log_and_tell(*line: Any) -> None:
            self._before()
            log(*line)
            context = self._contexts.get(line[1])
            if context is not None:
                self._tell(context, Line(self._now(), *line))

        native.rclpy_logging_rcutils_log = log_and_tell
        native.rclpy_logging_rosout_add_sublogger = self._add_child
        native.rclpy_logging_rosout_remove_sublogger = self._remove_child
        cls: Any = rclpy.node.Node
        create, destroy = cls.__init__, cls.destroy_node

        def created(node: Any, *args: Any, **kwargs: Any) -> None:
            create(node, *args, **kwargs)
            if kwargs.get("enable_rosout", True) and is_on(node.context):
                node._course_logger = node.get_logger().name  # it may become a mock
                self._contexts[node._course_logger] = node.context

        def destroyed(node: Any) -> None:
            self._contexts.pop(getattr(node, "_course_logger", ""), None)
            destroy(node)

        cls.__init__, cls.destroy_node = created, destroyed

    def listened_to(self, context: Any, latched: bool) -> None:
        """Publish from now on; to subscriptions that ask for the past, the last seconds first."""
        if context in self._publishers:
            return
        qos = QoSProfile(depth=DEPTH, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        publisher = self._node_in(context).create_publisher(Log, TOPIC, qos)
        self._publishers[context] = publisher
        now = self._now().nanoseconds
        for line in self._lines.pop(context, ()):
            if latched and now - line.time.nanoseconds <= LIFESPAN:
                publisher.publish(line.message())

    def leave(self, context: Any) -> None:
        """Forget a context that is shut down, and its nodes."""
        self._publishers.pop(context, None)
        self._lines.pop(context, None)
        self._contexts = {name: c for name, c in self._contexts.items() if c is not context}

    def _tell(self, context: Any, line: Line) -> None:
        publisher = self._publishers.get(context)
        if publisher is not None:
            publisher.publish(line.message())
        else:
            self._lines.setdefault(context, collections.deque(maxlen=DEPTH)).append(line)

    def _add_child(self, name: str, child: str) -> bool:
        if name not in self._contexts:
            return False
        full = f"{name}.{child}"
        self._children[full] += 1
        self._contexts[full] = self._contexts[name]
        return True

    def _remove_child(self, name: str, child: str) -> None:
        full = f"{name}.{child}"
        self._children[full] -= 1
        if not self._children[full]:
            self._contexts.pop(full, None)


def is_on(context: Any) -> bool:
    """Return whether the command line of a context leaves /rosout on."""
    flags = [
        word for word in getattr(context, "_course_arguments", ()) if word in (ENABLE, DISABLE)
    ]
    return not flags or flags[-1] == ENABLE
