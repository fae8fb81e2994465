"""Configure nbgrader: which steps are its own, which are the course's."""

from __future__ import annotations

from typing import Any

from nbgrader.preprocessors import (
    AssignLatePenalties,
    CheckCellMetadata,
    ClearOutput,
    ComputeChecksums,
    IncludeHeaderFooter,
    LockCells,
    SaveCells,
)

from grader.nbgrader.autograde import CourseExporter, JudgeNodes, RestoreCells
from grader.nbgrader.offline import work_offline
from grader.nbgrader.programs import find_programs
from grader.nbgrader.release import LeaveSkeletons

VALIDATION_LIMIT = 300  # [s] for a test cell in `nbgrader validate`; nbgrader's own is 30


def set_up(config: Any) -> None:
    """Add the course's steps to nbgrader's own."""
    find_programs()
    config.GenerateAssignment.preprocessors = [
        IncludeHeaderFooter,
        LockCells,
        LeaveSkeletons,
        ClearOutput,
        CheckCellMetadata,
        ComputeChecksums,
        SaveCells,
        CheckCellMetadata,
    ]
    config.Autograde.exporter_class = CourseExporter
    config.Autograde.sanitize_preprocessors = [RestoreCells, CheckCellMetadata]
    config.Autograde.autograde_preprocessors = [JudgeNodes, AssignLatePenalties, CheckCellMetadata]
    config.Execute.timeout = VALIDATION_LIMIT
    work_offline(config)
