"""What the robot's node sends: the scenario's messages, /clock, diagnostics."""

import importlib
from collections.abc import Sequence
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock

from sim.live.diagnostics import diagnostics
from sim.live.extras import Extras
from sim.live.health import Health
from sim.live.robot import LiveRobot
from sim.messages import LATCHED, TF_MESSAGE, Message
from sim.sensors import OFFERED, SENSOR_TOPICS

DEPTH = 10
STATIC = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Sender:
    """The publishers of a robot's node.

    Parameters
    ----------
    node, robot
        The node, and the robot that it runs.
    extras
        Record and show what is sent.
    clock
        Send /clock.
    """

    def __init__(self, node: Any, robot: LiveRobot, extras: Extras, *, clock: bool) -> None:
        self._node, self._robot, self._extras = node, robot, extras
        self._publishers = {topic: self._publisher(topic) for topic in robot.rates}
        if extras.recorder:
            for topic, publisher in self._publishers.items():
                qos = publisher.qos_profile
                extras.recorder.expect(
                    publisher.topic_name,
                    OFFERED[topic],
                    reliable=qos.reliability == ReliabilityPolicy.RELIABLE,
                    latched=qos.durability == DurabilityPolicy.TRANSIENT_LOCAL,
                    depth=qos.depth,
                )
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", DEPTH)
        self._clock = node.create_publisher(Clock, "/clock", 1) if clock else None

    @property
    def awaited(self) -> list[str]:
        """The topics for whose first subscriber a robot can wait: its sensors', or else all."""
        sensors = [topic for topic in self._publishers if topic in SENSOR_TOPICS]
        return sensors or list(self._publishers)

    def is_heard(self) -> bool:
        """Say whether anybody subscribes to an awaited topic."""
        return any(self._publishers[topic].get_subscription_count() for topic in self.awaited)

    def send(self, messages: Sequence[Message]) -> None:
        """Send the robot's messages of now, after /clock."""
        self.tell_time()
        now = self._robot.ros_now
        for message in messages:
            publisher = self._publishers[message.topic]
            publisher.publish(message.data)
            self._extras.record(publisher.topic_name, message.type, now, message.data)
        if self._extras.viewer:
            simulation = self._robot.simulation
            self._extras.viewer.show(
                messages,
                layout=simulation.layout,
                radius=simulation.scenario.robot.radius,
                lidar=simulation.scenario.lidar,
                pose=simulation.pose,
                seconds=simulation.now / 1e9,
                time=now,
            )

    def tell_time(self) -> None:
        """Send /clock, if time is simulated."""
        if self._clock:
            self._send(self._clock, Clock(clock=_stamp(self._robot.ros_now)))

    def tell_health(self, health: Health) -> None:
        """Send /diagnostics."""
        message = diagnostics(
            health,
            stamp=self._robot.ros_now,
            name=self._node.get_name(),
            hardware=f"mock robot in {self._robot.simulation.scenario.name}",
            paused=not self._robot.timeline.running,
        )
        self._send(self._diagnostics, message)

    def _publisher(self, topic: str) -> Any:
        package, _, name = OFFERED[topic].partition("/msg/")
        kind = getattr(importlib.import_module(f"{package}.msg"), name)
        sensors = self._robot.simulation.scenario.qos.sensors
        lossy = topic in SENSOR_TOPICS and sensors == "sensor_data"
        reliability = ReliabilityPolicy.BEST_EFFORT if lossy else ReliabilityPolicy.RELIABLE
        qos = STATIC if topic in LATCHED else QoSProfile(depth=DEPTH, reliability=reliability)
        is_global = OFFERED[topic] == TF_MESSAGE  # the frames of all robots are one tree
        return self._node.create_publisher(
            kind, topic if is_global else topic.removeprefix("/"), qos
        )

    def _send(self, publisher: Any, message: Any) -> None:
        """Publish a message that the simulation did not make."""
        data = serialize_message(message)
        publisher.publish(data)
        package = type(message).__module__.partition(".")[0]
        name = f"{package}/msg/{type(message).__name__}"
        self._extras.record(publisher.topic_name, name, self._robot.ros_now, data)


def _stamp(time: int) -> Any:
    seconds, nanoseconds = divmod(time, 10**9)
    return Time(sec=seconds, nanosec=nanoseconds)
