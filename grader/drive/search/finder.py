"""Look for the smallest world in which a node fails: draw worlds by chance, then simplify one.

Each try is one drive in virtual time. The simplest world of all comes first. Until half of the
tries are over, only what is worse than standing ends the drawing; then anything does. Of the world
that was found, one number of its plan after another is lowered, by halves, as long as the node
fails in the same way. With a number of tries, the same seed gives the same world; with a limit of
time the machine decides.
"""

import contextlib
import dataclasses
import itertools
import math
import time
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from random import Random

from msgspec.structs import replace

from grader.drive.as_toml import scenario_to_toml
from grader.drive.mishaps import BREAKS, DIES, KINDS, LOST, STANDS, TOUCHES, Mishap, mishap_of
from grader.drive.search.fair import is_fair
from grader.drive.search.words import sentence, title
from grader.drive.search.worlds import Arena, Draw, Plan
from grader.recording import Recording
from sim.scenario import Scenario

MINUTES = 1.0  # that a search takes if nobody says
AFTERMATH = 1.0  # [s] to show after the mishap
HARM = (DIES, TOUCHES, BREAKS)

Drive = Callable[[Scenario], Recording]
OnTry = Callable[[int, str], None]


@dataclass(frozen=True)
class Found:
    """A world in which the node fails."""

    scenario: Scenario
    recording: Recording
    mishap: Mishap
    plan: Plan = ()

    @property
    def sentence(self) -> str:
        """The sentence that a student reads."""
        return sentence(self.recording, self.mishap)

    @property
    def toml(self) -> str:
        """The scenario as a file for `course drive --scenario`."""
        return scenario_to_toml(self.scenario)


@dataclass(frozen=True)
class Search:
    """A search's findings, and its cost."""

    found: Found | None
    tries: int
    interrupted: bool = False

    def account(self, *, exercise: int, seed: int) -> str:
        """Return the sentence, the world as a file, and how many worlds were tried."""
        count = f"{self.tries} worlds" if self.tries != 1 else "one world"
        where = f"(exercise {exercise}, seed {seed}{', interrupted' if self.interrupted else ''})"
        if self.found is None:
            proof = "That is no proof: another seed tries others."
            return f"Nothing found in {count} {where}. {proof}"
        return f"{self.found.sentence}\n\n{self.found.toml}\nThe smallest of {count} {where}."


class _Over(Exception):
    """No tries or no time is left."""


@dataclass
class _Hunt:
    """The tries so far, and the smallest world among them in which the node failed."""

    arena: Arena
    drive: Drive
    on_try: OnTry
    most: float  # tries
    seconds: float
    tries: int = 0
    best: Found | None = None
    known: set[str] = field(default_factory=set)
    began: float = field(default_factory=time.monotonic)

    def draw(self, chance: Random) -> None:
        """Try random worlds, until the node fails in one."""
        if self._fails(Draw(), KINDS):
            return  # in the simplest world: nothing is simpler
        enough = HARM if self.arena.contract.free is not None else KINDS  # what to run into
        while self.best is None or (self.best.mishap.kind not in enough and self._spent() < 0.5):
            self._fails(Draw(chance=chance), enough if self.best else KINDS)

    def simplify(self) -> None:
        """Lower one number after another, then two by one, until none can be lowered."""
        before: Plan | None = None
        while self.best is not None and self.best.plan != before:
            before = self.best.plan
            for index in range(len(before)):
                self._lower(self.best, index)
            left = [(index, number - 1) for index, number in enumerate(self.best.plan) if number]
            pairs = map(dict, itertools.combinations(left, 2))
            any(self._still(self.best, pair) for pair in pairs)

    def _lower(self, best: Found, index: int) -> None:
        """Look for the lowest number with which the node fails: zero first, then by halves."""
        right, wrong = -1, best.plan[index]
        while wrong - right > 1:
            number = 0 if right < 0 else (right + wrong) // 2
            still = self._still(best, {index: number})
            right, wrong = (right, number) if still else (number, wrong)

    def _still(self, best: Found, lower: dict[int, int]) -> bool:
        """Say whether the node fails in the same way if these numbers of the plan are lower."""
        plan = tuple(lower.get(index, number) for index, number in enumerate(best.plan))
        return self._fails(Draw(plan), (best.mishap.kind,))

    def _fails(self, draw: Draw, wanted: Collection[str]) -> bool:
        """Drive in a world if it is fair and new; keep it if the node fails as is wanted."""
        if self._spent() >= 1.0:
            raise _Over
        scenario = self.arena.world(draw)
        text = scenario_to_toml(scenario)
        if self.best is not None and text == self.best.toml:
            self.best = dataclasses.replace(self.best, plan=draw.taken)
            return True
        if text in self.known or not is_fair(scenario):
            return False
        self.known.add(text)
        recording = self.drive(scenario)
        self.tries += 1
        mishap = mishap_of(recording, self.arena.contract)
        if fails := mishap is not None and mishap.kind in wanted:
            self.best = Found(scenario, recording, mishap, draw.taken)
        so_far = f": {self.best.mishap.text}; now looking for a smaller world" if self.best else ""
        self.on_try(self.tries, f"world {self.tries}{so_far}")
        return fails

    def _spent(self) -> float:
        """Return which share of tries or time is gone."""
        return max(self.tries / self.most, (time.monotonic() - self.began) / self.seconds)


def search(
    arena: Arena,
    drive: Drive,
    *,
    seed: int = 0,
    tries: int | None = None,
    minutes: float | None = None,
    on_try: OnTry = lambda tries, so_far: None,
) -> Search:
    """Look for the smallest world; Ctrl-C ends the search, and keeps what it has.

    Raises InputError: the node can't be driven in virtual time.

    Parameters
    ----------
    drive
        Drives the node in a scenario.
    tries, minutes
        When to end the search; after a minute if neither is given.
    on_try
        Is told after each try how many there were, and how far the search is, in words.
    """
    minutes = minutes or (math.inf if tries else MINUTES)
    hunt = _Hunt(arena, drive, on_try, tries or math.inf, 60.0 * minutes)
    interrupted = False
    try:
        with contextlib.suppress(_Over):
            hunt.draw(Random(seed))
            hunt.simplify()
    except KeyboardInterrupt:
        interrupted = True
    found = hunt.best and _told(hunt.best, arena, None if interrupted else drive)
    return Search(found, hunt.tries, interrupted)


def _told(found: Found, arena: Arena, drive: Drive | None) -> Found:
    """Return a world with its title, no longer than it takes to see what goes wrong.

    With `drive`, the node is driven once more, to see that the shorter world shows it, too.
    """
    scenario = replace(found.scenario, title=title(found.scenario), name="found")
    if drive is not None and found.mishap.kind not in (STANDS, LOST):
        shorter = cut(scenario, math.ceil(found.mishap.at + AFTERMATH))
        shown = drive(shorter)
        same = mishap_of(shown, arena.contract)
        if same is not None and same.kind == found.mishap.kind:
            return Found(shorter, shown, same)
    return Found(scenario, dataclasses.replace(found.recording, scenario=scenario), found.mishap)


def cut(scenario: Scenario, end: float) -> Scenario:
    """Return a scenario that ends earlier, without its later events."""
    end = min(scenario.duration, float(end))
    raw = [replace(each, end=min(each.end, end)) for each in scenario.raw if each.begin < end]
    script = [event for event in scenario.script if event.at < end]
    return replace(scenario, duration=end, raw=tuple(raw), script=tuple(script))
