"""Checks of exercise 1, obstacle_avoidance."""
