"""Fixtures of the batch's tests."""

from fake_class import grade_class, handed_in
from marked_class import graded, mark

__all__ = ["grade_class", "graded", "handed_in", "mark"]
