"""Checks of exercise 5, slow_model."""
