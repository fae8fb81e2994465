"""What stands in for msgspec and pymunk in the page reads and drives as they do."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.course.exercises import ROOT, all_exercises
from sim.scenario_files import load_scenario, scenario_names
from workspace.build import PAGE_PACKAGES, lay, page_packages

READ = """
import msgspec
from sim.scenario_files import load_scenario
print(json.dumps({name: repr(load_scenario(name)) for name in order}))
"""
CRASH = """
import pymunk
import numpy as np
from sim.scenario_files import load_scenario
from sim.simulation import Simulation
runs = []
for name, seed in order:
    draw = np.random.default_rng(seed)
    times = np.arange(0, 12, 0.5)
    commands = zip(times, draw.uniform(-0.2, 0.5, times.size), draw.uniform(-1.2, 1.2, times.size))
    simulation = Simulation(load_scenario(name), seed)
    simulation.advance(12 * 10**9, [(round(t * 1e9), float(v), float(w)) for t, v, w in commands])
    truth = simulation.truth()
    runs.append([truth.x.tolist(), truth.y.tolist(), truth.contact.tolist()])
print(json.dumps(runs))
"""
CROWDED = ("avoid_cart", "avoid_store", "avoid_corridor", "trend_cart", "demo_store")


def said_by(script: str, order: object, *paths: str) -> Any:
    """Run a script where some folders come first."""
    begin = "import json, sys\nsys.path[:0] = sys.argv[1:]\norder = json.load(sys.stdin)\n"
    done = subprocess.run(
        [sys.executable, "-c", begin + script, *paths, str(ROOT)],
        input=json.dumps(order),
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def in_page(script: str, order: object, at: Path) -> Any:
    lay(at, page_packages())
    folder = str(at / PAGE_PACKAGES)
    module = next(line for line in script.splitlines() if line).removeprefix("import ")
    return said_by(f"{script}\nassert {module}.__file__.startswith({folder!r})", order, folder)


def test_scenarios_are_the_same(tmp_path: Path) -> None:
    places = scenario_names()
    rooms = {part for path in places.values() for part in path.parts}
    assert rooms > {"demo", *(exercise.slug for exercise in all_exercises())}
    found = in_page(READ, list(places), tmp_path)
    for name in places:
        assert found[name] == repr(load_scenario(name))


@pytest.mark.long
def test_a_robot_that_runs_into_things_is_where_pymunk_has_it(tmp_path: Path) -> None:
    order = [(name, seed) for name in CROWDED for seed in range(8)]
    touched = 0
    for here, there in zip(in_page(CRASH, order, tmp_path), said_by(CRASH, order), strict=True):
        assert here[2] == there[2]
        assert np.hypot(*np.subtract(here[:2], there[:2])).max() < 0.001  # [m]
        touched += sum(here[2])
    assert touched > 800
