"""Checks of exercise 2, ml_velocity."""
