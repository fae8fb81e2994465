"""Takes its time to start: sleeps while it is imported, as for a driver, and computes a table."""

import time

time.sleep(0.3)

import rclpy  # noqa: E402
from seeing import Agent  # noqa: E402

TABLE = [i * i % 7 for i in range(3_000_000)]
rclpy.init()
rclpy.spin(Agent())
