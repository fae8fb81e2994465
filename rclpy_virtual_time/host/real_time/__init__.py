"""Real time: the student's program on plain rclpy and DDS, and the robot's ends."""
