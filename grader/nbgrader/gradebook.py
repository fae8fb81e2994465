"""Read the released cells from nbgrader's gradebook; write points and comments into it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from grader.nbgrader.marks import Mark
from grader.nbgrader.restore import Trusted


@dataclass(frozen=True)
class Place:
    """A notebook of a student, as nbgrader addresses it."""

    db_url: str
    notebook: str
    assignment: str
    student: str

    @classmethod
    def of(cls, resources: Any) -> Place:
        """Return the place that nbgrader's resources name."""
        about = resources["nbgrader"]
        names = ("db_url", "notebook", "assignment", "student")
        return cls(*(about[name] for name in names))


def trusted_cells(gradebook: Any, place: Place) -> list[Trusted]:
    """Return the cells of a notebook that nbgrader knows."""
    notebook = gradebook.find_notebook(place.notebook, place.assignment)
    points = {cell.name: float(cell.max_score) for cell in notebook.grade_cells}
    tasks = {cell.name: float(cell.max_score) for cell in notebook.task_cells}
    solutions = {cell.name for cell in notebook.solution_cells}
    return [
        Trusted(
            cell.name,
            cell.cell_type,
            cell.source,
            points.get(cell.name, tasks.get(cell.name)),
            cell.name in solutions,
            cell.name in tasks,
        )
        for cell in notebook.source_cells
    ]


def write_mark(gradebook: Any, place: Place, cell: str, mark: Mark) -> None:
    """Write the judge's points. A manual score is kept, and flagged for another look."""
    names = (cell, place.notebook, place.assignment, place.student)
    grade = gradebook.find_grade(*names)
    grade.auto_score = mark.points
    grade.needs_manual_grade = mark.by_hand or grade.manual_score is not None


def write_comment(gradebook: Any, place: Place, cell: str, text: str) -> None:
    """Write an automatic comment on the student's cell; the instructor's own is kept."""
    names = (cell, place.notebook, place.assignment, place.student)
    gradebook.find_comment(*names).auto_comment = text or None
