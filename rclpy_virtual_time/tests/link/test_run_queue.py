"""How long threads waited for a CPU."""

import os
import subprocess
import time
from pathlib import Path

import pytest

from rclpy_virtual_time.link.run_queue import RunQueue, is_ready

PATIENCE = 0.02


class Clock:
    """A clock that stands until it is set."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def queue(tmp_path: Path, clock: Clock) -> RunQueue:
    queue = RunQueue(os.getpid(), PATIENCE, clock, processors=2)
    queue._tasks = str(tmp_path)
    return queue


def say(folder: Path, thread: int, waited: int, state: str = "S", ran: int = 123) -> None:
    (folder / str(thread)).mkdir(exist_ok=True)
    (folder / str(thread) / "schedstat").write_text(f"{ran} {waited} 4\n")
    (folder / str(thread) / "stat").write_text(f"{thread} (a name) {state} 1 1 1\n")


def test_the_worst_off_thread_counts_since_the_last_look(queue: RunQueue, tmp_path: Path) -> None:
    say(tmp_path, 1, 5_000_000_000)
    say(tmp_path, 2, 0)
    assert queue.worst() == 0.0  # what was before the first look is not counted

    say(tmp_path, 1, 5_010_000_000)
    say(tmp_path, 2, 15_000_000)
    assert queue.worst() == 0.015
    assert queue.worst() == 0.0


def test_a_long_wait_counts_as_far_as_it_was_seen(
    queue: RunQueue, tmp_path: Path, clock: Clock
) -> None:
    for thread in (1, 2, 3):
        say(tmp_path, thread, 0)
    queue.worst()
    for state in "RRRS":
        clock.now += 0.02
        say(tmp_path, 1, 70_000_000, state)
        say(tmp_path, 2, 80_000_000, "S")  # counted by the kernel, but it slept
        say(tmp_path, 3, 0, "R")  # it ran
        queue.look()
    assert queue.worst() == pytest.approx(0.06)  # from the first look that saw it, and a turn

    say(tmp_path, 2, 180_000_000)
    clock.now += 0.1
    queue.look()
    assert queue.worst(unseen_too=True) == 0.1

    say(tmp_path, 2, 280_000_000)
    clock.now += 0.1
    queue.look()
    assert queue.worst() == PATIENCE


def test_what_cannot_be_read_or_is_new_is_left_out(queue: RunQueue, tmp_path: Path) -> None:
    (tmp_path / "3").mkdir()
    (tmp_path / "4").mkdir()
    (tmp_path / "4" / "schedstat").write_text("nonsense")
    assert queue.worst() == 0.0
    say(tmp_path, 7, 9_000_000_000)
    assert queue.worst() == 0.0
    assert RunQueue(2**22 + 1, PATIENCE).worst() == 0.0  # a process that is gone


@pytest.mark.skipif(
    not Path("/proc/self/schedstat").exists(), reason="this kernel doesn't count waiting times"
)
def test_the_kernels_own_count_can_be_read() -> None:
    queue = RunQueue(os.getpid(), PATIENCE)
    assert queue.worst() == 0.0
    assert Path(f"/proc/{os.getpid()}/task").is_dir()
    assert queue._known


def test_a_wait_that_lasts_longer_than_a_turn_counts_in_one(
    queue: RunQueue, tmp_path: Path, clock: Clock
) -> None:
    say(tmp_path, 1, 0)
    queue.worst()
    for turn in range(10):
        clock.now += 0.03
        say(tmp_path, 1, 300_000_000 if turn == 9 else 0, "R")  # counted when it is over
        queue.look()
        assert queue.pending() == pytest.approx(0.03 * turn)
        assert queue.worst() == pytest.approx(0.29 if turn == 9 else 0.0)
    assert queue.pending() == 0.0


def test_a_thread_that_runs_does_not_wait(queue: RunQueue, tmp_path: Path, clock: Clock) -> None:
    """Whenever one looks, and whenever one asks."""
    say(tmp_path, 1, 0, ran=0)
    queue.worst()
    for turn in range(1, 101):
        clock.now += 0.011
        say(tmp_path, 1, 0, "R", ran=20_000_000 * turn - 9_000_000)
        queue.look()
        clock.now += 0.009
        say(tmp_path, 1, 0, "R", ran=20_000_000 * turn)
        assert queue.worst() == 0.0
    assert queue.pending() < 0.002

    say(tmp_path, 1, 80_000_000, ran=2_000_000_000)  # then it slept, which the kernel counted
    assert queue.worst() < PATIENCE + 0.002


def own_threads(queue: RunQueue, folder: Path, clock: Clock, busy: int) -> None:
    """Let threads of the process take the processors for 0.2 s, while another one waits."""
    for turn in range(11):
        for thread in range(1, busy + 1):
            say(folder, thread, 0, "R", ran=20_000_000 * turn)
        say(folder, 9, 200_000_000 if turn == 10 else 0, "R", ran=0)
        if turn == 0:
            queue.worst()
        clock.now += 0.02 * (turn > 0)
        queue.look()


@pytest.mark.parametrize(("busy", "others"), [(0, 1.0), (1, 0.5), (2, 0.0)])
def test_what_threads_of_a_process_take_from_one_another_does_not_count(
    queue: RunQueue, tmp_path: Path, clock: Clock, busy: int, others: float
) -> None:
    own_threads(queue, tmp_path, clock, busy)
    assert queue.pending() == pytest.approx(0.18 * others)
    assert queue.worst() == pytest.approx(min(0.2, 0.18 * others + PATIENCE))
    again = RunQueue(os.getpid(), PATIENCE, clock, processors=2)
    again._tasks = str(tmp_path)
    own_threads(again, tmp_path, clock, busy)
    assert again.worst(unseen_too=True) == pytest.approx(0.2 * others)


def test_a_process_that_waits_for_input_is_not_ready() -> None:
    with subprocess.Popen(["cat"], stdin=subprocess.PIPE) as cat:
        limit = time.monotonic() + 20.0
        while is_ready(cat.pid) and time.monotonic() < limit:
            pass  # it starts
        assert not is_ready(cat.pid)
    assert not is_ready(cat.pid)  # it is gone
    assert is_ready(os.getpid())
