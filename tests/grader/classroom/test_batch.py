"""A whole class: the queue, held units, canaries, quarantine, regrading, with a fake judge."""

import csv
import shutil
from concurrent.futures import BrokenExecutor
from pathlib import Path
from typing import Any

import pytest
from fake_class import FILE, SLUG, Drifting, but, fair, grading
from handing_in import put, roster_of

from grader.classroom.intake import candidates
from grader.classroom.queue.engine import DaskWorkers
from grader.classroom.queue.work import Unit, UnitResult
from grader.classroom.row import ABSENT, GRADED, HELD, TWICE
from grader.course.students import student_key
from grader.errors import InputError


def test_everybody_is_graded_once(grade_class: Any, handed_in: Path, tmp_path: Path) -> None:
    results, workers, _ = grade_class()
    assert {r.state for r in results.values()} == {GRADED}
    assert workers.students == ["ann", "bob", "eve"]
    assert (tmp_path / "out" / "recordings" / "ann" / SLUG / "trial").is_dir()
    assert (tmp_path / "out" / "class.html").is_file()

    (handed_in / "bob" / FILE).write_text("# better\n")
    put(handed_in, **{f"new/{FILE}": "# new\n"})
    results, workers, _ = grade_class()
    assert workers.students == ["bob", "new"]

    shutil.rmtree(handed_in / "bob")
    results, workers, _ = grade_class(drop=True)
    assert workers.students == []
    assert sorted(results) == ["ann", "eve", "new"]


def test_settings_are_part_of_what_was_graded(grade_class: Any) -> None:
    secret = b"0123456789abcdef"
    grade_class()
    assert grade_class(field=True)[1].students == ["ann", "bob", "eve"]
    workers = grade_class(secret=secret)[1]
    assert [u.seed for u in workers.seen] == [
        student_key(secret, s, SLUG) for s in workers.students
    ]
    assert grade_class(secret=secret)[1].students == []


def test_missing_and_unreadable_files_are_held(grade_class: Any, handed_in: Path) -> None:
    (handed_in / "lea").mkdir()
    for name in ("robot.py", "sensor.py"):  # one alone would be taken
        (handed_in / "lea" / name).write_text("# a wrong name\n")
    put(handed_in, **{"max/report.pdf": b"no program, but handed in"})
    (handed_in / "kim.zip").write_bytes(b"broken")
    results, workers, _ = grade_class()
    assert workers.students == ["ann", "bob", "eve"]
    assert results["lea"].problem == f"expected a file {FILE}; there is robot.py, sensor.py"
    assert {results[student].state for student in ("lea", "kim", "max")} == {HELD}


def test_what_was_not_handed_in_is_neither_queued_nor_held(
    grade_class: Any, handed_in: Path
) -> None:
    (handed_in / "lea").mkdir()
    put(handed_in, **{"kim/goal_seeking_agent.py": "# another exercise\n"})
    results, workers, _ = grade_class()
    assert workers.students == ["ann", "bob", "eve"]
    assert results["lea"].state == results["kim"].state == ABSENT
    (handed_in / "lea" / FILE).write_text("# at last\n")
    results, workers, _ = grade_class(retry_held=True)
    assert workers.students == ["lea"]
    (handed_in / "lea" / FILE).unlink()
    (handed_in / "ann" / FILE).unlink()
    with pytest.raises(InputError, match="ann, lea"):
        grade_class(regrade=True)
    results, workers, _ = grade_class(regrade=True, drop=True)
    assert results["lea"].state == results["ann"].state == ABSENT
    assert workers.students == ["bob", "eve"]


def test_a_class_with_a_roster(grade_class: Any, handed_in: Path, tmp_path: Path) -> None:
    people = "id,name,section\n1,ann,A\n2,Bob,B\n3,Zoë Ünal,B\n"
    results, _, _ = grade_class(roster=roster_of(tmp_path, people))
    assert {s: r.state for s, r in results.items()} == {
        "ann": GRADED, "Bob": GRADED, "eve": GRADED, "Zoë Ünal": ABSENT,
    }  # fmt: skip
    page = (tmp_path / "out" / "class.html").read_text()
    assert "not in the roster: eve" in page
    assert "1 student handed in nothing" in page
    table = csv.DictReader((tmp_path / "out" / "scores.csv").read_text("utf-8-sig").splitlines())
    assert {row["student"]: (row["id"], row["section"], row["state"]) for row in table} == {
        "ann": ("1", "A", "graded"),
        "Bob": ("2", "B", "graded"),
        "eve": ("", "", "graded"),
        "Zoë Ünal": ("3", "B", "not handed in"),
    }


def test_exercises_are_those_that_somebody_handed_in(grade_class: Any, handed_in: Path) -> None:
    results, _, _ = grade_class(exercises=())
    assert {r.exercise for r in results.values()} == {SLUG}
    for name in ("ann", "bob", "eve"):
        (handed_in / name / FILE).rename(handed_in / name / "robot.py")
    with pytest.raises(InputError, match="none of 3 students has a file of any exercise; ann"):
        grade_class(exercises=())


def test_a_dying_worker_is_tried_three_times_the_last_alone(grade_class: Any) -> None:
    def deadly(unit: Unit) -> UnitResult:
        if unit.student == "bob":
            raise BrokenExecutor
        return fair(unit)

    results, workers, _ = grade_class(deadly)
    assert workers.students == ["ann", "bob", "eve", "bob", "bob"]
    assert [u.alone for u in workers.seen if u.student == "bob"] == [False, False, True]
    assert results["bob"].state == HELD
    assert "died" in results["bob"].problem
    assert results["eve"].state == GRADED
    assert grade_class()[1].students == []  # held ones wait for a person
    results, workers, _ = grade_class(retry_held=True)
    assert workers.students == ["bob"]
    assert results["bob"].state == GRADED


def test_the_graders_own_problem_holds(grade_class: Any) -> None:
    results, _, _ = grade_class(lambda unit: UnitResult(None, "no host"))
    assert {r.problem for r in results.values()} == {f"no host; {TWICE}"}


def test_weak_isolation_is_refused(grade_class: Any) -> None:
    with pytest.raises(InputError, match="nothing between"):
        grade_class(refusal="nothing between them")
    assert grade_class(refusal="nothing between them", trust=True)[1].seen[0].trust


def test_canaries_begin_and_end_a_run(grade_class: Any) -> None:
    results, workers, quiet = grade_class(canaries=25)
    order = [unit.student for unit in workers.seen]
    assert order == [".reference", ".mutant", "ann", "bob", "eve", ".reference", ".mutant"]
    assert list(results) == ["ann", "bob", "eve"]
    assert not [line for line in quiet.lines if "quarantine" in line]
    assert grade_class(canaries=25)[1].seen == []


def test_canaries_come_every_so_often(grade_class: Any) -> None:
    _, workers, _ = grade_class(canaries=1)
    assert [u.student for u in workers.seen].count(".reference") >= 3


def test_a_drift_puts_what_came_before_in_quarantine(grade_class: Any, tmp_path: Path) -> None:
    results, workers, quiet = grade_class(Drifting(), canaries=25)
    assert workers.students == ["ann", "bob", "eve"] * 2
    assert {r.state for r in results.values()} == {GRADED}
    (note,) = [line for line in quiet.lines if "quarantine" in line]
    assert "reference had an unexpected outcome in stop_zone" in note
    assert "The 3 submissions graded since" in note
    assert "quarantine" in (tmp_path / "out" / "class.html").read_text()


@pytest.mark.parametrize(
    ("bad", "stalled"), [(".reference", ""), (".mutant", ""), (".mutant", ".reference")]
)
def test_a_grader_that_judges_wrong_grades_nobody(grade_class: Any, bad: str, stalled: str) -> None:
    def wrong(unit: Unit) -> UnitResult:
        if unit.student == stalled:
            return UnitResult(grading("stop_zone", outcome="inconclusive"))
        return UnitResult(grading("wiring")) if unit.student == bad else fair(unit)

    results, workers, _ = grade_class(wrong, canaries=25)
    assert workers.students == []
    assert {r.state for r in results.values()} == {HELD}
    assert "could not be trusted" in results["ann"].problem


def test_one_submission_cannot_put_the_others_in_quarantine(grade_class: Any) -> None:
    unsure = UnitResult(grading("stop_zone", outcome="inconclusive"))
    results, workers, _ = grade_class(but("ann", unsure), canaries=25)
    assert (workers.students.count("bob"), workers.students.count("eve")) == (1, 1)
    assert [r.state for r in results.values()] == [HELD, GRADED, GRADED]


def test_regrading_runs_no_code_and_changes_the_score(grade_class: Any, handed_in: Path) -> None:
    grade_class()
    (handed_in / "bob" / FILE).write_text("# other\n")
    results, workers, _ = grade_class(lambda _: UnitResult(grading(score=90)), regrade=True)
    assert all(unit.saved and not unit.files for unit in workers.seen)
    assert workers.students == ["ann", "eve"]  # bob's recordings are of another file
    assert results["ann"].grading["score"] == 90
    assert grade_class()[1].students == ["bob"]


def test_regrading_after_a_check_was_repaired(
    grade_class: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    grade_class()
    monkeypatch.setattr(candidates, "fingerprint", lambda _: "f" * 32)
    assert grade_class(regrade=True)[1].students == ["ann", "bob", "eve"]
    assert grade_class()[1].students == []  # what the repaired checks judged need not run again

    monkeypatch.setattr(candidates, "fingerprint", lambda _: "e" * 32)
    assert grade_class()[1].students == ["ann", "bob", "eve"]


def test_no_scheduler(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    with pytest.raises(InputError, match="no scheduler there"):
        DaskWorkers("nonsense://nowhere:1")


@pytest.mark.parametrize("outcome", ["inconclusive", "error"])
def test_what_could_not_be_judged_gets_another_try(grade_class: Any, outcome: str) -> None:
    unsure = UnitResult(grading("stop_zone", outcome=outcome))
    results, workers, _ = grade_class(but("bob", unsure))
    assert workers.students.count("bob") == 2
    assert results["bob"].state == HELD
    assert "could not judge stop_zone: because" in results["bob"].problem
    assert "judged twice, the second time with nothing beside it" in results["bob"].problem
