"""A student's progress as one file: what was written in each exercise, its versions, own scenarios.

The page makes and takes the same file (`workspace/web/progress.js`). It may come from anywhere, so
it is read strictly, and as a whole before anything is written.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from grader.course.begin import begin
from grader.course.exercises import Exercise, all_exercises
from grader.course.submission import read_regular_file
from grader.course.untouched import bare
from grader.errors import InputError
from grader.grading.attempts import replace
from rclpy_virtual_time import readable
from sim.scenario_files import scenario_from_toml

MOST = 2**24  # [bytes]
KEPT, MANY = 20, 50  # versions, as in workspace/web/shelf.js; own scenarios
SCENARIO = r"^[A-Za-z0-9][A-Za-z0-9_]{0,79}\.toml$"

Name = Annotated[str, Meta(max_length=100)]
Files = Annotated[dict[Name, Annotated[str, Meta(max_length=2**20)]], Meta(max_length=20)]
Moment = Annotated[datetime, Meta(tz=True)]
Scenarios = dict[Annotated[str, Meta(pattern=SCENARIO)], Annotated[str, Meta(max_length=2**16)]]


class Version(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The files of an exercise as they once were."""

    files: Files
    points: Name  # what came of it, in words
    at: Moment


class Best(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The best lap in a world of a race; the page looks at what it says."""

    lap: Annotated[
        dict[Name, float | Annotated[str, Meta(max_length=200)] | None], Meta(max_length=20)
    ]
    track: dict[Literal["t", "x", "y", "yaw"], Annotated[list[float], Meta(max_length=2000)]]


class Work(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What was done in an exercise."""

    files: Files | None = None  # now; None: the skeleton
    versions: Annotated[list[Version], Meta(max_length=KEPT)] = []
    green: Version | None = None  # the last one that passed all checks
    scenarios: Annotated[Scenarios, Meta(max_length=MANY)] = {}
    race: Annotated[dict[Name, Best], Meta(max_length=10)] = {}


class Progress(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The whole file."""

    format: Literal["course-progress"]
    version: Literal[1]
    at: Moment
    exercises: Annotated[dict[Name, Work], Meta(max_length=100)]


def read_progress(file: Path) -> Progress:
    """Return what a file holds.

    Raises InputError: it can't be read, or is no such file.
    """
    try:
        data = read_regular_file(file, MOST)
        if len(data) <= MOST:
            return msgspec.json.decode(data, type=Progress)
        came = f"one of more than {MOST >> 20} MB"
    except OSError as error:
        came = f"none: {error.strerror}"
    except (ValueError, RecursionError) as error:
        came = f"a damaged or newer one ({error}); save it again where it was made"
        if b'"course-progress"' not in data:
            start = readable(data[:30].decode(errors="ignore")).strip()
            came = f"one that begins with “{start}”; choose another" if data else "an empty one"
            came = "one that is no text; choose another" if b"\0" in data else came
    raise InputError(
        f"{file}: expected a file that the page's *Progress* or `course progress --export` has "
        f"saved, got {came}"
    )


def bring(progress: Progress, here: Path) -> list[str]:
    """Lay each exercise's files into its folder in `here`, which is made if need be; say what came.

    A file is replaced if it is still the skeleton. Beside any other it gets a name of its own.

    Raises InputError: a folder or file can't be written.
    """
    known, said = {each.slug: each for each in all_exercises()}, []
    for slug, work in progress.exercises.items():
        exercise = known.get(slug)
        if exercise is None:
            said.append(f"left out: {slug!r}, which is no exercise of this course")
            continue
        now = work.files or (work.green and work.green.files) or {}
        said += [f"left out: {slug}/{name}, which is no file of this exercise"
                 for name in now if name not in exercise.files]  # fmt: skip
        files = {name: now[name] for name in exercise.files if name in now}
        skeletons = {name: (exercise.folder / name).read_bytes() for name in exercise.files}
        for name, text in work.scenarios.items():
            try:
                scenario_from_toml(text, name)
                files[name] = text
            except InputError as error:
                said.append(f"left out: {slug}/{error}")
        if not files:
            continue
        folder = here / slug if (here / slug).is_dir() else begin(exercise, here)
        said += [_lay(folder / name, text, skeletons.get(name)) for name, text in files.items()]
    return [each for each in said if each]


def _lay(target: Path, text: str, skeleton: bytes | None) -> str:
    """Write a file, or another beside it; say which. "" if it is there as it is."""
    free = {None} if skeleton is None else {None, bare(skeleton)}
    for number in itertools.count():
        more = f"_imported{number if number > 1 else ''}" if number else ""
        place = target.with_stem(target.stem + more)
        before = _there(place)
        if before == bare(text.encode()):
            return ""
        if before in free:
            break
    try:
        replace(place, text.encode())
    except OSError as error:
        raise InputError(f"{place}: {error.strerror}") from None
    return f"{place}: {target.name} there is yours" if number else f"{place}"


def _there(place: Path) -> bytes | None:
    """Return the bare content of what is in a place; None if nothing is."""
    try:
        return bare(read_regular_file(place, MOST))
    except OSError:
        return b"\0" if os.path.lexists(place) else None  # a folder, a link: like no text


def progress_of(here: Path, before: Progress | None) -> tuple[Progress, list[str]]:
    """Return what lies in the exercises' folders in `here`, and what was left out, in lines.

    What a file had `before` stays in it: texts that were changed since as versions.
    """
    known = before.exercises if before else {}
    works, said = dict(known), []
    for exercise in all_exercises():
        old = known.get(exercise.slug, Work())
        folder = here / exercise.slug
        texts = {}
        for place in sorted(folder.glob("*")):
            is_scenario = place.suffix == ".toml"
            if not is_scenario and place.name not in exercise.files:
                continue
            try:
                content = read_regular_file(place, MOST).decode().replace("\r\n", "\n")
                msgspec.convert({place.name: content}, Scenarios if is_scenario else Files)
                if is_scenario:
                    scenario_from_toml(content, place.name)
                texts[place.name] = content
            except (OSError, ValueError, InputError) as error:
                said.append(f"left out: {place}: {error}")
        if not texts:
            continue
        files = {name: texts.pop(name) for name in exercise.files if name in texts}
        now = files if _is_begun(exercise, files) else None
        versions = list(old.versions)
        if before and old.files and old.files not in [now, *(each.files for each in versions)]:
            versions = [Version(old.files, "put aside", before.at), *versions][:KEPT]
        scenarios = dict([*(old.scenarios | texts).items()][-MANY:])
        work = Work(now, versions, old.green, scenarios, old.race)
        if work != Work():
            works[exercise.slug] = work
    return Progress("course-progress", 1, datetime.now(UTC), works), said


def _is_begun(exercise: Exercise, files: Mapping[str, str]) -> bool:
    """Return whether one of the files is no skeleton any more."""
    return any(
        bare(text.encode()) != bare((exercise.folder / name).read_bytes())
        for name, text in files.items()
    )


def write_progress(progress: Progress, file: Path) -> None:
    """Write the file, in place of one of before.

    Raises InputError: it can't be written, or is too large to be read again.
    """
    content = msgspec.json.encode(progress)
    if len(content) > MOST:
        size = f"{len(content) / 2**20:.1f} MB"
        raise InputError(f"{file}: expected at most {MOST >> 20} MB, got {size}")
    try:
        replace(file, content)
    except OSError as error:
        raise InputError(f"{file}: {error.strerror}") from None
