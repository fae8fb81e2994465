"""Reads colcon packages and launch files, behind the wall: they are programs."""
