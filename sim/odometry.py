"""Wheel odometry: a pose that is estimated from how far the wheels turned.

Frame `odom` coincides with the world's frame at the start, then drifts with the scenario's scales.
A scripted teleport sets the estimate to the true pose, unlike dead reckoning: checks teleport the
robot to see how a node reacts to a new pose.
"""

import math

from sim.events import Event, periodic
from sim.faults import Times, deliveries, sensor_rng, survivors
from sim.layout import Layout, Pose
from sim.messages import BASE_FRAME, ODOM_FRAME, ODOM_TOPIC, ODOMETRY, Message, odometry, transform
from sim.scenario import Scenario


class Odometry:
    """Dead reckoning from the true motion.

    Parameters
    ----------
    scenario, layout
        Scales (1 = no drift); the true pose at the start, which is also the first estimate.
    seed
        Changes nothing of what is measured.
    """

    topic, type, table = ODOM_TOPIC, ODOMETRY, "odometry"

    def __init__(self, scenario: Scenario, layout: Layout, seed: int) -> None:
        spec = scenario.odometry
        self._linear_scale, self._angular_scale = spec.linear_scale, spec.angular_scale
        self._true = self._estimate = self._reported = layout.start

    @staticmethod
    def rate(scenario: Scenario) -> float:
        """Return its messages per second [Hz]."""
        return scenario.odometry.rate

    @staticmethod
    def arrivals(scenario: Scenario, seed: int) -> tuple[Times, Times]:
        """Return when the messages that arrive are measured, and when they arrive [ns]."""
        spec, faults = scenario.odometry, scenario.faults
        rng = sensor_rng(seed, "odometry link")
        times = periodic(spec.phase, spec.rate, scenario.duration)
        times = times[survivors(times, faults.odom_loss, rng, ())]
        return times, deliveries(times, faults.odom_latency, 0.0, rng)

    def jump(self, pose: Pose) -> None:
        """Set the estimate to the true pose [m, m, rad] after a teleport."""
        self._true = self._estimate = pose

    def message(self, event: Event, pose: Pose, speeds: tuple[float, float]) -> Message:
        """Return the message of this event: true pose [m, m, rad] and speeds [m/s, rad/s]."""
        self._reported = x, y, yaw = self.measure(pose)
        v, w = speeds[0] * self._linear_scale, speeds[1] * self._angular_scale
        return odometry(time=event.delivery, stamp=event.time, x=x, y=y, yaw=yaw, v=v, w=w)

    def transform(self, event: Event) -> Message:
        """Return the pose of the last message as a transform for tf2."""
        x, y, yaw = self._reported
        return transform(
            time=event.delivery, stamp=event.time, parent=ODOM_FRAME, child=BASE_FRAME,
            x=x, y=y, yaw=yaw,
        )  # fmt: skip

    def measure(self, true: Pose) -> Pose:
        """Return the reported pose for this true one [m, m, rad], yaw in ±π."""
        self._reckon(true)
        x, y, yaw = self._estimate
        return x, y, math.remainder(yaw, math.tau)

    def _reckon(self, true: Pose) -> None:
        """Add the motion since the last call, scaled, along the mean estimated heading."""
        x0, y0, yaw0 = self._true
        dx, dy, turn = true[0] - x0, true[1] - y0, true[2] - yaw0
        x, y, yaw = self._estimate
        scaled_turn = turn * self._angular_scale
        off = (yaw + 0.5 * scaled_turn) - (yaw0 + 0.5 * turn)  # estimated minus true heading
        c, s = self._linear_scale * math.cos(off), self._linear_scale * math.sin(off)
        self._true = true
        self._estimate = x + c * dx - s * dy, y + s * dx + c * dy, yaw + scaled_turn
