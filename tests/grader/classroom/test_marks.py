"""Marks that people change: what they come to, in every export, and what the log says of them."""

from __future__ import annotations

import csv
import errno
import io
import json
import re
import sqlite3
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from fake_class import FILE, SLUG, fair, grading
from made_results import check, result

from grader.classroom.amendments import (
    Entry,
    Late,
    Publish,
    Score,
    SetCheck,
    Undo,
    Waive,
    Whom,
    amended,
)
from grader.classroom.amendments.late import moment_of, span_of, times_of
from grader.classroom.marking import Marking, marking, reading
from grader.classroom.results.marks import points_of, tasks_of
from grader.classroom.row import GRADED, HELD
from grader.classroom.store import Store
from grader.classroom.work import Unit, UnitResult
from grader.errors import DiskFull, GraderError, InputError

ANN = Whom(("ann",))
CHECKS = (check("stop_zone", "pass", 60), check("slow_zone", "fail", 30), check("blind", "pass"))
WHY = "because"


def judged(unit: Unit) -> UnitResult:
    """70 of 100 for everybody; eve's slow_zone could not be judged."""
    checks = [dict(each) for each in CHECKS]
    if unit.student == "eve":
        checks[1]["outcome"] = "inconclusive"
    most = 70 if unit.student == "eve" else 100
    return UnitResult({**grading(score=70), "max_score": most, "checks": checks})


@pytest.fixture
def graded(grade_class: Any, tmp_path: Path) -> Path:
    grade_class(judged)
    return tmp_path / "out"


@pytest.fixture
def mark(graded: Path) -> Callable[..., dict[str, str]]:
    """Make changes, and return everybody's points by scores.csv."""

    def mark(*changes: Any) -> dict[str, str]:
        with marking(graded) as class_:
            for change in changes:
                class_.add(change, "prof", WHY)
        return points(graded)

    return mark


def scores(out: Path) -> dict[str, dict[str, str]]:
    text = (out / "scores.csv").read_text("utf-8-sig")
    return {row["student"]: row for row in csv.DictReader(io.StringIO(text, newline=""))}


def points(out: Path) -> dict[str, str]:
    return {student: row["points"] for student, row in scores(out).items()}


def payload(page: Path) -> dict[str, Any]:
    text = page.read_text("utf-8")
    start = text.index('id="payload">') + len('id="payload">')
    found: dict[str, Any] = json.loads(text[start : text.index("</script>", start)])
    return found


# --- what changes come to --------------------------------------------------------------------


def test_a_check_is_set(mark: Callable[..., Any], graded: Path) -> None:
    assert mark(SetCheck(SLUG, "slow_zone", 20, ANN)) == {"ann": "90", "bob": "70", "eve": ""}
    row = scores(graded)["ann"]
    assert row["points_as_graded"] == "70"
    assert "was set to 20 of 30 points" in row["changed"]
    page = payload(graded / "feedback" / "ann" / f"{SLUG}.html")["grading"]
    assert (page["score"], page["max_score"]) == (90, 100)
    assert "was set to 20 of 30 points" in page["notes"][-1]
    assert "Before: fail, 0 of 30 points" in page["checks"][1]["message"]


def test_a_check_is_waived_for_all_and_held_ones_count_again(
    mark: Callable[..., Any], graded: Path
) -> None:
    assert mark(Waive(SLUG, "slow_zone")) == {"ann": "100", "bob": "100", "eve": "100"}
    assert scores(graded)["eve"]["state"] == GRADED
    page = (graded / "class.html").read_text("utf-8")
    assert "2 failed" in page  # the check is as hard as it was


def test_a_waived_check_frees_nobody_who_is_held_for_something_else(
    mark: Callable[..., Any], graded: Path
) -> None:
    with Store(graded / "store.sqlite") as store:
        store.hold(("bob", SLUG), "the grader could not be trusted")
    assert mark(Waive(SLUG, "slow_zone"))["bob"] == ""
    assert scores(graded)["bob"]["state"] == HELD


def test_a_score_counts_before_all(mark: Callable[..., Any], graded: Path) -> None:
    late = Late(SLUG, 50.0, "2020-01-01T00:00+00:00", times={"ann": "2026-01-01T00:00+00:00"})
    found = mark(Score(SLUG, 85, Whom(("ann", "eve"))), Waive(SLUG, "slow_zone", ANN), late)
    assert found == {"ann": "85", "bob": "70", "eve": "85"}
    assert (graded / "feedback" / "eve" / f"{SLUG}.html").is_file()


def test_undo_and_undo_of_the_undo(mark: Callable[..., Any], graded: Path) -> None:
    assert mark(Score(SLUG, 85, ANN))["ann"] == "85"
    assert mark(Undo(1))["ann"] == "70"
    with pytest.raises(InputError, match="undone already, by entry 2"):
        mark(Undo(1))
    with pytest.raises(InputError, match="no entry 9; there are: 1 to 2"):
        mark(Undo(9))
    assert mark(Undo(2))["ann"] == "85"
    states = re.findall(r">(counts|undone)<", (graded / "class.html").read_text())
    assert states == ["counts", "undone", "counts"]  # the newest first


def test_a_score_for_one_who_handed_in_nothing(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    (handed_in / "kim").mkdir()
    grade_class(judged)
    out = tmp_path / "out"
    with marking(out) as class_:
        task = class_.exercise("")
        with pytest.raises(InputError, match=r"kim has no grading .*not handed in"):
            class_.check(task, "blind", Whom(("kim",)))
        class_.add(Score(SLUG, 40, class_.whom(["kim"], "", everybody=False, task=task)), "p", WHY)
    assert points(out)["kim"] == "40"
    assert "Set by hand: 40 of 100" in (out / "feedback" / "kim" / f"{SLUG}.html").read_text()
    assert 'href="feedback/kim/obstacle_avoidance.html">40<' in (out / "class.html").read_text()


def test_every_export_has_the_changed_score(mark: Callable[..., Any], graded: Path) -> None:
    mark(
        Score(SLUG, 85, ANN),
        Late(SLUG, 10, "2020-01-01T00:00+00:00", times={"bob": "2020-01-02T12:00+00:00"}),
    )
    for name in (f"canvas/{SLUG}.csv", f"moodle/{SLUG}.csv"):
        rows = list(csv.reader(io.StringIO((graded / name).read_text("utf-8"), newline="")))
        found = {row[0]: row for row in rows}
        assert "85" in found["ann"], name
        assert "50" in found["bob"], name
    ann = json.loads((graded / "gradescope" / "ann" / "results.json").read_text())
    assert ann["score"] == 85
    assert "Set by hand" in ann["output"]
    assert "85" in (graded / "feedback" / "ann" / "index.html").read_text()


def test_a_regrade_and_another_run_keep_the_marks(
    mark: Callable[..., Any], grade_class: Any, graded: Path, handed_in: Path
) -> None:
    mark(Score(SLUG, 85, Whom(("ann",), versions={"ann": "of another file"})))
    grade_class(fair, regrade=True)
    assert points(graded)["ann"] == "85"
    (handed_in / "ann" / FILE).write_text("# another\n")
    grade_class(judged)
    assert points(graded)["ann"] == "85"
    page = (graded / "class.html").read_text()
    assert "for an earlier submission, and still counts; look at it again: ann" in page


# --- whom and what ---------------------------------------------------------------------------


def test_nobody_and_nothing_is_guessed(graded: Path) -> None:
    with reading(graded) as class_:
        task = class_.exercise("")
        for words, section, everybody, said in (
            (["anne"], "", False, "nobody in this class is 'anne'; did you mean ann?"),
            (["zzz"], "", False, "scores.csv lists all 3"),
            ([], "A", False, "unknown section 'A'; there are: none"),
            ([], "", False, "expected whom"),
            (["ann"], "", True, "expected whom"),
        ):
            with pytest.raises(InputError) as caught:
                class_.whom(words, section, everybody=everybody)
            assert said in str(caught.value)
        with pytest.raises(InputError, match="did you mean slow_zone"):
            class_.check(task, "slowzone", Whom())
        with pytest.raises(InputError, match="unknown exercise of this class '3'; there are: obst"):
            class_.exercise("3")
        with pytest.raises(InputError, match="expected the reason"):
            class_.store.log.append(Undo(1), "prof", "  ")


def test_a_folder_that_is_no_class(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected the folder that"), marking(tmp_path):
        pass
    assert not list(tmp_path.iterdir())


def test_a_store_of_another_version_and_one_of_an_older(graded: Path) -> None:
    db = sqlite3.connect(graded / "store.sqlite")
    db.execute("PRAGMA user_version=99")
    db.commit()
    with pytest.raises(InputError, match="schema 99"), marking(graded):
        pass
    db.execute("DROP TABLE amendments")
    db.execute("DELETE FROM kept")
    db.execute("PRAGMA user_version=1")
    db.commit()
    db.close()
    with pytest.raises(InputError, match="run `course autograde` once more"), marking(graded):
        pass


# --- lateness --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("time", "points_"),
    [
        ("2026-05-04T23:59+02:00", "70"),  # in time
        ("2026-05-05T00:14+02:00", "70"),  # within the grace
        ("2026-05-05T00:15+02:00", "60"),  # one day, from the deadline on
        ("Wednesday, 6 May 2026, 12:00 AM", "50"),  # Moodle's, in the given zone: a day and a bit
        ("2026-05-05 21:58:59.123456789 UTC", "60"),
        ("2026-08-01T00:00+02:00", "30"),  # the cap
    ],
)
def test_days_grace_and_cap(time: str, points_: str, tmp_path: Path) -> None:
    file = tmp_path / "times.csv"
    file.write_text(f'id,time\nann,"{time}"\nbob,-\n')
    times = times_of(file, "Europe/Berlin", ["ann", "bob"], {})
    deadline = moment_of("2026-05-04 23:59", "Europe/Berlin")
    rule = Late(SLUG, 10, deadline, span_of("15min"), 40, "Europe/Berlin", times)
    entries = [Entry(1, "", "", rule, "")]
    results = [result(name, *CHECKS) for name in ("ann", "bob")]
    (ann, bob), _ = amended(results, entries, {})
    task = tasks_of(results)[0]
    assert (points_of(ann, task), points_of(bob, task)) == (float(points_), 70)


def test_more_time_for_one_and_nothing_below_zero(mark: Callable[..., Any], graded: Path) -> None:
    times = dict.fromkeys(("ann", "bob"), "2026-06-01T00:00+00:00")
    rule = Late(SLUG, 100, "2026-05-01T00:00+00:00", times=times)
    more = Late(SLUG, 100, "2026-07-01T00:00+00:00", times=times, whom=ANN)
    assert mark(rule, more) == {"ann": "70", "bob": "0", "eve": ""}
    assert "no time is known" not in (graded / "class.html").read_text()
    mark(Late(SLUG, 100, "2026-05-01T00:00+00:00"))
    page = (graded / "class.html").read_text()
    assert "no time is known of when it was handed in; not counted as late: ann, bob." in page


def test_canvas_says_only_late(grade_class: Any, handed_in: Path, tmp_path: Path) -> None:
    for path in list(handed_in.iterdir()):
        (path / FILE).unlink()
        path.rmdir()
    (handed_in / f"leecarla_LATE_12_34_{FILE}").write_text("# a\n")
    (handed_in / f"raybo_13_35_{FILE}").write_text("# b\n")
    grade_class(judged)
    out = tmp_path / "out"
    with marking(out) as class_:
        class_.add(Late(SLUG, 10), "prof", WHY)
    assert points(out) == {"leecarla_12": "60", "raybo_13": "70"}
    assert "counted as one day" in (out / "class.html").read_text()


def test_times_of_an_exchange_and_its_gradebook(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    for name, time in (("ann", "2026-05-04 20:00:00"), ("bob", "2026-05-06 00:00:01.5")):
        (handed_in / name).rename(handed_in / f"{name}+week1+{time} UTC")
    (handed_in / "eve" / FILE).unlink()
    (handed_in / "eve").rmdir()
    grade_class(judged)
    out = tmp_path / "out"
    with marking(out) as class_:
        class_.add(Late(SLUG, 10, "2026-05-04T22:00+02:00", grace=60), "prof", WHY)
    text = (out / "nbgrader.csv").read_text("utf-8")
    rows = {row["student_id"]: row for row in csv.DictReader(io.StringIO(text, newline=""))}
    found = {
        name: tuple(row[key] for key in ("raw_score", "late_submission_penalty", "score"))
        for name, row in rows.items()
    }
    assert found == {"ann": ("70", "0", "70"), "bob": ("70", "20", "50")}


def test_times_that_are_none(tmp_path: Path, graded: Path) -> None:
    file = tmp_path / "times.csv"
    with reading(graded) as class_:
        for text, said in (
            ("id,time\nann,soon\n", "'soon'; expected a time"),
            ("id,time\nanna,2026-05-04\n", "nobody in this class is"),
            ("id,when\nann,2026-05-04\n", "expected id"),
        ):
            file.write_text(text)
            with pytest.raises(InputError, match=said):
                times_of(file, "UTC", class_.students, class_.rows)
    with pytest.raises(InputError, match="expected a time zone"):
        moment_of("2026-05-04", "Mars")
    with pytest.raises(InputError, match="expected a time such as"):
        moment_of("tomorrow", "UTC")
    with pytest.raises(InputError, match="expected a time span"):
        span_of("a while")


# --- what is published -------------------------------------------------------------------------


def test_published_pages_are_kept_in_step(mark: Callable[..., Any], graded: Path) -> None:
    there = graded / "published"
    mark(Publish((), ANN))
    assert sorted(p.relative_to(there).as_posix() for p in there.rglob("*.html")) == [
        "ann/index.html", f"ann/{SLUG}.html",
    ]  # fmt: skip
    mark(Score(SLUG, 85, ANN))
    assert payload(there / "ann" / f"{SLUG}.html")["grading"]["score"] == 85
    mark(Publish((), Whom()), Undo(1))
    assert {p.name for p in there.iterdir()} == {"ann", "bob", "eve"}
    assert not (there / "eve" / f"{SLUG}.html").exists()  # she is held
    mark(Undo(3))
    assert not there.exists()


# --- the log -----------------------------------------------------------------------------------


def test_the_log_only_grows(mark: Callable[..., Any], graded: Path) -> None:
    mark(Score(SLUG, 85, ANN))
    db = sqlite3.connect(graded / "store.sqlite")
    for statement in ("UPDATE amendments SET why='x'", "DELETE FROM amendments"):
        with pytest.raises(sqlite3.IntegrityError, match="only grows"):
            db.execute(statement)
    db.close()


@pytest.fixture
def edit(graded: Path) -> Callable[[str], None]:
    def edit(statement: str) -> None:
        db = sqlite3.connect(graded / "store.sqlite")
        for verb in ("UPDATE", "DELETE"):
            db.execute(f"DROP TRIGGER IF EXISTS amendments_{verb}")
        db.execute(statement)
        db.commit()
        db.close()

    return edit


@pytest.mark.parametrize(
    ("statement", "number", "said"),
    [
        ("UPDATE amendments SET what=replace(what, '85', '99') WHERE number=1", 1, "changed"),
        ("UPDATE amendments SET what='[]' WHERE number=2", 2, "changed"),
        ("UPDATE amendments SET why='was told to' WHERE number=2", 2, "changed"),
        ("DELETE FROM amendments WHERE number=1", 1, "removed"),
        ("DELETE FROM amendments WHERE number=2", 2, "removed"),
    ],
)
def test_a_log_that_was_edited_by_hand(
    mark: Callable[..., Any], graded: Path, edit: Callable[[str], None], grade_class: Any,
    statement: str, number: int, said: str,
) -> None:  # fmt: skip
    mark(Score(SLUG, 85, ANN), Score(SLUG, 35, Whom(("bob",))))
    before = (graded / "scores.csv").read_text()
    edit(statement)
    with pytest.raises(InputError, match=f"entry {number} .*{said}"):
        mark(Score(SLUG, 1, ANN))
    with pytest.raises(InputError, match=f"entry {number} .*{said}"):
        grade_class(judged)
    assert (graded / "scores.csv").read_text() == before
    with reading(graded) as class_:
        assert [entry.number for entry in class_.entries if entry.problem] == [number]
    found = mark(Undo(number))  # said to count no longer
    assert found == {"ann": "85" if number == 2 else "70", "bob": "35" if number == 1 else "70",
                     "eve": ""}  # fmt: skip


@pytest.mark.parametrize("ends", [KeyboardInterrupt(), OSError(errno.ENOSPC, "full")])
def test_what_ends_while_results_are_written_is_in_the_log(
    graded: Path, monkeypatch: pytest.MonkeyPatch, ends: BaseException
) -> None:
    def end(*_: object) -> None:
        raise ends

    with monkeypatch.context() as patch:
        patch.setattr("grader.classroom.folder.write_results", end)
        with pytest.raises((KeyboardInterrupt, DiskFull)) as caught, marking(graded) as class_:
            class_.add(Score(SLUG, 85, ANN), "prof", WHY)
    if isinstance(caught.value, DiskFull):
        assert "course marks write" in str(caught.value)
    assert points(graded)["ann"] == "70"
    with marking(graded) as class_:
        class_.write()
    assert points(graded)["ann"] == "85"


def test_two_at_once(graded: Path) -> None:
    with marking(graded), pytest.raises(GraderError, match="another"), marking(graded):
        pass


def _append(out: Path, count: int) -> None:
    with Store(out / "store.sqlite") as store:
        for number in range(count):
            store.log.append(Undo(number), "prof", WHY)


def test_entries_of_two_at_once_are_all_there(tmp_path: Path) -> None:
    with Store(tmp_path / "store.sqlite"):
        pass
    with ThreadPoolExecutor(2) as both:
        list(both.map(_append, [tmp_path] * 2, [20] * 2))
    with Store(tmp_path / "store.sqlite") as store:
        entries = store.log.entries()
    assert [entry.number for entry in entries] == list(range(1, 41))
    assert not any(entry.problem for entry in entries)


@pytest.fixture
def odd_names(handed_in: Path) -> Iterator[list[str]]:
    names = ["=1+1", "--all", "<img src=x onerror=alert(1)>", "-h", "@SUM(A1)"]
    for name in names:
        (handed_in / name).mkdir()
        (handed_in / name / FILE).write_text(f"# {name}\n")
    yield names


def test_names_that_are_formulas_options_or_html(
    odd_names: list[str], grade_class: Any, tmp_path: Path
) -> None:
    grade_class(judged)
    out = tmp_path / "out"
    with marking(out) as class_:
        whom = class_.whom(["=1+1", "--all", "-h"], "", everybody=False)
        class_.add(Score(SLUG, 85, whom), "=cmd()", "<script>alert(1)</script>")
        odd: Marking = class_
        assert len(odd.students) == 8
    found = points(out)
    assert [found[name] for name in ("'=1+1", "'--all", "'-h", "'@SUM(A1)")] == [
        "85", "85", "85", "70",
    ]  # fmt: skip
    page = (out / "class.html").read_text("utf-8")
    assert "<script>" not in page
    assert "&lt;script&gt;alert(1)" in page
    assert "<img" not in page
