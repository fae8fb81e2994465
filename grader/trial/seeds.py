"""The seed of a trial: the scenario's own, or one that makes a world of another look."""

from __future__ import annotations

from grader.course.students import Seed, secret_seed
from sim.difficulty import comparable_seed
from sim.scenario import Scenario

CANDIDATES = 6  # seeds to choose a comparable world from


def trial_seed(scenario: Scenario, chosen: Seed | None) -> int:
    """Return the seed of a graded trial; worlds of other seeds are as hard as the scenario's."""
    if chosen is None:
        return scenario.usual_seed
    if isinstance(chosen, str):
        return comparable_seed(
            scenario, [secret_seed(chosen, scenario.name, i) for i in range(CANDIDATES)]
        )
    mixed = mixed_seed(scenario, chosen)
    return comparable_seed(scenario, [(mixed + 7_919 * i) % 2**31 for i in range(CANDIDATES)])


def mixed_seed(scenario: Scenario, chosen: int | None) -> int:
    """Return the seed of a trial: the scenario's own, or another for each `--seed`."""
    if chosen is None:
        return scenario.usual_seed
    return (scenario.seed + 1_000_003 * (chosen + 1)) % 2**31
