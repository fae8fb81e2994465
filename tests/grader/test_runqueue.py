"""How long threads waited for a CPU."""

import os
from pathlib import Path

import pytest

from grader import runqueue
from grader.runqueue import RunQueue


@pytest.fixture
def queue(tmp_path: Path) -> RunQueue:
    queue = RunQueue(os.getpid())
    queue._tasks = tmp_path
    return queue


def say(folder: Path, thread: int, waited: int) -> None:
    (folder / str(thread)).mkdir(exist_ok=True)
    (folder / str(thread) / "schedstat").write_text(f"123 {waited} 4\n")


def test_the_worst_off_thread_counts_since_the_last_look(queue: RunQueue, tmp_path: Path) -> None:
    say(tmp_path, 1, 5_000_000_000)
    say(tmp_path, 2, 0)
    assert queue.worst() == 0.0  # what was before the first look is not counted

    say(tmp_path, 1, 5_010_000_000)
    say(tmp_path, 2, 30_000_000)
    assert queue.worst() == 0.03
    assert queue.worst() == 0.0


def test_a_new_thread_starts_from_nothing(queue: RunQueue, tmp_path: Path) -> None:
    queue.worst()
    say(tmp_path, 7, 9_000_000_000)
    assert queue.worst() == 0.0


def test_what_cannot_be_read_is_left_out(queue: RunQueue, tmp_path: Path) -> None:
    (tmp_path / "3").mkdir()
    (tmp_path / "4").mkdir()
    (tmp_path / "4" / "schedstat").write_text("nonsense")
    assert queue.worst() == 0.0


def test_a_process_that_is_gone_waits_for_nothing() -> None:
    assert RunQueue(2**22 + 1).worst() == 0.0


@pytest.mark.skipif(
    not Path("/proc/self/schedstat").exists(), reason="this kernel doesn't count waiting times"
)
def test_the_kernels_own_count_can_be_read() -> None:
    queue = RunQueue(os.getpid())
    assert queue.worst() == 0.0
    assert runqueue.Path(f"/proc/{os.getpid()}/task").is_dir()
    assert queue._known
