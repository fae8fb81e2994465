"""Recordings spoilt in many ways: what a hostile node might have published, asked and logged."""

import random
import struct
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np

from grader.recording import Outcome, Recording
from sim.messages import STRING, TWIST, Message, decode, encode, typestore

Spoil = Callable[[Recording, random.Random], Recording]

FLOATS = (float("nan"), float("inf"), float("-inf"), 1e308, -1e308, 5e-324, -0.0, 2.0**63)
INTS = (0, 1, -1, 127)
STRINGS = ("", "\0", "\x1b[2J\u202e\r\n\t", "-inf", "1e999", "x" * 100_000, "9" * 5_000,
           "nan nan nan nan nan", "1e308 1e308 -1e308 1e308 1e308")  # fmt: skip
OBJECTS = (
    '{"label": "1e308 1e308 1e308 1e308 1e308", "confidence": 0.5, "stamp": 1.7e9}',
    '{"label": "\\ud800", "confidence": NaN, "stamp": -Infinity}',
    '{"label": "a", "confidence": 1' + "0" * 4_000 + ', "stamp": -1' + "0" * 4_000 + "}",
    '{"label": "a", "confidence": 0.5, "stamp": true}',
    '{"label": ["a"], "confidence": {}, "stamp": []}',
    '{"label": "a", "label": 3, "confidence": "0.5", "confidence": 0.5, "stamp": 1, "stamp": null}',
    '{"number": 0, "success": true, "message": "load 1"}',
    '{"number": 1e308, "success": {}, "message": 3}',
    '{"number": -99999999999999999999, "success": true, "message": null}',
    "[1, 2]",
    "null",
    "[" * 50_000,
    '{"a":' * 50_000,
)
TYPES = (
    TWIST,
    STRING,
    "std_msgs/msg/Float64",
    "std_msgs/msg/UInt32",
    "diagnostic_msgs/msg/DiagnosticArray",
    "sensor_msgs/msg/LaserScan",
    "no_such_msgs/msg/Type",
    "",
)
ODD_TOPICS = ("", "/", "cmd_vel", "//", "/navigation/detection", "/x" * 200)


def replaced(recording: Recording, **changes: Any) -> Recording:
    """Another recording; what the robot sent is decoded only once."""
    spoilt = replace(recording, **changes)
    for name in ("_scans", "_odometry"):
        spoilt.__dict__[name] = getattr(recording, name)
    return spoilt


def each_message(change: Callable[[Message, random.Random, int], list[Message]]) -> Spoil:
    """Spoil some of the messages of some topics, of a run that ends then [ns]."""

    def spoil(recording: Recording, rng: random.Random) -> Recording:
        topics = sorted({message.topic for message in recording.published})
        chosen = set(rng.sample(topics, rng.randint(1, len(topics)))) if topics else set()
        part, end = rng.choice((1.0, 0.5, 0.02)), round(recording.duration_s * 1e9)
        published: list[Message] = []
        for message in recording.published:
            spoilt = message.topic in chosen and rng.random() < part
            published += change(message, rng, end) if spoilt else [message]
        return replaced(recording, published=tuple(sorted(published, key=lambda m: m.time)))

    return spoil


def other_type(message: Message, rng: random.Random, end: int) -> list[Message]:
    return [Message(message.topic, rng.choice(TYPES), message.time, message.data)]


def other_amount(message: Message, rng: random.Random, end: int) -> list[Message]:
    return [message] * rng.choice((0, 0, 2, 30))


def other_time(message: Message, rng: random.Random, end: int) -> list[Message]:
    time = rng.choice((0, end, end // 2, min(end, message.time + rng.choice((1, 49_999_999)))))
    return [Message(message.topic, message.type, time, message.data)]


def other_bytes(message: Message, rng: random.Random, end: int) -> list[Message]:
    data = message.data
    spoilt = rng.choice((
        b"",
        data[:3],
        data[: len(data) // 2],
        data + rng.randbytes(9),
        data[:4] + rng.randbytes(max(0, len(data) - 4)),
        data[:4] + b"\xff" * max(0, len(data) - 4),
        rng.randbytes(100_000),
    ))  # fmt: skip
    return [Message(message.topic, message.type, message.time, spoilt)]


def other_values(message: Message, rng: random.Random, end: int) -> list[Message]:
    if message.type not in typestore().fielddefs:
        return [message]
    try:
        value = twisted(decode(message.data, message.type), rng)
        data = encode(value, message.type)
    except (ValueError, struct.error, OverflowError):  # not a value of this field after all
        return [message]
    return [Message(message.topic, message.type, message.time, data)]


def twisted(value: Any, rng: random.Random) -> Any:
    """Return a message, a part of a recording or a field with odd values in some of the places."""
    match value:
        case bool():
            return not value
        case float():
            return rng.choice(FLOATS)
        case int():
            return rng.choice(INTS)
        case str():
            return rng.choice(OBJECTS if value.startswith("{") else (*STRINGS, *OBJECTS))
        case bytes():  # floats; model_loads keeps other lengths from the checks that compare them
            return rng.choice((value[:8], np.full(len(value) // 8, rng.choice(FLOATS)).tobytes()))
        case list() | tuple():
            each = type(value)(twisted(item, rng) for item in value)
            return rng.choice((value[:0], value * 2, value[:1] * 300, each))
        case np.ndarray() | dict() | None:
            return value
    names = getattr(value, "__struct_fields__", None) or vars(value)
    changed = rng.sample(sorted(set(names) - {"__msgtype__"}), rng.randint(1, len(names) // 2 + 1))
    fields = {name: twisted(getattr(value, name), rng) for name in changed}
    if isinstance(value, msgspec.Struct):
        return msgspec.structs.replace(value, **fields)
    return replace(value, **fields)


def some_of(part: str) -> Spoil:
    """Leave out, repeat and change some of the endpoints, log lines or questions to models."""

    def spoil(recording: Recording, rng: random.Random) -> Recording:
        share, found = rng.choice((1.0, 0.5, 0.02)), []
        for item in getattr(recording, part):
            if rng.random() < share:
                found += [rng.choice((item, twisted(item, rng)))] * rng.choice((0, 1, 2, 100))
            else:
                found.append(item)
        if part == "inferences":
            found.sort(key=lambda one: one.asked)
        return replaced(recording, **{part: tuple(found)})

    return spoil


def more_topics(recording: Recording, rng: random.Random) -> Recording:
    """Publish on topics that are not the node's, the grader's own too."""
    end = round(recording.duration_s * 1e9)
    strange = []
    for _ in range(30):
        text = typestore().types[STRING](data=rng.choice((*OBJECTS, *STRINGS)))
        at = rng.randint(0, end)
        strange += [Message(rng.choice(ODD_TOPICS), STRING, at, encode(text, STRING))]
    broken = [each for message in strange[:5] for each in other_bytes(message, rng, end)]
    published = sorted([*recording.published, *strange, *broken], key=lambda m: m.time)
    return replaced(recording, published=tuple(published))


def other_end(recording: Recording, rng: random.Random) -> Recording:
    """Let the node end early, or claim that it lived although it said nothing more."""
    kind = rng.choice(("exception", "died", "stuck", "returned", "odd", "completed"))
    detail = rng.choice(("", "File ", 'File "a.py", line 1\n' * 1_000, "\0"))
    at = rng.choice((0.0, 0.1, recording.duration_s / 2))
    spoilt = ended(recording, Outcome(kind, rng.choice(STRINGS), at, detail))
    if kind == "completed":
        return replace(spoilt, duration_s=recording.duration_s, delivered=recording.delivered)
    return replace(spoilt, endpoints=rng.choice(((), recording.endpoints)))


def ended(recording: Recording, outcome: Outcome) -> Recording:
    """Return what there would be of a recording if the node had ended so."""
    cut = round(outcome.at * 1e9)
    return replace(
        recording,
        outcome=outcome,
        duration_s=outcome.at,
        delivered=tuple(m for m in recording.delivered if m.time < cut),
        published=tuple(m for m in recording.published if m.time <= cut),
        inferences=tuple(one for one in recording.inferences if one.asked <= cut),
    )


def other_models(recording: Recording, rng: random.Random) -> Recording:
    """Spoil what a student's trained models said."""
    if recording.training is None:
        return recording
    own = ("pickle", "again", "onnx", "onnx_inputs", "onnx_outputs", "runs")
    spoilt = {name: twisted(getattr(recording.training, name), rng) for name in rng.sample(own, 2)}
    return replaced(recording, training=msgspec.structs.replace(recording.training, **spoilt))


WAYS: dict[str, Spoil] = {
    "other types": each_message(other_type),
    "other bytes": each_message(other_bytes),
    "other values": each_message(other_values),
    "other amounts": each_message(other_amount),
    "other times": each_message(other_time),
    "more topics": more_topics,
    "other endpoints": some_of("endpoints"),
    "other log": some_of("log"),
    "other end": other_end,
    "other models": other_models,
    "other questions": some_of("inferences"),
}
