import hashlib
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim import simulation as simulation_module
from sim.layout import layout_to_json
from sim.lidar import PROFILES
from sim.messages import EPOCH_NS, LASER_SCAN, ODOMETRY, decode
from sim.placement import scenario_layout
from sim.robot import Robot
from sim.scenario import RobotSpec, load_scenario, scenario_from_toml
from sim.simulation import Simulation

SETTINGS = settings(derandomize=True, deadline=None, max_examples=25)
SECOND = 10**9
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
position_noise = 0.01
yaw_noise = 0.01
linear_scale = 1.02
[faults]
range_noise = 0.02
range_bias = 0.01
beam_dropout = 0.05
nan_speckle = 0.05
scan_latency = 0.12
scan_jitter = 0.2
scan_loss = 0.2
odom_loss = 0.1
odom_latency = 0.03
wheel_slip = 0.1
freeze = [[1.0, 1.5]]
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


def simulate(text, commands=(), seconds=6.0, world="open"):
    scenario = scenario_from_toml(f'title = "x"\nworld = "{world}"\n{text}', "x")
    simulation = Simulation(scenario)
    return simulation, simulation.advance(round(seconds * SECOND), commands)


def run(simulation, cuts, commands):
    """Advance in pieces, each with the commands of its time, and return messages and truth."""
    messages, left = [], list(commands)
    for until in cuts:
        now = [c for c in left if c[0] < until]
        left = left[len(now) :]
        messages += simulation.advance(until, now)
    truth = simulation.truth()
    fields = (
        truth.t,
        truth.x,
        truth.y,
        truth.yaw,
        truth.v,
        truth.w,
        truth.clearance,
        truth.contact,
    )
    return messages, b"".join(field.tobytes() for field in fields)


WHOLE = run(Simulation(scenario_from_toml(EVERYTHING, "x")), [6 * SECOND], COMMANDS)


def test_the_run_with_everything_has_everything():
    messages, _ = WHOLE
    assert {m.topic for m in messages} == {"/scan", "/odom", "/goal_pose"}
    assert 20 < sum(m.type == LASER_SCAN for m in messages) < 60
    assert 80 < sum(m.type == ODOMETRY for m in messages) < 121


def test_two_runs_are_identical():
    simulation = Simulation(scenario_from_toml(EVERYTHING, "x"))
    assert (simulation.seed, simulation.now) == (1, 0)
    assert run(simulation, [6 * SECOND], COMMANDS) == WHOLE


def digest():
    messages, truth = run(Simulation(scenario_from_toml(EVERYTHING, "x")), [6 * SECOND], COMMANDS)
    return hashlib.sha256(b"".join(m.data for m in messages) + truth).hexdigest()


def test_another_process_with_another_hash_seed_gives_the_same_bytes():
    code = "import test_simulation; print(test_simulation.digest())"
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


def test_messages_come_in_order_with_odometry_before_the_scan():
    _, messages = simulate("[lidar]\nphase = 0.05\n[odometry]\nphase = 0.05")
    assert [m.time for m in messages] == sorted(m.time for m in messages)
    assert [m.topic for m in messages[:3]] == ["/odom", "/scan", "/odom"]
    assert messages[0].time == messages[1].time == 50_000_000


def test_nothing_comes_after_the_duration():
    simulation, messages = simulate("duration = 2", seconds=2.0)
    assert messages[-1].time <= 2 * SECOND
    assert simulation.next_event() is None
    assert simulation.advance(5 * SECOND) == []
    assert simulation.truth().t[-1] == 5 * SECOND


def test_going_back_in_time_is_refused():
    simulation, _ = simulate("", seconds=1.0)
    with pytest.raises(ValueError, match="cannot advance to 5 ns: it is already 1000000000 ns"):
        simulation.advance(5)
    assert simulation.advance(SECOND) == []


def test_the_truth_is_sampled_every_20_ms_up_to_now():
    simulation, _ = simulate("", seconds=0.039999)
    assert simulation.truth().t.tolist() == [0, 20_000_000]
    simulation.advance(40_000_000)
    truth = simulation.truth()
    assert truth.t.tolist() == [0, 20_000_000, 40_000_000]
    assert truth.t.dtype == np.int64
    assert truth.contact.dtype == bool
    assert (truth.clearance == 10.0).all()


def test_a_touch_between_two_samples_is_in_the_truth(monkeypatch):
    class Touchy(Robot):
        def step(self, start, linear, angular):
            super().step(start, linear, angular)
            self.touched = start == 0.04

    monkeypatch.setattr(simulation_module, "Robot", Touchy)
    simulation, _ = simulate("", seconds=0.1)
    truth = simulation.truth()
    assert truth.contact.tolist() == [False, False, False, True, False, False]
    assert truth.clearance.tolist() == [10.0, 10.0, 10.0, 0.0, 10.0, 10.0]


def test_a_command_counts_from_the_next_step_after_its_time():
    simulation, _ = simulate("", [(30_000_001, 0.5, 0.0)], seconds=0.06)
    assert simulation.truth().v.tolist() == pytest.approx([0, 0, 0, 0.018])


def test_a_command_for_later_is_kept_and_a_late_one_counts_at_once():
    simulation, _ = simulate("", [(SECOND, 0.5, 0.0)], seconds=0.5)
    simulation.advance(SECOND)
    assert not simulation.truth().v.any()
    simulation.advance(round(1.02 * SECOND), [(0, 0.5, 0.0)])
    assert simulation.truth().v[-1] > 0


def test_the_lidar_sees_the_hall_and_the_odometry_the_motion():
    commands = [(k * 100_000_000, 0.3, 0.0) for k in range(40)]
    simulation, messages = simulate("", commands, seconds=4.0, world="hall")
    truth = simulation.truth()
    for message in messages:
        value = decode(message.data, message.type)
        x = np.interp(message.time, truth.t, truth.x)
        if message.type == LASER_SCAN:
            assert value.ranges[180] == pytest.approx(6 - x, abs=1e-3)
            assert value.ranges[270] == pytest.approx(4.0)
        else:
            assert value.pose.pose.position.x == pytest.approx(x, abs=1e-4)
            assert value.header.stamp.sec * SECOND + value.header.stamp.nanosec == (
                message.time + 1_700_000_000 * SECOND
            )
    assert value.twist.twist.linear.x == pytest.approx(0.3)


def test_the_lidar_sees_a_cart_where_it_is():
    scenario = scenario_from_toml(
        'title = "x"\n[world]\n[[world.carts]]\nsize = [0.5, 0.5]\npath = [[0, 5, 0], [4, 1, 0]]',
        "x",
    )
    for message in Simulation(scenario).advance(4 * SECOND):
        if message.type == LASER_SCAN:
            ahead = decode(message.data, message.type).ranges[180]
            assert ahead == pytest.approx(5 - message.time / SECOND - 0.25, abs=1e-3)


@pytest.mark.parametrize("name", PROFILES)
def test_every_profile_has_its_form(name):
    profile = PROFILES[name]
    _, messages = simulate(f'[lidar]\nprofile = "{name}"', seconds=2.0, world="hall")
    scans = [m for m in messages if m.type == LASER_SCAN]
    assert len(scans) == pytest.approx(2 * profile.rate, abs=1)
    scan = decode(scans[0].data, LASER_SCAN)
    assert len(scan.ranges) == profile.beams
    assert scan.angle_min == np.float32(profile.angle_min)
    assert scan.scan_time == np.float32(1 / profile.rate)
    ahead = scan.ranges[np.argmin(abs(profile.angles))]
    assert ahead == (6.0 if profile.range_max > 6 else profile.no_return)


def test_the_rate_can_be_changed():
    _, messages = simulate("[lidar]\nrate = 25\n[odometry]\nrate = 50", seconds=2.0)
    assert sum(m.type == LASER_SCAN for m in messages) == 50
    assert sum(m.type == ODOMETRY for m in messages) == 100


def test_a_frozen_lidar_repeats_its_readings_while_its_stamps_go_on():
    commands = [(k * 100_000_000, 0.3, 0.0) for k in range(60)]
    _, messages = simulate("[faults]\nfreeze = [[1.0, 2.0]]", commands, world="hall")
    scans = [decode(m.data, m.type) for m in messages if m.type == LASER_SCAN]
    ahead = [float(scan.ranges[180]) for scan in scans]
    assert len(set(ahead[9:20])) == 1
    assert len(set(ahead[20:40])) == 20
    stamps = [scan.header.stamp.sec * SECOND + scan.header.stamp.nanosec for scan in scans]
    assert set(np.diff(stamps)) == {100_000_000}


def test_a_bench_is_sent_scan_by_scan():
    text = """
    [[bench]]
    label = "near"
    fill = inf
    patches = [{from_deg = -5, to_deg = 5, range = 0.42}]
    repeat = 2
    [[bench]]
    empty = true
    [faults]
    range_noise = 0.5
    nan_speckle = 0.5
    """
    _, messages = simulate(text)
    scans = [decode(m.data, m.type).ranges for m in messages if m.type == LASER_SCAN]
    assert [len(scan) for scan in scans] == [360, 360, 0]
    assert scans[0][175:186].tolist() == [np.float32(0.42)] * 11
    assert np.isposinf(np.delete(scans[0], range(175, 186))).all()
    assert np.array_equal(scans[0], scans[1])


def test_the_clock_of_a_bench_can_be_set():
    text = """
    [[bench]]
    fill = 2.0
    [[bench]]
    stamp_offset = -5.0
    repeat = 2
    [[bench]]
    fill = 2.0
    """
    _, messages = simulate(text)
    scans = [decode(m.data, m.type) for m in messages if m.type == LASER_SCAN]
    stamps = [scan.header.stamp.sec + scan.header.stamp.nanosec / 1e9 for scan in scans]
    times = [m.time / 1e9 for m in messages if m.type == LASER_SCAN]
    start = EPOCH_NS / 1e9
    np.testing.assert_allclose(np.subtract(stamps, start), np.add(times, [0, -5, -5, 0]), atol=1e-6)


def test_the_script_sends_goals_and_poses_at_their_times():
    text = """
    rotate_deg = 90
    [odometry]
    enabled = false
    [lidar]
    enabled = false
    [[script]]
    at = 1.5
    goal = [2, 0, 0]
    [[script]]
    at = 1.0
    odom = [inf, 1, 0]
    [[script]]
    at = 2.0
    odom = [1, 0, 0]
    """
    _, messages = simulate(text)
    assert [(m.topic, m.time) for m in messages] == [
        ("/odom", SECOND),
        ("/goal_pose", 1_500_000_000),
        ("/odom", 2 * SECOND),
    ]
    first, goal, last = (decode(m.data, m.type) for m in messages)
    assert math.isinf(first.pose.pose.position.x)
    assert (goal.pose.position.x, goal.pose.position.y) == (0.0, 2.0)
    assert (last.pose.pose.position.x, last.pose.pose.position.y) == (0.0, 1.0)


def test_a_teleport_moves_the_robot_stops_it_and_is_seen_by_the_odometry():
    commands = [(k * 100_000_000, 0.3, 0.0) for k in range(10)]
    text = "[odometry]\nlinear_scale = 1.5\n[[script]]\nat = 1.6\nteleport = [-2, 1, 90]"
    simulation, messages = simulate(text, commands, seconds=3.0, world="hall")
    truth = simulation.truth()
    after = truth.t > 1_600_000_000
    assert truth.x[~after].max() > 0.3
    assert truth.x[after] == pytest.approx(-2.0)
    assert not truth.v[after].any()
    last = decode([m for m in messages if m.type == ODOMETRY][-1].data, ODOMETRY)
    assert last.pose.pose.position.x == pytest.approx(-2.0)
    assert 2 * last.pose.pose.orientation.z**2 == pytest.approx(1.0)


def test_a_mirrored_and_rotated_world_gives_the_mirrored_run():
    scenario = load_scenario("demo_wall")
    turned = msgspec.structs.replace(scenario, mirror=True, rotate_deg=90.0)
    plain, other = Simulation(scenario), Simulation(turned)
    commands = [(k * 100_000_000, 0.3, 0.2) for k in range(40)]
    scans = plain.advance(4 * SECOND, commands)
    mirrored = other.advance(4 * SECOND, [(t, v, -w) for t, v, w in commands])
    one, two = plain.truth(), other.truth()
    assert two.x == pytest.approx(one.y, abs=1e-9)
    assert two.y == pytest.approx(one.x, abs=1e-9)
    last, reflected = (
        decode([m for m in ms if m.type == LASER_SCAN][-1].data, LASER_SCAN).ranges
        for ms in (scans, mirrored)
    )
    assert reflected[1:][::-1] == pytest.approx(last[1:], abs=1.1e-3)


def test_jitter_moves_the_start_by_the_seed_and_within_its_limits():
    text = (
        'title = "x"\nworld = "open"\n[robot]\nstart = [1, 2, 30]\nstart_jitter = [0.5, 0.25, 10]'
    )
    scenario = scenario_from_toml(text, "x")
    starts = [scenario_layout(scenario, seed).start for seed in range(50)]
    off = np.array(starts) - (1.0, 2.0, math.radians(30))
    assert (abs(off) <= (0.5, 0.25, math.radians(10))).all()
    assert (abs(off).max(axis=0) > (0.4, 0.2, math.radians(8))).all()


def test_the_docstring_says_what_the_defaults_are():
    text = simulation_module.__doc__
    robot, lidar = RobotSpec(), PROFILES["default"]
    row = re.search(r"LaserScan .*\| ([\d.]+) … (\d+), ±inf", text)
    assert [float(x) for x in row.groups()] == [lidar.range_min, lidar.range_max]
    assert f"| ±{robot.max_linear} " in text
    assert f"| ±{robot.max_angular} " in text
    assert f"{robot.max_acceleration} m/s² and {robot.max_angular_acceleration:g} rad/s²" in text
    assert f"{robot.command_timeout} s after the last" in text
