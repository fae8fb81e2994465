"""Checks of exercise 6, model_server."""
