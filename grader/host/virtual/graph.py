"""What a node sees when it looks at the graph: a robot, and not what listens for the judge.

The judge hears every topic. On a robot nobody subscribes to a topic of a student's own, so these
subscriptions are left out of all that rclpy tells of the graph.
"""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import rclpy.node
import rclpy.publisher
from rclpy.event_handler import QoSPublisherEventType
from rclpy.topic_endpoint_info import TopicEndpointInfo

from ..robot_ends import ROBOT_NODE

ROBOT_LISTENS = frozenset({"/cmd_vel"})
OURS = "/probe/"  # topics between programs of ours and the judge

Hears = Callable[[Any, str], bool]  # context, topic: the judge has a subscription of its own


def install(hears: Hears) -> None:
    """Take the judge's subscriptions out of the answers of rclpy."""

    def ears(context: Any, topic: str) -> int:
        shown = topic in ROBOT_LISTENS or topic.startswith(OURS)
        return 0 if shown else int(hears(context, topic))

    _install_counts(ears)
    _install_lists(ears)


def hide_match(publisher: Any) -> None:
    """Let a publisher's matched events leave out the judge's subscription, made just now."""
    if publisher.topic_name in ROBOT_LISTENS:
        return
    for handler in publisher.event_handlers:
        if handler.event_type == QoSPublisherEventType.RCL_PUBLISHER_MATCHED:
            handler.callback = _less_one(handler.callback)


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


def _install_counts(ears: Callable[[Any, str], int]) -> None:
    node: Any = rclpy.node.Node
    publisher: Any = rclpy.publisher.Publisher
    count_in_graph, count_of_publisher = node.count_subscribers, publisher.get_subscription_count
    create_publisher = node.create_publisher

    def count_subscribers(self: Any, topic_name: str) -> int:
        topic = rclpy.expand_topic_name.expand_topic_name(
            topic_name, self.get_name(), self.get_namespace()
        )
        return int(count_in_graph(self, topic_name)) - ears(self.context, topic)

    def get_subscription_count(self: Any) -> int:
        context = getattr(self, "_course_context", None)
        return int(count_of_publisher(self)) - ears(context, self.topic_name)

    def create(self: Any, *args: Any, **kwargs: Any) -> Any:
        made = create_publisher(self, *args, **kwargs)
        made._course_context = self.context
        return made

    node.count_subscribers, node.create_publisher = count_subscribers, create
    publisher.get_subscription_count = get_subscription_count


def _install_lists(ears: Callable[[Any, str], int]) -> None:
    node: Any = rclpy.node.Node
    infos, names = node.get_subscriptions_info_by_topic, node.get_subscriber_names_and_types_by_node

    def get_subscriptions_info_by_topic(
        self: Any, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        found: list[TopicEndpointInfo] = infos(self, topic_name, no_mangle)
        if not ears(self.context, self.resolve_topic_name(topic_name)):
            return found
        return [info for info in found if info.node_name != ROBOT_NODE]

    def get_subscriber_names_and_types_by_node(
        self: Any, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> list[tuple[str, list[str]]]:
        found: list[tuple[str, list[str]]] = names(self, node_name, node_namespace, no_demangle)
        if node_name != ROBOT_NODE:
            return found
        return [entry for entry in found if not ears(self.context, entry[0])]

    node.get_subscriptions_info_by_topic = get_subscriptions_info_by_topic
    node.get_subscriber_names_and_types_by_node = get_subscriber_names_and_types_by_node
