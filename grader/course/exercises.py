"""The exercises of the course: their folders, and what `exercise.toml` says about them."""

from __future__ import annotations

import difflib
import tomllib
from functools import lru_cache
from pathlib import Path
from typing import Annotated

import msgspec

from grader.errors import GraderError, InputError

ROOT = Path(__file__).resolve().parents[2]
EXERCISES = ROOT / "exercises"
SOLUTIONS = ROOT / "solutions"
JUDGE = ROOT / "grader" / "exercises"


class Topic(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A topic that a node of the exercise uses."""

    name: str
    type: str  # "geometry_msgs/msg/Twist"
    direction: str  # "subscribe" or "publish", seen from the node
    node: str = ""  # the node that uses it, if the exercise has several


class Service(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A service that a node of the exercise offers or uses."""

    name: str
    type: str  # "std_srvs/srv/Trigger"
    direction: str  # "serve" or "call", seen from the node
    node: str = ""  # the node that serves or calls it, if the exercise has several


class Launch(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What `exercise.launch.py` starts, if that isn't each file once beside a demo."""

    scenario: str = ""  # of the mock robot
    programs: tuple[str, ...] = ()  # of the files, those that are nodes; all if empty
    nodes: tuple[tuple[str, tuple[str, ...]], ...] = ()  # a program, and the names of its nodes


class Essential(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What the exercise is about: while one of these checks fails, the score is capped."""

    checks: tuple[str, ...]
    why: str  # a sentence for students
    cap: Annotated[int, msgspec.Meta(ge=0, le=100)] = 50  # [%] of the points that count


class Exercise(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One exercise."""

    number: int
    slug: str
    title: str
    summary: str
    files: tuple[str, ...]
    node: str
    max_points: int
    topics: tuple[Topic, ...] = ()
    services: tuple[Service, ...] = ()
    libraries: tuple[str, ...] = ()  # modules that its nodes import and that import slowly
    essential: Essential | None = None
    launch: Launch = Launch()

    def __hash__(self) -> int:
        return hash(self.slug)

    @property
    def folder(self) -> Path:
        """The folder that students get."""
        return EXERCISES / self.slug

    @property
    def solutions(self) -> Path:
        """The reference solution, variants and mutants."""
        return SOLUTIONS / self.slug

    @property
    def judge(self) -> Path:
        """The judge's folder: contract, checks and scenarios."""
        return JUDGE / self.slug


def all_exercises() -> list[Exercise]:
    """Return the exercises in the order of the lesson.

    Raises GraderError: the folder of exercises is missing or an `exercise.toml` is broken.
    """
    files = sorted(EXERCISES.glob("*/exercise.toml"))
    if not files:
        raise GraderError(f"{EXERCISES}: no exercises here; run `course` from a full checkout")
    found = sorted((_read(file) for file in files), key=lambda exercise: exercise.number)
    for exercise in found:
        if not (exercise.judge / "contract.py").is_file():
            raise GraderError(
                f"{exercise.judge}: expected the judge's folder of exercise {exercise.number}, "
                "with contract.py, test_core.py and scenarios/"
            )
    return found


def find_exercise(name: str) -> Exercise:
    """Return the exercise of that name or number.

    Raises InputError: there is none; the message names the nearest.
    """
    exercises = all_exercises()
    for exercise in exercises:
        if name in (exercise.slug, str(exercise.number)):
            return exercise
    if name.isdecimal():
        first, last = exercises[0].number, exercises[-1].number
        raise InputError(f"unknown exercise {name!r}; their numbers are {first} to {last}")
    slugs = [exercise.slug for exercise in exercises]
    near = difflib.get_close_matches(name, slugs, n=1, cutoff=0.4)
    hint = f"did you mean {near[0]}?" if near else f"there are: {', '.join(slugs)}"
    raise InputError(f"unknown exercise {name!r}; {hint}")


def exercise_for(name: str | None, file: str) -> Exercise:
    """Return the exercise of that name or number; without one, that of the file's name.

    Raises InputError: there is none of that name, or the file's name is no exercise's.
    """
    if name is not None:
        return find_exercise(name)
    for exercise in all_exercises():
        if file in exercise.files:
            return exercise
    raise InputError(
        f"{file}: its name is that of no exercise's file; expected --exercise N, such as "
        "--exercise 1"
    )


@lru_cache(maxsize=64)
def _exercise(text: str) -> Exercise:
    return msgspec.convert(tomllib.loads(text), Exercise)


def _read(file: Path) -> Exercise:
    try:
        return _exercise(file.read_text("utf-8"))
    except (tomllib.TOMLDecodeError, msgspec.ValidationError) as error:
        raise GraderError(f"{file}: {error}") from error
