"""Marks that a person changes after the grading: an append-only log, and what follows from it.

Gradings in the store stay as the judge made them. The log is applied to them whenever results are
written, so an entry that is undone leaves no trace in a score, and all of it in the log.
"""
