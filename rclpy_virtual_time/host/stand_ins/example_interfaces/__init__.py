"""A stand-in for the package example_interfaces of ROS's tutorials, which has no wheel."""
