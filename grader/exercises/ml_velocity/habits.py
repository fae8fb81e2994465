"""What a node always does wrong with sectors or commands: a mistake is named, and paid for, once.

`front_min` judges it, and no node with another habit than the contract's passes that check. Others
take as given what they are not about: the sectors of all but the front, and, where the judge knows
what the model was asked and said, how a node commands it. `clipped` and the drives take nothing so.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from grader.checks.commands import Answer, garbage
from grader.checks.inferences import questions
from grader.checks.predictions import max_speed
from grader.models.features import FRONT_EDGE
from grader.recording import Recording

SHOWS = "ml_front_min"
EDGES = (90.0, 45.0, 30.0)  # [°] that others take for the front's: exercise 1's is the first
DIGITS = (1, 2, 3)  # to which others round, in m/s
WINDOWS = range(2, 21)  # predictions in an average
LEAST_WEIGHT = 0.01
LEAST_STEP = 0.01  # [m/s] who changes its commands by less stands, whatever the model says
TOLERANCE = 2e-4  # [m/s]


@dataclass(frozen=True)
class Habit:
    """How a node sees the front, and what it makes of a prediction."""

    front: float = FRONT_EDGE  # [°]
    windows: tuple[int, ...] = (1,)  # predictions, the last ones, that it averages: one of these
    weight: float = 1.0  # of the newest one, which it mixes with its last command
    step: float = math.inf  # [m/s] by which a command may differ from the last, up, down or both
    digits: int | None = None  # after the point, to which it rounds
    garbage: bool = False  # its commands are no numbers that the wheels could follow

    @property
    def commands(self) -> Habit:
        """The same node, if its sectors were the contract's."""
        return replace(self, front=FRONT_EDGE)

    def explains(self, speed: float, said: Sequence[float], last: float) -> bool:
        """Tell whether this is its command [m/s] after these predictions, and its last command."""
        if self.garbage:
            return bool(garbage(speed))
        means = (sum(said[-window:]) / len(said[-window:]) for window in self.windows)
        mixed = (self.weight * mean + (1.0 - self.weight) * last for mean in means)
        low, high = last - self.step, last + self.step
        near = (n for w in mixed for n in (min(max(w, low), high), min(w, high), max(w, low)))
        return any(abs(speed - self._rounded(wanted)) <= TOLERANCE for wanted in near)

    def _rounded(self, speed: float) -> float:
        return speed if self.digits is None else round(speed, self.digits)


CONTRACT = Habit()


def candidates(found: Sequence[Answer], said: Sequence[float | None]) -> Iterator[Habit]:
    """Yield what may be behind wrong commands; `said` is what the model said for each [m/s]."""
    yield from (Habit(front=edge) for edge in EDGES)
    if all(answer.speed is not None and garbage(answer.speed) for answer in found):
        yield Habit(garbage=True)
    yield Habit(windows=tuple(window for window in WINDOWS if _averages(window, found, said)))
    yield from (Habit(digits=digits) for digits in DIGITS)
    speeds = [0.0, *(answer.speed for answer in found if answer.speed is not None)]
    steps = [after - before for before, after in pairwise(speeds)]
    largest = (max(steps, default=0.0), -min(steps, default=0.0))
    yield from (Habit(step=step) for step in largest if step >= LEAST_STEP)
    for before, now, new in zip(found, found[1:], said[1:], strict=False):
        if before.speed is None or now.speed is None or new is None:
            return
        step = new - before.speed
        weight = (now.speed - before.speed) / step if step else 0.0
        if LEAST_WEIGHT < weight < 1.0:
            yield Habit(weight=weight)
            return


def _averages(window: int, found: Sequence[Answer], said: Sequence[float | None]) -> bool:
    one, known = Habit(windows=(window,)), [speed for speed in said if speed is not None]
    return len(known) == len(found) and all(
        answer.speed is not None and one.explains(answer.speed, known[: i + 1], 0.0)
        for i, answer in enumerate(found)
    )


def said_for(recording: Recording, found: Sequence[Answer]) -> list[float | None]:
    """Return what the model said of each scan, clipped [m/s]; None: nothing that is a number."""
    limit = max_speed(recording.scenario)
    ends = [*(answer.scan.t for answer in found), recording.duration_s][1:]
    said: list[float | None] = []
    for answer, end in zip(found, ends, strict=True):
        asked = questions(recording, "predict", answer.scan.t, end)  # the next scan's, too
        own = (i for i in asked if i.asked / 1e9 < (answer.scan.t + end) / 2)
        numbers = [min(max(s, 0.0), limit) for i in own for s in i.said if math.isfinite(s)]
        said.append(numbers[-1] if numbers else None)
    return said


def as_said(recording: Recording, found: Sequence[Answer], habit: Habit) -> list[Answer]:
    """Return the answers with what the model said, where the habit explains the command."""
    if habit.commands == CONTRACT:
        return list(found)
    history: list[float] = []
    last, answers = 0.0, []
    for answer, said in zip(found, said_for(recording, found), strict=True):
        speed = answer.speed
        if said is not None and speed is not None:
            history.append(said)
            if habit.explains(speed, history, last):
                answer = replace(answer, speed=said)  # noqa: PLW2901
        last = last if speed is None or garbage(speed) else speed
        answers.append(answer)
    return answers


def shows(recordings: Iterable[Recording]) -> Recording:
    """Return the recording that shows habits."""
    (found,) = {id(each): each for each in recordings if each.name == SHOWS}.values()
    return found
