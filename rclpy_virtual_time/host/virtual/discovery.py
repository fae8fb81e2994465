"""When the ends of topics and services find each other: on DDS not at once.

All real ends here share one DDS participant, where they meet at once. For those of one program that
is so on a robot, too. What is sent before two ends of different programs have met is known by the
time at which DDS stamped it, and dropped when it is taken.

- A program is known to others some time after its first node. Only where the robot waits for it,
  before the scenario begins, it is known as soon as it waits for work.
- An end that is made later finds at once what others have; some are found late by the others.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import random
import re
import sys
from collections import Counter, deque
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import rclpy.client
import rclpy.publisher
import rclpy.service
from rclpy.exceptions import InvalidHandle
from rclpy.qos import DurabilityPolicy, QoSCompatibility, qos_check_compatible
from rclpy.task import Future

from .. import advice, frames
from ..endpoints import HIDDEN_TOPICS
from .clock import real_time_ns
from .kernel import Kernel

KINDS = {  # the list of a node that holds the ends of a kind
    "publisher": "_publishers",
    "subscription": "_subscriptions",
    "client": "_clients",
    "service": "_services",
}
MARKS = 1000  # that an end keeps of what it has missed
UNCOUNTED = re.compile(r"/_|/transition_event$")  # actions, introspection, lifecycle nodes
ROBOT_LISTENS = {"/cmd_vel": "geometry_msgs/msg/Twist"}
PORTABLE: Any = sys.modules.get("rclpy_portable.native.machine")


class Party:
    """A program as DDS sees it, a participant: it lasts as long as it has nodes."""

    def __init__(self, program: object, context: Any, known: int) -> None:
        self.program, self.context = program, context
        self.known = known  # [ns] when others have found it
        self.nodes: dict[Any, None] = {}  # in the order in which they were made
        self.met = False  # it is known, and `newcomers` has said so


class Missed(NamedTuple):
    """A span of messages that reached a subscription before it had found their publishers."""

    begin: int  # [ns] by the clock of the stamps
    end: int
    arrives: Callable[[], int] | None = None  # [ns] of virtual time; None: it is lost


class Arrival(NamedTuple):
    """Work for an executor that DDS knows nothing of."""

    node: Any
    entity: Any  # it has a callback group
    take: Callable[[Any], Any] | None = None  # as executors have it; None: the one for messages


arrivals: list[Arrival] = []
sent: Counter[str] = Counter()  # messages, requests and answers in this process, by name


class Discovery:
    """Which programs have found each other's endpoints."""

    def __init__(self, kernel: Kernel, times: frames.Discovery, seed: int) -> None:
        self._kernel = kernel
        self._times = times
        self._random = random.Random(f"discovery {seed}")
        self._parties: list[Party] = []
        self._settled = 0  # [ns] when all will have met

    @property
    def calm(self) -> bool:
        """All have met."""
        return self._kernel.now >= self._settled

    def note(self, kind: str, node: Any, end: Any) -> None:
        """Note an end that a program has made."""
        now = self._kernel.now
        party = self.party(node.context) or self._join(node.context)
        party.nodes[node] = None
        end._course_node, end._course_party, end._course_found = node, party, now
        of_topic = kind in ("publisher", "subscription")
        end._course_name = end.topic_name if of_topic else end.service_name
        if now <= 0 or now < party.known:
            return  # it is found together with its program
        if kind == "subscription" and _latched(end):
            end._course_found += self._draw(self._times.latched)
        elif kind in ("publisher", "service") and self._random.random() < self._times.late:
            end._course_found += self._draw(self._times.end)
        self._settled = max(self._settled, end._course_found)

    def waits(self) -> None:
        """A program waits for work; before the scenario begins, the robot waits for it."""
        if self._kernel.now > 0 or self.calm:
            return
        for party in self._parties:
            if party.program is self._kernel.program:
                party.known = min(party.known, self._kernel.now)
        self._settled = max(party.known for party in self._parties)

    def nodes(self) -> Iterator[Any]:
        """Yield the nodes of all programs, in the order in which they were made."""
        yield from (node for party in self._parties for node in party.nodes)

    def newcomers(self) -> Iterator[Party]:
        """Yield the programs that have become known, once each: their first nodes are made."""
        for party in self._parties:
            if not party.met and self._kernel.now > max(0, party.known):
                party.met = True
                yield party

    def leave(self, node: Any = None, context: Any = None) -> None:
        """Note that a node is gone, or a context with all its nodes."""
        for party in self._parties:
            party.nodes.pop(node, None)
        self._parties = [p for p in self._parties if p.nodes and p.context is not context]

    def party(self, context: Any) -> Party | None:
        """Return the running program's part in a context, if it has any."""
        for party in self._parties:
            if party.program is self._kernel.program and party.context is context:
                return party
        return None

    # --- which programs know each other ----------------------------------------------------------

    def knows_robot(self, context: Any) -> bool:
        """Return whether the running program has found the robot."""
        party = None if self.calm else self.party(context)
        return party is None or party.known <= self._kernel.now

    def unseen(self, kind: str, name: str, context: Any, mate: Any = None) -> int:
        """Return how many ends the running program has yet to find; `mate` can talk to them."""
        party = None if self.calm else self.party(context)
        if party is None:
            return 0
        ends = [e for e in self._ends(kind, name) if not self._sees(party, e)]
        return sum(mate is None or _compatible(mate, kind, end) for end in ends)

    def finds_server(self, client: Any) -> bool:
        """Return whether a client's program has found a server of its service.

        Servers that rclpy makes in C, of actions and of lifecycle nodes, are not known here: where
        there is no other, DDS says it.
        """
        ends = [] if self.calm else list(self._ends("service", _name(client)))
        return not ends or any(self._sees(client._course_party, end) for end in ends)

    def strangers(self, context: Any) -> set[tuple[str, str]]:
        """Return name and namespace of each node that the running program has yet to find."""
        party = None if self.calm else self.party(context)
        if party is None:
            return set()
        now = self._kernel.now
        hidden = (p for p in self._parties if p is not party and now < max(p.known, party.known))
        return {(node.get_name(), node.get_namespace()) for p in hidden for node in p.nodes}

    def of_strangers(self, kinds: tuple[str, ...], context: Any) -> set[str]:
        """Return the names of topics or services that only such nodes have."""
        hidden = self.strangers(context)
        names: tuple[set[str], set[str]] = (set(), set())
        for node in self.nodes() if hidden else ():
            found = names[(node.get_name(), node.get_namespace()) in hidden]
            found.update(_name(e) for kind in kinds for e in getattr(node, KINDS[kind]))
        return names[True] - names[False]

    def tell(self, kind: str, about: str, more: str = "") -> None:
        """Note something of a topic for a person."""
        self._kernel.world.note(frames.Note(kind, about, more=more))

    # --- what is sent ----------------------------------------------------------------------------

    def publish(self, publisher: Any, send: Callable[[], None], unheard: list[Missed]) -> None:
        """Send a message of a program to the programs that have found its publisher.

        `unheard` gets a mark of it if the robot is not among them. The judge reads what is latched
        as a program would that comes later; the robot listens for nothing latched.
        """
        party: Party = publisher._course_party
        latched, found, name = _latched(publisher), publisher._course_found, _name(publisher)
        mark = self._send(name, send, party, found, latched=latched)
        read = latched and name not in ROBOT_LISTENS
        if self._kernel.now < max(party.known, found) and not read:
            unheard.append(mark)
            own = any(end._course_party is party for end in self._ends("subscription", name))
            if not own and name not in HIDDEN_TOPICS:
                self.tell("lost", name)

    def deliver(self, topic: str, send: Callable[[], None], *, latched: bool) -> None:
        """Send a message of the robot to the subscriptions that it has found."""
        self._send(topic, send, Party(None, None, 0), 0, latched=latched)

    def _send(
        self, topic: str, send: Callable[[], None], party: Party, found: int, *, latched: bool
    ) -> Missed:
        begin = _stamp()
        send()
        mark = Missed(begin, _stamp())
        for subscription in self._ends("subscription", topic):
            met = _meeting(party, subscription, found)
            if subscription._course_party is not party and self._kernel.now < met():
                late = met if latched and _latched(subscription) else None
                _missed_by(subscription).append(mark._replace(arrives=late))
        return mark

    def hold_history(self, subscription: Any) -> None:
        """Keep back what was sent before a latched subscription, until it has met the senders."""
        party: Party = subscription._course_party
        ends = self._ends("publisher", _name(subscription))
        if not self.calm and not any(end._course_party is party for end in ends):
            met = _meeting(party, subscription, 0)
            _missed_by(subscription).append(Missed(0, _stamp(), met))

    def when_calm(self, work: Arrival) -> None:
        """Have an executor do something when all have met."""
        self._kernel.call_at(self._settled, lambda: arrivals.append(work))

    def _join(self, context: Any) -> Party:
        known = self._kernel.now + self._draw(self._times.program)
        party = Party(self._kernel.program, context, known)
        self._settled = max(self._settled, known)
        self._parties.append(party)
        return party

    def _draw(self, span: frames.Span) -> int:
        return self._random.randint(*span)

    def _ends(self, kind: str, name: str) -> Iterator[Any]:
        for node in self.nodes():
            yield from (end for end in getattr(node, KINDS[kind]) if _name(end) == name)

    def _sees(self, party: Party, end: Any) -> bool:
        other: Party = end._course_party
        met = max(party.known, other.known, end._course_found)
        return other is party or met <= self._kernel.now


def may_have_work(end: Any) -> bool:
    """Return whether something may wait for a subscription, client or service.

    All that is sent is counted, but for what rcl itself sends to names of its own, and answers
    that a program sends below `Service.send_response`.
    """
    own = end.__dict__
    if own.get("_pending_requests"):
        return True
    try:
        name = own.get("_course_key") or _key(end)
    except InvalidHandle:  # it has been destroyed
        return True
    return bool(own.get("_course_seen", -1) < sent[name]) or _is_uncounted(name)


@functools.lru_cache(maxsize=256)
def _is_uncounted(name: str) -> bool:
    return bool(UNCOUNTED.search(name))


def count_sent() -> None:
    """Count the messages sent, because `may_have_work` tells by their number."""
    for cls, name in (
        (rclpy.publisher.Publisher, "publish"),
        (rclpy.client.Client, "call_async"),
        (rclpy.service.Service, "send_response"),
    ):
        setattr(cls, name, _counting(getattr(cls, name)))


def _counting(send: Any) -> Any:
    @functools.wraps(send)
    def count_and_send(end: Any, *args: Any, **kwargs: Any) -> Any:
        sent[_key(end)] += 1
        return send(end, *args, **kwargs)

    return count_and_send


def has_no_work(end: Any) -> None:
    """Note that nothing waits for an entity; latched messages may come late."""
    if not _latched(end):
        end._course_seen = sent[_key(end)]


def is_plain(subscription: Any) -> bool:
    """Return whether all messages that a subscription got have reached its program."""
    own = subscription.__dict__
    return not (own.get("_course_missed") or own.get("_course_arrived"))


def take(kernel: Kernel, subscription: Any, *, raw: bool) -> Any:
    """Return the next message that has reached a subscription, and its info; None: no more."""
    if arrived := subscription.__dict__.get("_course_arrived"):
        return arrived.popleft()
    marks: deque[Missed] = subscription.__dict__.get("_course_missed") or deque()
    depth = subscription.qos_profile.depth or None  # 0: it keeps all
    while (taken := subscription.handle.take_message(subscription.msg_type, raw)) is not None:
        stamp = taken[1]["source_timestamp"]
        if marks and stamp > marks[-1].end:
            marks.clear()  # what they mark has been taken
        mark = next((mark for mark in marks if mark.begin <= stamp <= mark.end), None)
        if mark is None or (mark.arrives and mark.arrives() <= kernel.now):
            return taken
        if mark.arrives:
            held = subscription.__dict__.setdefault("_course_held", deque(maxlen=depth))
            if not held:
                kernel.call_at(mark.arrives(), functools.partial(_arrive, subscription, held))
            held.append(taken)
    return None


def _arrive(subscription: Any, held: deque[Any]) -> None:
    subscription.__dict__.setdefault("_course_arrived", deque()).extend(held)
    arrivals.extend(Arrival(subscription._course_node, subscription) for _ in held)
    held.clear()


def install(discovery: Discovery, unheard: Callable[[Any], list[Missed]]) -> None:
    """Put it under publishers and clients; `unheard` holds what the robot misses, by context."""
    publisher: Any = rclpy.publisher.Publisher
    client: Any = rclpy.client.Client
    publish, is_ready, call_async = publisher.publish, client.service_is_ready, client.call_async
    lost = itertools.count(1)

    def virtual_publish(self: Any, msg: Any) -> None:
        if "_course_looked" not in self.__dict__:  # at its first message
            self._course_looked = True
            with contextlib.suppress(Exception):  # of the message's own
                if said := advice.given.wrong_field(msg):
                    discovery.tell("type", _name(self), said)
        party = None if discovery.calm else self.__dict__.get("_course_party")
        if party is None or not party.context.ok():
            publish(self, msg)
        else:
            discovery.publish(self, lambda: publish(self, msg), unheard(party.context))

    def virtual_is_ready(self: Any) -> bool:
        return bool(is_ready(self)) and discovery.finds_server(self)

    @functools.wraps(call_async)
    def virtual_call_async(self: Any, request: Any) -> Any:
        if discovery.finds_server(self) or not isinstance(request, self.srv_type.Request):
            return call_async(self, request)
        future = Future()
        with self._lock:
            self._pending_requests[-next(lost)] = future
        future.add_done_callback(self.remove_pending_request)
        return future

    publisher.publish = virtual_publish
    client.service_is_ready, client.call_async = virtual_is_ready, virtual_call_async


def _meeting(party: Party, subscription: Any, found: int) -> Callable[[], int]:
    """Return what says when a program's publisher and a subscription have met [ns]."""
    other: Party = subscription._course_party
    return lambda: max(party.known, other.known, found, subscription._course_found)


def _missed_by(subscription: Any) -> deque[Missed]:
    missed: deque[Missed] = subscription.__dict__.setdefault("_course_missed", deque(maxlen=MARKS))
    return missed


def _name(end: Any) -> str:
    return str(end.__dict__.get("_course_name", ""))


def _key(end: Any) -> str:
    """Return the topic or service of any end, also of those that rclpy makes for itself."""
    key = end.__dict__.get("_course_key")
    if key is None:
        key = end._course_key = end.topic_name if hasattr(end, "topic_name") else end.service_name
    return str(key)


def _latched(end: Any) -> bool:
    return bool(end.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL)


def _compatible(mate: Any, kind: str, end: Any) -> bool:
    """Return whether a publisher and a subscription can talk; the latter has found the other."""
    offered, asked = (mate, end) if kind == "subscription" else (end, mate)
    verdict, _ = qos_check_compatible(offered.qos_profile, asked.qos_profile)
    return mate.msg_type is end.msg_type and verdict != QoSCompatibility.ERROR


def _stamp() -> int:
    """Return a stamp between those of messages that were published before and after [ns]."""
    return int(PORTABLE.stamps.next() if PORTABLE else real_time_ns())
