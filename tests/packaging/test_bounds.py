"""What is patched inside another library is still there, and pyproject.toml bounds its version.

If a test fails after an update: look at what moved, then raise the bound in pyproject.toml.
"""

import tomllib
from datetime import UTC, datetime

import _time_machine
import time_machine
from packaging.requirements import Requirement

from grader.course.exercises import ROOT

PATCHED = "time-machine"


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
    assert "<" in {one.operator for one in requirements()[PATCHED].specifier}


def test_time_machine_takes_the_time_from_its_traveller() -> None:
    travel = time_machine.travel(0, tick=False)
    traveller = travel.start()
    try:
        traveller.time_ns = lambda: 42 * 10**9
        assert datetime.now(UTC).timestamp() == 42
        assert _time_machine.original_time_ns() > 10**18
    finally:
        travel.stop()
