"""The robot's radio: its ends of topics on DDS, in real time, in a process of their own.

It knows nothing of the robot: the judge says what to send, and hears what came and when.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import select
from typing import Any

import msgspec
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from ..frames import (
    MAX_PUBLISHED,
    MAX_PUBLISHED_BYTES,
    EndpointReport,
    HeardNow,
    Meet,
    Published,
    Transmit,
    Tuned,
    TuneIn,
)
from ..robot_ends import Heard, RobotEnds
from ..wire import Wire

TRANSIT_NS = 25_000_000  # [ns] that a message may have been under way
LOOK = 2.0  # [ms] between looks for messages; they carry the time at which they were sent
PACKAGES = {  # of which students publish messages; nothing else is imported
    "actionlib_msgs",
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "nav_msgs",
    "sensor_msgs",
    "shape_msgs",
    "std_msgs",
    "stereo_msgs",
    "tf2_msgs",
    "trajectory_msgs",
    "visualization_msgs",
}


class Radio:
    """Sends and hears for the judge."""

    def __init__(self, wire: Wire, order: TuneIn) -> None:
        self._wire = wire
        os.environ["ROS_DOMAIN_ID"] = str(order.domain)
        rclpy.init(args=[])
        offers = {offer.topic: offer for offer in order.offers}
        self._ends = RobotEnds(rclpy.get_default_context(), offers)
        self._connected: dict[str, int] = {}
        self._begun = False

    def serve(self) -> None:
        """Go on until the judge is gone; never returns."""
        self._wire.send(Tuned([], {}))
        poll = select.poll()
        poll.register(self._wire.read_fd, select.POLLIN)
        while True:
            if poll.poll(LOOK):
                self._obey()
            self._tell_what_was_heard()
            self._tell_who_is_there([])

    def _obey(self) -> None:
        match self._wire.receive():
            case Transmit() as order:
                self._begun = True
                for delivery in order.deliver:
                    self._ends.deliver(delivery.topic, delivery.data)
            case Meet() as order:
                self._tell_who_is_there([self._meet(end) for end in order.endpoints])
            case other:
                raise ValueError(f"{type(other).__name__} is not for a radio")

    def _meet(self, end: EndpointReport) -> EndpointReport:
        """Make the robot's end for one of a node; note why the two can't talk, if so."""
        mismatch = ""
        ros_type = message_class(end.type)
        if ros_type is not None:
            # a participant takes one type per topic; a second endpoint of another type is unheard
            with contextlib.suppress(Exception):
                if end.kind == "publisher":
                    self._ends.listen(end.topic, ros_type)
                elif end.kind == "subscription":
                    mismatch = self._ends.speak(end.topic, ros_type, _profile(end))
        return msgspec.structs.replace(end, mismatch=mismatch)

    def _tell_what_was_heard(self) -> None:
        heard = [
            Published(_moment(message, self._begun), message.topic, message.type, message.data)
            for message in self._ends.take(MAX_PUBLISHED)
        ]
        while heard:
            count, size = 0, 0
            while count < min(len(heard), MAX_PUBLISHED) and size < MAX_PUBLISHED_BYTES:
                size += len(heard[count].data) + len(heard[count].topic)
                count += 1
            self._wire.send(HeardNow(heard[:count]))
            heard = heard[count:]

    def _tell_who_is_there(self, endpoints: list[EndpointReport]) -> None:
        connected = self._ends.connections()
        if endpoints or connected != self._connected:
            self._connected = connected
            self._wire.send(Tuned(endpoints, connected))


def message_class(name: str) -> Any:
    """Return the class of a message type of the common interfaces; None for any other."""
    package, _, rest = name.partition("/msg/")
    if package not in PACKAGES:
        return None
    return getattr(importlib.import_module(f"{package}.msg"), rest, None)


def _moment(message: Heard, begun: bool) -> int:
    """Return when a message was sent [ns].

    The sender's stamp counts, which no delay of this process can falsify. Since time has `begun` it
    counts within limits: it is the student's process that sets it.
    """
    earliest = message.received - TRANSIT_NS if begun else 0
    return max(min(message.sent, message.received), earliest)


def _profile(end: EndpointReport) -> QoSProfile:
    with contextlib.suppress(KeyError):
        return QoSProfile(
            depth=1,
            reliability=ReliabilityPolicy[end.reliability.upper()],
            durability=DurabilityPolicy[end.durability.upper()],
        )
    return QoSProfile(depth=1)
