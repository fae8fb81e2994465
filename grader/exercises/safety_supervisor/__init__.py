"""Checks of exercise 7, safety_supervisor."""
