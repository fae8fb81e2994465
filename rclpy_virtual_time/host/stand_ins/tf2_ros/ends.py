"""A node's ends of /tf and /tf_static, with the QoS that tf2 uses."""

from __future__ import annotations

import threading
from collections.abc import Iterable
from typing import Any

import rclpy.executors
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile
from tf2_msgs.msg import TFMessage

from .exceptions import InvalidArgumentException

MOVING = QoSProfile(depth=100, history=HistoryPolicy.KEEP_LAST)
STATIC_HEARD = QoSProfile(
    depth=100, history=HistoryPolicy.KEEP_LAST, durability=DurabilityPolicy.TRANSIENT_LOCAL
)
STATIC_SAID = QoSProfile(
    depth=1, history=HistoryPolicy.KEEP_LAST, durability=DurabilityPolicy.TRANSIENT_LOCAL
)


class TransformListener:
    """Fills a buffer with what comes on /tf and /tf_static."""

    def __init__(
        self,
        buffer: Any,
        node: Any,
        *,
        spin_thread: bool = False,
        qos: Any = None,
        static_qos: Any = None,
        tf_topic: str = "/tf",
        tf_static_topic: str = "/tf_static",
    ) -> None:
        self.buffer, self.node = buffer, node
        self.tf_sub = node.create_subscription(TFMessage, tf_topic, self.callback, qos or MOVING)
        self.tf_static_sub = node.create_subscription(
            TFMessage, tf_static_topic, self.static_callback, static_qos or STATIC_HEARD
        )
        if spin_thread:
            self.executor = rclpy.executors.SingleThreadedExecutor()
            self.executor.add_node(node)
            self.dedicated_listener_thread = threading.Thread(target=self.executor.spin)
            self.dedicated_listener_thread.daemon = True
            self.dedicated_listener_thread.start()

    def callback(self, data: Any) -> None:
        """Keep the transforms of a TFMessage."""
        self._keep(data, self.buffer.set_transform)

    def static_callback(self, data: Any) -> None:
        """Keep the static transforms of a TFMessage."""
        self._keep(data, self.buffer.set_transform_static)

    def unregister(self) -> None:
        """Hear no more."""
        self.node.destroy_subscription(self.tf_sub)
        self.node.destroy_subscription(self.tf_static_sub)

    def _keep(self, data: Any, keep: Any) -> None:
        for transform in data.transforms:
            try:
                keep(transform, "default_authority")
            except InvalidArgumentException as error:
                self.node.get_logger().error(str(error), throttle_duration_sec=1.0)


class TransformBroadcaster:
    """Tells others of transforms that change."""

    def __init__(self, node: Any, qos: Any = None) -> None:
        self.pub_tf = node.create_publisher(TFMessage, "/tf", qos or MOVING)

    def sendTransform(self, transform: Any) -> None:  # noqa: N802  (the name in tf2_ros)
        """Send a TransformStamped or a list of them."""
        self.pub_tf.publish(TFMessage(transforms=_listed(transform)))


class StaticTransformBroadcaster:
    """Publishes transforms that stay, to later subscriptions too."""

    def __init__(self, node: Any, qos: Any = None) -> None:
        self.pub_tf = node.create_publisher(TFMessage, "/tf_static", qos or STATIC_SAID)
        self._sent: dict[str, Any] = {}  # by child frame

    def sendTransform(self, transform: Any) -> None:  # noqa: N802
        """Send a TransformStamped or a list of them, together with all that was sent before."""
        self._sent |= {each.child_frame_id: each for each in _listed(transform)}
        self.pub_tf.publish(TFMessage(transforms=list(self._sent.values())))


def _listed(transform: Any) -> list[Any]:
    return list(transform) if isinstance(transform, Iterable) else [transform]
