"""The store of a class: transactions, states, what survives."""

import os
import signal
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

from grader.classroom.queue.store import Store
from grader.classroom.row import GRADED, HELD, RUNNING, WAITING
from grader.errors import InputError

ANN, BOB = ("ann", "goal_seeking"), ("bob", "goal_seeking")
GRADING = {"score": 3, "max_score": 5, "checks": [], "recordings": []}


def states(store: Store) -> dict[str, str]:
    return {result.student: result.state for result in store.results()}


def test_a_unit_goes_its_way(tmp_path: Path) -> None:
    with Store(tmp_path / "s") as store:
        store.enter(ANN, "h1")
        assert store.waiting() == [ANN]
        store.claim(ANN, "h1", ["a.py"])
        assert (store.waiting(), states(store)) == ([], {"ann": RUNNING})
        store.finish(ANN, GRADING, recordings="recordings/ann", wall_s=2.0)
    with Store(tmp_path / "s") as store:
        (result,) = store.results()

    assert (result.state, result.grading, result.attempts) == (GRADED, GRADING, 1)
    assert (result.recordings, result.wall_s) == (Path("recordings/ann"), 2.0)
    assert result.finished.endswith("+00:00")
    assert result.file_names == ("a.py",)


def test_only_what_changed_waits_again(tmp_path: Path) -> None:
    with Store(tmp_path / "s") as store:
        for key in (ANN, BOB):
            store.enter(key, "h1")
            store.claim(key, "h1", [])
            store.finish(key, GRADING)
        store.enter(ANN, "h1")
        store.enter(BOB, "h2")

        assert states(store) == {"ann": GRADED, "bob": WAITING}
        assert store.results()[1].grading is None


def test_problems_are_held_and_missing_files_may_come(tmp_path: Path) -> None:
    with Store(tmp_path / "s") as store:
        store.enter(ANN, "h0", problem="no file")
        store.enter(ANN, "h0", problem="no file")
        assert states(store) == {"ann": HELD}
        store.retry_held()  # nothing was tried, nothing to try
        assert states(store) == {"ann": HELD}
        store.enter(ANN, "h1")
        assert store.waiting() == [ANN]


def test_who_is_gone_is_forgotten_in_these_exercises_only(tmp_path: Path) -> None:
    other = ("bob", "trend_memory")
    with Store(tmp_path / "s") as store:
        for key in (ANN, BOB, other):
            store.enter(key, "h")
        store.keep_only([ANN], ["goal_seeking"])
        assert [(r.student, r.exercise) for r in store.results()] == [ANN, other]


def test_other_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("no database, but long enough to be taken for one" * 40)
    with pytest.raises(InputError, match="expected the store"):
        Store(tmp_path / "text")
    db = sqlite3.connect(tmp_path / "newer")
    db.execute("PRAGMA user_version=99")
    db.close()
    with pytest.raises(InputError, match="schema 99"):
        Store(tmp_path / "newer")


def test_kill_9_leaves_what_was_finished(tmp_path: Path) -> None:
    script = (
        "import os, sys; from pathlib import Path; from grader.classroom.queue.store import Store\n"
        "store = Store(Path(sys.argv[1]))\n"
        "for n in range(5):\n"
        "    key = (f's{n}', 'e'); store.enter(key, 'h'); store.claim(key, 'h', [])\n"
        "    if n < 3: store.finish(key, {'score': n})\n"
        "store._db.execute('BEGIN'); store._db.execute('DELETE FROM units')\n"
        "os.kill(os.getpid(), 9)\n"
    )
    done = subprocess.run([sys.executable, "-c", script, str(tmp_path / "s")], check=False)
    assert done.returncode == -signal.SIGKILL
    with Store(tmp_path / "s") as store:
        store.requeue_running()
        assert list(states(store).values()) == [GRADED] * 3 + [WAITING] * 2
        assert [r.grading for r in store.results()][:3] == [{"score": n} for n in range(3)]
    assert os.listdir(tmp_path) == ["s"]
