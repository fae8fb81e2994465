"""When messages are measured and when they arrive."""

import pytest
from simulated import SECOND, simulate

from sim.events import Kind
from sim.scenario_files import scenario_from_toml
from sim.schedule import ODOM, schedule

SCAN = Kind.SENSOR


def events(text, kind, seed=1):
    scenario = scenario_from_toml('title = "x"\nworld = "open"\n' + text, "x")
    return [event for event in schedule(scenario, seed) if event.kind == kind]


def test_periodic_messages_do_not_drift():
    found = events("duration = 1000\n[odometry]\nrate = 30\nphase = 0.5", ODOM)
    assert len(found) == 30 * 999 + 15 + 1
    assert found[-1].time == 1000 * 10**9
    assert all(e.time == round((0.5 + e.index / 30) * 1e9) for e in found)


def test_latency_keeps_the_stamp_and_late_messages_miss_the_end():
    found = events("duration = 2\n[faults]\nscan_latency = 0.3", SCAN)
    assert {e.delivery - e.time for e in found} == {300_000_000}
    assert max(e.delivery for e in found) <= 2 * 10**9
    assert len(found) == 17


def test_lost_scans_are_lost_by_the_seed():
    text = "duration = 100\n[faults]\nscan_loss = 0.2"
    assert len(events(text, SCAN)) == pytest.approx(800, abs=40)
    assert events(text, SCAN) == events(text, SCAN)
    assert events(text, SCAN) != events(text, SCAN, seed=2)
    assert events(text, ODOM) == events("duration = 100", ODOM)


def test_lost_scans_use_up_no_bench_entry():
    text = 'duration = 9\n[faults]\nscan_loss = 0.5\n[[bench]]\nlabel = "a"\nrepeat = 7'
    assert [e.index for e in events(text, SCAN)] == list(range(7))


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
