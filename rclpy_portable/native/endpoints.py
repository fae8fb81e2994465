"""Publishers and subscriptions. Delivery is synchronous: what is published is there to be taken."""

from __future__ import annotations

import itertools
from collections import deque
from typing import TYPE_CHECKING, Any, NamedTuple

from .. import cdr
from . import machine, names
from .arguments import TOPIC
from .enums import PolicyKind, PublisherEvent, SubscriptionEvent
from .errors import RCLError
from .events import KINDS, SUBSCRIPTION_KINDS, Statuses, Watch
from .graph import ros_type
from .handles import Destroyable
from .qos import BEST, KEEP_ALL, MANUAL_BY_TOPIC, TRANSIENT_LOCAL, rmw_qos_profile_t

if TYPE_CHECKING:
    from .node import Node

_gids = itertools.count(1)


class Sample(NamedTuple):
    """A message on its way."""

    data: bytes  # CDR
    sent: int  # [ns] since 1970
    number: int  # of its publisher, from 1
    expires: int | None  # [ns] since 1970


class End(Destroyable):
    """What publishers, subscriptions, services and clients have in common."""

    scheme = TOPIC

    def __init__(self, node: Node, cls: Any, name: str, qos: rmw_qos_profile_t | None) -> None:
        full = node.resolve(name, self.scheme)
        if problem := names.full_topic_name_problem(full):
            raise ValueError(f"invalid topic name '{name}': {problem[0]}")
        self.node = node
        self.participant = node.participant
        self.cls = cls
        self.topic = full
        self.profile = qos or rmw_qos_profile_t.predefined("default")
        self.gid = next(_gids)

    @property
    def wire(self) -> str:
        """Its name in DDS."""
        return f"rt{self.topic}"

    @property
    def type_name(self) -> str:
        """The ROS name of its type."""
        return ros_type(self.cls)

    def get_topic_name(self) -> str:
        """Return the full name of the topic."""
        return self.topic

    def get_logger_name(self) -> str:
        """Return the name of the node's logger."""
        return self.node.logger_name()


class Publisher(End):
    """A publisher; it keeps messages for those who come later if its durability says so."""

    def __init__(self, node: Node, cls: Any, topic: str, qos: rmw_qos_profile_t | None) -> None:
        super().__init__(node, cls, topic, qos)
        self.participant.claim(self.wire, cls, "publisher")
        self.peers: list[Subscription] = []
        self.statuses = Statuses(KINDS)
        resolved = self.profile.resolved()
        self.kept: deque[Sample] | None = None
        if resolved.durability == TRANSIENT_LOCAL:
            most = None if resolved.history == KEEP_ALL else resolved.depth or 1
            self.kept = deque(maxlen=most)
        self._lifespan = resolved.lifespan if resolved.lifespan < BEST else None
        self._numbers = itertools.count(1)
        self._lease: Watch | None = None
        self._deadline: Watch | None = None
        if resolved.deadline < BEST:
            missed = PublisherEvent.RCL_PUBLISHER_OFFERED_DEADLINE_MISSED
            self._deadline = Watch(resolved.deadline, lambda n: self.statuses.note(missed, n))
        lease = resolved.liveliness_lease_duration
        if resolved.liveliness == MANUAL_BY_TOPIC and lease < BEST:
            self._lease = Watch(lease, lambda _: self._die(), once=True)
        self.watches = [watch for watch in (self._deadline, self._lease) if watch]
        self.alive = self._lease is None
        self.participant.introduce_publisher(self)

    def publish(self, message: Any) -> None:
        """Send a message."""
        self.publish_raw(cdr.serialize(message))

    def publish_raw(self, data: bytes) -> None:
        """Send a message that is serialized already; RCLError if its context is shut down."""
        if not self.participant.alive:
            raise RCLError("Failed to publish: publisher's context is invalid")
        sent = machine.stamps.next()
        expires = None if self._lifespan is None else sent + self._lifespan
        sample = Sample(bytes(data), sent, next(self._numbers), expires)
        if self.kept is not None:
            self.kept.append(sample)
        if self.watches:
            if self._deadline:
                self._deadline.feed()
            self.assert_liveliness()
        for subscription in self.peers:
            subscription.hear(sample)
        machine.changed()

    def assert_liveliness(self) -> None:
        """Say that the publisher is alive."""
        if self._lease is not None:
            self._lease.feed()
            if not self.alive:
                self.alive = True
                for subscription in self.peers:
                    subscription.note_liveliness(alive=1, not_alive=0)

    def get_subscription_count(self) -> int:
        """Return how many subscriptions it has found."""
        return len(self.peers)

    def wait_for_all_acked(self, _timeout: Any) -> bool:
        """Delivery is synchronous."""
        return True

    def note(self, kind: PublisherEvent, policy: PolicyKind | None = None) -> None:
        """Note an event."""
        self.statuses.note(kind, **({} if policy is None else {"last_policy_kind": policy}))

    def gain(self, subscription: Subscription) -> None:
        """Have found a subscription, which gets what was kept for it."""
        self.peers.append(subscription)
        self._note_match(1)
        if self.kept and subscription.profile.resolved().durability == TRANSIENT_LOCAL:
            for sample in self.kept:
                subscription.hear(sample)

    def lose(self, subscription: Subscription) -> None:
        """Have lost a subscription."""
        if subscription in self.peers:
            self.peers.remove(subscription)
            self._note_match(-1)

    def _note_match(self, change: int) -> None:
        self.statuses.note(
            PublisherEvent.RCL_PUBLISHER_MATCHED,
            max(change, 0),
            current_count=len(self.peers),
            current_count_change=change,
        )

    def _die(self) -> None:
        self.alive = False
        self.statuses.note(PublisherEvent.RCL_PUBLISHER_LIVELINESS_LOST)
        for subscription in self.peers:
            subscription.note_liveliness(alive=-1, not_alive=1)

    def _destroy(self) -> None:
        self.participant.forget_publisher(self)


class Subscription(End):
    """A subscription, with the messages that wait to be taken."""

    def __init__(self, node: Node, cls: Any, topic: str, qos: rmw_qos_profile_t | None) -> None:
        super().__init__(node, cls, topic, qos)
        self.participant.claim(self.wire, cls, "subscription")
        self.peers: list[Publisher] = []
        self.statuses = Statuses(SUBSCRIPTION_KINDS)
        resolved = self.profile.resolved()
        most = None if resolved.history == KEEP_ALL else resolved.depth or 1
        self.queue: deque[Sample] = deque(maxlen=most)
        self.watches: list[Watch] = []
        if resolved.deadline < BEST:
            missed = SubscriptionEvent.RCL_SUBSCRIPTION_REQUESTED_DEADLINE_MISSED
            self.watches.append(Watch(resolved.deadline, lambda n: self.statuses.note(missed, n)))
        self.participant.introduce_subscription(self)

    @property
    def ready(self) -> bool:
        """There is a message to take."""
        return bool(self.queue)

    def hear(self, sample: Sample) -> None:
        """Take in a message."""
        self.queue.append(sample)
        for watch in self.watches:
            watch.feed()

    def take_message(self, cls: Any, raw: bool) -> tuple[Any, dict[str, int | None]] | None:
        """Return the oldest message and what is known of it; None if there is none."""
        while self.queue:
            sample = self.queue.popleft()
            if sample.expires is not None and sample.expires < machine.wall_ns():
                continue
            info = {
                "source_timestamp": sample.sent,
                "received_timestamp": sample.sent,
                "publication_sequence_number": sample.number,
                "reception_sequence_number": None,
            }
            return (sample.data if raw else cdr.deserialize(sample.data, cls)), info
        return None

    def get_publisher_count(self) -> int:
        """Return how many publishers it has found."""
        return len(self.peers)

    def note(self, kind: SubscriptionEvent, policy: PolicyKind | None = None) -> None:
        """Note an event."""
        self.statuses.note(kind, **({} if policy is None else {"last_policy_kind": policy}))

    def note_liveliness(self, *, alive: int, not_alive: int) -> None:
        """Note that publishers have come to life, or died."""
        living = sum(peer.alive for peer in self.peers)
        self.statuses.note(
            SubscriptionEvent.RCL_SUBSCRIPTION_LIVELINESS_CHANGED,
            alive_count=living,
            not_alive_count=len(self.peers) - living,
            alive_count_change=alive,
            not_alive_count_change=not_alive,
        )

    def gain(self, publisher: Publisher) -> None:
        """Have found a publisher."""
        self.peers.append(publisher)
        self._note_match(1)
        if publisher.alive:
            self.note_liveliness(alive=1, not_alive=0)

    def lose(self, publisher: Publisher) -> None:
        """Have lost a publisher."""
        if publisher in self.peers:
            self.peers.remove(publisher)
            self._note_match(-1)
            self.note_liveliness(alive=-publisher.alive, not_alive=publisher.alive - 1)

    def _note_match(self, change: int) -> None:
        self.statuses.note(
            SubscriptionEvent.RCL_SUBSCRIPTION_MATCHED,
            max(change, 0),
            current_count=len(self.peers),
            current_count_change=change,
        )

    def _destroy(self) -> None:
        self.participant.forget_subscription(self)
