"""The robot's time, on clocks that the test moves.

Tests `sim.live.robot`, `timeline`, `health` and `topics`.
"""

from itertools import pairwise

import msgspec
import pytest

from sim.live.health import HealthMeter
from sim.live.robot import LiveRobot
from sim.live.timeline import Timeline
from sim.live.topics import sent_topics
from sim.messages import EPOCH_NS, ODOM_TOPIC, SCAN_TOPIC, decode
from sim.scenario_files import load_scenario, scenario_from_toml

TODAY = 1_800_000_000 * 10**9


class Clocks:
    """Monotonic and wall clock [ns] that only move when told."""

    def __init__(self) -> None:
        self.elapsed = 0

    def monotonic(self) -> int:
        return 5_000 + self.elapsed

    def wall(self) -> int:
        return TODAY + self.elapsed

    def move(self, seconds: float) -> None:
        self.elapsed += round(seconds * 1e9)

    def timeline(self, **options: object) -> Timeline:
        return Timeline(monotonic=self.monotonic, wall=self.wall, **options)  # type: ignore[arg-type]


def running(clocks: Clocks, **options: object) -> Timeline:
    timeline = clocks.timeline(**options)
    timeline.run(True)
    return timeline


def drive(robot: LiveRobot, clocks: Clocks, seconds: float) -> list[tuple[str, float, int]]:
    """Live on time; return topic, stamp since TODAY [s], and when it was sent [ns]."""
    end = clocks.elapsed + round(seconds * 1e9)
    sent = []
    while (due := robot.due()) <= (end - clocks.elapsed) / 1e9:
        clocks.move(max(due, 0.0))
        messages, _ = robot.step()
        for message in messages:
            stamp = decode(message.data, message.type).header.stamp
            since = stamp.sec - TODAY // 10**9 + stamp.nanosec / 1e9
            sent.append((message.topic, since, clocks.elapsed))
    clocks.elapsed = end
    return sent


def test_time_stands_until_it_is_told_to_run() -> None:
    clocks = Clocks()
    timeline = clocks.timeline()
    clocks.move(3.0)
    assert timeline.now() == 0
    assert timeline.seconds_until(10**9) == float("inf")

    timeline.run(True)
    clocks.move(2.0)
    assert timeline.now() == 2 * 10**9
    assert timeline.seconds_until(3 * 10**9) == pytest.approx(1.0)
    assert timeline.epoch == TODAY + 3 * 10**9  # the stamps of today


def test_after_a_pause_stamps_are_of_today_again() -> None:
    clocks = Clocks()
    timeline = running(clocks)
    clocks.move(1.0)
    timeline.run(False)
    clocks.move(10.0)
    timeline.run(True)
    assert timeline.now() == 10**9
    assert timeline.epoch + timeline.now() == clocks.wall()


def test_simulated_time_goes_at_its_rate_and_never_back() -> None:
    clocks = Clocks()
    timeline = running(clocks, rate=2.0, simulated=True)
    clocks.move(3.0)
    assert timeline.now() == 6 * 10**9
    timeline.restart()
    assert timeline.now() == 0
    assert timeline.ros_time(0) == EPOCH_NS + 6 * 10**9
    timeline.set_rate(0.5)
    clocks.move(1.0)
    assert timeline.now() == 500_000_000


def test_messages_leave_on_time_with_stamps_of_today() -> None:
    clocks = Clocks()
    robot = LiveRobot(load_scenario("demo_wall"), running(clocks))
    sent = drive(robot, clocks, 1.0)

    scans = [(stamp, time / 1e9) for topic, stamp, time in sent if topic == SCAN_TOPIC]
    assert len(scans) == 10
    assert [time for _, time in scans] == pytest.approx([0.013 + i / 10 for i in range(10)])
    assert [stamp for stamp, _ in scans] == pytest.approx([time for _, time in scans])
    assert sum(topic == ODOM_TOPIC for topic, _, _ in sent) == 20
    health = robot.meter.take(1.0, 1.0)
    assert health.keeps_up
    assert health.rates[SCAN_TOPIC] == (10.0, 10.0)


def test_after_a_stall_nothing_stale_is_sent_in_a_burst() -> None:
    clocks = Clocks()
    robot = LiveRobot(load_scenario("demo_wall"), running(clocks))
    drive(robot, clocks, 0.5)
    clocks.move(0.08)
    drive(robot, clocks, 0.42)
    short_delay = robot.meter.take(1.0, 1.0)  # which is made up for
    assert (robot.simulation.now >= 0.99e9, short_delay.keeps_up) == (True, True)
    assert 0.0 < short_delay.worst_lateness <= 0.08
    clocks.move(3.0)
    sent = drive(robot, clocks, 1.0)

    by_topic: dict[str, list[tuple[float, float]]] = {SCAN_TOPIC: [], ODOM_TOPIC: []}
    for topic, stamp, time in sent:
        by_topic[topic].append((stamp, time / 1e9))
    for topic, period in ((SCAN_TOPIC, 0.1), (ODOM_TOPIC, 0.05)):
        times = [time for _, time in by_topic[topic]]
        gaps = [b - a for a, b in pairwise(times)]
        assert gaps == pytest.approx([period] * len(gaps), abs=1e-6)
        assert all(stamp == pytest.approx(time, abs=1e-6) for stamp, time in by_topic[topic])
    health = robot.meter.take(5.0, 1.0)
    assert health.overruns == 1
    assert health.slipped == pytest.approx(3.0, abs=0.1)


def test_reset_begins_anew_and_draws_with_another_seed() -> None:
    clocks = Clocks()
    scenario = scenario_from_toml(
        'title = "t"\nworld = "open"\n[robot]\nstart_jitter = [1, 1, 20]\n', "t"
    )
    robot = LiveRobot(scenario, clocks.timeline())
    start = robot.simulation.layout.start
    robot.command(0.5, 0.0)  # no command counts while time stands still
    robot.timeline.run(True)
    drive(robot, clocks, 0.1)
    assert robot.simulation.pose == start
    robot.command(0.5, 0.0)
    drive(robot, clocks, 0.4)
    assert robot.simulation.pose != start
    robot.begin(robot.planned(scenario.seed))
    assert robot.simulation.now == 0
    assert robot.simulation.pose == start
    assert robot.timeline.epoch == clocks.wall()
    robot.begin(robot.planned(scenario.seed + 1))
    assert robot.simulation.pose != start


def test_the_robot_is_over_after_its_duration() -> None:
    clocks = Clocks()
    short = msgspec.structs.replace(load_scenario("demo_wall"), duration=0.25)
    robot = LiveRobot(short, running(clocks))
    while not robot.over:
        clocks.move(max(robot.due(), 0.0))
        robot.step()
    assert clocks.elapsed == 250_000_000


@pytest.mark.parametrize(
    ("name", "topics"),
    [
        ("demo_wall", {"/scan": 10.0, "/odom": 20.0}),
        ("avoid_field_wide", {"/scan": 40.0}),
        ("demo_open", {"/odom": 20.0, "/goal_pose": 0.0}),
        ("safe_e_stop", {"/scan": 5.0, "/e_stop": 0.0, "/cmd_vel_raw": 0.0}),
        ("avoid_field_turned", {"/tf": 0.0, "/tf_static": 0.0}),
    ],
)
def test_only_what_the_scenario_sends_has_a_topic(name: str, topics: dict[str, float]) -> None:
    sent = sent_topics(load_scenario(name))
    assert {topic: sent.get(topic) for topic in topics} == topics


def test_health_starts_over_with_each_look() -> None:
    meter = HealthMeter({"/scan": 10.0})
    for _ in range(5):
        meter.sent("/scan", 0.003)
    meter.slipped(0.2)
    first, second = meter.take(1.0, 2.0), meter.take(1.0, 2.0)
    assert first.rates == {"/scan": (20.0, 5.0)}
    assert (first.worst_lateness, first.overruns, first.slipped) == (0.003, 1, 0.2)
    assert not first.keeps_up
    assert second.rates == {"/scan": (20.0, 0.0)}
    assert second.keeps_up
