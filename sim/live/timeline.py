"""Scenario time and ROS time of a live robot: running, paused or slipped.

Scenario time follows the machine's monotonic clock at a rate. Where it paused or slipped (the
machine stalled), ROS time on real clocks ran on, and later messages have later stamps; simulated
ROS time pauses and slips with it.
"""

import math
import time
from collections.abc import Callable

from sim.messages import EPOCH_NS

Clock = Callable[[], int]  # [ns]


class Timeline:
    """The time of one robot; it stays at 0 until `run`.

    Parameters
    ----------
    rate
        Scenario seconds in a second.
    simulated
        ROS time is scenario time since `EPOCH_NS`; otherwise it is that of the wall clock.
    monotonic, wall
        The clocks of the machine [ns].
    """

    def __init__(
        self,
        *,
        rate: float = 1.0,
        simulated: bool = False,
        monotonic: Clock = time.monotonic_ns,
        wall: Clock = time.time_ns,
    ) -> None:
        self.rate = rate
        self.running = False
        self._simulated, self._monotonic, self._wall = simulated, monotonic, wall
        self.epoch = EPOCH_NS  # ROS time at scenario time 0 [ns]
        self._anchor(0)

    def now(self) -> int:
        """Return the scenario time [ns]."""
        if not self.running:
            return self._scenario
        return self._scenario + round((self._monotonic() - self._real) * self.rate)

    def ros_time(self, time: int) -> int:
        """Return the ROS time [ns since 1970] when the robot has reached `time` [ns].

        On real clocks that is the wall clock's; simulated time is never ahead of the robot.
        """
        return self.epoch + time if self._simulated else self._wall()

    def seconds_until(self, time: int) -> float:
        """Return in how many real seconds it is `time` [ns]: below 0 if late, inf while paused."""
        if not self.running:
            return math.inf
        return (time - self.now()) / self.rate / 1e9

    def run(self, running: bool) -> None:
        """Run, or pause."""
        now = self.now()
        self.running = running
        self._anchor(now)

    def set_rate(self, rate: float) -> None:
        """Go on at another rate."""
        now = self.now()
        self.rate = rate
        self._anchor(now)

    def slip_to(self, time: int) -> None:
        """Set scenario time back to `time` [ns]: what was missed is not caught up on."""
        self._anchor(time)

    def restart(self) -> None:
        """Set scenario time to 0; ROS time never goes back."""
        if self._simulated:
            self.epoch += self.now()
        self._anchor(0)

    def _anchor(self, scenario: int) -> None:
        self._real, self._scenario = self._monotonic(), scenario
        if not self._simulated:
            self.epoch = self._wall() - scenario
