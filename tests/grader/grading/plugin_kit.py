"""Fake trials, for checks that the plug-in of pytest runs over them."""

import itertools
from collections.abc import Callable, Sequence

from grader.grading.grading import Grading
from grader.recording import Live, Outcome, Recording
from grader.trial.trials import NoRecording, TrialFault

PREAMBLE = """\
import os, sys
import pytest
from grader.checks.verdict import fail, inconclusive
check = pytest.mark.check
"""
CHAIN = """
    @check(points=1, scenarios=("{scenario}",))
    def test_first(recordings):
        '''First.'''
        {body}
    @check(points=1, scenarios=("b",), needs=("first",))
    def test_second(recordings):
        '''Second.'''
    @check(points=1, scenarios=("c",), needs=("second",))
    def test_third(recordings):
        '''Third.'''
    @check(points=1, scenarios=("d",))
    def test_alone(recordings):
        '''Alone.'''
"""
count = itertools.count()


class FakeRecording(str):
    """A recording that is its name; `late` was made on a machine that stalled."""

    @property
    def live(self) -> Live | None:
        return Live(0, "", 1.0, 0.0, "a message was late") if self == "late" else None

    @property
    def outcome(self) -> Outcome:
        return Outcome("exception" if self == "dead" else "completed")


class FakeTrials:
    """Recordings that are their names; those called `none` don't exist."""

    def __init__(self, fault: Exception | None = None) -> None:
        self.prepared: list[list[str]] = []
        self.asked: list[str] = []
        self._fault = fault

    def prepare(self, scenarios: Sequence[str]) -> None:
        self.prepared.append(list(scenarios))

    def get(self, scenario: str) -> Recording:
        self.asked.append(scenario)
        if isinstance(self._fault, TrialFault) and scenario != self._fault.scenario:
            return FakeRecording(scenario)  # type: ignore[return-value]
        if self._fault is not None:
            raise self._fault
        if scenario == "none":
            raise NoRecording("no recording of the scenario none")
        return FakeRecording(scenario)  # type: ignore[return-value]

    def recordings(self) -> list[Recording]:
        return []

    def faults(self) -> list[TrialFault]:
        return [self._fault] if isinstance(self._fault, TrialFault) else []

    def notes(self) -> list[str]:
        return []

    def lacks(self, scenarios: Sequence[str], libraries: Sequence[str]) -> str:
        return "PyTorch is not installed here" if "torch" in libraries else ""


Run = Callable[..., Grading]


def outcomes(grading: Grading) -> dict[str, str]:
    return {check.id: check.outcome for check in grading.checks}
