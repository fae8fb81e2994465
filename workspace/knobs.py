"""What a person can turn in a drive: the parameters that its nodes have declared."""

from __future__ import annotations

import contextlib
import json
from collections import defaultdict
from collections.abc import Callable
from typing import Any

from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_service import ParameterService

from grader.recording import Recording
from grader.recording.hands import deeds
from rclpy_portable.native.endpoints import Publisher
from sim.messages import decode

EVENTS = "/parameter_events", "rcl_interfaces/msg/ParameterEvent"
ROS_OWN = ("use_sim_time", "qos_overrides.", "start_type_description_service")


class Knobs:
    """Notes what nodes declare, and each value that a parameter gets, for good: make it once."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._declared: dict[str, dict[str, Any]] = {}  # descriptors by their names, by node
        self._events: list[tuple[float, bytes]] = []
        begin, send = ParameterService.__init__, Publisher.publish_raw

        def begun(service: Any, node: Any) -> None:
            self._declared[node.get_fully_qualified_name()] = node._descriptors
            begin(service, node)

        def sent(publisher: Any, data: bytes) -> None:
            if (publisher.topic, publisher.type_name) == EVENTS:
                self._events.append((now(), data))
            send(publisher, data)

        ParameterService.__init__, Publisher.publish_raw = begun, sent

    def of(self, recording: Recording) -> dict[str, Any]:
        """Return the `knobs`, what the programs `hear`, and what was `done`, for JSON.

        A knob has the texts of its values, each with its time.
        """
        values: defaultdict[tuple[str, str], list[tuple[float, str]]] = defaultdict(list)
        for time, data in self._events:
            with contextlib.suppress(ValueError):  # bytes that a node sent itself
                event = decode(data, EVENTS[1])
                for each in (*event.new_parameters, *event.changed_parameters):
                    values[event.node, each.name].append((time, _text(each.value)))
        knobs = [
            _knob(about) | {"node": node, "values": values[node, name]}
            for node in dict.fromkeys(end.node for end in recording.ends)
            for name, about in self._declared.get(node, {}).items()
            if not name.startswith(ROS_OWN)
        ]
        hears = [end.topic for end in recording.ends if end.kind == "subscription"]
        done = [deed._asdict() for deed in deeds(recording)]
        return {"knobs": knobs, "hears": hears, "done": done}


def _knob(about: Any) -> dict[str, Any]:
    kind = Parameter.Type(about.type).name.lower()
    ranges = {"double": about.floating_point_range, "integer": about.integer_range}
    spans = ((each.from_value, each.to_value, each.step) for each in ranges.get(kind, ()))
    return {"name": about.name, "kind": kind, "about": about.description,
            "limits": list(map(str, next(spans, ()))), "fixed": about.read_only}  # fmt: skip


def _text(value: Any) -> str:
    """Return a value as the command line takes it."""
    found = parameter_value_to_python(value)
    found = found.tolist() if hasattr(found, "tolist") else found
    return (
        found if isinstance(found, str) else json.dumps(found, separators=(",", ":"), default=str)
    )
