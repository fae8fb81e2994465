"""Wheel odometry: the pose that a robot believes, from how far its wheels turned.

The frame `odom` is the world's frame at the start and drifts away from it as the scales and the
slip of the scenario say. A scripted teleport is the exception to dead reckoning: it puts the
estimate right, because checks move the robot to see what a node makes of its new pose.
"""

import math

import numpy as np

from sim.layout import Pose
from sim.scenario import OdometrySpec


class Odometry:
    """Dead reckoning from the true motion, with the errors of the scenario.

    Parameters
    ----------
    spec
        Scales (1 = no drift) and noise (standard deviations, of every reported value) [m, rad].
    start
        The true pose at the start, which is also the first estimate [m, m, rad].
    rng
        This sensor's own generator.
    wheel_slip
        Part of the wheels' motion that the robot did not make, but the wheels measured.
    """

    def __init__(
        self,
        spec: OdometrySpec,
        start: Pose,
        rng: np.random.Generator,
        *,
        wheel_slip: float = 0.0,
    ) -> None:
        self._linear_scale = spec.linear_scale / (1.0 - wheel_slip)
        self._angular_scale = spec.angular_scale / (1.0 - wheel_slip)
        self._position_noise, self._yaw_noise = spec.position_noise, spec.yaw_noise
        self._noisy = spec.position_noise > 0 or spec.yaw_noise > 0
        self._rng = rng
        self._true = self._estimate = start

    def jump(self, pose: Pose) -> None:
        """Take over the true pose after a teleport [m, m, rad]."""
        self._true = self._estimate = pose

    def measure(self, true: Pose) -> Pose:
        """Return the reported pose now that the true one is this [m, m, rad], yaw in ±π."""
        self._reckon(true)
        x, y, yaw = self._estimate
        if self._noisy:
            dx, dy, dyaw = self._rng.standard_normal(3)
            x += self._position_noise * float(dx)
            y += self._position_noise * float(dy)
            yaw += self._yaw_noise * float(dyaw)
        return x, y, math.remainder(yaw, math.tau)

    def speeds(self, v: float, w: float) -> tuple[float, float]:
        """Return the reported forward and turning speed [m/s, rad/s] for the true ones."""
        return v * self._linear_scale, w * self._angular_scale

    def _reckon(self, true: Pose) -> None:
        """Add the motion since the last call, scaled, along the mean heading of both."""
        x0, y0, yaw0 = self._true
        dx, dy, turn = true[0] - x0, true[1] - y0, true[2] - yaw0
        x, y, yaw = self._estimate
        scaled_turn = turn * self._angular_scale
        off = (yaw + 0.5 * scaled_turn) - (yaw0 + 0.5 * turn)  # estimated minus true heading
        c, s = self._linear_scale * math.cos(off), self._linear_scale * math.sin(off)
        self._true = true
        self._estimate = x + c * dx - s * dy, y + s * dx + c * dy, yaw + scaled_turn
