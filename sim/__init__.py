"""The mock robot: worlds, physics and sensors, without ROS."""
