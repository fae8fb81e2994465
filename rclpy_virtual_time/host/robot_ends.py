"""The robot's ends of topics in one DDS participant: it hears all and speaks as a robot does.

The robot's end of a topic is made right after the student's, never before: a participant accepts
one type per topic, and the wrong type must end in a real robot's silence, not in an exception in
the student's constructor.
"""

from __future__ import annotations

import bisect
from types import SimpleNamespace
from typing import Any, NamedTuple

import rclpy.node
from rclpy.parameter import Parameter
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

from .endpoints import type_name
from .frames import Offer

DEPTH = 5_000  # messages a subscription holds: more than MAX_PUBLISHED, and Fast DDS's most
ROBOT_DEPTH = 10
ROBOT_NODE = "mock_robot"
PARAMETER_EVENTS = "/parameter_events"


class Heard(NamedTuple):
    """One message of a student's node."""

    sent: int  # [ns] since 1970, of the real clock
    received: int
    topic: str
    type: str
    data: bytes  # CDR


class _RobotNode(rclpy.node.Node):  # type: ignore[misc]
    """A node that publishes no parameter events, because a student's node may come before it."""

    def create_publisher(self, msg_type: Any, topic: str, *args: Any, **kwargs: Any) -> Any:
        if topic == PARAMETER_EVENTS:
            return SimpleNamespace(publish=lambda event: None)
        return super().create_publisher(msg_type, topic, *args, **kwargs)


class RobotEnds:
    """Subscriptions to what students publish, publishers of what the robot offers."""

    def __init__(
        self, context: Any, offers: dict[str, Offer], latched: dict[str, bytes] | None = None
    ) -> None:
        self._offers = offers
        self._latched = {} if latched is None else latched  # what was sent once, by topic
        self._listeners: dict[str, tuple[str, Any, Any]] = {}
        self._speakers: dict[str, Any] = {}
        self.count = 0  # messages in the last `take`, also those that it may not hear
        self.unheard: list[Any] = []  # marks of what is not for it, in their order
        self._own_words: list[tuple[str, bytes]] = []  # that a listener will hear
        self.node = _RobotNode(
            ROBOT_NODE,
            context=context,
            use_global_arguments=False,
            start_parameter_services=False,
            enable_rosout=False,
            parameter_overrides=[Parameter("start_type_description_service", value=False)],
        )

    def listen(self, topic: str, msg_type: Any) -> None:
        """Hear a topic from now on."""
        if topic in self._listeners:
            return
        qos = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
        listener = self.node.create_subscription(msg_type, topic, lambda _: None, qos, raw=True)
        self._listeners[topic] = (type_name(msg_type), msg_type, listener)

    def hears(self, topic: str) -> bool:
        """Return whether the robot listens to a topic."""
        return topic in self._listeners

    def speak(self, topic: str, msg_type: Any, theirs: QoSProfile) -> str:
        """Serve a subscription; return why the robot can't reach it, if so."""
        offer = self._offers.get(topic)
        if offer is None:
            return ""
        if type_name(msg_type) != offer.type:
            return f"the robot publishes {offer.type}"
        reliability = (
            ReliabilityPolicy.RELIABLE if offer.reliable else ReliabilityPolicy.BEST_EFFORT
        )
        durability = DurabilityPolicy.VOLATILE
        if offer.latched:
            durability = DurabilityPolicy.TRANSIENT_LOCAL
            if theirs.durability != durability:  # as where the robot spoke before the node came
                return "the robot sends it once: only a transient-local subscription hears it"
        qos = QoSProfile(
            depth=ROBOT_DEPTH,
            reliability=reliability,
            durability=durability,
            liveliness=LivelinessPolicy.AUTOMATIC,  # as the driver's, and to be compared below
        )
        if topic not in self._speakers:
            self._speakers[topic] = self.node.create_publisher(msg_type, topic, qos)
            if topic in self._latched:
                self._say(topic, self._latched[topic])
        verdict, reason = qos_check_compatible(qos, theirs)
        if verdict != QoSCompatibility.ERROR:
            return ""
        said = [part.strip() for part in str(reason).split(";")]
        errors = [part.removeprefix("ERROR: ").lower() for part in said if part[:6] == "ERROR:"]
        return ", and ".join(errors)

    def speaks(self, topic: str) -> bool:
        """Return whether the robot has a publisher of a topic."""
        return topic in self._speakers

    def speaker(self, topic: str) -> Any:
        """Return the robot's publisher of a topic; None where it has none."""
        return self._speakers.get(topic)

    def take(self, most: int = 10**9) -> list[Heard]:
        """Return the messages heard after the last call, in the order in which they were sent.

        A node can publish as fast as this takes: after `most` messages the rest waits.
        """
        taken: list[Heard] = []
        self.count = 0
        for topic, (name, msg_type, listener) in self._listeners.items():
            while (
                len(taken) < most
                and (message := listener.handle.take_message(msg_type, True)) is not None
            ):
                data, info = message
                self.count += 1
                if (topic, data) in self._own_words:
                    self._own_words.remove((topic, data))
                    continue
                sent, received = info["source_timestamp"], info["received_timestamp"]
                if self._is_unheard(sent):
                    continue
                taken.append(Heard(sent, received, topic, name, data))
        self.unheard.clear()
        return sorted(taken, key=lambda heard: heard.sent)

    def _is_unheard(self, sent: int) -> bool:
        index = bisect.bisect_right(self.unheard, sent, key=lambda mark: mark.begin) - 1
        return index >= 0 and bool(sent <= self.unheard[index].end)

    def deliver(self, topic: str, data: bytes) -> None:
        """Publish a message of the robot; without an endpoint of the student's it is lost."""
        if topic in self._offers and self._offers[topic].latched:
            self._latched[topic] = data
        if topic in self._speakers:
            self._say(topic, data)

    def _say(self, topic: str, data: bytes) -> None:
        if topic in self._listeners:
            self._own_words.append((topic, data))
        self._speakers[topic].publish(data)

    def close(self) -> None:
        """Take all ends out of the graph."""
        self.node.destroy_node()
        self._listeners.clear()
        self._speakers.clear()

    def connections(self) -> dict[str, int]:
        """Return how many ends of others each end has found: by "kind topic" of theirs."""
        listening = {
            f"publisher {topic}": listener.get_publisher_count()
            for topic, (_, _, listener) in self._listeners.items()
        }
        speaking = {
            f"subscription {topic}": speaker.get_subscription_count()
            for topic, speaker in self._speakers.items()
        }
        return {**listening, **speaking}
