"""Marks that people change: what they come to, in every export."""

import csv
import errno
import io
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_class import FILE, SLUG, fair
from handing_in import roster_of
from made_results import result
from marked_class import ANN, CHECKS, WHY, judged, marked, payload, points, scores

from grader.classroom.amendments.apply import amended
from grader.classroom.amendments.change import Late, Publish, Score, SetCheck, Undo, Waive, Whom
from grader.classroom.amendments.late import lateness, moment_of, times_of
from grader.classroom.amendments.log import Entry
from grader.classroom.amendments.marks import points_of
from grader.classroom.amendments.people import the_student
from grader.classroom.desk.marking import marking, reading
from grader.classroom.folder import UNWRITTEN
from grader.classroom.queue.store import Store
from grader.classroom.results import write
from grader.classroom.row import GRADED, HELD
from grader.errors import DiskFull, GraderError, InputError
from grader.lms.book import Handed, StudentRow
from grader.lms.people import Person
from grader.lms.told import span

# --- what changes come to --------------------------------------------------------------------


def test_a_check_is_set(mark: Callable[..., Any], graded: Path) -> None:
    assert mark(SetCheck(SLUG, "slow_zone", 20, ANN)) == {"ann": "90", "bob": "70", "eve": ""}
    row = scores(graded)["ann"]
    assert row["points_as_graded"] == "70"
    assert "was set to 20 of 30 points" in row["changed"]
    page = payload(graded / "feedback" / "ann" / f"{SLUG}.html")["grading"]
    assert (page["score"], page["max_score"]) == (90, 100)
    assert "was set to 20 of 30 points" in page["notes"][-1]
    (set_,) = (check for check in page["checks"] if check["id"] == "slow_zone")
    assert "Before: fail, 0 of 30 points" in set_["message"]


def test_a_check_is_waived_for_all_and_held_ones_count_again(
    mark: Callable[..., Any], graded: Path
) -> None:
    assert mark(Waive(SLUG, "slow_zone")) == {"ann": "100", "bob": "100", "eve": "100"}
    assert scores(graded)["eve"]["state"] == GRADED
    page = (graded / "class.html").read_text("utf-8")
    assert "2 failed" in page  # the check is as hard as it was


@pytest.mark.parametrize(
    ("may_lower", "points_"),
    [(False, {"ann": "70", "bob": "90"}), (True, {"ann": "25", "bob": "75"})],
)
def test_no_mark_is_lowered_unless_it_is_said(
    mark: Callable[..., Any], may_lower: bool, points_: dict[str, str]
) -> None:
    """Without the zone of 60 points, ann has 10 of 40, and bob, whose other check was set, 30."""
    mark(SetCheck(SLUG, "slow_zone", 20, Whom(("bob",)), may_lower=False))
    found = mark(Waive(SLUG, "stop_zone", may_lower=may_lower))
    assert found == points_ | {"eve": ""}
    lower = SetCheck(SLUG, "slow_zone", 5, Whom(("bob",)), may_lower=False)
    assert mark(lower) == found


def test_a_waived_check_frees_nobody_who_is_held_for_something_else(
    mark: Callable[..., Any], graded: Path
) -> None:
    with Store(graded / "store.sqlite") as store:
        store.hold(("bob", SLUG), "the grader could not be trusted: it could not judge wiring")
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
    text = (graded / "canvas" / f"{SLUG}.csv").read_text("utf-8")
    found = {row[0]: row for row in csv.reader(io.StringIO(text, newline=""))}
    assert "85" in found["ann"]
    assert "50" in found["bob"]
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


# --- nothing that goes wrong loses an entry ----------------------------------------------------


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


# --- whom and what ---------------------------------------------------------------------------


def test_nobody_and_nothing_is_guessed(graded: Path) -> None:
    with reading(graded) as class_:
        task = class_.exercise("")
        for words, section, everybody, said in (
            (["anne"], "", False, "not 'anne'; did you mean ann?"),
            (["zzz"], "", False, "scores.csv lists all"),
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
            class_.store.log(Undo(1), "prof", "  ")


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("Ray, Carla", ""),
        ("ray, carla", ""),
        ("carla ray", ""),
        ("Lee", r"did you mean leeann_1 \(Ann Lee, 1\) or leeann_2 \(Ann Lee, 2\)\?"),
        (
            "Ann Lee",
            r"not 'Ann Lee'; did you mean leeann_1 \(Ann Lee, 1\) or leeann_2 \(Ann Lee, 2\)\?",
        ),
        ("Ray", r"did you mean raycarla_3 \(Carla Ray, 3\)\?"),
    ],
)
def test_people_are_called_as_gradebooks_do(word: str, said: str) -> None:
    names = {"leeann_1": "Ann Lee", "leeann_2": "Ann Lee", "raycarla_3": "Carla Ray"}
    rows = {student: StudentRow(student, Person(name, ids={"canvas": student[-1]}))
            for student, name in names.items()}  # fmt: skip
    if not said:
        assert the_student(word, list(names), rows) == "raycarla_3"
        return
    with pytest.raises(InputError, match=said):
        the_student(word, list(names), rows)


def test_a_folder_without_a_graded_class(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="expected the folder that"), marking(tmp_path):
        pass
    assert not list(tmp_path.iterdir())
    with Store(tmp_path / "store.sqlite"):
        pass
    with pytest.raises(InputError, match="nothing was graded here yet"), marking(tmp_path):
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
    rule = Late(SLUG, 10, deadline, span("15min"), 40, "Europe/Berlin", times)
    entries = [Entry(1, "", "", rule, "")]
    results = [result(name, *CHECKS) for name in ("ann", "bob")]
    (ann, bob), _ = amended(results, entries, {})
    assert (points_of(ann), points_of(bob)) == (float(points_), 70)


def test_more_time_for_one_and_nothing_below_zero(mark: Callable[..., Any], graded: Path) -> None:
    times = dict.fromkeys(("ann", "bob"), "2026-06-01T00:00+00:00")
    rule = Late(SLUG, 100, "2026-05-01T00:00+00:00", times=times)
    more = Late(SLUG, 100, "2026-07-01T00:00+00:00", times=times, whom=ANN)
    assert mark(rule, more) == {"ann": "70", "bob": "0", "eve": ""}
    assert "no time is known" not in (graded / "class.html").read_text()
    mark(Late(SLUG, 100, "2026-05-01T00:00+00:00"))
    page = (graded / "class.html").read_text()
    assert "no time is known of when it was handed in; not counted as late: ann, bob." in page


def test_moodles_worksheet_knows_times_and_extensions(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    """In German, and in the zone of the deadline."""
    head = (
        "ID,Vollständiger Name,Status,Bewertung,Beste Bewertung,Bewertung kann geändert werden,"
        "Zuletzt geändert (Abgabe),Zuletzt geändert (Bewertung)\n"
    )
    more = "Abgegeben - Verlängertes Abgabeende bis: Donnerstag, 7. Mai 2026, 12:00"
    time = '"Donnerstag, 7. Mai 2026, 00:30"'
    for n, name in enumerate(("ann", "bob", "eve")):
        (handed_in / name).rename(handed_in / f"{name}_{70 + n}_assignsubmission_file")
        head += f'Teilnehmer/in{70 + n},{name},"{more if name == "bob" else "-"}",,"100,00",Ja,'
        head += f"{time if name != 'eve' else '-'},-\n"
    grade_class(judged, roster=roster_of(tmp_path, head))
    rule = Late(SLUG, 10, "2026-05-04T23:59+02:00", zone="Europe/Berlin")
    assert marked(tmp_path / "out", rule) == {"ann": "40", "bob": "70", "eve": ""}


def test_canvas_says_only_late(grade_class: Any, handed_in: Path, tmp_path: Path) -> None:
    for path in list(handed_in.iterdir()):
        (path / FILE).unlink()
        path.rmdir()
    (handed_in / f"leecarla_LATE_12_34_{FILE}").write_text("# a\n")
    (handed_in / f"raybo_13_35_{FILE}").write_text("# b\n")
    grade_class(judged)
    out = tmp_path / "out"
    assert marked(out, Late(SLUG, 10)) == {"leecarla_12": "60", "raybo_13": "70"}
    assert "counted as one day" in (out / "class.html").read_text()


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
    with pytest.raises(InputError, match="expected a time of the years"):
        moment_of("tomorrow", "UTC")
    with pytest.raises(InputError, match="expected a time span"):
        span("a while")


def test_pages_stay_published_while_they_are_written_and_a_kill_is_told(
    mark: Callable[..., Any], graded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mark(Publish((), Whom()))
    page = graded / "published/bob/obstacle_avoidance.html"
    before, real = page.read_bytes(), write.index_page
    made: list[Any] = []

    def killed(*about: Any) -> str:
        made.append(about)
        if len(made) == 1:  # of feedback; then comes the published one
            return real(*about)
        assert page.read_bytes() == before
        raise KeyboardInterrupt

    monkeypatch.setattr(write, "index_page", killed)
    with pytest.raises(KeyboardInterrupt):
        mark(Score(SLUG, 30, ANN))
    assert page.read_bytes() == before
    monkeypatch.undo()
    with marking(graded) as class_:
        assert f"course marks write {graded}" in class_.summary()
        class_.write()
        assert "course marks write" not in class_.summary()
    assert points(graded)["ann"] == "30"


@pytest.mark.parametrize(
    ("deadline", "told", "days"),
    [
        ("2026-10-24T23:59", "Sunday, 25 October 2026, 11:59 PM", 1),  # 25 hours later
        ("2026-10-24T23:59", "Monday, 26 October 2026, 12:00 AM", 2),
        ("2026-10-25T02:59", "2026-10-25T02:10+01:00", 1),  # the hour that there is twice
        ("2026-03-28T23:59", "Sunday, 29 March 2026, 11:59 PM", 1),
        ("2026-03-29T02:30", "Sunday, 29 March 2026, 2:30 AM", 0),  # an hour that isn't there
    ],
)
def test_late_days_where_clocks_change(deadline: str, told: str, days: int) -> None:
    zone = "Europe/Berlin"
    rule = Late(SLUG, 10, moment_of(deadline, zone), 0, 100, zone, {})
    assert lateness(rule, "ann", Handed("moodle", time=told)) == (days, "")


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


def test_a_change_writes_only_the_pages_that_it_changes(
    mark: Callable[..., Any], graded: Path
) -> None:
    mark(Publish((), Whom()))
    places = [graded / folder / student / "index.html" for folder in ("feedback", "published")
              for student in ("ann", "bob")]  # fmt: skip
    before = [each.stat().st_ino for each in places]  # replaced at once, so another is new
    mark(Score(SLUG, 30, ANN))
    after = [each.stat().st_ino for each in places]
    assert [a == b for a, b in zip(before, after, strict=True)] == [False, True, False, True]
    mark(Publish((), ANN), Undo(1))
    assert [each.exists() for each in places] == [True, True, True, False]
    (graded / "feedback/bob/index.html").unlink()
    with Store(graded / "store.sqlite") as store:
        store.keep(UNWRITTEN, "yes")  # a command was ended while it wrote
    mark(Score(SLUG, 40, ANN))
    assert places[1].is_file()
