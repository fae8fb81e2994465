"""Checks of exercise 9, latency_monitor."""
