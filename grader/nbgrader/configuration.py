"""Configure nbgrader: which steps are its own, which the course's; where its programs are."""

import os
import sys
from pathlib import Path
from typing import Any

from nbconvert.preprocessors import CSSHTMLHeaderPreprocessor
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
from grader.nbgrader.late import LatePenalty
from grader.nbgrader.offline import work_offline
from grader.nbgrader.release import HideMarkScheme, LeaveSkeletons
from grader.nbgrader.waiting import FILTERS, ExportGrades, ShowGrades

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
        HideMarkScheme,  # after SaveCells: the gradebook keeps them for the graders
        ComputeChecksums,
        CheckCellMetadata,
    ]
    config.Autograde.exporter_class = CourseExporter
    config.Autograde.sanitize_preprocessors = [RestoreCells, CheckCellMetadata]
    config.Autograde.autograde_preprocessors = [JudgeNodes, AssignLatePenalties, CheckCellMetadata]
    # Penalties once more: what a person has marked since has its points only now. So no page that
    # is there already is kept, as formgrader keeps none.
    config.GenerateFeedback.force = True
    config.GenerateFeedback.preprocessors = [
        AssignLatePenalties,
        HideMarkScheme,
        ShowGrades,
        CSSHTMLHeaderPreprocessor,
    ]
    config.ExportApp.plugin_class = ExportGrades
    config.AssignLatePenalties.plugin_class = LatePenalty
    config.Execute.timeout = VALIDATION_LIMIT
    work_offline(config)
    config.HTMLExporter.filters |= FILTERS


def find_programs() -> None:
    """Let nbgrader find `alembic` in an environment that is not activated."""
    programs = str(Path(sys.executable).parent)
    paths = os.environ.get("PATH", os.defpath).split(os.pathsep)
    if programs not in paths:
        os.environ["PATH"] = os.pathsep.join([programs, *paths])
