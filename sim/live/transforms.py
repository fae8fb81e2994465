"""/tf and /tf_static: where the robot estimates it is, in the frames of REP-105.

`odom` → `base_link` with every odometry message, `base_link` → the lidar's frame once. tf2_msgs is
part of every ROS installation, but there is no wheel of it: without it the robot sends no
transforms.
"""

import math
from typing import Any

from sim.messages import BASE_FRAME, ODOM_FRAME, half_angle
from sim.scenario import LidarSpec


def tf_message_class() -> Any:
    """Return tf2_msgs' TFMessage; None where it is not installed."""
    try:
        from tf2_msgs.msg import TFMessage  # noqa: PLC0415
    except ImportError:
        return None
    return TFMessage


class Transforms:
    """Makes TFMessages.

    Parameters
    ----------
    tf_message, transform_stamped
        The classes of tf2_msgs/TFMessage and geometry_msgs/TransformStamped.
    """

    def __init__(self, tf_message: Any, transform_stamped: Any) -> None:
        self._tf_message, self._transform_stamped = tf_message, transform_stamped

    def of_lidar(self, lidar: LidarSpec, stamp: Any) -> Any:
        """Return where the lidar is on the robot, for /tf_static."""
        transform = self._transform_stamped()
        transform.header.stamp = stamp
        transform.header.frame_id, transform.child_frame_id = BASE_FRAME, lidar.frame
        x, y, yaw = lidar.pose
        to = transform.transform
        to.translation.x, to.translation.y = x, y
        to.rotation.z, to.rotation.w = half_angle(yaw)
        return self._tf_message(transforms=[transform])

    def of_odometry(self, odometry: Any) -> Any:
        """Return `odom` → `base_link` for a nav_msgs/Odometry, for /tf.

        None for a pose that is not finite, which a scenario may send and tf2 rejects.
        """
        position, rotation = odometry.pose.pose.position, odometry.pose.pose.orientation
        if not all(map(math.isfinite, (position.x, position.y, rotation.z, rotation.w))):
            return None
        transform = self._transform_stamped()
        transform.header.stamp = odometry.header.stamp
        transform.header.frame_id, transform.child_frame_id = ODOM_FRAME, BASE_FRAME
        to = transform.transform
        to.translation.x, to.translation.y = position.x, position.y
        to.rotation.z, to.rotation.w = rotation.z, rotation.w
        return self._tf_message(transforms=[transform])
