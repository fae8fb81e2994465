"""What a node sees of the graph: a robot and the programs that it has found, and no judge.

The judge hears every topic. On a robot nobody subscribes to a topic of a student's own, so these
subscriptions are left out of all that rclpy tells of the graph. And the robot's ends are only made
with those of a program; names and counts have them from when the robot is found, as on a robot.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import SimpleNamespace
from typing import Any

import rclpy.node
import rclpy.publisher
import rclpy.subscription
from rclpy.event_handler import QoSPublisherEventType, QoSSubscriptionEventType
from rclpy.expand_topic_name import expand_topic_name

from ..frames import Offer
from ..robot_ends import ROBOT_NODE, RobotEnds
from .discovery import ROBOT_LISTENS, Arrival, Discovery

MATE = {"publisher": "subscription", "subscription": "publisher"}
MATCHED = (
    QoSPublisherEventType.RCL_PUBLISHER_MATCHED,
    QoSSubscriptionEventType.RCL_SUBSCRIPTION_MATCHED,
)
COUNTS = {
    "count_publishers": "publisher",
    "count_subscribers": "subscription",
    "count_clients": "client",
    "count_services": "service",
}
INFOS = {
    "get_publishers_info_by_topic": "publisher",
    "get_subscriptions_info_by_topic": "subscription",
}
OF_NODE = {
    "get_publisher_names_and_types_by_node": "publisher",
    "get_subscriber_names_and_types_by_node": "subscription",
    "get_service_names_and_types_by_node": "service",
    "get_client_names_and_types_by_node": "client",
}

Ends = Callable[[Any], RobotEnds | None]  # the robot's in a context


def install(discovery: Discovery, ends_in: Ends, offers: Mapping[str, Offer]) -> None:
    """Take the judge's subscriptions, and what is not found yet, out of the answers of rclpy."""
    view = _View(discovery, ends_in, offers)
    for name, kind in COUNTS.items():
        _install_count(view, name, kind)
    _install_peers(view, rclpy.publisher.Publisher, "get_subscription_count", "subscription")
    _install_peers(view, rclpy.subscription.Subscription, "get_publisher_count", "publisher")
    for name, kind in INFOS.items():
        _install_infos(view, name, kind)
    for name, kind in OF_NODE.items():
        _install_names_of_node(view, name, kind)
    _install_names(view)


class _View:
    """Endpoints that exist and that programs must not see."""

    def __init__(self, discovery: Discovery, ends_in: Ends, offers: Mapping[str, Offer]) -> None:
        self.discovery = discovery
        self._ends_in = ends_in
        self._offers = offers

    def judge(self, kind: str, context: Any, topic: str) -> int:
        """Return how many ends of a topic the judge has of which a program knows nothing."""
        ends = self._ends_in(context)
        if ends is None or kind not in MATE:
            return 0
        is_robots = kind == "publisher" or topic in ROBOT_LISTENS
        if is_robots and self.discovery.knows_robot(context):
            return 0
        return int(ends.speaks(topic) if kind == "publisher" else ends.hears(topic))

    def unmade(self, kind: str, context: Any) -> dict[str, str]:
        """Return topics and types of the robot's ends that no program's has called for yet."""
        if kind not in MATE or not self._offers or not self.discovery.knows_robot(context):
            return {}  # without offers there is no robot
        ends = self._ends_in(context)
        if kind == "publisher":
            every, made = {o.topic: o.type for o in self._offers.values()}, ends and ends.speaks
        else:
            every, made = ROBOT_LISTENS, ends and ends.hears
        return {topic: type_ for topic, type_ in every.items() if not (made and made(topic))}

    def strangers(self, context: Any) -> set[tuple[str, str]]:
        """Return name and namespace of each node that is not found yet."""
        found = self.discovery.strangers(context)
        if not self.discovery.knows_robot(context):
            found.add((ROBOT_NODE, "/"))
        return found


def watch_matches(kind: str, node: Any, end: Any, discovery: Discovery) -> None:
    """Let matched events tell of ends when they are found, and not of the judge's."""

    def when_found(callback: Callable[[Any], Any], handler: Any) -> Callable[[Any], Any]:
        def tell(info: Any) -> Any:
            unseen = discovery.unseen(MATE[kind], end.topic_name, node.context, end)
            if discovery.knows_robot(node.context) and not unseen:
                return callback(info)

            async def tell_now() -> None:
                tell(info)

            discovery.when_calm(Arrival(node, handler, lambda _: tell_now))
            return None

        return tell

    for handler in end.event_handlers:
        if handler.event_type in MATCHED:
            hidden = kind == "publisher" and end.topic_name not in ROBOT_LISTENS
            callback = _less_one(handler.callback) if hidden else handler.callback
            handler.callback = when_found(callback, handler)


def _less_one(callback: Callable[[Any], Any]) -> Callable[[Any], Any]:
    told = 0  # subscriptions that the node knows of, the judge's left out

    def without_the_judge(info: Any) -> Any:
        nonlocal told
        total, current = info.total_count - 1, info.current_count - 1
        change, told = total - told, total
        if not change and info.current_count_change in (0, 1):
            return None  # it was only the judge's that matched
        return callback(
            SimpleNamespace(
                total_count=total,
                total_count_change=change,
                current_count=current,
                current_count_change=change or info.current_count_change,
            )
        )

    return without_the_judge


def _install_count(view: _View, name: str, kind: str) -> None:
    real = getattr(rclpy.node.Node, name)

    def count(self: Any, topic_name: str) -> int:
        topic = expand_topic_name(topic_name, self.get_name(), self.get_namespace())
        unseen = view.discovery.unseen(kind, topic, self.context)
        unseen += view.judge(kind, self.context, topic)
        return int(real(self, topic_name)) - unseen + (topic in view.unmade(kind, self.context))

    setattr(rclpy.node.Node, name, count)


def _install_peers(view: _View, cls: Any, name: str, kind: str) -> None:
    real = getattr(cls, name)

    def count(self: Any) -> int:
        found = int(real(self))
        party = self.__dict__.get("_course_party")
        if party is None or not found:
            return found
        unseen = view.discovery.unseen(kind, self.topic_name, party.context, self)
        return max(0, found - unseen - view.judge(kind, party.context, self.topic_name))

    setattr(cls, name, count)


def _install_infos(view: _View, name: str, kind: str) -> None:
    real = getattr(rclpy.node.Node, name)

    def infos(self: Any, topic_name: str, no_mangle: bool = False) -> list[Any]:
        found: list[Any] = real(self, topic_name, no_mangle)
        strangers = view.strangers(self.context)
        if view.judge(kind, self.context, self.resolve_topic_name(topic_name)):
            strangers.add((ROBOT_NODE, "/"))
        return [i for i in found if (i.node_name, i.node_namespace) not in strangers]

    setattr(rclpy.node.Node, name, infos)


def _install_names_of_node(view: _View, name: str, kind: str) -> None:
    real = getattr(rclpy.node.Node, name)

    def names(self: Any, node_name: str, node_namespace: str, *args: Any, **kwargs: Any) -> Any:
        if (node_name, node_namespace) in view.strangers(self.context):
            node_name = f"{node_name}_is_not_found"  # rclpy says that there is none
        found = real(self, node_name, node_namespace, *args, **kwargs)
        if node_name != ROBOT_NODE:
            return found
        return [entry for entry in found if not view.judge(kind, self.context, entry[0])]

    setattr(rclpy.node.Node, name, names)


def _install_names(view: _View) -> None:
    node: Any = rclpy.node.Node
    nodes, enclaves = (
        node.get_node_names_and_namespaces,
        node.get_node_names_and_namespaces_with_enclaves,
    )
    topics, services = node.get_topic_names_and_types, node.get_service_names_and_types

    def found_nodes(real: Any) -> Any:
        def names(self: Any) -> Any:
            strangers = view.strangers(self.context)
            return [entry for entry in real(self) if (entry[0], entry[1]) not in strangers]

        return names

    def found_names(real: Any, *kinds: str) -> Any:
        def names(self: Any, *args: Any, **kwargs: Any) -> Any:
            hidden = view.discovery.of_strangers(kinds, self.context)
            found = {e[0]: e for e in real(self, *args, **kwargs) if e[0] not in hidden}
            for kind in kinds:
                for topic, type_ in view.unmade(kind, self.context).items():
                    found.setdefault(topic, (topic, [type_]))
            return [found[topic] for topic in sorted(found)]

        return names

    node.get_node_names_and_namespaces = found_nodes(nodes)
    node.get_node_names_and_namespaces_with_enclaves = found_nodes(enclaves)
    node.get_node_names = lambda self: [n for n, _ in self.get_node_names_and_namespaces()]
    node.get_topic_names_and_types = found_names(topics, "publisher", "subscription")
    node.get_service_names_and_types = found_names(services, "service", "client")
