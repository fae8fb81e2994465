"""What is no bag is refused, and what is not a bag of ours is kept."""

import shutil
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.rosbag2 import StoragePlugin, Writer

from grader.errors import InputError
from grader.recording import Recording, bag
from sim.messages import EPOCH_NS, typestore

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
    with Writer(tmp_path / "foreign", version=9, storage_plugin=storage) as writer:
        kind = "std_msgs/msg/Bool"
        connection = writer.add_connection("/e_stop", kind, typestore=typestore())
        writer.write(connection, EPOCH_NS, b"\0\1\0\0\1")
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


def test_broken_metadata(saved: Path) -> None:
    for content in ("", "a: [", "- 1", "3", "rosbag2_bagfile_information: 3", "\0"):
        (saved / "metadata.yaml").write_text(content)
        refused(saved)


@settings(derandomize=True, deadline=None, max_examples=25)
@given(
    st.lists(
        st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=30
    )
)
def test_damaged_bags_are_refused_or_recordings(
    recording: Recording,
    tmp_path_factory: pytest.TempPathFactory,
    damages: list[tuple[float, int]],
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
