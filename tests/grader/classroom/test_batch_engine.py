"""Local workers: they are replaced when they die or grow old, and end with their parent."""

import io
import os
import subprocess
import sys
import tarfile
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from pathlib import Path

import pytest

from grader.classroom.queue import engine, work
from grader.classroom.queue.engine import LocalWorkers, open_workers

ROOT = Path(__file__).resolve().parents[3]
PARENT = """\
import io
import os
from grader.classroom.queue.engine import LocalWorkers

if __name__ == "__main__":
    workers = LocalWorkers(1)
    print(workers.submit(os.getpid).result(), flush=True)
    os.kill(os.getpid(), 9)
"""


@pytest.fixture
def workers() -> Iterator[LocalWorkers]:
    with open_workers(1) as opened:
        yield opened


def test_a_dead_worker_is_replaced(workers: LocalWorkers) -> None:
    first = workers.submit(os.getpid).result()
    with pytest.raises(BrokenExecutor):
        workers.submit(os._exit, 3).result()
    second = workers.submit(os.getpid).result()
    assert second not in (first, os.getpid())
    assert workers.submit(os.getpid).result() == second  # the dead one is out of the way


def test_an_old_worker_is_replaced(workers: LocalWorkers, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "MAX_UNITS", 1)
    assert workers.submit(os.getpid).result() != workers.submit(os.getpid).result()


def test_workers_import_nothing_from_the_current_folder(
    workers: LocalWorkers, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("runpy", "random", "socket", "pickle", "tempfile"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('a student')")
    monkeypatch.chdir(tmp_path)
    assert workers.submit(os.getpid).result() != os.getpid()


def test_workers_end_with_a_killed_parent(tmp_path: Path) -> None:
    """The pipe to the parent's stdout is the worker's too: it ends when both are gone."""
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    done = subprocess.run(
        [sys.executable, script], check=False, stdout=subprocess.PIPE, text=True, timeout=60,
        stderr=subprocess.DEVNULL, env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode == -9
    assert int(done.stdout) > 0  # and here nobody holds the pipe any more


def test_of_a_floods_recordings_none_are_sent(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    bag.touch()
    os.truncate(bag, work.MOST_SENT // 2)
    with tarfile.open(fileobj=io.BytesIO(work._packed(tmp_path))) as archive:
        assert archive.getnames() == [".", "./bag"]
    os.truncate(bag, work.MOST_SENT + 1)
    assert work._packed(tmp_path) == b""
