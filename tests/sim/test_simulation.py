"""What a simulation sends and does: commands, script, truth. Determinism has a file of its own."""

import math

import msgspec
import numpy as np
import pytest
from simulated import SECOND, scans_in, simulate

from sim import simulation as simulation_module
from sim.messages import LASER_SCAN, ODOMETRY, decode
from sim.robot import Robot
from sim.scenario_files import load_scenario
from sim.simulation import Simulation


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


def test_late_commands_give_the_same_drive_later():
    sent = [(0, 0.5, 0.0), (400_000_000, 0.1, 1.0)]
    at_once, _ = simulate("", sent, seconds=2.0)
    late, _ = simulate("[faults]\ncommand_latency = 0.2", sent, seconds=2.2)
    late.advance(round(2.5 * SECOND))
    now, then = at_once.truth(), late.truth()
    assert not then.v[:11].any()  # 0.2 s, in samples of 20 ms
    assert then.x[10:111].tolist() == now.x.tolist()
    assert then.yaw[10:111].tolist() == now.yaw.tolist()


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


def test_the_script_sends_goals_and_poses_at_their_times():
    text = """
    rotate_deg = 90
    odometry = { enabled = false }
    lidar = { enabled = false }
    script = [
        { at = 1.5, goal = [2, 0, 0] },
        { at = 1.0, odom = [inf, 1, 0] },
        { at = 2.0, odom = [1, 0, 0] },
        { at = 2.5, goal = [2, 0, 0], stamp_offset = -1.5 },
        { at = 3.0, goal = [2, 0, 0], unstamped = true },
    ]
    """
    _, messages = simulate(text)
    assert [(m.topic, m.time / SECOND) for m in messages] == [
        ("/odom", 1.0),
        ("/goal_pose", 1.5),
        ("/odom", 2.0),
        ("/goal_pose", 2.5),
        ("/goal_pose", 3.0),
    ]
    first, goal, last, *others = (decode(m.data, m.type) for m in messages)
    assert math.isinf(first.pose.pose.position.x)
    assert (goal.pose.position.x, goal.pose.position.y) == (0.0, 2.0)
    assert (last.pose.pose.position.x, last.pose.pose.position.y) == (0.0, 1.0)
    stamps = [other.header.stamp for other in (goal, *others)]
    assert [stamp.sec for stamp in stamps] == [1_700_000_001, 1_700_000_001, 0]
    assert [stamp.nanosec for stamp in stamps] == [500_000_000, 0, 0]


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
    last, reflected = (scans_in(messages)[-1].ranges for messages in (scans, mirrored))
    assert reflected[1:][::-1] == pytest.approx(last[1:], abs=1.1e-3)
