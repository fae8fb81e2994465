"""A node's ends of topics and services, and what is wrong with them: each line for a person.

It knows what the robot and the node's own programs offer. What the messages say is looked at as
far as it can only be a mistake.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections import Counter
from collections.abc import Iterator

import numpy as np

from grader.checks.commands import garbage, spell
from grader.recording import Endpoint, Recording
from sim.messages import CMD_VEL_TOPIC, GOAL_TOPIC, TWIST, TWIST_STAMPED, Message, decode
from sim.scenario_files import load_scenario, scenario_names
from sim.sensors import OFFERED, enabled_sensors

COMMANDS = (TWIST, TWIST_STAMPED)  # types of messages that the robot understands
OF_CARS = "ackermann_msgs/"  # how the types of what drives other robots begin
LOOKED_AT = 300  # messages of one topic; of commands all
MAX_DEPTH = 8  # of fields within fields
OURS = "/from_node"  # before topics on which the node speaks in the robot's name
ALIKE = 0.75  # two names
RATED = 1.0  # [s] that a node has to be there for a rate of its messages, and for missing ones
TINY = 1e-6  # [m/s], [rad/s]
MOST_NOTED = 490.0  # [Hz] a loop without a wait publishes more, and in real time 500 are noted
DEMOS = "demo_"  # how the scenarios begin that are for any node
LIFECYCLE = "lifecycle_msgs/"  # the ends of such a node that rclpy makes in C: nobody sees them
PARAMETER_SERVICES = (
    "describe_parameters",
    "get_parameter_types",
    "get_parameters",
    "list_parameters",
    "set_parameters",
    "set_parameters_atomically",
    "get_type_description",
)
ARROWS = {"publisher": "->", "subscription": "<-"}


def topic_lines(recording: Recording) -> list[str]:
    """Return a line for each endpoint, and below, indented, its problems."""
    ends = recording.endpoints
    if not ends and recording.outcome.kind == "hung":
        return ["not known: a node says which it has when it first waits for something"]
    if not ends:
        return ["the node created no publisher and no subscription"]
    sent = Counter(message.topic for message in recording.delivered)
    said = Counter((m.topic.removeprefix(OURS), m.type) for m in recording.published)
    blocks: list[tuple[str, ...]] = []
    for end in (end for end in recording.ends if end.kind != "timer"):
        line = _line(end, *_count(recording, end, sent, said), _lasted(recording))
        several = len({other.node for other in recording.ends}) > 1 or "(" in end.process
        drives = several and (end.kind, end.topic) == ("publisher", CMD_VEL_TOPIC)
        line = f"{line}, by {end.node} of {end.process}" if drives else line
        blocks.append((line, *(f"    {text}" for text in _problems(recording, end, sent))))
    lines = []
    for (line, *below), count in Counter(blocks).items():
        lines += [f"{line}, {count} times" if count > 1 else line, *below]
    return lines


def _lasted(recording: Recording) -> float:
    """Return the node's lifetime [s]; the robot rolls on without the node."""
    return recording.duration_s if recording.outcome.completed else recording.outcome.at


def _count(
    recording: Recording, end: Endpoint, sent: Counter[str], said: Counter[tuple[str, str]]
) -> tuple[int, str]:
    """Return the number of messages an endpoint sent or could hear, and the words for them.

    Which of several publishers sent a message is not known, nor whether one of the programs' own
    came in time for a subscription of theirs.
    """
    own, ends = said[end.topic, end.type], recording.endpoints
    if end.kind == "publisher":
        alike = [o for o in ends if (o.kind, o.topic, o.type) == (end.kind, end.topic, end.type)]
        words = "more than {}" if recording.live and own > MOST_NOTED * _lasted(recording) else "{}"
        return own, f"{words} together" if len(alike) > 1 else words
    robots = 0 if end.mismatch else sent[end.topic]
    if not own or not _own_publishers(end, ends, connected=True):
        return robots, "{}"
    return robots + own, "up to {}"


def _line(end: Endpoint, count: int, words: str, duration: float) -> str:
    line = f"{ARROWS.get(end.kind, end.kind)} {end.topic}  {end.type}"
    if end.kind not in ARROWS:
        return line
    rate = f" ({count / duration:.1f} Hz)" if count > 1 and duration >= RATED else ""
    messages = words.format(f"{count} message{'' if count == 1 else 's'}")
    return f"{line}  {end.reliability}  {messages}{rate}"


def _problems(recording: Recording, end: Endpoint, sent: Counter[str]) -> Iterator[str]:
    match end.kind:
        case "publisher":
            yield from _of_publisher(recording, end)
        case "subscription" if text := _of_subscription(recording, end, sent):
            yield f"WARNING: {text}"
        case "client" if not _served(recording, end):
            yield "WARNING: nobody offers this service: calls are never answered"
        case "action client" if not _served(recording, end):
            yield "WARNING: nobody offers this action: goals are never taken"


def _of_subscription(recording: Recording, end: Endpoint, sent: Counter[str]) -> str:
    """Say why nothing arrives; empty if something can."""
    ends = recording.endpoints
    if _own_publishers(end, ends, connected=True) or (sent[end.topic] and not end.mismatch):
        return ""
    node = end.topic.rpartition("/")[0]
    if end.type.startswith(LIFECYCLE) and any(other.node == node for other in ends):
        return ""  # the node tells of its own states
    if end.mismatch:
        return f"nothing arrives: {end.mismatch}"
    for other in _own_publishers(end, ends):
        if other.type != end.type:
            return f"nothing arrives: {other.node} publishes {other.type} here"
        return f"nothing arrives: {_qos_mismatch(other, end)}"
    if end.topic in OFFERED:
        if _lasted(recording) < RATED:
            return ""  # it had no time to hear anything
        hint = "; --goal X Y sends a goal" if end.topic == GOAL_TOPIC else _where(end.topic)
        return f"the robot sends nothing here in {recording.name}{hint}"
    near = difflib.get_close_matches(end.topic, sorted(sent), n=1, cutoff=ALIKE)
    near = near or [topic for topic in sorted(sent) if OFFERED.get(topic) == end.type]
    has = near[0] if near else ", ".join(sorted(sent))
    return "nobody publishes this topic" + (f"; the robot publishes {has}" if has else "")


def _where(topic: str) -> str:
    """Say in which scenarios for any node the robot has the sensor."""
    demos = [load_scenario(name) for name in scenario_names() if name.startswith(DEMOS)]
    sent = {d.name: {s.topic for s in enabled_sensors(d).values()} for d in demos if not d.program}
    having = ", ".join(name for name, topics in sent.items() if topic in topics)
    return f"; it does in {having}" if having else ""


def _of_publisher(recording: Recording, end: Endpoint) -> Iterator[str]:
    heard_by = [
        other
        for other in recording.endpoints
        if (other.kind, other.topic, other.type) == ("subscription", end.topic, end.type)
    ]
    alike = difflib.SequenceMatcher(None, end.topic, CMD_VEL_TOPIC).ratio() >= ALIKE
    drives = end.type in COMMANDS or end.type.startswith(OF_CARS)
    if end.topic == CMD_VEL_TOPIC and end.type not in COMMANDS:
        yield f"WARNING: the robot does not hear this: it takes {TWIST} here"
    elif end.topic != CMD_VEL_TOPIC and not heard_by and (drives or alike):
        yield f"WARNING: nobody listens here: the robot takes {TWIST} on {CMD_VEL_TOPIC}"
    elif end.topic == CMD_VEL_TOPIC and end.type == TWIST_STAMPED:
        yield "note: the exercises expect Twist here; the robot understood"
    messages = [
        m
        for m in recording.published
        if (m.topic.removeprefix(OURS), m.type) == (end.topic, end.type)
    ]
    is_command = end.topic == CMD_VEL_TOPIC and end.type in COMMANDS
    rate = len(messages) / max(_lasted(recording), RATED)
    if rate > MOST_NOTED:
        yield f"WARNING: {rate:.0f} a second flood the network; 10 to 50 commands a second do"
    text = _wrong_number(messages if is_command else messages[:LOOKED_AT])
    if not text and is_command:
        text = _timed_out(recording, messages)
    if text:
        yield f"WARNING: {text}"


def _own_publishers(
    end: Endpoint, ends: tuple[Endpoint, ...], *, connected: bool = False
) -> list[Endpoint]:
    """Return the programs' own publishers of a topic, or the publishers an endpoint hears."""
    found = [other for other in ends if (other.kind, other.topic) == ("publisher", end.topic)]
    if not connected:
        return found
    return [each for each in found if each.type == end.type and not _qos_mismatch(each, end)]


def _qos_mismatch(publisher: Endpoint, subscription: Endpoint) -> str:
    if (publisher.reliability, subscription.reliability) == ("best_effort", "reliable"):
        return "best effort publisher and reliable subscription"
    if (publisher.durability, subscription.durability) == ("volatile", "transient_local"):
        return "volatile publisher and transient local subscription"
    return ""


def _served(recording: Recording, client: Endpoint) -> bool:
    node, _, service = client.topic.rpartition("/")
    if service in PARAMETER_SERVICES or client.type.startswith(LIFECYCLE):  # in each such node
        return any(end.node == node for end in recording.endpoints)
    offers = "service" if client.kind == "client" else "action server"
    return any(
        (end.kind, end.topic, end.type) == (offers, client.topic, client.type)
        for end in recording.endpoints
    )


def _wrong_number(messages: list[Message]) -> str:
    """Say so if a float field holds what can only be another type's memory."""
    for message in messages:
        try:
            fields = dict(_floats(decode(message.data, message.type)))
        except ValueError:
            return ""
        for field, value in fields.items():
            if 0.0 < abs(value) < math.inf and garbage(value):
                said = garbage(value).removeprefix("This number is garbage: ")
                return f"{field} is {spell(value)} at {message.time / 1e9:.2f} s, garbage: {said}"
            if message.topic == CMD_VEL_TOPIC and not math.isfinite(value):
                return (
                    f"{field} is {value} at {message.time / 1e9:.2f} s, and the robot stands. Was "
                    "it computed (0/0, an empty list), or is it a negative int? Write float(…)."
                )
    return ""


def _floats(value: object, name: str = "", depth: int = 0) -> Iterator[tuple[str, float]]:
    """Return the float fields of a message by their names."""
    if isinstance(value, float):
        yield name, value
    elif dataclasses.is_dataclass(value) and depth < MAX_DEPTH:
        for field in dataclasses.fields(value):
            inner = getattr(value, field.name)
            yield from _floats(inner, f"{name}.{field.name}" if name else field.name, depth + 1)


def _timed_out(recording: Recording, commands: list[Message]) -> str:
    """Say so if the robot came to a stop because no further command came."""
    lasts = recording.scenario.robot.command_timeout
    end = _lasted(recording)
    if not commands:
        return ""
    times = np.array([message.time / 1e9 for message in commands])
    moves = np.array([any(abs(v) > TINY for v in _twist(each).values()) for each in commands])
    late = np.flatnonzero(moves & (np.diff(times, append=end) > lasts + TINY))
    if not len(late):
        return ""
    at, *then = times[late[0] :]
    until = f" until {then[0]:.2f} s" if then else ""
    return (
        f"the robot stopped at {at + lasts:.2f} s: it obeys a command for {lasts:g} s, and after "
        f"{at:.2f} s no other came{until}. Publish all the time, such as from a timer of 0.1 s"
    )


def _twist(message: Message) -> dict[str, float]:
    try:
        return dict(_floats(decode(message.data, message.type)))
    except ValueError:
        return {}
