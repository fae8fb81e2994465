"""What is no bag is refused, and what is not a bag of ours is kept."""

import contextlib
import importlib
import shutil
import sqlite3
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from grader.errors import InputError
from grader.recording import Recording, bag
from sim.messages import EPOCH_NS, typestore

zstd = importlib.import_module(
    "compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd"
)
# --- what is no bag ------------------------------------------------------------------------------


def refused(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        bag.load(path)
    said = str(caught.value)
    assert str(path) in said
    assert "\n" not in said
    assert len(said) < 1_000
    return said


def test_what_is_no_bag(tmp_path: Path) -> None:
    (tmp_path / "file.txt").write_text("no")
    for place in ("absent", "absent.mcap", "", "file.txt"):
        assert "expected a bag" in refused(tmp_path / place)


@pytest.mark.parametrize("storage", list(StoragePlugin))
def test_a_bag_of_another_recorder_is_told_what_it_lacks(
    tmp_path: Path, storage: StoragePlugin
) -> None:
    foreign(tmp_path / "foreign", storage)
    said = refused(tmp_path / "foreign")
    assert "it has /e_stop (1)" in said
    assert "lacks /course/trial" in said


def test_truncated_bags(saved: Path) -> None:
    whole = (saved / "bag.mcap").read_bytes()
    for part in (0.9999, 0.9, 0.3, 0.001, 0.0):
        (saved / "bag.mcap").write_bytes(whole[: int(len(whole) * part)])
        refused(saved)
    (saved / "bag.mcap").unlink()
    refused(saved)


def test_metadata_is_not_read(saved: Path) -> None:
    (saved / "metadata.yaml").write_text("a: [")
    assert isinstance(bag.load(saved), Recording)


def foreign(
    folder: Path, storage: StoragePlugin, spoil: Callable[[Writer], object] = lambda _: None
) -> Path:
    """Write a bag of another recorder, with one message; return its file."""
    writer = Writer(folder, version=9, storage_plugin=storage)
    if storage is StoragePlugin.MCAP:
        writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with writer:
        spoil(writer)
        connection = writer.add_connection("/e_stop", "std_msgs/msg/Bool", typestore=typestore())
        writer.write(connection, EPOCH_NS, b"\0\1\0\0\1")
    return next(file for file in folder.iterdir() if file.suffix != ".yaml")


def test_a_bomb_costs_only_its_reader(tmp_path: Path) -> None:
    """80 kB of MCAP that unpack to 1.5 GiB."""

    def pack(writer: Any) -> None:
        frame = zstd.compress(bytes(2**20))
        writer.storage.compressor = lambda _: 1_500 * frame

    foreign(tmp_path / "bag", StoragePlugin.MCAP, pack)
    assert "more than 512 MiB of memory" in refused(tmp_path / "bag")


def test_a_record_of_any_length_is_refused(tmp_path: Path) -> None:
    file = foreign(tmp_path / "bag", StoragePlugin.MCAP)
    content = bytearray(file.read_bytes())
    at = content.index(b"ros2") - 12
    for length in (3 * 2**30, 2**62, 2**64 - 1):
        content[at : at + 8] = length.to_bytes(8, "little")
        file.write_bytes(content)
        refused(tmp_path / "bag")


def test_a_table_that_computes_its_blobs_costs_only_its_reader(tmp_path: Path) -> None:
    """32 kB of SQLite that hold two messages of 900 MB."""
    file = foreign(tmp_path / "bag", StoragePlugin.SQLITE3)
    columns = "id INTEGER, topic_id INTEGER, timestamp INTEGER"
    with contextlib.closing(sqlite3.connect(file)) as database, database:
        database.execute("ALTER TABLE messages RENAME TO old")
        blob = "data BLOB AS (zeroblob(900000000))"
        database.execute(f"CREATE TABLE messages ({columns}, {blob})")
        for _ in range(2):
            database.execute("INSERT INTO messages SELECT id, topic_id, timestamp FROM old")
    assert "out of memory" in refused(tmp_path / "bag")


def test_a_file_that_is_a_link_is_not_read(saved: Path) -> None:
    (saved / "bag.mcap").rename(saved / "other")
    (saved / "bag.mcap").symlink_to("other")
    refused(saved)


@settings(derandomize=True, deadline=None, max_examples=10)
@given(
    st.lists(
        st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=30
    )
)
def test_damaged_bags_are_refused_or_recordings(
    recording: Recording, tmp_path_factory: pytest.TempPathFactory, damages: list[tuple[float, int]]
) -> None:
    folder = tmp_path_factory.getbasetemp() / "damaged"
    bag.save(recording, folder)
    file = folder / "damaged.mcap"
    content = bytearray(file.read_bytes())
    for where, value in damages:
        content[int(where * len(content))] = value
    file.write_bytes(content)
    try:
        assert isinstance(bag.load(folder), Recording)
    except InputError as error:
        assert "\n" not in str(error)


def test_a_bag_of_somebody_else(tmp_path: Path) -> None:
    folder = tmp_path / "foreign"
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/x", "std_msgs/msg/String", typestore=typestore())
        writer.write(connection, EPOCH_NS, b"\0\1\0\0\1\0\0\0\0")

    assert "not one of a trial: it has /x (1); it lacks /course/trial" in refused(folder)


@pytest.mark.parametrize("change", ["format", "missing", "scenario", "yaw"])
def test_a_document_of_another_form(
    change: str, recording: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def other(recording: Recording, original=bag._document) -> object:  # type: ignore[no-untyped-def]
        document = msgspec.to_builtins(original(recording))
        if change == "missing":
            del document["outcome"]
        else:
            document |= {
                "format": {"format": 0},
                "scenario": {"scenario": "{}"},
                "yaw": {"yaw": []},
            }[change]
        return document

    monkeypatch.setattr(bag, "_document", other)
    folder = bag.save(recording, tmp_path / "bag")

    refused(folder)


# --- what is not to be overwritten ---------------------------------------------------------------


def keeps(recording: Recording, place: Path) -> None:
    with pytest.raises(InputError, match="exists and is not a bag") as caught:
        bag.save(recording, place)
    assert "\n" not in str(caught.value)


def test_other_things_are_kept(recording: Recording, saved: Path, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    for place, file in (("folder", "folder/thesis"), (saved, saved / "thesis"), ("file", "file")):
        (tmp_path / file).write_text("years of work")
        keeps(recording, tmp_path / place)
        assert (tmp_path / file).read_text() == "years of work"


def test_a_link_to_a_bag_is_kept(recording: Recording, saved: Path, tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(saved)
    keeps(recording, link)
    moved = Path(shutil.move(saved, tmp_path / "elsewhere"))  # which a bag may be
    assert bag.load(moved).digest() == recording.digest()
