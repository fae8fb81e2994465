"""A disk that is full, and results that can't be stored: a batch ends cleanly and goes on later."""

import errno
import sqlite3
from pathlib import Path
from typing import Any

import pytest
from fake_class import FILE, but, grading

from grader.classroom.queue import grading_run
from grader.classroom.queue.store import Store
from grader.classroom.queue.work import Unit, UnitResult
from grader.classroom.row import GRADED, HELD, WAITING
from grader.errors import DiskFull, is_disk_full

# --- what can't be stored --------------------------------------------------------------------


def test_a_result_that_can_not_be_stored_is_held(grade_class: Any) -> None:
    results, _, _ = grade_class(but("bob", UnitResult({**grading(), "odd": {1, 2}})))
    assert {name: r.state for name, r in results.items()} == {
        "ann": GRADED, "bob": HELD, "eve": GRADED,
    }  # fmt: skip
    assert "could not be stored (TypeError" in results["bob"].problem


def test_folders_with_names_that_are_no_text(grade_class: Any, handed_in: Path) -> None:
    for number, folder in enumerate((b"caf\xe9", b"\xff")):
        place = Path(str(handed_in), "bob", folder.decode("utf-8", "surrogateescape"))
        place.mkdir()
        (place / FILE).write_text(f"# {number}\n")
    (handed_in / "bob" / FILE).unlink()
    student = Path(str(handed_in), b"zo\xe9".decode("utf-8", "surrogateescape"))
    student.mkdir()
    (student / FILE).write_text("#\n")
    results, workers, _ = grade_class()
    assert workers.students == ["ann", "bob", "eve", "zo_"]
    assert results["bob"].state == results["zo_"].state == GRADED


# --- a full disk -----------------------------------------------------------------------------


def full(*_: object, **__: object) -> Any:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_store_without_room_stops_the_batch_and_goes_on_later(
    grade_class: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = Store.__init__

    def small(self: Store, path: Path) -> None:
        real(self, path)
        pages = self._db.execute("PRAGMA page_count").fetchone()[0]
        self._db.execute(f"PRAGMA max_page_count={pages + 3}")

    long = {**grading(), "notes": ["x" * 9_000]}
    monkeypatch.setattr(Store, "__init__", small)
    with pytest.raises(DiskFull) as caught:
        grade_class(lambda unit: UnitResult(long))
    said = str(caught.value)
    assert "\n" not in said
    assert str(tmp_path / "out") in said
    assert "run the same command again" in said
    monkeypatch.undo()
    with Store(tmp_path / "out" / "store.sqlite") as store:
        states = [result.state for result in store.results()]
    assert states.count(GRADED) >= 1
    assert states.count(WAITING) >= 1


def test_a_disk_that_fills_while_results_are_written(
    grade_class: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as disk:
        disk.setattr("grader.classroom.results.feedback.exercise_page", full)
        with pytest.raises(DiskFull, match="run the same command again"):
            grade_class()
    assert (tmp_path / "out" / "scores.csv").is_file()
    assert not list((tmp_path / "out").rglob("*.part"))
    _, workers, _ = grade_class()
    assert workers.students == []
    assert (tmp_path / "out" / "feedback" / "eve" / "obstacle_avoidance.html").is_file()


def test_an_archive_that_does_not_fit_is_not_broken(
    grade_class: Any, handed_in: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("grader.classroom.intake.students.unpack", full)
    (handed_in / "kim.zip").write_bytes(b"PK")
    with pytest.raises(DiskFull):
        grade_class()


@pytest.mark.parametrize("canaries", [0, 25])
def test_a_full_disk_ends_the_batch_before_it_holds_everybody(
    canaries: int, grade_class: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_room(unit: Unit) -> UnitResult:
        return UnitResult(None, "No space left", disk_full=True)

    with monkeypatch.context() as disk:
        disk.setattr(grading_run, "has_space", lambda *_: False)
        with pytest.raises(DiskFull):
            grade_class(no_room, canaries=canaries)
    with Store(tmp_path / "out" / "store.sqlite") as store:
        assert {result.state for result in store.results()} == {WAITING}
    assert {r.state for r in grade_class()[0].values()} == {GRADED}


def test_one_that_fills_the_disk_itself_stops_nobody(
    grade_class: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    fills = but("ann", UnitResult(None, "the disk was full", disk_full=True))
    monkeypatch.setattr(grading_run, "has_space", lambda *_: True)
    results, workers, _ = grade_class(fills)
    assert workers.students == ["ann", "bob", "eve", "ann"]
    assert workers.seen[-1].alone
    assert [r.state for r in results.values()] == [HELD, GRADED, GRADED]


def test_a_full_disk_is_known_by_its_cause() -> None:
    assert not is_disk_full(OSError(errno.EIO, "broken"))
    assert not is_disk_full(sqlite3.OperationalError("database or disk is full"))  # only its words
    unopened = sqlite3.OperationalError("disk I/O error")
    unopened.sqlite_errorcode = sqlite3.SQLITE_IOERR_SHMSIZE  # to the last byte
    assert is_disk_full(unopened)
    error = ValueError("a bag")
    error.__cause__ = OSError(errno.EDQUOT, "quota")
    assert is_disk_full(error)
    assert is_disk_full(DiskFull("x"))
