"""A race in the page has the figures, tracks and digests of `course race`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
from test_drives import said_by_page

from grader.authoring.ghosts import ghosts_of
from grader.course.exercises import Exercise, all_exercises
from grader.drive.race import reference_laps
from grader.exercises import contract_of
from rclpy_virtual_time.link.hosts import ForkServer


def test_the_page_and_the_command_have_the_same_figures_and_digests(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    racing = [each for each in all_exercises() if worlds_of(each)]

    def beside(exercise: Exercise) -> list[Any]:  # another, twice as fast, and one of another world
        laps = [(msgspec.to_builtins(lap), t) for lap, t in reference_laps(exercise.slug).values()]
        fast = [{"lap": lap, "track": t | {"t": [each / 2 for each in t["t"]]}} for lap, t in laps]
        return [{"x": each, "y": each | {"lap": {"of": "0"}}} for each in fast]

    orders = [
        {"exercise": each.slug, "file": str(each.solutions / each.files[0]), "tell": True,
         "others": each.files, "scenarios": worlds_of(each),
         "beside": beside(each)}
        for each in racing
    ]  # fmt: skip
    for exercise, raced in zip(racing, said_by_page(tmp_path, orders), strict=True):
        driven = ghosts_of(exercise, forkserver).values()
        assert [laps for *laps, _ in raced] == [[each["lap"], each["track"]] for each in driven]
        assert all(lost.endswith(" to x") for *_, (_, lost) in raced)


def worlds_of(exercise: Exercise) -> tuple[str, ...]:
    return contract_of(exercise).race
