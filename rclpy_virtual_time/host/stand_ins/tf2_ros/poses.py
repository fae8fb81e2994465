"""Positions and turns: composed, inverted, interpolated."""

from __future__ import annotations

import math

Vector = tuple[float, float, float]  # x, y, z [m]
Quaternion = tuple[float, float, float, float]  # x, y, z, w
Pose = tuple[Vector, Quaternion]

IDENTITY: Pose = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def composed(first: Pose, second: Pose) -> Pose:
    """Return the pose of `second`, which is given in the frame `first`."""
    (x, y, z), turn = first
    dx, dy, dz = turned(second[0], turn)
    return (x + dx, y + dy, z + dz), product(turn, second[1])


def inverse(pose: Pose) -> Pose:
    (x, y, z), (qx, qy, qz, qw) = pose
    back = (-qx, -qy, -qz, qw)
    dx, dy, dz = turned((x, y, z), back)
    return (-dx, -dy, -dz), back


def turned(vector: Vector, turn: Quaternion) -> Vector:
    qx, qy, qz, qw = turn
    x, y, z, _ = product(product(turn, (*vector, 0.0)), (-qx, -qy, -qz, qw))
    return x, y, z


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def between(a: Pose, b: Pose, part: float) -> Pose:
    x, y, z = (p + part * (q - p) for p, q in zip(a[0], b[0], strict=True))
    cosine = sum(p * q for p, q in zip(a[1], b[1], strict=True))
    sign = -1.0 if cosine < 0 else 1.0  # the short way
    angle = math.acos(min(1.0, abs(cosine)))
    if angle < 1e-9:
        return (x, y, z), a[1]
    first, second = (math.sin(share * angle) for share in (1.0 - part, part))
    qx, qy, qz, qw = (
        (first * p + sign * second * q) / math.sin(angle) for p, q in zip(a[1], b[1], strict=True)
    )
    return (x, y, z), (qx, qy, qz, qw)
