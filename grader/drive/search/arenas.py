"""The worlds in which an exercise's node is searched for mistakes, by its contract."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from grader.checks.contract import Contract
from grader.course.exercises import Exercise
from grader.drive.search.worlds import driving_worlds, goal_worlds
from grader.exercises import driving_contract_of
from sim.scenario import Scenario


@dataclass(frozen=True)
class Arena:
    """Where a node of an exercise is looked at, and by what it is judged."""

    worlds: SearchStrategy[Scenario]
    contract: Contract


def arena_of(exercise: Exercise, *, field: bool = False) -> Arena:
    """Return the worlds and the contract of an exercise.

    `field`: also what only nodes with the badge field-ready have to cope with.

    Raises
    ------
    InputError
        Its nodes do not drive.
    """
    contract = driving_contract_of(exercise)
    return Arena(_worlds(contract, field=field), contract)


def _worlds(contract: Contract, *, field: bool) -> SearchStrategy[Scenario]:
    if contract.goals:
        return goal_worlds(field=field)
    return driving_worlds(
        contract.search_for,
        supervises=contract.supervises,
        nodes=st.sampled_from(contract.nodes),
        field=field,
    )
