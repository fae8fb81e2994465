"""What changed since the last attempt, whatever became of the file that remembers it."""

from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from grader.cli.why import why
from grader.course.exercises import SOLUTIONS, find_exercise
from grader.errors import InputError
from grader.grading.attempts import (
    LAST,
    MAX_BYTES,
    MAX_FILES,
    attempts,
    history,
    keep,
    last_grading,
    since_last,
)
from grader.grading.grading import Grading
from grader.grading.plugin import CheckResult

EXERCISE = find_exercise("obstacle_avoidance")
NAME = EXERCISE.files[0]


def grading(**outcomes: str) -> Grading:
    """Return a grading in which each check is worth ten points; `field…` are worth none."""
    checks = []
    for name, outcome in outcomes.items():
        most = 0 if name.startswith("field") else 10
        kind, points = ("core" if most else "field"), most if outcome == "pass" else 0
        checks.append(CheckResult(name, name, kind, points, most, outcome))
    return Grading(EXERCISE, NAME, 1, tuple(checks), ())


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "work" / NAME
    path.parent.mkdir()
    path.write_text("pass")
    return path


@pytest.fixture(autouse=True)
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where they are kept, for this test."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    history().parent.mkdir(parents=True)
    return history()


def test_what_changed_is_told_by_the_points(file: Path) -> None:
    first = grading(wiring="pass", slow_zone="fail", stop_zone="skip", field_lds01="skip")
    assert since_last(first, file) == ""
    better = grading(wiring="fail", slow_zone="pass", stop_zone="pass", field_lds01="pass")
    said = "+20: slow_zone, stop_zone, field_lds01; -10: wiring"
    assert since_last(better, file) == said
    assert since_last(better, file) == ""
    assert since_last(first, file.parent).endswith(
        "-20: slow_zone, stop_zone, field_lds01"
    )  # the folder


def test_a_check_that_was_not_judged_or_not_run_changes_nothing(file: Path) -> None:
    since_last(grading(wiring="pass", slow_zone="fail", stop_zone="fail"), file)
    assert since_last(grading(wiring="error", slow_zone="pass"), file) == "+10: slow_zone"
    assert since_last(grading(wiring="pass", stop_zone="pass"), file) == "+10: stop_zone"


def test_another_exercise_and_another_file_have_their_own(file: Path, tmp_path: Path) -> None:
    since_last(grading(wiring="fail"), file)
    assert since_last(grading(wiring="pass"), tmp_path / NAME) == ""
    other = replace(grading(wiring="pass"), exercise=find_exercise("goal_seeking"))
    assert since_last(other, file) == ""


@pytest.mark.parametrize(
    "content",
    [
        b"", b"{", b"[]", b"\xff", b'{"attempts": {"x": {"y": [1]}}}', b"[" * 40_000,
        b'{"attempts": {"obstacle_avoidance:%s": {"wiring": ["a", 2]}}}' % NAME.encode(),
        b" " * (MAX_BYTES + 10),
    ],
    ids=range(8),
)  # fmt: skip
def test_a_damaged_file_is_no_error(file: Path, kept: Path, content: bytes) -> None:
    kept.write_bytes(content)
    assert since_last(grading(wiring="fail"), file) == ""
    assert since_last(grading(wiring="pass"), file) == "+10: wiring"


def test_a_link_is_not_followed(file: Path, kept: Path, tmp_path: Path) -> None:
    target = tmp_path / "target"
    target.write_text("precious")
    kept.symlink_to(target)
    since_last(grading(wiring="fail"), file)
    assert target.read_text() == "precious"
    assert since_last(grading(wiring="pass"), file) == "+10: wiring"


def test_where_nothing_can_be_kept_nothing_is_said(
    file: Path, kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept.mkdir()
    for home in (str(tmp_path / "state"), str(file)):  # a folder of that name, a file as a folder
        monkeypatch.setenv("XDG_STATE_HOME", home)
        since_last(grading(wiring="fail"), file)
        assert since_last(grading(wiring="pass"), file) == ""
    assert list(kept.parent.iterdir()) == [kept]  # nothing is left lying about
    assert attempts() == {}


def test_it_stays_small_and_away_from_the_students_folder(file: Path) -> None:
    for i in range(MAX_FILES + 5):
        since_last(grading(wiring="pass"), file.with_name(f"agent_{i}.py"))
    assert len(attempts()) == MAX_FILES
    newest = file.with_name(f"agent_{MAX_FILES + 4}.py")
    assert list(attempts().items())[-1] == ((EXERCISE.slug, newest), {"wiring": True})
    assert list(file.parent.iterdir()) == [file]


def test_the_courses_own_solutions_are_nobodys_attempt() -> None:
    since_last(grading(wiring="fail"), SOLUTIONS / "obstacle_avoidance" / NAME)
    assert attempts() == {}


def test_why_prints_one_check_of_the_last_grading_in_full(kept: Path) -> None:
    said = CheckResult("slow_zone", "It is slow.", "core", 0, 10, "fail", message="It drove on.")
    asked = CliRunner().invoke(why, ["slow_zone"])
    assert isinstance(asked.exception, InputError)  # nothing has been graded
    keep(Grading(EXERCISE, NAME, 1, (said,), ()).as_dict())
    for arguments in (["slow_zone"], []):
        assert "It drove on." in CliRunner().invoke(why, arguments).output
    asked = CliRunner().invoke(why, ["slow_zon"])
    assert "did you mean 'slow_zone'" in str(asked.exception)
    kept.with_name(LAST).write_text("not JSON")
    assert last_grading() is None
