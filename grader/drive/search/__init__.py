"""Look for worlds in which a node fails (docs/search.md)."""

from __future__ import annotations

from grader.course.submission import Submission
from grader.drive.mishaps import Mishap
from grader.drive.node import drive_in
from grader.drive.search.account import MINUTES, account, how_far
from grader.drive.search.finder import Found, OnTry, Search, search
from grader.drive.search.worlds import Arena, arena_of
from grader.link.launcher import Launcher
from grader.recording import Recording
from sim.scenario import Scenario

__all__ = [
    "MINUTES",
    "Found",
    "Mishap",
    "Search",
    "account",
    "arena_of",
    "how_far",
    "search",
    "search_node",
]


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
    """Look for the smallest world in which this node fails; see `search`."""

    def drive(scenario: Scenario) -> Recording:
        return drive_in(submission, scenario, forkserver)

    return search(arena, drive, seed=seed, tries=tries, seconds=seconds, on_try=on_try)
