"""Make a student's folder of an exercise: task, hints, skeletons, words, a first test."""

import re
from pathlib import Path

from grader.course.exercises import EXERCISES, Exercise, all_exercises
from grader.errors import InputError

GIVEN = ("README.md", "hints.md")
GLOSSARY = "glossary.md"
DRIVE = re.compile(r"course drive (?P<file>\w+\.py) --scenario (?P<scenario>\w+)")  # in a README
TESTS = '''\
"""Tests of your own: `pytest` runs them, here. README.md says what the node has to do."""

FILE, SCENARIO = "{file}", "{scenario}"


def test_it_runs_to_the_end(drive):
    run = drive(FILE, scenario=SCENARIO)
    assert run.outcome.completed, run.ending


def test_it_publishes(drive):
    run = drive(FILE, scenario=SCENARIO)
    assert run.messages("{topic}")


# What comes next? A run has run.twists(), run.scans(), run.clearance, run.log and more.
'''


def begin(exercise: Exercise, parent: Path) -> Path:
    """Make the folder of an exercise in `parent`; return it.

    Raises InputError: it is there already, or it can't be written.
    """
    target = parent / exercise.slug
    try:
        target.mkdir()
    except FileExistsError:
        text = f"{target} is there already, and may hold work of yours; start in another folder"
        raise InputError(text) from None
    except OSError as error:
        raise InputError(f"{target}: {error.strerror}") from None
    for name in exercise.files:
        (target / name).write_bytes((exercise.folder / name).read_bytes())
    for name in GIVEN:
        text = (exercise.folder / name).read_text("utf-8").replace(f"../{GLOSSARY}", GLOSSARY)
        (target / name).write_text(text, "utf-8")
    (target / GLOSSARY).write_bytes((EXERCISES / GLOSSARY).read_bytes())
    if (tests := own_tests(exercise)) is not None:
        (target / f"test_{exercise.slug}.py").write_text(tests, "utf-8")
    return target


def own_tests(exercise: Exercise) -> str | None:
    """Return a student's first tests, in the scenario that the README drives; None without one."""
    found = DRIVE.search((exercise.folder / "README.md").read_text("utf-8"))
    topics = [each.name for each in exercise.topics if each.direction == "publish"]
    return TESTS.format(**found.groupdict(), topic=topics[0]) if found and topics else None


def to_begin(parent: Path) -> Exercise:
    """Return the first exercise whose folder is not in `parent` yet; the last if all are."""
    every = all_exercises()
    return next((each for each in every if not (parent / each.slug).exists()), every[-1])
