"""How far a robot drove, and whether it touched anything."""

import numpy as np
import pytest
from node_runs import RunNode, short

from grader.checks.driving import path_length, require_no_contact
from grader.checks.moments import first_contact
from grader.checks.verdict import CheckFailed

DRIVES = """
class Agent(Echo):
    def on_scan(self, scan):
        twist = Twist()
        twist.linear.x = 0.5
        self.publisher.publish(twist)
rclpy.init()
rclpy.spin(Agent())
"""


def test_a_straight_drive_is_as_long_as_its_ends_are_apart(run_node: RunNode) -> None:
    recording = run_node(DRIVES, short(1.0))
    truth = recording.truth

    driven = float(np.hypot(truth.x[-1] - truth.x[0], truth.y[-1] - truth.y[0]))
    assert path_length(recording) == pytest.approx(driven)
    assert driven > 0.2
    require_no_contact(recording, "")


def test_who_drives_into_the_wall_fails_at_the_contact(run_node: RunNode) -> None:
    recording = run_node(DRIVES, short(10.0))

    with pytest.raises(CheckFailed, match="the robot ran into something") as caught:
        require_no_contact(recording, "look", expected="a stop")
    assert caught.value.at == first_contact(recording)
    assert (caught.value.expected, caught.value.help) == ("a stop", "look")
