"""Marks that a person changes after the grading: an append-only log, and what follows from it.

Gradings in the store stay as the judge made them. The log is applied to them whenever results are
written, so an entry that is undone leaves no trace in a score, and all of it in the log.
"""

from grader.classroom.amendments.apply import amended, published
from grader.classroom.amendments.change import (
    Change,
    Late,
    Publish,
    Score,
    SetCheck,
    Undo,
    Waive,
    Whom,
)
from grader.classroom.amendments.log import Entry, Log, active, described, undone_by

__all__ = [
    "Change", "Entry", "Late", "Log", "Publish", "Score", "SetCheck", "Undo", "Waive", "Whom",
    "active", "amended", "described", "published", "undone_by",
]  # fmt: skip
