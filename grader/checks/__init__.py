"""The checks of every exercise: pytest tests that read recordings."""
