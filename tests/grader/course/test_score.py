"""The cap: what holds it, what doesn't, and what is left of each check's points."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from grader.course import exercises
from grader.course.exercises import ROOT, Essential, find_exercise
from grader.course.score import score_of
from grader.errors import GraderError, InputError
from grader.grading.grading import grade
from grader.trial.trials import SavedTrials

ESSENTIAL = Essential(("stop",), "Somebody is in the way.")


def check(id: str, outcome: str, points: int, kind: str = "core") -> dict[str, object]:
    won = points if outcome == "pass" else 0
    return {
        "id": id, "title": f"{id} works.", "outcome": outcome, "points": won,
        "max_points": points, "kind": kind,
    }  # fmt: skip


def test_without_an_essential_check_the_points_are_the_score() -> None:
    score = score_of([check("stop", "fail", 10), check("go", "pass", 90)], None)
    assert (score.raw, score.most, score.points, score.note, score.share) == (90, 100, 90, "", 1.0)


@pytest.mark.parametrize(
    ("outcome", "points"),
    [("fail", 50), ("skip", 50), ("pass", 100), ("error", 90), ("inconclusive", 90)],
)
def test_the_cap_holds_while_an_essential_check_is_failed_or_skipped(
    outcome: str, points: int
) -> None:
    score = score_of([check("stop", outcome, 10), check("go", "pass", 90)], ESSENTIAL)
    assert score.points == points
    assert bool(score.note) is (points == 50)


def test_the_cap_is_a_share_of_the_points_that_count() -> None:
    checks = [check("stop", "fail", 10), check("go", "pass", 70), check("gpu", "unavailable", 20)]
    score = score_of(checks, ESSENTIAL)
    assert (score.most, score.raw, score.points) == (80, 70, 40)
    assert score.share == pytest.approx(40 / 70)
    assert score.note == (
        "At most 40 of 80 points until this passes: “stop works”. Somebody is in the way. "
        "Before this cap: 70 points."
    )


def test_a_score_below_the_cap_is_left_alone() -> None:
    score = score_of([check("stop", "fail", 60), check("go", "pass", 40)], ESSENTIAL)
    assert (score.points, score.note) == (40, "")


def test_field_checks_neither_give_points_nor_hold_the_cap() -> None:
    checks = [check("go", "pass", 100), check("stop", "fail", 0, kind="field")]
    assert score_of(checks, ESSENTIAL).points == 100


@pytest.mark.parametrize("cap", [-1, 101])
def test_a_cap_beyond_a_percentage_is_refused_with_file_and_key(
    cap: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    about = (ROOT / "exercises/obstacle_avoidance/exercise.toml").read_text("utf-8")
    (tmp_path / "obstacle_avoidance").mkdir()
    file = tmp_path / "obstacle_avoidance" / "exercise.toml"
    file.write_text(about.replace("cap = 50", f"cap = {cap}"))
    monkeypatch.setattr(exercises, "EXERCISES", tmp_path)
    with pytest.raises(GraderError, match=r"exercise\.toml: .*\$\.essential\.cap"):
        exercises.all_exercises()


def test_an_essential_check_that_is_none_is_refused_with_the_nearest_name() -> None:
    exercise = find_exercise("1")
    wrong = replace(exercise, essential=Essential(("stop_zona",), "why"))
    with pytest.raises(InputError) as caught:
        grade(wrong, SavedTrials([]), file="x.py")
    assert str(caught.value) == (
        "exercises/obstacle_avoidance/exercise.toml: essential.checks: no check 'stop_zona'; "
        "did you mean 'stop_zone'?"
    )


def test_what_a_person_has_waived_does_not_hold_the_cap() -> None:
    waived = {**check("stop", "skip", 10), "waived": True, "max_points": 0}
    assert score_of([waived, check("go", "pass", 90)], ESSENTIAL).points == 90
