"""Which scenario time it is, and which ROS time: in step with the clock, at rest, or slipped.

Scenario time follows the machine's monotonic clock at a rate. Where it stood still or was put back
(a pause, a machine that stalled), ROS time on real clocks goes on, so the stamps of what comes next
are of then; simulated ROS time stands still with it.
"""

import math
import time
from collections.abc import Callable

from sim.messages import EPOCH_NS

Clock = Callable[[], int]  # [ns]


class Timeline:
    """The time of one robot; it stands at 0 until `run`.

    Parameters
    ----------
    rate
        Scenario seconds in a second.
    simulated
        ROS time begins at `EPOCH_NS` and is the scenario's; otherwise it is today's.
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
        """Return the ROS time [ns since 1970] now that the robot has come to `time` [ns].

        On real clocks that is today's; simulated time is not ahead of the robot.
        """
        return self.epoch + time if self._simulated else self._wall()

    def seconds_until(self, time: int) -> float:
        """Return in how many real seconds it is `time` [ns]: less than 0 if late, inf if never."""
        if not self.running:
            return math.inf
        return (time - self.now()) / self.rate / 1e9

    def run(self, running: bool) -> None:
        """Go on, or stand still."""
        now = self.now()
        self.running = running
        self._anchor(now)

    def set_rate(self, rate: float) -> None:
        """Go on at another rate."""
        now = self.now()
        self.rate = rate
        self._anchor(now)

    def slip_to(self, time: int) -> None:
        """Let it be `time` [ns] now: what was missed is not made up for."""
        self._anchor(time)

    def restart(self) -> None:
        """Let a scenario begin at 0; ROS time never goes back."""
        if self._simulated:
            self.epoch += self.now()
        self._anchor(0)

    def _anchor(self, scenario: int) -> None:
        self._real, self._scenario = self._monotonic(), scenario
        if not self._simulated:
            self.epoch = self._wall() - scenario
