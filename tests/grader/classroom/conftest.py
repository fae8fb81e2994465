"""Fixtures of the batch's tests."""

from fake_class import grade_class, handed_in

__all__ = ["grade_class", "handed_in"]
