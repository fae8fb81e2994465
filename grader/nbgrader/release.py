"""Steps of `nbgrader generate_assignment`: replace solutions, hide mark schemes."""

from typing import Any

from nbformat import NotebookNode
from nbgrader.preprocessors import ClearMarkScheme, NbGraderPreprocessor
from traitlets import Unicode

from grader.course.skeletons import strip_solution
from grader.nbgrader.cells import definition, unknown_checks, wanted
from grader.nbgrader.points import points_of

Resources = dict[str, Any]


class LeaveSkeletons(NbGraderPreprocessor):  # type: ignore[misc]
    """Leaves the skeleton of each `%%node` cell, and a stub for an answer in the others.

    nbgrader's own ClearSolutions does not know the `### SKELETON` parts of solutions.
    """

    stub = Unicode("*Your answer:*", help="The text in place of an answer.").tag(config=True)

    def preprocess_cell(
        self, cell: NotebookNode, resources: Resources, cell_index: int
    ) -> tuple[NotebookNode, Resources]:
        """Return the cell as students get it.

        Raises InputError: a test cell asks for checks that don't exist, or the markers of a
        solution are wrong.
        """
        about = cell.metadata.get("nbgrader", {})
        if about.get("solution"):
            cell.source = self._released(cell, str(about.get("grade_id")))
        elif about.get("grade") and (asked := wanted(cell.source)) is not None:
            unknown_checks(asked, points_of(asked.exercise))
        return cell, resources

    def _released(self, cell: NotebookNode, name: str) -> str:
        if cell.cell_type != "code" or definition(cell.source) is None:
            return self.stub
        magic, _, body = cell.source.partition("\n")
        return f"{magic}\n{strip_solution(body, f'cell {name}')}".rstrip("\n")


class HideMarkScheme(ClearMarkScheme):  # type: ignore[misc]
    """Takes the mark schemes out of the instructor's own cells; what students wrote stays.

    The gradebook keeps the question with it, so `RestoreCells` puts it back into the graded
    notebook. nbgrader's own step takes it out of what students get, but it knows mark schemes in
    task cells only, and there a student's answer has no cell of its own that could be restored.
    """

    def preprocess_cell(
        self, cell: NotebookNode, resources: Resources, cell_index: int
    ) -> tuple[NotebookNode, Resources]:
        """Return the cell as students see it."""
        about = cell.metadata.get("nbgrader", {})
        if about.get("locked") and not about.get("solution"):
            self._remove_mark_scheme_region(cell)
        return cell, resources
