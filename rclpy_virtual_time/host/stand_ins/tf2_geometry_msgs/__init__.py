"""A stand-in for the package tf2_geometry_msgs, which has no wheel: messages in another frame."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from geometry_msgs.msg import (
    PointStamped,
    PoseStamped,
    PoseWithCovarianceStamped,
    Vector3Stamped,
    WrenchStamped,
)
from tf2_ros import ConvertRegistration, TransformRegistration
from tf2_ros.buffer import pose_of
from tf2_ros.poses import IDENTITY, Pose, composed, turned

__all__ = [
    "do_transform_point",
    "do_transform_pose",
    "do_transform_pose_stamped",
    "do_transform_pose_with_covariance_stamped",
    "do_transform_vector3",
    "do_transform_wrench",
    "from_msg_msg",
    "to_msg_msg",
    "transform_covariance",
]


def to_msg_msg(msg: Any) -> Any:
    """Return the message itself."""
    return msg


from_msg_msg = to_msg_msg


def do_transform_point(point: Any, transform: Any) -> Any:
    """Return a PointStamped in the frame of a TransformStamped's header."""
    found, pose = PointStamped(header=transform.header), pose_of(transform.transform)
    _set(found.point, composed(pose, (_xyz(point.point), IDENTITY[1]))[0])
    return found


def do_transform_vector3(vector3: Any, transform: Any) -> Any:
    """Return a Vector3Stamped in the frame of a TransformStamped's header: turned, not moved."""
    found, pose = Vector3Stamped(header=transform.header), pose_of(transform.transform)
    _set(found.vector, turned(_xyz(vector3.vector), pose[1]))
    return found


def do_transform_pose(pose: Any, transform: Any) -> Any:
    """Return a Pose in the frame of a TransformStamped's header."""
    found = copy.deepcopy(pose)
    there: Pose = composed(
        pose_of(transform.transform), (_xyz(pose.position), _xyzw(pose.orientation))
    )
    _set(found.position, there[0])
    _set(found.orientation, there[1])
    return found


def do_transform_pose_stamped(pose: Any, transform: Any) -> Any:
    """Return a PoseStamped in the frame of a TransformStamped's header."""
    return PoseStamped(header=transform.header, pose=do_transform_pose(pose.pose, transform))


def do_transform_pose_with_covariance_stamped(pose: Any, transform: Any) -> Any:
    """Return a PoseWithCovarianceStamped in the frame of a TransformStamped's header."""
    found = PoseWithCovarianceStamped(header=transform.header)
    found.pose.pose = do_transform_pose(pose.pose.pose, transform)
    found.pose.covariance = transform_covariance(pose.pose.covariance, transform)
    return found


def do_transform_wrench(wrench: Any, transform: Any) -> Any:
    """Return a WrenchStamped in the frame of a TransformStamped's header: turned, not moved."""
    found, pose = WrenchStamped(header=transform.header), pose_of(transform.transform)
    _set(found.wrench.force, turned(_xyz(wrench.wrench.force), pose[1]))
    _set(found.wrench.torque, turned(_xyz(wrench.wrench.torque), pose[1]))
    return found


def transform_covariance(cov_in: Any, transform: Any) -> Any:
    """Return a covariance (36 numbers, row by row) in the frame of a TransformStamped's header."""
    turn = pose_of(transform.transform)[1]
    axes = np.transpose([turned(axis, turn) for axis in np.eye(3).tolist()])
    both = np.kron(np.eye(2), axes)
    return (both @ np.reshape(cov_in, (6, 6)) @ both.T).reshape(36)


def _xyz(vector: Any) -> Any:
    return vector.x, vector.y, vector.z


def _xyzw(turn: Any) -> Any:
    return turn.x, turn.y, turn.z, turn.w


def _set(message: Any, numbers: Any) -> None:
    for name, number in zip("xyzw", numbers, strict=False):
        setattr(message, name, number)


for _type, _transform in (
    (PointStamped, do_transform_point),
    (Vector3Stamped, do_transform_vector3),
    (PoseStamped, do_transform_pose_stamped),
    (PoseWithCovarianceStamped, do_transform_pose_with_covariance_stamped),
    (WrenchStamped, do_transform_wrench),
):
    TransformRegistration().add(_type, _transform)
    ConvertRegistration().add_to_msg(_type, to_msg_msg)
    ConvertRegistration().add_from_msg(_type, from_msg_msg)
