"""Which rule wins where two match: judged by what the node says of them in this very run.

A node that does not know a rule, or forgets it, makes that mistake and no other one: what it says
is wrong only where it names a rule that matches, but not the first, and knows that one as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

from grader.checks.commands import ZERO
from grader.checks.verdict import fail
from grader.exercises.safety_supervisor.contract import AS_ASKED, Habit, Tick, ticks
from grader.exercises.safety_supervisor.evidence import SETTLING, TOPIC, Report, reports
from grader.recording import Recording

TICKS = 3  # after which a reason has to be there
LEAST = 3  # rules, of five, that a node has to name first where others match as well


@dataclass(frozen=True)
class _Contest:
    """A time during which the same two or more rules matched."""

    ticks: tuple[Tick, ...]
    rules: tuple[str, ...]  # that match, the one that wins first
    said: tuple[Report, ...]  # the one in force at that third tick, and all after it
    new: tuple[Report, ...]  # since the first tick

    def later(self) -> tuple[Report, ...]:
        """Return what it says once it had said the first rule, but for the last two ticks."""
        end = self.ticks[-TICKS].t
        said = [report.t for report in self.said if report.reason == self.rules[0]]
        return tuple(each for each in self.said if said[0] < each.t < end)


def require_first_match(
    recording: Recording, help: str, habit: Habit = AS_ASKED, *, least: int = LEAST
) -> None:
    """Fail unless the node says the first of the rules that match, wherever it shows an order.

    And goes on saying it while they do. It has to show that for at least so many rules.
    """
    every = {report.reason for report in reports(recording)}
    won = set()
    for contest in _contests(recording, habit):
        first, *others = contest.rules
        candidates = contest.new
        if first in {report.reason for report in contest.said}:
            won.add(first)
            candidates = contest.later()
        wrong = [each for each in candidates if each.reason in others]
        if wrong and first in every:
            fail(
                f"{' and '.join(contest.rules)} match ({contest.ticks[0].situation.what})",
                expected=f"a text that begins with {first}",
                actual=f"“{wrong[0].text[:60]}”",
                at=wrong[0].t,
                recording=recording,
                help=help,
            )
    if len(won) < least:
        fail(
            "too few reasons came to see which rule wins",
            expected="the first of two rules that match, each time",
            actual=f"that of {len(won)} rules" if won else f"none of them on {TOPIC}",
            at=min((contest.ticks[0].t for contest in _contests(recording, habit)), default=None),
            recording=recording,
            help="Get reasons and the checks of the single rules right first.",
        )


def _contests(recording: Recording, habit: Habit) -> Iterator[_Contest]:
    said = [Report(0.0, 0, -1, ""), *reports(recording)]
    for rules, group in groupby(ticks(recording, habit=habit), key=lambda tick: tick.matching):
        found = tuple(tick for tick in group if tick.t > SETTLING)
        if len(rules) < 2 or len(found) < TICKS:
            continue
        third, end = found[TICKS - 1].t + ZERO, found[-1].t + ZERO
        before = [report for report in said if report.t <= third][-1:]
        after = [report for report in said if third < report.t <= end]
        new = (report for report in said if found[0].t - ZERO <= report.t <= end)
        yield _Contest(found, rules, (*before, *after), tuple(new))
