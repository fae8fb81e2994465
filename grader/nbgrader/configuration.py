"""Configure nbgrader: which steps are its own, which are the course's."""

from __future__ import annotations

import os
import sys
from pathlib import Path
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
from grader.nbgrader.release import LeaveSkeletons

VALIDATION_LIMIT = 300  # [s] for a test cell in `nbgrader validate`; nbgrader's own is 30


def set_up(config: Any) -> None:
    """Add the course's steps to nbgrader's own."""
    _find_programs()
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


def _find_programs() -> None:
    """Let nbgrader find `alembic`, which it runs by name, in an environment not activated."""
    programs = str(Path(sys.executable).parent)
    paths = os.environ.get("PATH", os.defpath).split(os.pathsep)
    if programs not in paths:
        os.environ["PATH"] = os.pathsep.join([programs, *paths])
