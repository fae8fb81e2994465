"""The host's ends of the student's topics: real DDS endpoints in the student's own participant.

Within a participant matching and delivery are synchronous, so what was published is there to be
taken at once, in the order of its source timestamps.
"""

from __future__ import annotations

import contextlib
import functools
import sys
import weakref
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import rclpy.context
import rclpy.node
from rclpy.duration import Duration
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy
from rclpy.subscription import Subscription

from .. import advice
from ..endpoints import ACTIONS, HIDDEN_TOPICS, EndpointWatch, is_parameter_service, report
from ..frames import (
    MAX_ENDPOINTS,
    MAX_PUBLISHED,
    MAX_PUBLISHED_BYTES,
    EndpointReport,
    Note,
    Offer,
    Published,
)
from ..robot_ends import Heard, RobotEnds
from . import discovery as found
from . import graph, parameter_files, tasks
from .kernel import Kernel
from .rosout import TOPIC as ROSOUT
from .rosout import Rosout

OFTEN = (
    f"the node published more than {MAX_PUBLISHED:,} messages at a time: does a loop publish "
    "without a pause? A timer, or time.sleep, gives it one"
)
LARGE = (
    f"the node published more than {MAX_PUBLISHED_BYTES >> 20} MiB at a time: messages as large as "
    "images have to be smaller here, or fewer"
)
TIMERS = 20  # of a node, at a time; as many again are reported, because they grow
HISTORY = Duration(seconds=2)  # of real time at most
LATCHED = DurabilityPolicy.TRANSIENT_LOCAL


class Bridge:
    """Hears all that the student's nodes publish and speaks for the robot."""

    def __init__(self, offers: tuple[Offer, ...], discovery: found.Discovery) -> None:
        self.discovery = discovery
        self.waits = discovery.waits
        self._offers = {offer.topic: offer for offer in offers}
        self._ends: dict[Any, RobotEnds] = {}  # by context
        self._latched: dict[str, bytes] = {}  # what the robot sent once, by topic
        self._latching: weakref.WeakSet[Any] = weakref.WeakSet()  # publishers with a history
        self._last_words: list[Heard] = []  # from contexts that have been shut down
        self.rosout: Rosout | None = None
        self.endpoints: list[EndpointReport] = []  # of which the judge does not know
        self._noted: list[Note] = []  # timers that are slow
        self.published: list[Published] = []
        self.changes = 0  # goes up when endpoints appear or disappear
        self.parameters_in_use = False  # some node asks for another's parameters
        self._bytes = 0  # of what is published
        self.overflow = ""  # what the node published more of than the link can carry

    def install(self) -> None:
        """Watch the student's nodes create their endpoints."""
        EndpointWatch(self._on_endpoint).install()
        graph.install(self.discovery, self._ends.get, self._offers)
        found.install(self.discovery, lambda context: self._ends_in(context).unheard)
        node_cls: Any = rclpy.node.Node
        node_cls.create_timer = self._counting_timers(node_cls.create_timer)
        node_cls.destroy_node = self._counting(node_cls.destroy_node)
        for end_cls in (Publisher, Subscription):  # also without the node, which spins on then
            end_cls.destroy = self._counting(end_cls.destroy)
        cls: Any = rclpy.context.Context
        for name in ("shutdown", "try_shutdown"):
            setattr(cls, name, self._leaving_first(getattr(cls, name)))

    def tell_rosout(self, now: Callable[[], Any], before: Callable[[], None]) -> None:
        """Let programs listen to what nodes log; `now` returns the ROS time.

        `before` is called before each line.
        """
        self.rosout = Rosout(now, lambda context: self._ends_in(context).node, before)
        self.rosout.install()

    def collect(self, now: int) -> int:
        """Take the messages that the student's nodes published by `now` [ns]; return how many."""
        self._keep(now, self._last_words)
        self._last_words = []
        taken = [heard for ends in self._ends.values() for heard in ends.take()]
        if len(self._ends) > 1:
            taken.sort(key=lambda heard: heard.sent)
        self._keep(now, taken)
        return sum(ends.count for ends in self._ends.values())

    def _keep(self, now: int, taken: list[Heard]) -> None:
        for heard in taken:
            self._bytes += len(heard.data) + len(heard.topic) + len(heard.type)
            if len(self.published) == MAX_PUBLISHED or self._bytes > MAX_PUBLISHED_BYTES:
                self.overflow = LARGE if self._bytes > MAX_PUBLISHED_BYTES else OFTEN
                return
            self.published.append(Published(now, heard.topic, heard.type, heard.data))

    def take(self) -> list[Published]:
        """Return the messages collected after the last call."""
        published, self.published, self._bytes = self.published, [], 0
        return published

    def deliver(self, topic: str, data: bytes) -> None:
        """Publish a message of the robot; without an endpoint of the student's it is lost."""
        if topic in self._offers and self._offers[topic].latched:
            self._latched[topic] = data
        if self.discovery.calm:
            self._send(topic, data)
            return
        latched = topic in self._latched
        self.discovery.deliver(topic, lambda: self._send(topic, data), latched=latched)

    def _send(self, topic: str, data: bytes) -> None:
        for ends in self._ends.values():
            ends.deliver(topic, data)

    def new_endpoints(self) -> list[EndpointReport]:
        """Return endpoints that the student created and that were not told of: a frame's worth."""
        new, self.endpoints = self.endpoints[:MAX_ENDPOINTS], self.endpoints[MAX_ENDPOINTS:]
        return new

    def notes(self, kernel: Kernel) -> Iterator[Note]:
        """Yield notes on callbacks and nodes, and once on each program's files."""
        yield from tasks.waits(kernel)
        noted, self._noted = self._noted, []
        yield from noted
        for party in self.discovery.newcomers():
            with contextlib.suppress(Exception):  # files and names are the student's: anything
                yield from list(_unread(party))
        for node in self.discovery.nodes():
            with contextlib.suppress(InvalidHandle):
                if node.get_clock().ros_time_is_active:
                    clock = "/clock" if node.count_publishers("/clock") else ""
                    yield Note("sim_time", node.get_fully_qualified_name(), count=0, more=clock)
            machine = node.__dict__.get("_state_machine")
            if isinstance(machine, rclpy_implementation.LifecycleStateMachine):
                with contextlib.suppress(Exception):  # as above
                    name, state = node.get_fully_qualified_name(), machine.current_state[1]
                    ends = node.__dict__.get("_managed_entities", ())
                    on = sum(getattr(each, "is_activated", False) is True for each in ends)
                    yield Note("lifecycle", name, count=on, more=state)

    def contexts(self) -> list[Any]:
        """Return the contexts in which there are ends of topics."""
        return list(self._ends)

    def _on_endpoint(self, kind: str, node: Any, endpoint: Any) -> None:
        if kind in ACTIONS:
            party = self.discovery.party(node.context)
            number = getattr(party and party.program, "number", 0)
            self.endpoints.append(report(kind, node, endpoint, process=number))
            return
        self.changes += 1
        self.discovery.note(kind, node, endpoint)
        mismatch = ""
        match kind:
            case "subscription" if endpoint.topic_name == ROSOUT and self.rosout:
                latched = endpoint.qos_profile.durability == LATCHED
                self.rosout.listened_to(node.context, latched)
                return
            case "publisher" | "subscription" if endpoint.topic_name in HIDDEN_TOPICS:
                return
            case "publisher":
                self._ends_in(node.context).listen(endpoint.topic_name, endpoint.msg_type)
                graph.watch_matches(kind, node, endpoint, self.discovery)
                if endpoint.qos_profile.durability == LATCHED:
                    self._latching.add(endpoint)
            case "subscription":
                mismatch = self._ends_in(node.context).speak(
                    endpoint.topic_name, endpoint.msg_type, endpoint.qos_profile
                )
                graph.watch_matches(kind, node, endpoint, self.discovery)
                if endpoint.qos_profile.durability == LATCHED:
                    endpoint._course_seen = 0  # what it takes counts: history comes late
                    self._await_history(endpoint.topic_name)
                    self.discovery.hold_history(endpoint)
            case "service":
                endpoint._course_parameters = is_parameter_service(endpoint.service_name)
                if endpoint._course_parameters:
                    return
            case "client":
                self.parameters_in_use |= is_parameter_service(endpoint.service_name)
        process = getattr(endpoint._course_party.program, "number", 0)
        self.endpoints.append(report(kind, node, endpoint, mismatch, process))

    def _await_history(self, topic: str) -> None:
        """Wait until a new subscription has the messages published before it.

        Only this DDS brings from a thread of its own, a moment later in real time: without the
        wait it would come at another virtual time in each run.
        """
        speakers = [ends.speaker(topic) for ends in self._ends.values()]
        for publisher in (*speakers, *self._latching):
            if publisher is not None and publisher.topic_name == topic:
                with contextlib.suppress(InvalidHandle):  # it was destroyed
                    publisher.wait_for_all_acked(HISTORY)

    def _ends_in(self, context: Any) -> RobotEnds:
        if context not in self._ends:
            self._ends[context] = RobotEnds(context, self._offers, self._latched)
        return self._ends[context]

    def _counting_timers(self, create: Any) -> Any:
        @functools.wraps(create)
        def create_and_count(node: Any, *args: Any, **kwargs: Any) -> Any:
            timer = create(node, *args, **kwargs)
            if timer.timer_period_ns >= tasks.SLEEP:
                name = node.get_fully_qualified_name()
                self._noted.append(Note("timer", name, count=0, lasted=timer.timer_period_ns))
            if TIMERS < len(list(node.timers)) <= 2 * TIMERS:
                owner = node.get_fully_qualified_name()
                self.endpoints.append(EndpointReport("timer", owner, "", ""))
            return timer

        return create_and_count

    def _counting(self, destroy: Any) -> Any:
        def destroy_and_count(each: Any) -> None:
            self.changes += 1
            if isinstance(each, rclpy.node.Node):
                self.discovery.leave(node=each)
            destroy(each)

        return destroy_and_count

    def _leaving_first(self, shutdown: Any) -> Any:
        """A context that is shut down takes the robot's ends with it; another may follow."""

        def leave_and_shutdown(context: Any) -> None:
            if self.rosout:
                self.rosout.leave(context)
            self.discovery.leave(context=context)
            ends = self._ends.pop(context, None)
            if ends is not None:
                self._last_words += ends.take()
                ends.close()
            shutdown(context)

        return leave_and_shutdown


def _unread(party: found.Party) -> Iterator[Note]:
    """Yield the parameters of a program's command line or files that no node reads."""
    start: Any = getattr(party.program, "start", None)  # of one program among several
    own = start.arguments if start else getattr(party.context, "_course_arguments", ())
    yield from parameter_files.unread(own, [n.get_fully_qualified_name() for n in party.nodes])
    file = Path(start.file if start else getattr(sys.modules["__main__"], "__file__", ""))
    if unused := advice.given.unused_imports(file.read_bytes()):
        yield Note("imports", ", ".join(unused), file.name)
