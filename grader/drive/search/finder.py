"""Look for the smallest world in which a node fails: hypothesis draws and shrinks.

Each try is one drive in virtual time. Half of the search looks for what is worse than standing; if
nothing of the kind turns up, the other half shrinks a world in which the robot stands. The first
hit fixes the kind of mishap: from then on only smaller worlds with the same kind count. With a
number of tries, the same seed gives the same world; with a limit of time the machine decides.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from random import Random

from hypothesis import Phase, find, settings
from hypothesis.errors import NoSuchExample
from hypothesis.internal.conjecture import providers
from hypothesis.internal.constants_ast import Constants
from msgspec.structs import replace

from grader.drive.mishaps import (
    BREAKS,
    DIES,
    KINDS,
    LOST,
    STANDS,
    TOUCHES,
    Mishap,
    mishap_of,
)
from grader.drive.search.toml import scenario_to_toml
from grader.drive.search.words import sentence, title
from grader.drive.search.worlds import Arena
from grader.recording import Recording
from sim.scenario import Scenario

NAME = "found"
ENDLESS = 1_000_000  # tries where time is the limit
REPEATS = 10  # hypothesis draws worlds that it has drawn before; they are no tries
AFTERMATH = 1.0  # [s] to show after the mishap

Drive = Callable[[Scenario], Recording]


@dataclass(frozen=True)
class Found:
    """A world in which the node fails."""

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

_RANK = {kind: rank for rank, kind in enumerate(KINDS)}
HARM = frozenset({DIES, TOUCHES, BREAKS})


class _Over(BaseException):
    """No tries or no time is left: hypothesis lets this through."""


@dataclass
class _Hunt:
    """The tries so far, and the smallest world with each kind of mishap among them."""

    arena: Arena
    drive: Drive
    on_try: OnTry
    most: int  # tries
    seconds: float
    wanted: frozenset[str] = frozenset()
    share: float = 1.0  # of tries and seconds that may go by without a hit
    tries: int = 0
    trouble: Exception | None = None

    def __post_init__(self) -> None:
        self._began = time.monotonic()
        self._known: dict[str, str] = {}  # world: kind of mishap, "" for none
        self._smallest: dict[str, tuple[Scenario, Recording, Mishap]] = {}

    @property
    def best(self) -> tuple[Scenario, Recording, Mishap] | None:
        """The smallest world of the kind that is looked for, or else of the worst kind."""
        kinds = sorted(self._smallest, key=lambda kind: (kind not in self.wanted, _RANK[kind]))
        return self._smallest[kinds[0]] if kinds else None

    def fails(self, scenario: Scenario) -> bool:
        """Drive in a world, unless that is known; tell whether it is one to be looked for."""
        text = scenario_to_toml(scenario)
        if text not in self._known:
            try:
                self._known[text] = self._try(scenario)
            except Exception as error:  # not to be shrunk: it is no answer to the question
                self.trouble = error
                raise _Over from error
        kind = self._known[text]
        if kind in self.wanted:
            self.wanted = frozenset({kind})
        elif kind and self.tries == 1:
            self.wanted = frozenset({kind})  # it fails in the simplest world of all
        return kind in self.wanted

    def _try(self, scenario: Scenario) -> str:
        share = 1.0 if len(self.wanted) == 1 else self.share
        passed = time.monotonic() - self._began
        if self.tries >= self.most * share or passed > self.seconds * share:
            raise _Over
        recording = self.drive(scenario)
        self.tries += 1
        mishap = mishap_of(recording, self.arena.contract)
        if mishap is not None:
            known = self._smallest.get(mishap.kind)
            if known is None or smallness(scenario) < smallness(known[0]):
                self._smallest[mishap.kind] = scenario, recording, mishap
        self.on_try(self.tries, self.best[2] if self.best else None)
        return mishap.kind if mishap else ""


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

    Raises
    ------
    InputError
        The node can't be driven in virtual time.
    """
    hunt = _Hunt(arena, drive, on_try, tries or ENDLESS, seconds or math.inf)
    interrupted = False
    try:
        if arena.contract.free is not None:  # there are things to run into
            _run(hunt, seed, HARM, 0.5)
        if hunt.best is None or len(hunt.wanted) > 1:
            _run(hunt, seed, frozenset(KINDS), 1.0)
    except KeyboardInterrupt:
        interrupted = True
    found = None if hunt.best is None else _told(hunt, *hunt.best, again=not interrupted)
    return Search(found, hunt.tries, interrupted)


def _run(hunt: _Hunt, seed: int, wanted: frozenset[str], share: float) -> None:
    hunt.wanted, hunt.share = wanted, share
    how = settings(
        max_examples=min(ENDLESS, REPEATS * hunt.most),
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.shrink),
    )
    with _by_seed_alone(), contextlib.suppress(NoSuchExample, _Over):
        find(hunt.arena.worlds, hunt.fails, settings=how, random=Random(seed))
    if hunt.trouble is not None:
        raise hunt.trouble


@contextlib.contextmanager
def _by_seed_alone() -> Iterator[None]:
    """Keep hypothesis from drawing numbers that it finds in the code of this very process.

    It would read every module that is loaded and not installed, and what it draws would depend on
    them; there is no setting against it.
    """
    read, known = providers._get_local_constants, providers.CONSTANTS_CACHE
    providers._get_local_constants = Constants
    providers.CONSTANTS_CACHE = type(known)(1024)
    try:
        yield
    finally:
        providers._get_local_constants, providers.CONSTANTS_CACHE = read, known


def _told(
    hunt: _Hunt, scenario: Scenario, recording: Recording, mishap: Mishap, *, again: bool
) -> Found:
    """Return a world with its title, no longer than it takes to see what goes wrong.

    `again`: the node may be driven once more, to see that the shorter world shows it, too.
    """
    scenario = replace(scenario, title=title(scenario), name=NAME)
    if again and mishap.kind not in (STANDS, LOST):
        shorter = cut(scenario, math.ceil(mishap.at + AFTERMATH))
        shown = hunt.drive(shorter)
        same = mishap_of(shown, hunt.arena.contract)
        if same is not None and same.kind == mishap.kind:
            return Found(shorter, shown, same, sentence(shown, same))
    recording = dataclasses.replace(recording, scenario=scenario)
    return Found(scenario, recording, mishap, sentence(recording, mishap))


def cut(scenario: Scenario, duration: float) -> Scenario:
    """Return a scenario that ends earlier, without what would happen later."""
    duration = min(scenario.duration, float(duration))
    return replace(
        scenario,
        duration=duration,
        script=tuple(event for event in scenario.script if event.at < duration),
        raw=tuple(
            replace(stream, end=min(stream.end, duration))
            for stream in scenario.raw
            if stream.begin < duration
        ),
    )
