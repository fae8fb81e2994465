"""What the folders of exercises say of themselves, and how an exercise is found."""

from pathlib import Path

import pytest

from grader.course import exercises
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.errors import GraderError, InputError
from sim.messages import typestore

ALL = all_exercises()
slugs = pytest.mark.parametrize("exercise", ALL, ids=lambda exercise: exercise.slug)


def test_they_come_in_the_order_of_the_lesson() -> None:
    numbers = [exercise.number for exercise in ALL]

    assert numbers == sorted(set(numbers))
    assert {"obstacle_avoidance", "goal_seeking"} <= {exercise.slug for exercise in ALL}


@slugs
def test_what_an_exercise_says_is_there(exercise: Exercise) -> None:
    assert exercise.folder.name == exercise.slug
    assert exercise.max_points == 100
    for file in exercise.files:
        assert (exercise.solutions / file).is_file()
        assert (exercise.folder / file).is_file(), "make skeletons"
    assert list(exercise.judge.glob("test_*.py"))
    assert (exercise.folder / "README.md").is_file()
    assert find_exercise(exercise.slug) == find_exercise(str(exercise.number)) == exercise
    for topic in exercise.topics:
        assert topic.name.startswith("/")
        assert topic.type in typestore().fielddefs
        assert topic.direction in ("subscribe", "publish")
    for service in exercise.services:
        assert service.name.startswith("/")
        assert "/srv/" in service.type
        assert service.direction in ("serve", "call")


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("obstacle_avoidence", "did you mean obstacle_avoidance?"),
        ("goalseeking", "did you mean goal_seeking?"),
        ("Goal_Seeking", "did you mean goal_seeking?"),
        ("", "there are: "),
        ("0", f"numbers are 1 to {ALL[-1].number}"),
        ("../goal_seeking", "did you mean goal_seeking?"),
        ("zzz", "obstacle_avoidance"),
    ],
)
def test_unknown_names(name: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        find_exercise(name)

    assert f"unknown exercise {name!r}; " in str(caught.value)
    assert hint in str(caught.value)


@pytest.mark.parametrize("text", ["number = ", "number = 1\n", "wrong = 1\n", 'number = "one"\n'])
def test_broken_files_are_the_graders_fault(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exercises, "EXERCISES", tmp_path)
    with pytest.raises(GraderError, match="no exercises here"):
        all_exercises()
    (tmp_path / "x").mkdir()
    (tmp_path / "x" / "exercise.toml").write_text(text)
    with pytest.raises(GraderError, match=r"exercise\.toml: ") as caught:
        all_exercises()

    assert "\n" not in str(caught.value)


def test_an_exercise_without_a_judge_is_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(exercises, "JUDGE", tmp_path)
    with pytest.raises(GraderError, match=r"obstacle_avoidance: expected the judge's folder"):
        all_exercises()
