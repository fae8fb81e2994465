"""Who speaks and listens: the participants of one domain, their nodes and endpoints.

A context is a DDS participant. Within it a topic has one type; between participants endpoints of
another type don't find each other. With ROS_AUTOMATIC_DISCOVERY_RANGE=OFF no participants do.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeVar

from .enums import PublisherEvent, SubscriptionEvent
from .errors import RCLError
from .qos import conflicts

if TYPE_CHECKING:
    from .endpoints import Publisher, Subscription
    from .node import Node
    from .services import Client, Service

T = TypeVar("T")


class Participant:
    """What one context has in the graph."""

    def __init__(self, domain: int) -> None:
        self.nodes: list[Node] = []
        self.publishers: list[Publisher] = []
        self.subscriptions: list[Subscription] = []
        self.services: list[Service] = []
        self.clients: list[Client] = []
        self._types: dict[str, tuple[Any, int]] = {}  # by name on the wire: class, how many ends
        self.alive = True
        self._domain = _domain(domain)
        self._domain.append(self)

    def leave(self) -> None:
        """Be nobody's peer any more: the context is shut down."""
        self.alive = False
        for end in (*self.publishers, *self.subscriptions):
            _part(end)
        if self in self._domain:
            self._domain.remove(self)

    def everybody(self) -> list[Participant]:
        """Return all participants that can be found, this one first."""
        return [self, *(other for other in self._domain if other is not self)]

    def all_nodes(self) -> Iterator[Node]:
        """Return the nodes of all participants."""
        return itertools.chain.from_iterable(p.nodes for p in self.everybody())

    def all_publishers(self) -> list[Publisher]:
        """Return the publishers of all participants."""
        return [end for p in self.everybody() for end in p.publishers]

    def all_subscriptions(self) -> list[Subscription]:
        """Return the subscriptions of all participants."""
        return [end for p in self.everybody() for end in p.subscriptions]

    def all_services(self) -> list[Service]:
        """Return the services of all participants."""
        return [end for p in self.everybody() for end in p.services]

    def all_clients(self) -> list[Client]:
        """Return the clients of all participants."""
        return [end for p in self.everybody() for end in p.clients]

    def claim(self, wire: str, cls: Any, what: str, noun: str = "topic") -> None:
        """Note that one more end of a kind has this type under a name on the wire.

        Raises RCLError: the name has another type in this participant.
        """
        kind, count = self._types.get(wire, (cls, 0))
        if kind is not cls:
            raise RCLError(
                f"Failed to create {what}: create_{what}() called for existing {noun} name "
                f"{wire} with incompatible type {dds_type(cls)}"
            )
        self._types[wire] = (cls, count + 1)

    def release(self, wire: str) -> None:
        """Note that one end less has this name."""
        kind, count = self._types[wire]
        if count > 1:
            self._types[wire] = (kind, count - 1)
        else:
            del self._types[wire]

    def introduce_publisher(self, publisher: Publisher) -> None:
        """Let a publisher meet the subscriptions to its topic."""
        self.publishers.append(publisher)
        for subscription in self.all_subscriptions():
            if subscription.topic == publisher.topic:
                _meet(publisher, subscription)

    def introduce_subscription(self, subscription: Subscription) -> None:
        """Let a subscription meet the publishers of its topic."""
        self.subscriptions.append(subscription)
        for publisher in self.all_publishers():
            if publisher.topic == subscription.topic:
                _meet(publisher, subscription)

    def forget_publisher(self, publisher: Publisher) -> None:
        """Take a publisher out of the graph."""
        self.publishers.remove(publisher)
        _part(publisher)
        self.release(publisher.wire)

    def forget_subscription(self, subscription: Subscription) -> None:
        """Take a subscription out of the graph."""
        self.subscriptions.remove(subscription)
        _part(subscription)
        self.release(subscription.wire)


_domains: dict[int, list[Participant]] = {}


def _domain(number: int) -> list[Participant]:
    if os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE") == "OFF":
        return []
    return _domains.setdefault(number, [])


def _meet(publisher: Publisher, subscription: Subscription) -> None:
    if publisher.cls is not subscription.cls:
        publisher.note(PublisherEvent.RCL_PUBLISHER_INCOMPATIBLE_TYPE)
        subscription.note(SubscriptionEvent.RCL_SUBSCRIPTION_INCOMPATIBLE_TYPE)
        return
    if found := conflicts(publisher.profile.resolved(), subscription.profile.resolved()):
        policy = found[0][0]
        publisher.note(PublisherEvent.RCL_PUBLISHER_OFFERED_INCOMPATIBLE_QOS, policy)
        subscription.note(SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_INCOMPATIBLE_QOS, policy)
        return
    publisher.gain(subscription)
    subscription.gain(publisher)


def _part(end: Any) -> None:
    for peer in list(end.peers):
        peer.lose(end)
        end.lose(peer)


def ros_type(cls: Any) -> str:
    """Return the ROS name of a generated class: geometry_msgs/msg/Twist."""
    # also of a class of the program's own that is derived from a generated one
    made = [each for each in cls.__mro__ if type(each) is type(cls)][-1]
    package, kind = made.__module__.split(".")[:2]
    return f"{package}/{kind}/{made.__name__}"


def dds_type(cls: Any) -> str:
    """Return the name that DDS has for a generated class."""
    package, kind, name = ros_type(cls).split("/")
    return f"{package}::{kind}::dds_::{name}_"
