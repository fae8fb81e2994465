"""A race in the page has the figures, tracks and digests of `course race`."""

from __future__ import annotations

from pathlib import Path

from test_drives import said_by_page

from grader.authoring.ghosts import ghosts_of
from grader.course.exercises import Exercise, all_exercises
from grader.exercises import contract_of
from rclpy_virtual_time.link.hosts import ForkServer


def test_the_page_and_the_command_have_the_same_figures_and_digests(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    racing = [each for each in all_exercises() if worlds_of(each)]
    orders = [
        {"exercise": each.slug, "file": str(each.solutions / each.files[0]), "tell": True,
         "others": each.files, "scenarios": worlds_of(each)}
        for each in racing
    ]  # fmt: skip
    for exercise, raced in zip(racing, said_by_page(tmp_path, orders), strict=True):
        driven = ghosts_of(exercise, forkserver).values()
        assert raced == [[each["lap"], each["track"]] for each in driven]


def worlds_of(exercise: Exercise) -> tuple[str, ...]:
    return contract_of(exercise).race
