"""Wheel odometry: a pose that is estimated from how far the wheels turned.

Frame `odom` coincides with the world's frame at the start, then drifts with the scenario's scales.
A scripted teleport sets the estimate to the true pose, unlike dead reckoning: checks teleport the
robot to see how a node reacts to a new pose.
"""

import math

from sim.layout import Pose
from sim.scenario import OdometrySpec


class Odometry:
    """Dead reckoning from the true motion.

    Parameters
    ----------
    spec
        Scales (1 = no drift).
    start
        The true pose at the start, which is also the first estimate [m, m, rad].
    """

    def __init__(self, spec: OdometrySpec, start: Pose) -> None:
        self._linear_scale, self._angular_scale = spec.linear_scale, spec.angular_scale
        self._true = self._estimate = start

    def jump(self, pose: Pose) -> None:
        """Set the estimate to the true pose [m, m, rad] after a teleport."""
        self._true = self._estimate = pose

    def measure(self, true: Pose) -> Pose:
        """Return the reported pose for this true one [m, m, rad], yaw in ±π."""
        self._reckon(true)
        x, y, yaw = self._estimate
        return x, y, math.remainder(yaw, math.tau)

    def speeds(self, v: float, w: float) -> tuple[float, float]:
        """Return the reported forward and turning speed [m/s, rad/s] for the true ones."""
        return v * self._linear_scale, w * self._angular_scale

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
