"""What waits for a person has no score yet: pages of feedback and exported tables say so.

nbgrader itself counts it as 0.0 in both, as it counts what nobody handed in.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from jinja2.filters import do_float, do_round
from nbformat import NotebookNode
from nbgrader.api import Gradebook, MissingEntry
from nbgrader.plugins import CsvExportPlugin
from nbgrader.preprocessors import GetGrades

NOT_YET = "not judged yet"
Resources = dict[str, Any]


class ShowGrades(GetGrades):  # type: ignore[misc]
    """Puts the gradebook's scores into the pages of feedback."""

    def preprocess(self, nb: NotebookNode, resources: Resources) -> tuple[NotebookNode, Resources]:
        """Return the notebook with its scores."""
        nb, resources = super().preprocess(nb, resources)
        if any(cell.metadata.get("nbgrader", {}).get("score") == NOT_YET for cell in nb.cells):
            resources["nbgrader"]["score"] = NOT_YET
        return nb, resources

    def _get_score(self, cell: NotebookNode, resources: Resources) -> None:
        super()._get_score(cell, resources)
        about = cell.metadata["nbgrader"]
        place = self.notebook_id, self.assignment_id, self.student_id
        if self.gradebook.find_grade(about["grade_id"], *place).needs_manual_grade:
            about["score"] = NOT_YET


def _of_numbers(work: Callable[..., Any]) -> Callable[..., Any]:
    return lambda value, *more: value if value == NOT_YET else work(value, *more)


# Jinja's, through which nbgrader's templates show each score.
FILTERS = {"float": _of_numbers(do_float), "round": _of_numbers(do_round)}


class ExportGrades(CsvExportPlugin):  # type: ignore[misc]
    """Writes nbgrader's table: no score where a person has to look, and how many points wait."""

    def export(self, gradebook: Gradebook) -> None:
        """Write the table."""
        super().export(gradebook)
        path = Path(self.to or "grades.csv")
        head, *rows = path.read_text().splitlines()
        lines = [f"{head},not_judged"]
        for row in rows:  # assignment,duedate,timestamp,student_id,…,raw_score,penalty,score,max
            assignment, _, _, student, _ = row.split(",", 4)
            waiting = self._waiting(gradebook, assignment, student)
            start, *_, most = row.rsplit(",", 4)
            lines.append(f"{f'{start},,,,{most}' if waiting else row},{waiting:g}")
        path.write_text("\n".join(lines) + "\n")

    def _waiting(self, gradebook: Gradebook, assignment: str, student: str) -> float:
        """Return how many points nobody has given or refused."""
        try:
            found = gradebook.find_submission(assignment, student)
        except MissingEntry:  # nothing was handed in, or nothing of it graded
            course = self.parent.coursedir
            place = course.format_path(course.submitted_directory, student, assignment)
            most = gradebook.find_assignment(assignment).max_score
            return float(most if Path(place).exists() else 0)
        grades = [grade for notebook in found.notebooks for grade in notebook.grades]
        return float(sum(grade.max_score for grade in grades if grade.needs_manual_grade))
