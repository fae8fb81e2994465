"""Look for the smallest world in which a node comes to grief: hypothesis draws and shrinks.

Each try is one drive in virtual time. The first world found fixes what is looked for; from then on
only smaller worlds with the same kind of mishap count. With a number of tries, the same seed gives
the same world; with a limit of time it depends on the machine.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random
from unittest import mock

from hypothesis import Phase, find, settings
from hypothesis.errors import NoSuchExample
from hypothesis.internal.conjecture import providers
from hypothesis.internal.constants_ast import Constants
from msgspec.structs import replace

from grader.drive.search.arenas import Arena
from grader.drive.search.mishaps import LOST, STANDS, Mishap, mishap_of
from grader.drive.search.toml import scenario_to_toml
from grader.drive.search.words import sentence, title
from grader.recording import Recording
from sim.scenario import Scenario

NAME = "found"
ENDLESS = 1_000_000  # tries where time is the limit
REPEATS = 10  # hypothesis draws worlds that it has drawn before; they are no tries
AFTERMATH = 1.0  # [s] to show after the mishap

Drive = Callable[[Scenario], Recording]


@dataclass(frozen=True)
class Found:
    """A world in which the node comes to grief."""

    scenario: Scenario
    recording: Recording
    mishap: Mishap
    sentence: str

    @property
    def toml(self) -> str:
        """The scenario as a file for `course drive --scenario`."""
        return scenario_to_toml(self.scenario)


@dataclass(frozen=True)
class Search:
    """What a search found, and what it took."""

    found: Found | None
    tries: int
    interrupted: bool = False


OnTry = Callable[[int, "Mishap | None"], None]


class _Over(BaseException):
    """No tries or no time is left: hypothesis lets this through."""


@dataclass
class _Hunt:
    """The tries so far, and the smallest world with a mishap among them."""

    arena: Arena
    drive: Drive
    tries_left: int
    deadline: float | None  # on the monotonic clock [s]
    on_try: OnTry
    tries: int = 0
    best: tuple[Scenario, Recording, Mishap] | None = None

    def __post_init__(self) -> None:
        self._known: dict[str, bool] = {}

    def comes_to_grief(self, scenario: Scenario) -> bool:
        """Drive in a world; tell whether it is one to be looked for."""
        text = scenario_to_toml(scenario)
        if text not in self._known:
            self._known[text] = self._try(scenario)
        return self._known[text]

    def _try(self, scenario: Scenario) -> bool:
        if not self.tries_left or (self.deadline and time.monotonic() > self.deadline):
            raise _Over
        recording = self.drive(scenario)
        self.tries += 1
        self.tries_left -= 1
        mishap = mishap_of(recording, self.arena.contract)
        hit = mishap is not None and (self.best is None or mishap.kind == self.best[2].kind)
        if mishap is not None and hit:
            self._keep(scenario, recording, mishap)
        self.on_try(self.tries, self.best[2] if self.best else None)
        return hit

    def _keep(self, scenario: Scenario, recording: Recording, mishap: Mishap) -> None:
        if self.best is None or smallness(scenario) < smallness(self.best[0]):
            self.best = scenario, recording, mishap


def smallness(scenario: Scenario) -> tuple[int, int, str]:
    """Return what orders worlds: things, then whatever else a file has to say, then the text."""
    world, text = scenario.world, scenario_to_toml(scenario)
    goals = sum(event.goal is not None for event in scenario.script)
    return len(world.boxes) + len(world.walls) + goals, len(text), text


def search(
    arena: Arena,
    drive: Drive,
    *,
    seed: int = 0,
    tries: int | None = None,
    seconds: float | None = None,
    on_try: OnTry = lambda tries, mishap: None,
) -> Search:
    """Look for the smallest world; Ctrl-C ends the search, and keeps what it has.

    Parameters
    ----------
    drive
        Drives the node in a scenario.
    tries, seconds
        When to end the search; at least one of them.
    on_try
        Is told after each try how many there were, and what has been found so far.
    """
    deadline = None if seconds is None else time.monotonic() + seconds
    hunt = _Hunt(arena, drive, tries or ENDLESS, deadline, on_try)
    interrupted = False
    try:
        _run(hunt, seed)
    except _Over:
        pass
    except KeyboardInterrupt:
        interrupted = True
    found = None if hunt.best is None else _told(hunt, *hunt.best)
    return Search(found, hunt.tries, interrupted)


def _run(hunt: _Hunt, seed: int) -> None:
    how = settings(
        max_examples=min(ENDLESS, REPEATS * hunt.tries_left),
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.shrink),
    )
    with _by_seed_alone(), contextlib.suppress(NoSuchExample):
        find(hunt.arena.worlds, hunt.comes_to_grief, settings=how, random=Random(seed))


@contextlib.contextmanager
def _by_seed_alone() -> Iterator[None]:
    """Keep hypothesis from drawing numbers that it finds in the code of this very process.

    It would read every module that is loaded and not installed, and what it draws would depend on
    them; there is no setting against it.
    """
    cache = type(providers.CONSTANTS_CACHE)(1024)
    with (
        mock.patch.object(providers, "_get_local_constants", Constants),
        mock.patch.object(providers, "CONSTANTS_CACHE", cache),
    ):
        yield


def _told(hunt: _Hunt, scenario: Scenario, recording: Recording, mishap: Mishap) -> Found:
    """Return a world with its title, no longer than it takes to see what goes wrong."""
    scenario = replace(scenario, title=title(scenario), name=NAME)
    if mishap.kind not in (STANDS, LOST):
        shorter = replace(scenario, duration=min(scenario.duration, _rounded(mishap.at)))
        again = hunt.drive(shorter)
        same = mishap_of(again, hunt.arena.contract)
        if same is not None and same.kind == mishap.kind:
            return Found(shorter, again, same, sentence(again, same))
    return Found(scenario, recording, mishap, sentence(recording, mishap))


def _rounded(at: float) -> float:
    return float(math.ceil(at + AFTERMATH))
