"""Temporary folders of graders that were killed."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from rclpy_virtual_time.link import scratch


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def dead() -> int:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def test_what_the_dead_left_goes(place: Path) -> None:
    left = place / f"course-{dead()}-abc"
    (left / "deep" / "er").mkdir(parents=True)
    (left / "deep" / "file").write_text("x")
    (left / "deep").chmod(0)

    scratch.sweep()

    assert not left.exists()


def test_everything_else_stays(place: Path) -> None:
    with scratch.fresh_folder() as own:
        (place / "course-work-1").mkdir()
        (place / "mine").mkdir()
        (place / "mine" / "file").write_text("x")
        (place / f"course-{dead()}-link").symlink_to(place / "mine")
        (place / f"course-{dead()}-file").write_text("x")
        (place / f"course-{os.getppid()}-neighbour").mkdir()
        before = sorted(place.rglob("*"))

        scratch.sweep()

        assert own.is_dir()
        assert sorted(place.rglob("*")) == before


def test_a_link_in_the_place_of_the_folder_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "others").mkdir()
    (tmp_path / "others" / "kept").write_text("not the node's")
    with scratch.fresh_folder() as folder:
        folder.rmdir()
        folder.symlink_to(tmp_path / "others")
    assert (tmp_path / "others" / "kept").exists()
    assert not folder.is_symlink()
