"""Checks of exercise 8, model_formats."""
