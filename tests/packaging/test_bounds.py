"""What is patched inside other libraries is still there, and pyproject.toml bounds their versions.

If a test fails after an update: look at what moved, then raise the bound in pyproject.toml.
"""

from __future__ import annotations

import inspect
import tomllib
from datetime import UTC, datetime

import _time_machine
import time_machine
from hypothesis.internal.conjecture import providers
from hypothesis.internal.constants_ast import Constants
from packaging.requirements import Requirement

from grader.course.exercises import ROOT
from grader.drive.search import finder

PATCHED = ("hypothesis", "time-machine")


def requirements() -> dict[str, Requirement]:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    return {one.name: one for one in map(Requirement, project["dependencies"])}


def test_the_pinned_versions_are_within_the_bounds() -> None:
    pins = dict(
        line.split("==")
        for line in (ROOT / "constraints.txt").read_text("utf-8").splitlines()
        if "==" in line
    )
    wrong = [
        str(one) for name, one in requirements().items() if not one.specifier.contains(pins[name])
    ]
    assert wrong == []


def test_what_is_patched_has_an_upper_bound() -> None:
    for name in PATCHED:
        assert "<" in {one.operator for one in requirements()[name].specifier}


def test_hypothesis_takes_its_constants_from_where_they_are_patched() -> None:
    drawn = inspect.getsource(providers.HypothesisProvider)
    assert "_get_local_constants()" in drawn
    assert "CONSTANTS_CACHE[key]" in drawn
    before = providers._get_local_constants, providers.CONSTANTS_CACHE
    with finder._by_seed_alone():
        assert providers._get_local_constants() == Constants()
        assert providers.CONSTANTS_CACHE is not before[1]
    assert (providers._get_local_constants, providers.CONSTANTS_CACHE) == before


def test_time_machine_takes_the_time_from_its_traveller() -> None:
    travel = time_machine.travel(0, tick=False)
    traveller = travel.start()
    try:
        traveller.time_ns = lambda: 42 * 10**9
        assert datetime.now(UTC).timestamp() == 42
        assert _time_machine.original_time_ns() > 10**18
    finally:
        travel.stop()
