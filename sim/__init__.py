"""The mock robot: worlds, physics and sensors, without ROS.

PYTEST_DONT_REWRITE: the plug-in `grader.testing.plugin` makes pytest look at this package.
"""
