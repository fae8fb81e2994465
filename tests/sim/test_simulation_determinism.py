"""Scenario and seed determine every byte of a run (sim/simulation.py)."""

import hashlib
import os
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated import SECOND

from sim.layout import layout_to_json
from sim.messages import LASER_SCAN, ODOMETRY
from sim.scenario_files import scenario_from_toml
from sim.simulation import Simulation

SETTINGS = settings(derandomize=True, deadline=None, max_examples=8)
EVERYTHING = """
title = "Everything at once"
duration = 6
[world]
[[world.walls]]
points = [[-3, -3], [4, -3], [4, 3], [-3, 3]]
closed = true
[[world.clutter]]
area = [[1, -2], [3, 2]]
count = 5
[[world.carts]]
size = [0.4, 0.4]
path = [[0, -2, -2], [2, -2, 2], [4, -2, -2]]
loop = true
[robot]
start_jitter = [0.1, 0.1, 20]
[odometry]
linear_scale = 1.02
[faults]
range_noise = 0.02
beam_dropout = 0.05
nan_speckle = 0.05
scan_latency = 0.12
scan_jitter = 0.2
scan_loss = 0.2
odom_loss = 0.1
odom_latency = 0.03
blackout = [[2.0, 2.5]]
[[script]]
at = 1.0
goal = [2, 1, 90]
[[script]]
at = 2.005
teleport = [-1, 1, 45]
[[script]]
at = 3.0
odom = [nan, 0, 0]
"""
COMMANDS = [(k * 137_000_000, 0.5 - 0.1 * (k % 4), 0.4 * (k % 3) - 0.3) for k in range(40)]


def run(simulation, cuts, commands):
    """Advance in pieces, each with the commands of its time, and return messages and truth."""
    messages, left = [], list(commands)
    for until in cuts:
        now = [c for c in left if c[0] < until]
        left = left[len(now) :]
        messages += simulation.advance(until, now)
    truth = simulation.truth()
    return messages, b"".join(getattr(truth, field.name).tobytes() for field in fields(truth))


WHOLE = run(Simulation(scenario_from_toml(EVERYTHING, "x")), [6 * SECOND], COMMANDS)


def test_the_run_with_everything_has_everything():
    messages, _ = WHOLE
    assert {m.topic for m in messages} == {"/scan", "/odom", "/goal_pose"}
    assert 20 < sum(m.type == LASER_SCAN for m in messages) < 60
    assert 80 < sum(m.type == ODOMETRY for m in messages) < 121


def digest():
    messages, truth = WHOLE
    return hashlib.sha256(b"".join(m.data for m in messages) + truth).hexdigest()


def test_another_process_with_another_hash_seed_gives_the_same_bytes():
    code = "from test_simulation_determinism import digest; print(digest())"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=Path(__file__).parent,
        env={**os.environ, "PYTHONHASHSEED": "77", "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == digest()


def test_another_seed_is_another_run_and_the_global_generators_are_left_alone():
    scenario = scenario_from_toml(EVERYTHING, "x")
    before = np.random.get_state()[1].tobytes()
    simulation = Simulation(scenario, 2)
    assert simulation.seed == 2
    assert layout_to_json(simulation.layout) != layout_to_json(Simulation(scenario).layout)
    assert run(simulation, [6 * SECOND], COMMANDS) != WHOLE
    assert np.random.get_state()[1].tobytes() == before


@SETTINGS
@given(st.lists(st.integers(0, 6 * SECOND), max_size=30))
def test_how_a_run_is_cut_into_pieces_does_not_matter(cuts):
    simulation = Simulation(scenario_from_toml(EVERYTHING, "x"))
    assert run(simulation, [*sorted(cuts), 6 * SECOND], COMMANDS) == WHOLE


def test_going_from_event_to_event_is_the_same_run():
    simulation = Simulation(scenario_from_toml(EVERYTHING, "x"))
    messages, left, events = [], list(COMMANDS), []
    while (until := simulation.next_event()) is not None:
        assert until > simulation.now
        now = [c for c in left if c[0] < until]
        left = left[len(now) :]
        found = simulation.advance(until, now)
        assert all(m.time == until for m in found)
        events.append(until)
        messages += found
    messages += simulation.advance(6 * SECOND, left)
    assert messages == WHOLE[0]
    assert 2_005_000_000 in events
    assert run(simulation, [], [])[1] == WHOLE[1]
