"""What the robot hears on /cmd_vel: Twist, and TwistStamped, for which it gives a warning.

A DDS participant has one type per topic, so the second type needs a participant of its own.
"""

import math
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from rclpy.qos import QoSProfile, ReliabilityPolicy

from sim.live.extras import Extras
from sim.live.robot import LiveRobot
from sim.messages import CMD_VEL_TOPIC, TWIST, TWIST_STAMPED, twist_from_cdr, twist_stamped_from_cdr

ACCEPTS_ANY = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
WARN_EVERY = 10.0  # [s]


class Hearing:
    """The subscriptions of a robot's node.

    Parameters
    ----------
    node, stamped_node
        The robot's node, and one in another participant.
    robot
        Follows the commands that are heard.
    extras
        Record and show them.
    """

    def __init__(self, node: Any, stamped_node: Any, robot: LiveRobot, extras: Extras) -> None:
        self._log, self._robot, self._extras = node.get_logger(), robot, extras
        topic = CMD_VEL_TOPIC.removeprefix("/")
        node.create_subscription(Twist, topic, self._on_twist, ACCEPTS_ANY, raw=True)
        self.topic: str = node.resolve_topic_name(topic)
        stamped_node.create_subscription(
            TwistStamped, self.topic, self._on_twist_stamped, ACCEPTS_ANY, raw=True
        )

    def _on_twist(self, data: bytes) -> None:
        self._command(TWIST, data, twist_from_cdr)

    def _on_twist_stamped(self, data: bytes) -> None:
        self._log.warning(
            f"{TWIST_STAMPED} on {self.topic}: this robot takes it, but a real one takes one "
            f"type only, and in this course that is {TWIST}: publish that",
            throttle_duration_sec=WARN_EVERY,
        )
        self._command(TWIST_STAMPED, data, twist_stamped_from_cdr)

    def _command(self, type: str, data: bytes, read: Callable[[bytes], tuple[float, ...]]) -> None:
        now = self._robot.ros_now
        self._extras.record(self.topic, type, now, data)
        try:
            fields = read(data)
        except ValueError as error:
            self._log.warning(f"{self.topic}: {error}", throttle_duration_sec=WARN_EVERY)
            return
        linear, angular = fields[0], fields[5]
        if not (math.isfinite(linear) and math.isfinite(angular)):
            self._log.warning(
                f"{self.topic}: linear.x = {linear}, angular.z = {angular}: expected finite "
                "numbers; the robot takes it as a stop",
                throttle_duration_sec=WARN_EVERY,
            )
        self._robot.command(linear, angular)
        if self._extras.viewer:
            self._extras.viewer.command(linear, angular, now)
