"""The robot as a node among others: processes that talk over DDS.

Tests `sim.live.node`, and through it `sending`, `hearing`, `parameters`, `diagnostics`, `extras`,
`recorder`, `memory` and `run`.
"""

import math
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from processes import Line, Process, Town, town
from rosbags.rosbag2 import Reader

from rclpy_virtual_time.link.domains import own_domain
from sim.messages import EPOCH_NS, TWIST

pytestmark = pytest.mark.long  # but one: in test_live_command_line.py
ODOM_PERIOD = 0.05  # [s]
LONGEST_STOP = 0.5 + 0.5 / 0.9  # [s] a command counts, and the ramp from 0.5 m/s at 0.9 m/s²


@dataclass(frozen=True)
class Square:
    """A robot in `demo_wall` and somebody who listens to it."""

    town: Town
    robot: Process
    listener: Process

    def speed(self, wanted: Callable[[float], bool]) -> Line:
        """Wait for such a speed [m/s] in the odometry."""
        return self.listener.next_json("/odom", lambda odom: wanted(odom["v"]))


@pytest.fixture(scope="module")
def square(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Square]:
    with own_domain() as domain, town(domain, tmp_path_factory.mktemp("square")) as here:
        yield Square(here, here.robot(), here.listener())


def contents(bag: Path) -> tuple[Counter[str], set[tuple[str, str]]]:
    """Return how many messages of each topic are in a bag, and the types of its topics."""
    with Reader(bag) as reader:
        counts = Counter(connection.topic for connection, _, _ in reader.messages())
        return counts, {(c.topic, c.msgtype) for c in reader.connections}


def test_it_drives_while_somebody_tells_it_to_and_no_longer(square: Square) -> None:
    teleop = square.town.teleop(0.5, 0.0)
    square.speed(lambda v: v > 0.45)
    teleop.end(signal.SIGKILL)
    killed = time.time()
    moving = 0  # odometry that was measured after that; it counts the robot's own time
    while (odom := square.listener.next_json("/odom"))["v"] > 0.01:
        moving += odom["stamp"] > killed
    assert moving <= LONGEST_STOP / ODOM_PERIOD + 4  # the last commands were still under way

    again = square.town.teleop(-0.5, 0.0)
    square.speed(lambda v: v < -0.45)
    again.end(signal.SIGKILL)
    square.speed(lambda v: abs(v) < 0.01)


def test_twist_stamped_moves_it_too_and_it_says_that_this_is_not_the_type(square: Square) -> None:
    stamped = square.town.teleop(0.3, 0.0, "stamped")
    square.speed(lambda v: v > 0.25)
    stamped.end(signal.SIGKILL)
    said = square.robot.wait_for("TwistStamped")
    assert "in this course that is geometry_msgs/msg/Twist" in said
    square.speed(lambda v: abs(v) < 0.01)


def test_a_command_that_is_not_finite_is_a_stop_with_a_warning(square: Square) -> None:
    broken = square.town.teleop(math.nan, 0.0)
    assert "expected finite numbers" in square.robot.wait_for("linear.x = nan")
    broken.end(signal.SIGKILL)
    assert abs(square.listener.next_json("/odom")["v"]) < 0.01


def test_it_can_be_paused(square: Square) -> None:
    listener = square.listener
    assert listener.ask("pause true")["message"].startswith("paused at ")
    listener.next_json("/diagnostics", lambda status: status["message"] == "paused")
    listener.next_json("/diagnostics", lambda status: status["message"] == "0.0 of 10.0 Hz")
    assert listener.ask("pause false")["message"].startswith("running at ")
    listener.next_json("/scan")


def test_a_parameter_is_refused_with_a_reason(square: Square) -> None:
    for order, reason in {
        "rate 2.0": "start the robot with --clock",
        "rate nan": "Parameter rate out of range",
        "command_timeout 2.0": "read-only",
    }.items():
        answer = square.listener.ask(f"set {order}")
        assert (answer["success"], reason in answer["message"]) == (False, True), answer


def test_a_sensor_data_lidar_is_heard_by_best_effort_only(here: Town) -> None:
    """Beside it, another robot in another domain that nobody here hears."""
    with own_domain() as elsewhere, town(elsewhere, here.folder) as there:
        scenario = ("--scenario", "avoid_field_best_effort")
        robot = here.robot(*scenario, "--record", "ours")
        other = there.robot(*scenario, "--lidar", "wide", "--record", "theirs")
        reliable, lenient = here.listener("reliable"), here.listener("best_effort")
        robot.wait_for("incompatible QoS")
        assert {lenient.next_json("/scan")["beams"] for _ in range(5)} == {360}
        reliable.end(signal.SIGKILL)
        assert '"/scan"' not in reliable.rest()
        assert robot.end(signal.SIGINT) == 0
        assert other.end(signal.SIGTERM) == 0
    assert "Traceback" not in robot.rest() + other.rest()
    for name in ("ours", "theirs"):
        counts, _ = contents(here.folder / name)
        assert counts["/scan"] >= 5
        assert set(counts) <= {"/scan", "/diagnostics"}


def test_in_simulated_time_it_waits_begins_and_ends(here: Town) -> None:
    robot = here.robot("--wait", "--clock", "--rate", "2", "--duration", "4", "--record", "bag")
    here.teleop(0.1, 0.0).wait_for("a robot hears this")
    listener = here.listener("best_effort")  # a reliable robot is heard by it, too
    for topic in ("/clock", "/scan"):
        assert 0.0 <= listener.next_json(topic)["stamp"] - EPOCH_NS / 1e9 <= 4.0
    assert "the robot ends" in robot.rest()
    assert robot.popen.returncode == 0

    counts, types = contents(here.folder / "bag")
    assert counts["/scan"] == 40
    assert counts["/odom"] == 80
    assert counts["/clock"] >= 100
    assert counts["/cmd_vel"] >= 1
    assert {("/clock", "rosgraph_msgs/msg/Clock"), ("/cmd_vel", TWIST)} <= types
    with Reader(here.folder / "bag") as reader:
        times = [time for _, time, _ in reader.messages()]
    assert times[-1] == EPOCH_NS + 4 * 10**9
