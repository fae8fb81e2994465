"""Recordings spoilt in many ways: what a hostile node might have published, asked and logged."""

import random
import struct
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np

from grader.host.frames import Tensor
from grader.link.log import LogLine
from grader.recording import Endpoint, ModelAnswers, Outcome, Recording, ScriptRun
from sim.messages import STRING, TWIST, Message, decode, encode, typestore

Spoil = Callable[[Recording, random.Random], Recording]

FLOATS = (float("nan"), float("inf"), float("-inf"), 1e308, -1e308, 5e-324, -0.0, 2.0**63)
INTS = (0, 1, -1, 127, 255, 2**31 - 1, 2**32 - 1, -(2**31))
STRINGS = (
    "",
    " ",
    "\0",
    "\x1b[2J\r\n\t",
    "\u202eabc\ufeff",
    "NaN",
    "-inf",
    "1e999",
    "1_000",
    "x" * 100_000,
    "9" * 5_000,
    "1 2 3 4 5",
    "nan nan nan nan nan",
    "1e308 1e308 -1e308 1e308 1e308",
)
OBJECTS = (
    '{"label": "1e308 1e308 1e308 1e308 1e308", "confidence": 0.5, "stamp": 1.7e9}',
    '{"label": "nan 1 1 1 1", "confidence": 0.5, "stamp": 1.7e9}',
    '{"label": "\\ud800", "confidence": NaN, "stamp": -Infinity}',
    '{"label": "a", "confidence": 1' + "0" * 4_000 + ', "stamp": 1.0}',
    '{"label": "a", "confidence": 0.5, "stamp": -1' + "0" * 4_000 + "}",
    '{"label": "a", "confidence": 0.5, "stamp": 1e308}',
    '{"label": "a", "confidence": 0.5, "stamp": true}',
    '{"label": ["a"], "confidence": {}, "stamp": []}',
    '{"label": "a", "label": 3, "confidence": "0.5", "confidence": 0.5, "stamp": 1, "stamp": null}',
    '{"number": 0, "success": true, "message": "load 1"}',
    '{"number": 1e308, "success": {}, "message": 3}',
    '{"number": [1], "success": 1}',
    '{"number": -99999999999999999999, "success": true, "message": null}',
    "[1, 2]",
    "null",
    "3",
    '"text"',
    "[" * 50_000,
    '{"a":' * 50_000,
    "1" * 5_000,
    "{",
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
ODD_TOPICS = ("", "/", "cmd_vel", "//", "/probe/told", "/probe/asked", "/probe/served",
              "/navigation/detection", "/x" * 200)  # fmt: skip


def with_messages(recording: Recording, published: list[Message]) -> Recording:
    """Another recording with these messages; what the robot sent is decoded only once."""
    spoilt = replace(recording, published=tuple(sorted(published, key=lambda m: m.time)))
    for name in ("_scans", "_odometry"):
        spoilt.__dict__[name] = getattr(recording, name)
    return spoilt


def each_message(change: Callable[[Message, random.Random], Message]) -> Spoil:
    """Spoil some of the messages of some topics: all, half, or a single one."""

    def spoil(recording: Recording, rng: random.Random) -> Recording:
        topics = sorted({message.topic for message in recording.published})
        chosen = set(rng.sample(topics, rng.randint(1, len(topics)))) if topics else set()
        part = rng.choice((1.0, 0.5, 0.02))
        return with_messages(
            recording,
            [
                change(m, rng) if m.topic in chosen and rng.random() < part else m
                for m in recording.published
            ],
        )

    return spoil


def other_type(message: Message, rng: random.Random) -> Message:
    return Message(message.topic, rng.choice(TYPES), message.time, message.data)


def other_bytes(message: Message, rng: random.Random) -> Message:
    data = message.data
    spoilt = rng.choice(
        (
            b"",
            data[:3],
            data[: len(data) // 2],
            data + rng.randbytes(9),
            rng.randbytes(len(data)),
            data[:4] + rng.randbytes(max(0, len(data) - 4)),
            data[:4] + b"\xff" * max(0, len(data) - 4),
            rng.randbytes(100_000),
        )
    )
    return Message(message.topic, message.type, message.time, spoilt)


def other_values(message: Message, rng: random.Random) -> Message:
    if message.type not in typestore().fielddefs:
        return message
    if message.type == TWIST:
        values = [rng.choice((*FLOATS, 0.0, 0.1)) for _ in range(6)]
        data = message.data[:4] + struct.pack("<6d", *values)
        return Message(message.topic, TWIST, message.time, data)
    try:
        value = twisted(decode(message.data, message.type), rng)
        data = encode(value, message.type)
    except (ValueError, struct.error, OverflowError):  # not a value of this field after all
        return message
    return Message(message.topic, message.type, message.time, data)


def twisted(value: Any, rng: random.Random) -> Any:
    """Return a message or a field with odd values in some of the places."""
    match value:
        case bool():
            return not value
        case float():
            return rng.choice(FLOATS)
        case int():
            return rng.choice(INTS[:4])
        case str():
            return rng.choice(OBJECTS if value.startswith("{") else (*STRINGS, *OBJECTS))
        case list():
            return rng.choice(
                ([], value * 2, value[:1] * 300, [twisted(item, rng) for item in value])
            )
        case np.ndarray():
            return value
    fields = {name: getattr(value, name) for name in value.__dataclass_fields__}
    fields.pop("__msgtype__", None)
    changed = rng.sample(sorted(fields), rng.randint(1, len(fields)))
    for name in changed:
        fields[name] = twisted(fields[name], rng)
    return type(value)(**fields)


def other_amounts(recording: Recording, rng: random.Random) -> Recording:
    """Leave messages out, or repeat them."""
    topics = sorted({message.topic for message in recording.published})
    chosen = set(rng.sample(topics, rng.randint(1, len(topics)))) if topics else set()
    often = rng.choice((0, 0, 2, 30))
    kept = rng.choice((0.0, 0.5, 0.98))
    found: list[Message] = []
    for message in recording.published:
        whole = message.topic not in chosen or rng.random() < kept
        found += [message] * (1 if whole else often)
    return with_messages(recording, found)


def other_times(recording: Recording, rng: random.Random) -> Recording:
    """Let all come at once, at the start or at the end, or a moment late."""
    end = round(recording.duration_s * 1e9)
    shift = rng.choice((0, end, end // 2))
    late = rng.choice((1, 49_999_999, 10**9))
    return with_messages(
        recording,
        [
            Message(m.topic, m.type, min(end, m.time + late) if late > 1 else shift, m.data)
            for m in recording.published
        ],
    )


def more_topics(recording: Recording, rng: random.Random) -> Recording:
    """Publish on topics that are not the node's, the grader's own too."""
    end = round(recording.duration_s * 1e9)
    strange = [
        Message(
            rng.choice(ODD_TOPICS),
            STRING,
            rng.randint(0, end),
            encode(typestore().types[STRING](data=rng.choice((*OBJECTS, *STRINGS))), STRING),
        )
        for _ in range(30)
    ]
    broken = [other_bytes(message, rng) for message in strange[:5]]
    return with_messages(recording, [*recording.published, *strange, *broken])


def more_endpoints(recording: Recording, rng: random.Random) -> Recording:
    """Have thousands of ends, or none, with names that no node has."""
    kinds = ("publisher", "subscription", "service", "client", "timer", "")
    names = (*ODD_TOPICS, "/cmd_vel", "/scan", "/detect", "x" * 10_000, "\x1b[2J")
    odd = [
        Endpoint(rng.choice(kinds), rng.choice(names), rng.choice(names), rng.choice(TYPES),
                 "", "", -1, rng.choice(("", "no")))
        for _ in range(rng.choice((3, 1_000)))
    ]  # fmt: skip
    own = list(recording.endpoints) if rng.random() < 0.6 else []
    spoilt = with_messages(recording, list(recording.published))
    return replace_keeping(spoilt, endpoints=tuple(rng.sample(own + odd, len(own + odd))))


def other_log(recording: Recording, rng: random.Random) -> Recording:
    lines = [
        LogLine(rng.choice((0, -1, 10**18)), rng.choice(("error", "", "\0")), rng.choice(STRINGS))
        for _ in range(20)
    ]
    return replace_keeping(recording, log=tuple(lines) if rng.random() < 0.8 else ())


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
    training = recording.training
    if training is None:
        return recording
    count = len(training.expert)
    values = rng.choice(
        (
            b"",
            np.full(count, rng.choice(FLOATS)).tobytes(),
            np.zeros(count + 1).tobytes(),
            np.zeros(1).tobytes(),
            training.pickle.values[:-3],
        )
    )
    shape = rng.choice(((), (count,), (count, 1), (0,), (1, count), (-1,), (2**40, 2**40)))
    answers = ModelAnswers(rng.choice(("", "", STRINGS[3])), rng.random() < 0.8, shape, values)
    odd_tensor = (Tensor("", ()), Tensor("tensor(float)", ("", "5")), Tensor("\0", ("x",) * 16))
    run = ScriptRun(rng.choice(("returned", "exited")), "", "File \0", -1.0, {})
    changes: dict[str, Any] = {
        "pickle": answers,
        "again": answers,
        "onnx": answers,
        "onnx_inputs": tuple(rng.choices(odd_tensor, k=rng.randint(0, 3))),
        "onnx_outputs": tuple(rng.choices(odd_tensor, k=rng.randint(0, 3))),
        "runs": rng.choice(((), (run,), (run, run), training.runs)),
        "single_wall": rng.choice((b"", values[: len(values) // 8 * 8])),
        "problem": rng.choice(("", "no script")),
    }
    names = rng.sample(sorted(changes), rng.randint(1, 3))
    spoilt = {name: changes[name] for name in names}
    return replace_keeping(recording, training=msgspec.structs.replace(training, **spoilt))


def other_questions(recording: Recording, rng: random.Random) -> Recording:
    """Ask the models that the judge keeps more, less, or about something else."""
    end = round(recording.duration_s * 1e9)
    kept = rng.choice((0.0, 0.5, 0.98))
    found = []
    for one in recording.inferences:
        if rng.random() < kept:
            found.append(one)
            continue
        asked = rng.choice((-1, 0, one.asked, end // 2, end))
        changes: dict[str, Any] = {
            "method": rng.choice(("load", "predict", "predict_proba")),
            "file": rng.choice((one.file, *STRINGS[:3])),
            "asked": asked,
            "answered": rng.choice((asked, asked + 1, max(asked, one.answered), 10**18)),
            "said": rng.choice(((), one.said * 2, (rng.choice(FLOATS),), (0.5,) * 300)),
            "failed": not one.failed,
            "labels": rng.choice(((), one.labels * 2, STRINGS[:3])),
        }
        names = rng.sample(sorted(changes), rng.randint(1, 3))
        changed = msgspec.structs.replace(one, **{name: changes[name] for name in names})
        found += [changed] * rng.choice((0, 1, 1, 2))
    return replace_keeping(recording, inferences=tuple(sorted(found, key=lambda one: one.asked)))


def replace_keeping(recording: Recording, **changes: Any) -> Recording:
    """Replace parts of a recording but its messages."""
    spoilt = replace(recording, **changes)
    for name in ("_scans", "_odometry"):
        spoilt.__dict__[name] = getattr(recording, name)
    return spoilt


WAYS: dict[str, Spoil] = {
    "other types": each_message(other_type),
    "other bytes": each_message(other_bytes),
    "other values": each_message(other_values),
    "other amounts": other_amounts,
    "other times": other_times,
    "more topics": more_topics,
    "more endpoints": more_endpoints,
    "other log": other_log,
    "other end": other_end,
    "other models": other_models,
    "other questions": other_questions,
}
