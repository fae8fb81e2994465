"""Checks of exercise 4, trend_memory."""
