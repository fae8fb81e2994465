"""A saved recording is the recording, and any tool can open it."""

import math
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from node_runs import short
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader

from grader.course.submission import Submission
from grader.link.log import LogLine
from grader.recording import Compute, Inference, Outcome, Recording, bag
from grader.trial.virtual_time import run_trial
from sim.messages import EPOCH_NS, Message, decode, typestore

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


def test_what_models_were_asked_is_kept(recording: Recording, tmp_path: Path) -> None:
    asked = (
        Inference("load", "model.pkl", -1, -1, 80_000_000),
        Inference("predict", "model.pkl", 5, 200, 195, (0.25, math.nan, -math.inf)),
        Inference("predict", "model.pkl", 300, 330, 30, failed=True),
    )
    before = replace(recording, inferences=asked)
    after = bag.load(bag.save(before, tmp_path / "asked"))
    assert repr(after.inferences) == repr(asked)
    assert after.digest() == before.digest() != recording.digest()


@pytest.mark.parametrize("part", ["truth", "compute"])
def test_arrays_are_equal_bit_for_bit(part: str, recording: Recording, saved: Path) -> None:
    loaded = bag.load(saved)

    for field in fields(getattr(recording, part)):
        before = getattr(getattr(recording, part), field.name)
        after = getattr(getattr(loaded, part), field.name)
        assert before.dtype == after.dtype, field.name
        assert before.tobytes() == after.tobytes(), field.name


def test_a_bag_may_be_read_by_its_file_saved_again_and_replaced(
    recording: Recording, saved: Path, tmp_path: Path
) -> None:
    assert bag.load(saved / "bag.mcap").digest() == recording.digest()
    again = bag.save(bag.load(saved), tmp_path / "a" / "b" / "c")
    assert bag.load(again).digest() == recording.digest()
    bag.save(replace(recording, seed=99), saved)
    assert bag.load(saved).seed == 99


def test_a_trial_that_never_was(recording: Recording, tmp_path: Path) -> None:
    empty = run_trial(Submission(tmp_path / "x.py", "the file is empty"), short(1.0), None)  # type: ignore[arg-type]
    loaded = bag.load(bag.save(empty, tmp_path / "empty"))

    assert loaded.outcome == empty.outcome
    assert loaded.digest() == empty.digest()
    assert len(loaded.compute.wall) == 0


def test_cpu_times_may_be_unknown_and_computing_charged(
    recording: Recording, tmp_path: Path
) -> None:
    unknown = Compute(np.array([0.5]), np.array([0.1]), np.array([np.nan]), np.zeros(1))
    odd = replace(recording, compute=unknown, charged=True)
    loaded = bag.load(bag.save(odd, tmp_path / "bag"))

    assert loaded.charged
    np.testing.assert_array_equal(loaded.compute.cpu, [np.nan])


text = st.text(st.characters(exclude_categories=["Cs"]), max_size=60)


@settings(derandomize=True, deadline=None, max_examples=15)
@given(
    st.lists(
        st.builds(
            LogLine,
            time=st.integers(0, 10**9),
            level=st.sampled_from(["debug", "info", "warn", "error", "fatal", "stdout", "stderr"]),
            text=text,
        ),
        max_size=4,
    ),
    text,
)
def test_any_text_survives(
    recording: Recording, tmp_path_factory: pytest.TempPathFactory, log: list[LogLine], said: str
) -> None:
    said_all = replace(
        recording,
        log=tuple(sorted(log, key=lambda line: line.time)),
        outcome=Outcome("exception", said, 0.1 + 0.2, said * 3),
    )
    folder = tmp_path_factory.mktemp("bags") / "bag"
    loaded = bag.load(bag.save(said_all, folder))

    assert loaded.log == said_all.log
    assert loaded.outcome == said_all.outcome


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


def test_unknown_types_are_left_out(recording: Recording, tmp_path: Path) -> None:
    strange = Message("/strange", "my_package/msg/Strange", 10, b"\0\1\0\0data")
    odd = replace(recording, published=(strange, *recording.published))
    loaded = bag.load(bag.save(odd, tmp_path / "bag"))

    assert loaded.published == recording.published


def test_two_types_on_one_topic(recording: Recording, tmp_path: Path) -> None:
    number = Message("/said", "std_msgs/msg/Float64", 10**9, b"\0\1\0\0" + bytes(8))
    mixed = tuple(sorted((*recording.published, number), key=lambda message: message.time))
    loaded = bag.load(bag.save(replace(recording, published=mixed), tmp_path / "bag"))

    assert sorted(loaded.published, key=repr) == sorted(mixed, key=repr)


ODD = ["", "no slash", "/a: b\n- c", "/#x", "/'\"", "/\0", "/\x1b[0m", "/ü", "*", "/" * 256]


def test_odd_topics(recording: Recording, tmp_path: Path) -> None:
    odd = tuple(Message(topic, "std_msgs/msg/String", 10, b"\xff" * 5) for topic in ODD)
    loaded = bag.load(bag.save(replace(recording, published=odd), tmp_path / "bag"))

    assert sorted(loaded.published, key=repr) == sorted(odd, key=repr)
