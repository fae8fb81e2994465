"""What `course doctor` says that a class would fail on."""

import importlib.metadata
import os
import resource
from pathlib import Path

import pytest

from rclpy_virtual_time.host.sandbox.layers import LAYERS, MOUNTS
from rclpy_virtual_time.link import trouble as room
from rclpy_virtual_time.link.trouble import trouble

WITHOUT_MOUNTS = [layer for layer in LAYERS if layer != MOUNTS]


@pytest.fixture(autouse=True)
def a_good_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever this one has: much memory and no other versions."""
    (tmp_path / "meminfo").write_text("MemTotal: 1 kB\nMemAvailable:   9000000 kB\n")
    (tmp_path / "constraints.txt").write_text("numpy==" + importlib.metadata.version("numpy"))
    monkeypatch.setattr(room, "MEMINFO", tmp_path / "meminfo")
    monkeypatch.setattr(room, "CGROUP", tmp_path)
    monkeypatch.setattr(room, "CONSTRAINTS", tmp_path / "constraints.txt")
    monkeypatch.setattr(room, "SPACE", 1)
    monkeypatch.setattr(room, "FILES", 1)


@pytest.mark.parametrize(
    ("place", "name", "value", "words"),
    [
        (room, "SPACE", 2**60, "MiB free, expected 1,099,511,627,776: submissions work there"),
        (resource, "getrlimit", lambda _: (64, 4096), "may open 64 files, expected 512: ulimit -n"),
        (os, "access", lambda *_: False, "can't be written to"),
    ],
)
def test_what_is_short_is_said(
    monkeypatch: pytest.MonkeyPatch, place: object, name: str, value: object, words: str
) -> None:
    assert trouble(LAYERS) == ()
    monkeypatch.setattr(place, name, value)

    assert words in trouble(LAYERS)[0]


def test_small_shared_memory_matters_where_hosts_have_none_of_their_own(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(room, "SHM", tmp_path / "missing")

    assert trouble(LAYERS) == ()
    assert "missing can't be used" in trouble(WITHOUT_MOUNTS)[0]


def test_a_containers_limit_of_memory_is_said(tmp_path: Path) -> None:
    (tmp_path / "memory.max").write_text("536870912\n")
    (tmp_path / "memory.current").write_text("0\n")

    assert trouble(LAYERS)[0].startswith("512 MiB of memory are left, expected 1,024")
    (tmp_path / "memory.max").write_text("max\n")
    assert trouble(LAYERS) == ()


def test_other_versions_are_named(tmp_path: Path) -> None:
    (tmp_path / "constraints.txt").write_text("# tested\nnumpy==0.1\nclick==0.1\n")

    (said,) = trouble(LAYERS)

    here = importlib.metadata.version("numpy")
    assert f"Scores may differ from those elsewhere: numpy {here} (tested: 0.1);" in said
