"""Run unchanged rclpy programs in virtual time: isolated, deterministic, recorded at the edge."""
