"""The judge's side of each exercise: its contract, its checks and its scenarios."""

from __future__ import annotations

import importlib

from grader.checks.case import Oracle
from grader.checks.contract import Contract
from grader.course.exercises import Exercise
from grader.errors import InputError


def contract_of(exercise: Exercise) -> Contract:
    """Return what an exercise's node is."""
    found = importlib.import_module(f"{__name__}.{exercise.slug}.contract").CONTRACT
    assert isinstance(found, Contract)
    return found


def driving_contract_of(exercise: Exercise) -> Contract:
    """Return what an exercise promises of any drive, unless its nodes don't drive by themselves."""
    contract = contract_of(exercise)
    if not contract.drives:
        raise InputError(f"exercise {exercise.number}: its nodes do not drive by themselves")
    return contract


def oracle_of(exercise: Exercise) -> Oracle:
    """Return the exercise's `cases`; one without a contract says nothing of any occasion."""
    if not (exercise.judge / "contract.py").is_file():
        return lambda recording: ()
    oracle: Oracle = importlib.import_module(f"{__name__}.{exercise.slug}.contract").cases
    return oracle
