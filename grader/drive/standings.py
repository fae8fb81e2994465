"""Results of a race as files, and the table of a class that is made of them.

A file is what a student says; marks never come from it. Each byte is hostile until it is read.
"""

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from grader.course.beside import listed
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.submission import read_regular_file
from grader.drive.race import Lap, Name, digest_of, one_line, unit_of, worlds_of
from grader.errors import InputError
from sim.scenario_files import load_scenario

MOST_BYTES = 10_000  # of a result
MOST_FILES = 5_000
MOST_SIGNS = 24  # of a nickname


class Result(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a file says."""

    course: Name  # its version
    exercise: Name  # the slug
    nickname: Annotated[str, Meta(max_length=200)]
    laps: tuple[Lap, Lap, Lap]

    @property
    def finished(self) -> int:
        """How many worlds."""
        return sum(lap.figure is not None for lap in self.laps)

    @property
    def total(self) -> float:
        """The sum of the figures [s] or [m]."""
        return round(sum(lap.figure or 0.0 for lap in self.laps), 2)

    @property
    def rank(self) -> tuple[int, float]:
        """What to sort by: see `ranking_of`."""
        less = unit_of(find_exercise(self.exercise)) == "s"
        return -self.finished, self.total if less else -self.total


def clean_nickname(nickname: str) -> str:
    """Return a nickname as one short line.

    Raises InputError: nothing of it can be seen, or it is too long.
    """
    name = one_line(nickname)
    if 1 <= len(name) <= MOST_SIGNS:
        return name
    raise InputError(f"nickname: expected 1 to {MOST_SIGNS} visible characters, got {len(name)}")


def read_result(path: Path) -> Result:
    """Return the result in a file.

    Raises InputError: it can't be read, is none, or is of worlds that this course does not have.
    """
    try:
        data = read_regular_file(path, MOST_BYTES)
        if len(data) > MOST_BYTES:
            raise InputError(f"expected at most {MOST_BYTES} bytes")
        result = msgspec.json.decode(data, type=Result)
    except OSError as error:
        raise InputError(error.strerror or "cannot be read") from None
    except (msgspec.DecodeError, ValueError, RecursionError) as error:
        raise InputError(f"expected the result of a race ({error})") from None
    if result.exercise not in [each.slug for each in all_exercises()]:
        raise InputError("no exercise is called that")
    worlds = {world: digest_of(world) for world in worlds_of(find_exercise(result.exercise))}
    if [(lap.world, lap.of) for lap in result.laps] != list(worlds.items()):
        raise InputError(f"its worlds are not {', '.join(worlds)}, or those of another course")
    if any((lap.figure is None) == (not lap.ended) for lap in result.laps):
        raise InputError("expected a figure, or why there is none")
    if result.finished == 0:
        raise InputError("expected a world that was finished, got none")
    if unit_of(find_exercise(result.exercise)) == "m":
        for lap in result.laps:
            scenario = load_scenario(lap.world)
            if (lap.figure or 0.0) > scenario.duration * scenario.robot.max_linear:
                raise InputError(f"{lap.world}: no robot drives {lap.figure:g} m there")
    return msgspec.structs.replace(result, nickname=clean_nickname(result.nickname))


def wanted_at(file: Path, exercise: Exercise, name: str | None) -> tuple[str, Result | None]:
    """Return the nickname by which a result is to be written to a file, and what is there already.

    "" and None without a nickname. Raises InputError: the file has another result.
    """
    if name is None:
        return "", None
    nickname = clean_nickname(name)
    before = read_result(file) if file.exists() else None
    if before and (before.exercise, before.nickname) != (exercise.slug, nickname):
        raise InputError(f"{file}: has another's result, or another exercise's; choose --out")
    return nickname, before


def standings(folder: Path) -> tuple[dict[str, list[Result]], list[str]]:
    """Return the best result of each nickname by exercise, best first; and what is to be said.

    Raises InputError: it is no folder, or has too many files.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder with results, files such as race.json")
    files = sorted(folder.rglob("*.json"))
    if len(files) > MOST_FILES:
        raise InputError(f"{folder}: {len(files)} results, expected at most {MOST_FILES}")
    said, found = [], defaultdict[tuple[str, str], list[tuple[Result, str]]](list)
    for path in files:
        name = one_line(path.relative_to(folder).as_posix())
        try:
            result = read_result(path)
            found[result.exercise, result.nickname.casefold()].append((result, name))
        except InputError as error:
            said.append(f"{name}: left out: {one_line(str(error))}")
    others = [path for path in sorted(folder.rglob("*")) if path.suffix != ".json"]
    if more := [one_line(path.relative_to(folder).as_posix()) for path in others if path.is_file()]:
        said.append(f"{listed(more)}: left out: expected results, files such as race.json")
    entries: dict[str, list[Result]] = {}
    for (slug, _), theirs in sorted(found.items()):
        best, file = min(theirs, key=lambda each: each[0].rank)
        entries.setdefault(slug, []).append(best)
        if theirs[1:]:
            names = ", ".join(f"{name} (by “{each.nickname}”)" for each, name in theirs)
            said.append(
                f"{best.nickname}: {len(theirs)} results by one nickname, for neither case nor "
                f"blanks count: {names}; {file} counts"
            )
    return {slug: sorted(best, key=lambda each: each.rank) for slug, best in entries.items()}, said


def class_rows(exercise: Exercise, results: Sequence[Result]) -> list[list[str]]:
    """Return the table of an exercise: equals share a place; the distance kept, and the jolts."""
    unit, ranks = unit_of(exercise), [each.rank for each in results]
    worlds = [f"{world} [{unit}]" for world in (*worlds_of(exercise), "sum")]
    rows = [["", "nickname", "finished", *worlds, "nearest [m]", "accel. [m/s²]"]]
    for each in results:
        near = min((lap.nearest for lap in each.laps if lap.nearest is not None), default=None)
        figures = [lap.figure for lap in each.laps]
        figures += [each.total, near, max(lap.acceleration for lap in each.laps)]
        place, finished = f"{1 + ranks.index(each.rank)}.", f"{each.finished} of {len(each.laps)}"
        rows.append([place, each.nickname, finished, *map(shown, figures)])
    return rows


def lap_rows(exercise: Exercise, laps: dict[str, Sequence[Lap]]) -> list[list[str]]:
    """Return a table of laps: for each world a row of each who has one there."""
    first = "time [s]" if unit_of(exercise) == "s" else "way [m]"
    rows = [["", first, "nearest [m]", "median [m]", "accel. [m/s²]", "turning [rad/s²]"]]
    for i, world in enumerate(worlds_of(exercise)):
        rows.append([world, *[""] * 5])
        for who, theirs in laps.items():
            lap = theirs[i]
            figures = (lap.figure, lap.nearest, lap.median, lap.acceleration, lap.turning)
            rows.append([f"  {who}", *map(shown, figures)])
    return rows


def shown(figure: float | None) -> str:
    """Return a figure as text."""
    return "-" if figure is None else f"{figure:.2f}"


def lines(rows: Sequence[Sequence[str]], left: int = 1) -> str:
    """Return a table as lines of text; the first `left` columns begin at the left."""
    sides = [f"{'<' if i < left else '>'}{max(map(len, column))}"
             for i, column in enumerate(zip(*rows, strict=True))]  # fmt: skip
    return "\n".join("  ".join(map(format, row, sides)).rstrip() for row in rows)
