"""`python -m rclpy_agents_course` is the command `course`."""

from . import main

main()
