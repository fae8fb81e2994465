"""The host's ends of the student's topics: real DDS endpoints in the student's own participant.

The bridge's end of a topic is made right after the student's, never before: a participant accepts
one type per topic, and the wrong type must end in a real robot's silence, not in an exception in
the student's constructor. Within a participant matching and delivery are synchronous, so what was
published is there to be taken at once, in the order of its source timestamps.
"""

from __future__ import annotations

from typing import Any

import rclpy.node
from rclpy.qos import (
    QoSCompatibility,
    QoSProfile,
    ReliabilityPolicy,
    qos_check_compatible,
)

from .frames import MAX_PUBLISHED, MAX_PUBLISHED_BYTES, EndpointReport, Offer, Published

DEPTH = 5_000  # messages a subscription holds: more than MAX_PUBLISHED, and Fast DDS's most
ROBOT_DEPTH = 10
ROBOT_NODE = "_mock_robot"
HIDDEN_TOPICS = {"/parameter_events", "/rosout", "/clock"}
PARAMETER_SERVICES = (
    "/describe_parameters",
    "/get_parameter_types",
    "/get_parameters",
    "/list_parameters",
    "/set_parameters",
    "/set_parameters_atomically",
    "/get_type_description",
)


class Bridge:
    """Hears all that the student's nodes publish and speaks for the robot."""

    def __init__(self, offers: tuple[Offer, ...]) -> None:
        self._offers = {offer.topic: offer for offer in offers}
        self._inside = False  # the bridge itself creates an endpoint just now
        self._nodes: dict[int, Any] = {}  # by context
        self._listeners: dict[tuple[int, str], tuple[str, Any, Any]] = {}
        self._speakers: dict[tuple[int, str], Any] = {}
        self._endpoints: list[EndpointReport] = []
        self.published: list[Published] = []
        self.changes = 0  # goes up when endpoints appear
        self.parameters_in_use = False  # some node asks for another's parameters
        self._bytes = 0  # of what is published
        self.overflow = False  # the node published more than the link can carry

    def install(self) -> None:
        """Watch the student's nodes create their endpoints."""
        self._watch("create_publisher", self._on_publisher)
        self._watch("create_subscription", self._on_subscription)
        self._watch("create_service", self._on_service)
        self._watch("create_client", self._on_client)

    def collect(self, now: int) -> None:
        """Take what the student's nodes published; it gets the time `now` [ns]."""
        taken: list[tuple[int, str, str, bytes]] = []
        for (_, topic), (type_name, msg_type, handle) in self._listeners.items():
            while (message := handle.take_message(msg_type, True)) is not None:
                data, info = message
                taken.append((info["source_timestamp"], topic, type_name, data))
        taken.sort(key=lambda item: item[0])
        for _, topic, type_name, data in taken:
            self._bytes += len(data) + len(topic) + len(type_name)
            if len(self.published) == MAX_PUBLISHED or self._bytes > MAX_PUBLISHED_BYTES:
                self.overflow = True
                return
            self.published.append(Published(now, topic, type_name, data))

    def take(self) -> list[Published]:
        """Return what was collected since the last call."""
        published, self.published, self._bytes = self.published, [], 0
        return published

    def deliver(self, topic: str, data: bytes) -> None:
        """Publish a message of the robot; nobody hears it where the student has no end."""
        for (_, name), speaker in self._speakers.items():
            if name == topic:
                speaker.publish(data)

    def new_endpoints(self) -> list[EndpointReport]:
        """Return the endpoints that the student created since the last call."""
        endpoints, self._endpoints = self._endpoints, []
        return endpoints

    # --- endpoints of the student ----------------------------------------------------------------

    def _watch(self, method: str, react: Any) -> None:
        cls: Any = rclpy.node.Node
        create = getattr(cls, method)

        def watched(node: Any, *args: Any, **kwargs: Any) -> Any:
            endpoint = create(node, *args, **kwargs)
            if not self._inside:
                self._inside = True
                try:
                    react(node, endpoint)
                finally:
                    self._inside = False
                    self.changes += 1
            return endpoint

        watched.__name__, watched.__doc__ = method, create.__doc__
        setattr(cls, method, watched)

    def _on_publisher(self, node: Any, publisher: Any) -> None:
        topic = publisher.topic_name
        if topic in HIDDEN_TOPICS:
            return
        self._listen(node.context, topic, publisher.msg_type)
        self._report("publisher", node, topic, publisher.msg_type, publisher.qos_profile)

    def _on_subscription(self, node: Any, subscription: Any) -> None:
        topic = subscription.topic_name
        if topic in HIDDEN_TOPICS:
            return
        mismatch = self._speak(node.context, topic, subscription)
        qos = subscription.qos_profile
        self._report("subscription", node, topic, subscription.msg_type, qos, mismatch)

    def _on_service(self, node: Any, service: Any) -> None:
        name = service.service_name
        service._course_parameters = is_parameter_service(name)
        if not service._course_parameters:
            self._report("service", node, name, service.srv_type)

    def _on_client(self, node: Any, client: Any) -> None:
        self.parameters_in_use |= is_parameter_service(client.service_name)
        self._report("client", node, client.service_name, client.srv_type)

    def _report(
        self, kind: str, node: Any, topic: str, ros_type: Any, qos: Any = None, mismatch: str = ""
    ) -> None:
        self._endpoints.append(
            EndpointReport(
                kind,
                node.get_fully_qualified_name(),
                topic,
                type_name(ros_type, "srv" if kind in ("service", "client") else "msg"),
                qos.reliability.name.lower() if qos else "",
                qos.durability.name.lower() if qos else "",
                qos.depth if qos else 0,
                mismatch,
            )
        )

    # --- the bridge's own ends -------------------------------------------------------------------

    def _node(self, context: Any) -> Any:
        key = id(context)
        if key not in self._nodes:
            self._nodes[key] = rclpy.node.Node(
                ROBOT_NODE,
                context=context,
                use_global_arguments=False,
                start_parameter_services=False,
                enable_rosout=False,
            )
        return self._nodes[key]

    def _listen(self, context: Any, topic: str, msg_type: Any) -> None:
        key = (id(context), topic)
        if key in self._listeners:
            return
        qos = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
        listener = self._node(context).create_subscription(
            msg_type, topic, lambda _: None, qos, raw=True
        )
        self._listeners[key] = (type_name(msg_type, "msg"), msg_type, listener.handle)

    def _speak(self, context: Any, topic: str, subscription: Any) -> str:
        """Create the robot's publisher; return why it can't reach this subscription, if so."""
        offer = self._offers.get(topic)
        if offer is None:
            return ""
        if type_name(subscription.msg_type, "msg") != offer.type:
            return f"the robot publishes {offer.type}"
        reliability = (
            ReliabilityPolicy.RELIABLE if offer.reliable else ReliabilityPolicy.BEST_EFFORT
        )
        qos = QoSProfile(depth=ROBOT_DEPTH, reliability=reliability)
        key = (id(context), topic)
        if key not in self._speakers:
            node = self._node(context)
            self._speakers[key] = node.create_publisher(subscription.msg_type, topic, qos)
        verdict, reason = qos_check_compatible(qos, subscription.qos_profile)
        if verdict != QoSCompatibility.ERROR:
            return ""
        return str(reason).removeprefix("ERROR: ").rstrip("; ").lower()


def is_parameter_service(name: str) -> bool:
    """Tell whether it is one of the services that every node has."""
    return name.endswith(PARAMETER_SERVICES)


def type_name(ros_type: Any, kind: str) -> str:
    """Return the ROS name of a generated class: geometry_msgs/msg/Twist."""
    return f"{ros_type.__module__.split('.')[0]}/{kind}/{ros_type.__name__}"
