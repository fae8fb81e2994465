"""A saved recording is the recording, and any tool can open it."""

import math
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from node_runs import short
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from grader.course.submission import Submission
from grader.recording import Compute, Inference, Outcome, Recording, bag
from grader.trial.virtual_time import run_trial
from rclpy_virtual_time.link.log import LogLine
from sim.messages import EPOCH_NS, Message, decode, typestore

TEXT = "".join(map(chr, [*range(0x180), 0x2028, 0x202E, 0xFFFF, 0x1F600]))  # all that is odd


# --- the same again ------------------------------------------------------------------------------


def test_what_is_loaded_is_what_was_saved(recording: Recording, saved: Path) -> None:
    loaded = bag.load(saved)

    for name in (
        "scenario", "seed", "duration_s", "outcome", "endpoints", "log", "log_truncated", "charged",
    ):  # fmt: skip
        assert getattr(loaded, name) == getattr(recording, name), name
    assert loaded.delivered == recording.delivered
    assert loaded.published == recording.published
    assert loaded.digest() == recording.digest()
    assert loaded.bag == str(saved)


def test_what_is_rare_is_kept_too(recording: Recording, saved: Path) -> None:
    """And saving again replaces the bag."""
    asked = (
        Inference("load", "model.pkl", -1, -1, 80_000_000),
        Inference("predict", "model.pkl", 5, 200, 195, (0.25, math.nan, -math.inf)),
        Inference("predict", "model.pkl", 300, 330, 30, failed=True),
    )
    rare = replace(
        recording,
        inferences=asked,
        charged=True,
        outcome=Outcome("exception", TEXT, 0.1 + 0.2, TEXT * 3),
        log=(LogLine(0, "debug", TEXT), LogLine(10**9, "stdout", TEXT[::-1])),
        compute=Compute(np.array([0.5]), np.array([0.1]), np.array([np.nan]), np.zeros(1)),
    )
    loaded = bag.load(bag.save(rare, saved) / "bag.mcap")

    assert repr(loaded.inferences) == repr(asked)
    assert (loaded.charged, loaded.outcome, loaded.log) == (True, rare.outcome, rare.log)
    np.testing.assert_array_equal(loaded.compute.cpu, [np.nan])
    assert loaded.digest() == rare.digest() != recording.digest()


@pytest.mark.parametrize("part", ["truth", "compute"])
def test_arrays_are_equal_bit_for_bit(part: str, recording: Recording, saved: Path) -> None:
    loaded = bag.load(saved)

    for field in fields(getattr(recording, part)):
        before = getattr(getattr(recording, part), field.name)
        after = getattr(getattr(loaded, part), field.name)
        assert before.dtype == after.dtype, field.name
        assert before.tobytes() == after.tobytes(), field.name


def test_a_trial_that_never_was(recording: Recording, tmp_path: Path) -> None:
    empty = run_trial(Submission(tmp_path / "x.py", "the file is empty"), short(1.0), None)  # type: ignore[arg-type]
    loaded = bag.load(bag.save(empty, tmp_path / "empty"))

    assert loaded.outcome == empty.outcome
    assert loaded.digest() == empty.digest()
    assert len(loaded.compute.wall) == 0


# --- for others ----------------------------------------------------------------------------------


@pytest.mark.parametrize("reader_of", [Reader, lambda path: AnyReader([path])])
def test_rosbags_reads_every_message(reader_of, recording: Recording, saved: Path) -> None:  # type: ignore[no-untyped-def]
    topics, last = set(), 0
    with reader_of(saved) as reader:
        for connection, stamp, data in reader.messages():
            assert typestore().deserialize_cdr(data, connection.msgtype) is not None
            assert last <= stamp
            assert 0 <= stamp - EPOCH_NS <= recording.duration_s * 1e9
            topics.add(connection.topic)
            last = stamp

    said = {message.topic for message in recording.messages}
    truth = {"/ground_truth/odom", "/ground_truth/clearance", "/ground_truth/contact"}
    assert topics == said | truth | {"/rosout", "/course/trial"}


def test_topics_offer_what_their_publishers_do(recording: Recording, saved: Path) -> None:
    with Reader(saved) as reader:
        offered = {c.topic: c.ext.offered_qos_profiles for c in reader.connections}
    said = {
        topic: (qos.reliability.name, qos.durability.name, qos.depth)
        for topic, (qos,) in offered.items()
    }
    assert recording.scenario.qos.sensors == "reliable"
    assert said["/scan"] == ("RELIABLE", "VOLATILE", 10)
    assert said["/said"] == ("RELIABLE", "VOLATILE", 10)
    assert said["/rosout"][1] == "TRANSIENT_LOCAL"


def test_mcap_reads_it_as_ros2(recording: Recording, saved: Path) -> None:
    with (saved / "bag.mcap").open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
        assert summary is not None
        assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
        assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
        named = {schema.name: schema.data for schema in summary.schemas.values()}
        assert b"float32[] ranges" in named["sensor_msgs/msg/LaserScan"]
        scans = [message for _, _, message in reader.iter_messages(topics=["/scan"])]

    assert [(m.log_time - EPOCH_NS, m.data) for m in scans] == [
        (m.time, m.data) for m in recording.of("/scan")
    ]


def test_stamps_are_those_of_the_messages(recording: Recording, saved: Path) -> None:
    with Reader(saved) as reader:
        for connection, stamp, data in reader.messages():
            if connection.topic not in ("/ground_truth/odom", "/rosout", "/odom"):
                continue
            value = decode(bytes(data), connection.msgtype)
            header = value.stamp if connection.topic == "/rosout" else value.header.stamp
            assert 1.6e9 < header.sec < 1.8e9
            assert header.sec * 10**9 + header.nanosec == stamp


# --- what nodes can do to it ---------------------------------------------------------------------

ODD = ("", "no slash", "/a: b\n- c", "/#x", "/'\"", "/\x00", "/\x1b[0m", "/ü", "*", "/{a: 1}",
       "/" * 256)  # fmt: skip


def test_odd_topics_and_types_are_kept_and_unknown_ones_left_out(
    recording: Recording, tmp_path: Path
) -> None:
    known = [
        Message("/said", "std_msgs/msg/String", 9, b"\0\1\0\0\1\0\0\0\0"),
        Message("/said", "std_msgs/msg/Float64", 10, b"\0\1\0\0" + bytes(8)),
        *(
            Message(topic, "std_msgs/msg/String", 11 + i, b"\xff" * 5)
            for i, topic in enumerate(ODD)
        ),
    ]
    strange = Message("/strange", "my_package/msg/Strange", 10, b"\0\1\0\0data")
    odd = replace(recording, published=(strange, *known))
    loaded = bag.load(bag.save(odd, tmp_path / "a" / "b"))

    assert loaded.published == tuple(known)
