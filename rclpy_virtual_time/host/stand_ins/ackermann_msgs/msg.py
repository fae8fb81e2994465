"""The messages of ackermann_msgs."""

from rclpy_virtual_time.host.interfaces import define

globals().update(
    define("ackermann_msgs", {
        "AckermannDrive": """
            float32 steering_angle           # [rad]
            float32 steering_angle_velocity  # [rad/s]
            float32 speed                    # [m/s]
            float32 acceleration             # [m/s²]
            float32 jerk                     # [m/s³]
        """,
        "AckermannDriveStamped": """
            std_msgs/Header header
            AckermannDrive drive
        """,
    })
)  # fmt: skip
