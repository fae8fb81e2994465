"""What stands in for msgspec in the page reads each scenario there as msgspec does."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from grader.course.exercises import ROOT
from sim.scenario_files import load_scenario, scenario_names

READ = """
import json, sys
sys.path[:0] = sys.argv[1:]
import msgspec
from sim.scenario_files import load_scenario
assert "stand_ins" in msgspec.__file__
print(json.dumps({name: repr(load_scenario(name)) for name in json.load(sys.stdin)}))
"""


@pytest.mark.parametrize(
    "room",
    ["demo", "obstacle_avoidance", "goal_seeking", "trend_memory", "safety_supervisor"],
)
def test_scenarios_are_the_same_with_the_stand_in(room: str) -> None:
    names = [name for name, path in scenario_names().items() if room in path.parts]
    assert names
    done = subprocess.run(
        [sys.executable, "-c", READ, str(ROOT / "workspace" / "stand_ins"), str(ROOT)],
        input=json.dumps(names),
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {name: repr(load_scenario(name)) for name in names}
