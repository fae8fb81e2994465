"""Save a recording as a rosbag2 bag (MCAP) and load it again.

The bag holds what a robot's own bag would (the topics, the log as `/rosout`), the simulator's
ground truth as ordinary topics, so that Foxglove and `ros2 bag play` show it, and one JSON document
with what has no message type (scenario, seed, endpoints, outcome).

Somebody else's bag may be made to harm its reader: its file is parsed in a cell, and nothing else
of it (metadata.yaml) is read.
"""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

import msgspec
import numpy as np

from grader.errors import GraderError, InputError
from grader.recording import Compute, Endpoint, Inference, Live, Outcome, Recording, Training
from rclpy_virtual_time import FileReader, LogLine
from sim.bag_qos import profile
from sim.layout import layout_from_json, layout_to_json
from sim.messages import (
    BOOL,
    EPOCH_NS,
    FLOAT64,
    LATCHED,
    ODOMETRY,
    STRING,
    Message,
    bool_,
    decode,
    encode,
    float64,
    odometry,
    string,
    typestore,
)
from sim.scenario_files import scenario_from_json, scenario_to_json
from sim.sensors import SENSOR_TOPICS
from sim.simulation import Truth

METADATA = "metadata.yaml"
TRIAL_TOPIC = "/course/trial"
FROM_NODE = "/from_node"  # before the node's topics that are the robot's, too
LOG_TOPIC = "/rosout"
LOG = "rcl_interfaces/msg/Log"
TRUTH_ODOMETRY = "/ground_truth/odom"
TRUTH_CLEARANCE = "/ground_truth/clearance"
TRUTH_CONTACT = "/ground_truth/contact"
LEVELS = {"debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50}
FORMAT = 2
MAX_TOPICS, MAX_TOPIC = 8, 60  # of a bag that is not of a trial; [characters]
MAX_REASON = 300  # [characters] of why a bag can't be read
STORAGES = (".mcap", ".db3")
READER = FileReader(cpu=20, answer=96 << 20)  # a node may publish 64 MiB
MAX_DOCUMENT = 16 << 20  # [bytes] of JSON; what is made of it takes many times as much


class _Document(msgspec.Struct, frozen=True):
    """The data saved beside the messages."""

    format: int
    scenario: str
    layout: str
    seed: int
    duration_s: float
    outcome: Outcome
    endpoints: tuple[Endpoint, ...]
    log_truncated: bool
    yaw: list[float]  # [rad] ground truth, exact: a quaternion loses the last digits
    delivered: dict[str, str]  # topic: type
    published: dict[str, str]
    compute: list[tuple[float, float, float | None, float]]
    training: Training | None = None
    live: Live | None = None
    inferences: bytes = b"\x90"  # MessagePack: JSON has no NaN
    charged: bool = False


def save(recording: Recording, folder: Path) -> Path:
    """Write the recording as a new bag; return its folder.

    Raises InputError: there is something else at `folder`.
    """
    from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: PLC0415  (60 ms, only when needed)

    _clear(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections: dict[tuple[str, str], Any] = {}
        for message in sorted(_all_messages(recording), key=lambda m: m.time):
            key = (message.topic, message.type)
            if key not in connections:
                connections[key] = _connect(writer, message, _offered(recording, message.topic))
            connection = connections[key]
            if connection is not None:
                writer.write(connection, recording.epoch + message.time, message.data)
    return folder


def load(path: Path) -> Recording:
    """Read a bag that `save` wrote: the folder, or the .mcap file in it.

    Raises InputError: it isn't such a bag.
    """
    folder = path.parent if path.suffix == ".mcap" else path
    if not (folder / METADATA).is_file():
        raise InputError(f"{path}: expected a bag (a folder with metadata.yaml), found none")
    files = sorted(file for file in folder.iterdir() if file.suffix in STORAGES)[:1]
    messages: list[Message] = []
    try:
        for file in files:
            messages = READER.read(messages_in, file.suffix, file=file, returns=list[Message])
        if any(message.topic == TRIAL_TOPIC for message in messages):
            return _assemble(messages, str(folder))
    except GraderError:
        raise
    except Exception as error:  # whatever the broken bytes lead to
        said = " ".join(str(error).split())[:MAX_REASON]
        raise InputError(f"{path}: not a bag that this course has recorded ({said})") from error
    raise InputError(_lacking(path, messages))


def messages_in(file: IO[bytes], suffix: str) -> list[Message]:
    """Return the messages in a bag's one file, in this process."""
    from rosbags.rosbag2 import Reader  # noqa: PLC0415

    opened: Any = _Opened(file, suffix)  # it has what is asked of it
    with Reader(opened) as reader:
        return [
            Message(connection.topic, connection.msgtype, stamp, bytes(data))
            for connection, stamp, data in reader.messages()
        ]


def warm_up() -> None:
    """Import what reads bags, before a cell is closed."""
    import rosbags.rosbag2  # noqa: F401, PLC0415


class _Opened:
    """An open file as rosbags asks a path for it."""

    def __init__(self, file: IO[bytes], suffix: str) -> None:
        self.suffix = suffix
        self._file = file

    def __str__(self) -> str:
        return f"bag{self.suffix}"

    def exists(self) -> bool:
        return True

    def is_dir(self) -> bool:
        return False

    def open(self, mode: str) -> IO[bytes]:
        return os.fdopen(os.dup(self._file.fileno()), mode)

    def stat(self) -> os.stat_result:
        return os.fstat(self._file.fileno())


def _lacking(path: Path, messages: list[Message]) -> str:
    """Say what a bag of another recorder holds, and what it lacks for grading."""
    counts = Counter(_printable(message.topic) for message in messages)
    shown = [f"{topic} ({count})" for topic, count in sorted(counts.items())[:MAX_TOPICS]]
    more = f" and {len(counts) - len(shown)} more" if len(counts) > len(shown) else ""
    return (
        f"{path}: a bag, but not one of a trial: it has {', '.join(shown) or 'no messages'}{more}; "
        f"it lacks {TRIAL_TOPIC}, the scenario and where the robot truly was, which only "
        "`course grade … --bags DIR` and `course drive … --bag DIR` record"
    )


def _printable(topic: str) -> str:
    """Return a topic's name, without what would confuse a terminal."""
    return "".join(c if c.isprintable() else "?" for c in topic)[:MAX_TOPIC]


def _assemble(messages: list[Message], folder: str) -> Recording:
    (head,) = [m for m in messages if m.topic == TRIAL_TOPIC]
    if len(head.data) > MAX_DOCUMENT:
        raise ValueError(f"a description of {len(head.data):,} bytes")
    document = msgspec.json.decode(decode(head.data, STRING).data, type=_Document)
    if document.format != FORMAT:
        raise ValueError(f"format {document.format}, expected {FORMAT}")
    epoch = EPOCH_NS if document.live is None else document.live.epoch
    messages = [replace(message, time=message.time - epoch) for message in messages]
    return Recording(
        scenario=scenario_from_json(document.scenario),
        layout=layout_from_json(document.layout),
        seed=document.seed,
        duration_s=document.duration_s,
        delivered=tuple(m for m in messages if m.topic in document.delivered),
        published=tuple(m for m in messages if m.topic in document.published),
        truth=_truth(messages, document.yaw),
        outcome=document.outcome,
        endpoints=document.endpoints,
        log=tuple(_log_line(m) for m in messages if m.topic == LOG_TOPIC),
        log_truncated=document.log_truncated,
        compute=Compute(*np.array(document.compute, dtype=float).reshape(-1, 4).T),
        training=document.training,
        live=document.live,
        inferences=msgspec.msgpack.decode(document.inferences, type=tuple[Inference, ...]),
        charged=document.charged,
        bag=folder,
    )


def _clear(folder: Path) -> None:
    if not folder.exists():
        return
    if not _is_bag(folder):
        raise InputError(f"{folder}: exists and is not a bag; choose another place for the bags")
    shutil.rmtree(folder)


def _is_bag(folder: Path) -> bool:
    """Return whether the folder holds a bag and nothing else, so that it may be replaced."""
    if folder.is_symlink() or not (folder / METADATA).is_file():
        return False
    return all(file.name == METADATA or file.suffix == ".mcap" for file in folder.iterdir())


def _connect(writer: Any, message: Message, offered: tuple[Any, ...]) -> Any:
    """Return a connection for the topic; None for a type that the type store doesn't know."""
    if message.type not in typestore().fielddefs:
        return None
    return writer.add_connection(
        message.topic, message.type, typestore=typestore(), offered_qos_profiles=offered
    )


def _offered(recording: Recording, topic: str) -> tuple[Any, ...]:
    """Return the quality of service with which a topic was published."""
    name = topic.removeprefix(FROM_NODE) if topic.startswith(f"{FROM_NODE}/") else topic
    publishers = [e for e in recording.endpoints if (e.kind, e.topic) == ("publisher", name)]
    if any(m.topic == topic for m in recording.published) and publishers:
        first = publishers[0]
        return profile(
            reliable=first.reliability != "best_effort",
            latched=first.durability == "transient_local",
            depth=first.depth,
        )
    lossy = topic in SENSOR_TOPICS and recording.scenario.qos.sensors == "sensor_data"
    return profile(reliable=not lossy, latched=topic in (*LATCHED, LOG_TOPIC), depth=10)


def _all_messages(recording: Recording) -> Iterator[Message]:
    yield string(TRIAL_TOPIC, 0, msgspec.json.encode(_document(recording)).decode())
    yield from recording.delivered
    yield from recording.published
    truth = recording.truth
    for i, t in enumerate(truth.t):
        time = int(t)
        yield odometry(
            time=time,
            x=float(truth.x[i]),
            y=float(truth.y[i]),
            yaw=float(truth.yaw[i]),
            v=float(truth.v[i]),
            w=float(truth.w[i]),
            topic=TRUTH_ODOMETRY,
        )
        yield float64(TRUTH_CLEARANCE, time, float(truth.clearance[i]))
        yield bool_(TRUTH_CONTACT, time, bool(truth.contact[i]))
    for line in recording.log:
        yield _log_message(line)


def _document(recording: Recording) -> _Document:
    compute = recording.compute
    return _Document(
        format=FORMAT,
        scenario=scenario_to_json(recording.scenario),
        layout=layout_to_json(recording.layout),
        seed=recording.seed,
        duration_s=recording.duration_s,
        outcome=recording.outcome,
        endpoints=recording.endpoints,
        log_truncated=recording.log_truncated,
        yaw=recording.truth.yaw.tolist(),
        delivered={m.topic: m.type for m in recording.delivered},
        published={m.topic: m.type for m in recording.published},
        compute=np.column_stack(list(vars(compute).values())).tolist(),
        training=recording.training,
        live=recording.live,
        inferences=msgspec.msgpack.encode(recording.inferences),
        charged=recording.charged,
    )


def _truth(messages: list[Message], yaw: list[float]) -> Truth:
    poses = [m for m in messages if m.topic == TRUTH_ODOMETRY]
    rows = []
    for message in poses:
        value = decode(message.data, ODOMETRY)
        position, twist = value.pose.pose.position, value.twist.twist
        rows.append((position.x, position.y, twist.linear.x, twist.angular.z))
    x, y, v, w = np.array(rows, dtype=float).reshape(-1, 4).T.copy()
    clearance = [decode(m.data, FLOAT64).data for m in messages if m.topic == TRUTH_CLEARANCE]
    contact = [decode(m.data, BOOL).data for m in messages if m.topic == TRUTH_CONTACT]
    if not len(yaw) == len(poses) == len(clearance) == len(contact):
        raise ValueError("the ground truth is incomplete")
    return Truth(
        t=np.array([m.time for m in poses], dtype=np.int64),
        x=x,
        y=y,
        yaw=np.array(yaw, dtype=float),
        v=v,
        w=w,
        clearance=np.array(clearance, dtype=float),
        contact=np.array(contact, dtype=bool),
    )


def _log_message(line: LogLine) -> Message:
    types = typestore().types
    sec, nanosec = divmod(EPOCH_NS + line.time, 10**9)
    value = types[LOG](
        stamp=types["builtin_interfaces/msg/Time"](sec=sec, nanosec=nanosec),
        level=LEVELS.get(line.level, 20),
        name=line.level,
        msg=line.text,
        file="",
        function="",
        line=0,
    )
    return Message(LOG_TOPIC, LOG, line.time, encode(value, LOG))


def _log_line(message: Message) -> LogLine:
    value = decode(message.data, LOG)
    return LogLine(message.time, value.name, value.msg)


def load_all(path: Path) -> list[Recording]:
    """Load one bag, or every bag in a folder.

    Raises InputError: there is none, or one can't be read.
    """
    if path.is_dir() and not (path / "metadata.yaml").exists():
        folders = sorted(file.parent for file in path.glob("*/metadata.yaml"))
        if folders:
            return [load(folder) for folder in folders]
    return [load(path)]
