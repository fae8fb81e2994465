"""Checks of exercise 3, goal_seeking."""
