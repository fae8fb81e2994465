"""`course marks` and `course report`: what they say, their exit codes, the options of a batch."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner
from fake_class import FILE, SLUG, grading, until
from handing_in import put
from marked_class import points

from grader.classroom import batch
from grader.classroom.options import Options
from grader.classroom.queue.store import Store
from grader.classroom.queue.work import Unit, UnitResult
from grader.classroom.row import GRADED, WAITING
from grader.cli import cli
from grader.errors import GraderError, InputError
from grader.lms.people import Person, Roster


@pytest.fixture
def graded(grade_class: Any, tmp_path: Path) -> Path:
    grade_class()
    return tmp_path / "out"


Course = Callable[..., tuple[int, str]]


@pytest.fixture
def course(graded: Path) -> Course:
    def course(command: str, *arguments: object) -> tuple[int, str]:
        words = [*command.split(), str(graded), *map(str, arguments)]
        done = CliRunner().invoke(cli, words, standalone_mode=False)
        if done.exception is not None:
            raise done.exception
        return done.return_value, done.output  # type: ignore[return-value]

    return course


def test_writing_says_how_far_it_is(course: Course, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("grader.classroom.results.write.EVERY", 2)
    assert course("marks write") == (0, "the pages of 2 of 3 students are written\nWritten.\n")


def test_a_score_its_log_and_its_undo(course: Course, graded: Path) -> None:
    code, said = course("marks score", 85, "--student", "ann", "--why", "by e-mail", "--by", "Dr A")
    assert code == 0
    assert said.splitlines() == [
        f"Entry 1: {SLUG}: 85 points (ann)", "Scores that change: 1, 1 of them down",
        f"  ann  {SLUG}  100 → 85",
    ]  # fmt: skip
    code, said = course("report", "--student", "ann")
    assert code == 0
    for part in (f"{SLUG}: 85, graded 100", "Set by hand", "by entry 1", "Dr A", "why: by e-mail"):
        assert part in said
    code, said = course("marks undo", 1, "--why", "a slip")
    assert "ann  obstacle_avoidance  85 → 100" in said
    _, said = course("report")
    assert "[undone by 2]" in said
    _, said = course("report", "--json", "-")
    first, second = json.loads(said)
    assert (first["what"]["kind"], second["what"]) == ("score", {"kind": "undo", "number": 1})
    assert points(graded) == dict.fromkeys(("ann", "bob", "eve"), "100")


def test_a_preview_writes_nothing(course: Course, graded: Path) -> None:
    said = course("marks score", 85, "--student", "ann", "--why", "x", "--preview")[1]
    assert said.splitlines() == [
        "Nothing is written. Scores that change: 1, 1 of them down", f"  ann  {SLUG}  100 → 85",
    ]  # fmt: skip
    assert points(graded)["ann"] == "100"
    assert course("report")[1].endswith("Nobody has changed a mark.\n")


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("marks score 101 --student ann", "gives 0 to 100"),
        ("marks score 50 --all", "a score is one student's"),
        ("marks score 50 --student annn", "did you mean ann"),
        ("marks set no_check 5 --all", "unknown check of obstacle_avoidance"),
        ("marks late --per-day 10 --all --times nowhere.csv", "cannot read"),
        ("marks late --per-day 10 --all --deadline soon", "expected a time"),
        ("marks late --per-day 10 --all --deadline 2026-05-04", "expected the time of day, too"),
        ("marks late --per-day 10 --all --zone Mars", "expected a time zone"),
        ("marks late --per-day nan --all", "expected a number from 0 to 100, such as 8.5"),
        ("marks late --per-day 10% --all", "expected a number from 0 to 100"),
        ("marks late --per-day 10 --cap nan --all", "expected a number from 0 to 100"),
        ("marks set slow_zone nan --all", "expected a number from 0 to 1,000,000, such as 8.5"),
        ("marks score 8,5 --student ann", "'8,5': expected a number from 0 to 1,000,000"),
        ("marks score nan --student ann", "expected a number from 0 to 1,000,000"),
        ("marks set slow_zone -5 --all", "No such option '?-5"),
        ("marks undo 7", "no entry 7"),
        ("report --student nobody_at_all", "expected one student of this class"),
    ],
)
def test_wrong_usage_changes_nothing(course: Course, command: str, said: str) -> None:
    group, *rest = command.split()
    first = f"{group} {rest.pop(0)}" if group == "marks" else group
    why = ("--why", "x") if group == "marks" else ()
    with pytest.raises((InputError, click.UsageError), match=said):
        course(first, *rest, *why)
    assert course("report")[1].endswith("Nobody has changed a mark.\n")


def test_students_called_like_an_option(
    grade_class: Any, handed_in: Path, course: Course, graded: Path
) -> None:
    put(handed_in, **{f"--all/{FILE}": "#\n"})
    grade_class()
    _, said = course("marks score", 1, "--student", "--all", "--why", "--by")
    assert "(all)" in said  # `tar *` would take the dashes for an option
    assert points(graded) == {"all": "1", "ann": "100", "bob": "100", "eve": "100"}


def test_a_note_is_said_once(course: Course) -> None:
    late = ("--per-day", 10, "--deadline", "2026-05-04T23:59", "--all", "--why", "x")
    assert "no time is known" in course("marks late", *late)[1]
    assert "no time is known" not in course("marks score", 85, "--student", "ann", "--why", "x")[1]


# --- one student once more -------------------------------------------------------------------


def test_one_student_again(grade_class: Any) -> None:
    grade_class()
    _, workers, _ = grade_class(again=("ANN",))
    assert workers.students == ["ann"]
    with pytest.raises(
        InputError, match="expected one student of this class, not 'anne'; did you mean ann"
    ):
        grade_class(again=("anne",))


def test_one_student_judged_again(grade_class: Any) -> None:
    grade_class()
    lower: Callable[[Unit], UnitResult] = lambda unit: UnitResult(grading(score=40))  # noqa: E731
    results, workers, _ = grade_class(lower, regrade=True, only=("bob",))
    assert workers.students == ["bob"]
    assert {name: r.grading["score"] for name, r in results.items() if r.grading} == {
        "ann": 100, "bob": 40, "eve": 100,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("words", "regrade", "only"),
    [
        ((), False, ()),
        (("--regrade",), True, ()),
        (("--regrade", "ann"), True, ("ann",)),
        (("--regrade", "ann", "--regrade", "bob"), True, ("ann", "bob")),
    ],
)
def test_regrade_takes_a_student_or_none(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, words: tuple[str, ...], regrade: bool,
    only: tuple[str, ...],
) -> None:  # fmt: skip
    told: list[tuple[bool, Options]] = []

    def grade(_: Any, __: Any, options: Options, ___: Any, *, regrade: bool) -> Any:
        told.append((regrade, options))
        raise GraderError("enough")

    monkeypatch.setattr(batch, "autograde", grade)
    command = ["autograde", str(tmp_path), "--out", str(tmp_path / "out"), "--trust", *words]
    done = CliRunner().invoke(cli, command, standalone_mode=False)
    assert isinstance(done.exception, GraderError), done.output
    assert [(again, options.only) for again, options in told] == [(regrade, only)]


def test_a_folder_after_regrade_is_no_student(tmp_path: Path) -> None:
    command = ["autograde", "--out", str(tmp_path / "out"), "--regrade", str(tmp_path)]
    done = CliRunner().invoke(cli, command, standalone_mode=False)
    assert isinstance(done.exception, InputError)
    assert "what comes after --regrade is a student" in str(done.exception)


# --- after Ctrl-C ------------------------------------------------------------------------------


def test_after_ctrl_c_what_is_there_is_complete(grade_class: Any, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        grade_class(until("eve"))
    out = tmp_path / "out"
    with Store(out / "store.sqlite") as store:
        assert [result.state for result in store.results()] == [GRADED, GRADED, WAITING]
    assert points(out) == {"ann": "100", "bob": "100", "eve": ""}
    assert "1 not graded yet" in (out / "class.html").read_text()
    for name in ("ann", "bob"):
        assert (out / "feedback" / name / f"{SLUG}.html").is_file()
    assert "ann,,ann,,100" in (out / "canvas" / f"{SLUG}.csv").read_text()
    grade_class()
    assert points(out) == dict.fromkeys(("ann", "bob", "eve"), "100")


def test_who_has_nothing_to_be_published_is_named(course: Course, grade_class: Any) -> None:
    grade_class(roster=Roster((Person("zoe", ids={"login": "zoe"}),)))
    said = course("marks publish", "--all", "--why", "looked at")[1]
    assert "Students with published feedback: 3 " in said
    assert said.splitlines()[-1].endswith("an index without pages: zoe")
