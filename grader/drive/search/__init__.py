"""Look for worlds in which a node comes to grief (docs/search.md)."""

from __future__ import annotations

from msgspec.structs import replace

from grader.course.submission import Submission
from grader.drive.node import drive_node
from grader.drive.search.arenas import Arena, arena_of, exercise_for
from grader.drive.search.finder import Found, OnTry, Search, search
from grader.drive.search.mishaps import Mishap
from grader.link.launcher import Launcher
from grader.recording import Recording
from grader.trial.virtual_time import Limits
from sim.scenario import Scenario, Transforms

__all__ = [
    "Found",
    "Mishap",
    "Search",
    "arena_of",
    "drive_in",
    "exercise_for",
    "search",
    "search_node",
]
PATIENCE = Limits(start=10.0, step=2.0, total=20.0)  # a node that hangs is found hanging often


def search_node(
    arena: Arena,
    submission: Submission,
    forkserver: Launcher,
    *,
    seed: int = 0,
    tries: int | None = None,
    seconds: float | None = None,
    on_try: OnTry = lambda tries, mishap: None,
) -> Search:
    """Look for the smallest world in which this node comes to grief; see `search`."""

    def drive(scenario: Scenario) -> Recording:
        return drive_in(submission, scenario, forkserver)

    return search(arena, drive, seed=seed, tries=tries, seconds=seconds, on_try=on_try)


def drive_in(submission: Submission, scenario: Scenario, forkserver: Launcher) -> Recording:
    """Drive a node as `course drive --scenario` does, but with less patience."""
    with_frames = replace(scenario, transforms=Transforms(enabled=True))
    return drive_node(submission, with_frames, forkserver, limits=PATIENCE)
