"""A node's ends of topics and services, and what is wrong with them: each line for a person.

What the messages say is looked at as far as it can only be a mistake.
"""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Iterator

import numpy as np

from grader.checks.commands import garbage, spell
from grader.recording import Endpoint, Recording
from grader.recording.wiring import COMMANDS, MOST_NOTED, OURS, RATED, Wiring
from sim.messages import CMD_VEL_TOPIC, TWIST_STAMPED, Message, decode

LOOKED_AT = 300  # messages of one topic; of commands all
MAX_DEPTH = 8  # of fields within fields
TINY = 1e-6  # [m/s], [rad/s]
ARROWS = {"publisher": "->", "subscription": "<-"}


def topic_lines(recording: Recording) -> list[str]:
    """Return a line for each endpoint, and below, indented, its problems."""
    ends = recording.endpoints
    if not ends and recording.outcome.kind == "hung":
        return ["not known: a node says which it has when it first waits for something"]
    if not ends:
        return ["the node created no publisher and no subscription"]
    wiring = Wiring(recording)
    blocks: list[tuple[str, ...]] = []
    for end in (end for end in recording.ends if end.kind != "timer"):
        line = f"{ARROWS.get(end.kind, end.kind)} {end.topic}  {end.type}"
        line += f"  {end.reliability}  {wiring.messages(end)}" if end.kind in ARROWS else ""
        several = len({other.node for other in recording.ends}) > 1 or "(" in end.process
        drives = several and (end.kind, end.topic) == ("publisher", CMD_VEL_TOPIC)
        line = f"{line}, by {end.node} of {end.process}" if drives else line
        blocks.append((line, *(f"    {text}" for text in _problems(recording, wiring, end))))
    lines = []
    for (line, *below), count in Counter(blocks).items():
        lines += [f"{line}, {count} times" if count > 1 else line, *below]
    return lines


def _problems(recording: Recording, wiring: Wiring, end: Endpoint) -> Iterator[str]:
    if fault := wiring.fault(end):
        yield f"WARNING: {fault}"
    if end.kind != "publisher":
        return
    is_command = end.topic == CMD_VEL_TOPIC and end.type in COMMANDS
    if is_command and end.type == TWIST_STAMPED:
        yield "note: the exercises expect Twist here; the robot understood"
    messages = [
        m
        for m in recording.published
        if (m.topic.removeprefix(OURS), m.type) == (end.topic, end.type)
    ]
    rate = len(messages) / max(wiring.lasted, RATED)
    if rate > MOST_NOTED:
        yield f"WARNING: {rate:.0f} a second flood the network; 10 to 50 commands a second do"
    text = _wrong_number(messages if is_command else messages[:LOOKED_AT])
    if not text and is_command:
        text = _timed_out(recording, messages, wiring.lasted)
    if text:
        yield f"WARNING: {text}"


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


def _timed_out(recording: Recording, commands: list[Message], end: float) -> str:
    """Say so if the robot came to a stop because no further command came."""
    lasts = recording.scenario.robot.command_timeout
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
