"""The messages of a trial as numbers: what a recording hands to checks and reports."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.messages import (
    Message,
    odometry_from_cdr,
    pose_from_cdr,
    scan_from_cdr,
    twist_from_cdr,
)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Twists:
    """The Twist messages of one topic."""

    t: Floats  # (n,) [s]
    values: Floats  # (n, 6) linear x, y, z [m/s], angular x, y, z [rad/s]

    @property
    def linear_x(self) -> Floats:
        """Forward speed, (n,) [m/s]."""
        return self.values[:, 0]

    @property
    def angular_z(self) -> Floats:
        """Turning speed, positive to the left, (n,) [rad/s]."""
        return self.values[:, 5]


@dataclass(frozen=True, eq=False)
class Scan:
    """One LaserScan as the node got it."""

    t: float  # [s] scenario time of delivery
    stamp: float  # [s] scenario time in its header
    angle_min: float  # [rad]
    angle_increment: float  # [rad]
    range_min: float  # [m]
    range_max: float  # [m]
    ranges: NDArray[np.float32]  # (n_beams,) [m]
    mount: float = 0.0  # [rad] how far the lidar is turned on the robot; /tf_static says it

    @property
    def angles(self) -> Floats:
        """Beam angles, (n_beams,) [rad], as the message says: in the lidar's frame."""
        return self.angle_min + self.angle_increment * np.arange(len(self.ranges), dtype=float)

    @property
    def first_angle(self) -> float:
        """Angle of the first beam on the robot [rad], 0 ahead."""
        return self.angle_min + self.mount


@dataclass(frozen=True)
class Odom:
    """The Odometry messages of one topic."""

    t: Floats  # (n,) [s]
    x: Floats  # (n,) [m]
    y: Floats  # (n,) [m]
    yaw: Floats  # (n,) [rad]
    v: Floats  # (n,) [m/s]
    w: Floats  # (n,) [rad/s]


@dataclass(frozen=True)
class Goals:
    """The goals that the node was given."""

    t: Floats  # (n,) [s]
    x: Floats  # (n,) [m]
    y: Floats  # (n,) [m]


def percentile(values: Floats, share: float) -> float:
    """Return a percentile of (n,) values by linear interpolation; numpy's imports masked arrays."""
    ordered, place = np.sort(values), (len(values) - 1) * share / 100
    low, high = ordered[math.floor(place)], ordered[math.ceil(place)]
    return float(low + (high - low) * (place % 1.0))


def twists(messages: Iterable[Message]) -> Twists:
    """Decode Twist messages; what is not a Twist is left out."""
    times, values = [], []
    for message in messages:
        try:
            values.append(twist_from_cdr(message.data))
        except ValueError:
            continue
        times.append(message.time / 1e9)
    return Twists(np.array(times, dtype=float), np.array(values, dtype=float).reshape(-1, 6))


def scans(messages: Iterable[Message], epoch: int, mount: float = 0.0) -> tuple[Scan, ...]:
    """Decode LaserScan messages.

    Parameters
    ----------
    epoch
        The ROS time at scenario time 0 [ns].
    mount
        How far the lidar is turned on the robot [rad].
    """
    return tuple(_scan(message, epoch, mount) for message in messages)


def odometry(messages: Iterable[Message]) -> Odom:
    """Decode Odometry messages."""
    rows = [_odometry_row(message) for message in messages]
    return Odom(*np.array(rows, dtype=float).reshape(-1, 6).T)


def goals(messages: Iterable[Message]) -> Goals:
    """Decode PoseStamped messages."""
    rows = []
    for message in messages:
        x, y, *_ = pose_from_cdr(message.data)
        rows.append((message.time / 1e9, x, y))
    return Goals(*np.array(rows, dtype=float).reshape(-1, 3).T)


def _scan(message: Message, epoch: int, mount: float) -> Scan:
    stamp, numbers, ranges = scan_from_cdr(message.data)
    angle_min, _, angle_increment, _, _, range_min, range_max = numbers
    return Scan(
        t=message.time / 1e9,
        stamp=float(stamp - epoch) / 1e9,
        angle_min=angle_min,
        angle_increment=angle_increment,
        range_min=range_min,
        range_max=range_max,
        ranges=ranges,
        mount=mount,
    )


def _odometry_row(message: Message) -> tuple[float, ...]:
    (x, y, _, qx, qy, qz, qw), twist = odometry_from_cdr(message.data)
    yaw = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
    return message.time / 1e9, x, y, yaw, twist[0], twist[5]
