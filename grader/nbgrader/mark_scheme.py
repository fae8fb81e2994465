"""Mark schemes: the part of a question that graders see in formgrader, and students never.

The gradebook keeps the question with it, so `RestoreCells` puts it back into the graded notebook.
nbgrader's own step takes it out of what students get, but it knows mark schemes in task cells
only, and there a student's answer has no cell of its own that could be restored and graded.
"""

from typing import Any

from nbformat import NotebookNode
from nbgrader.preprocessors import ClearMarkScheme


class HideMarkScheme(ClearMarkScheme):  # type: ignore[misc]
    """Takes the mark schemes out of the instructor's own cells; what students wrote stays."""

    def preprocess_cell(
        self, cell: NotebookNode, resources: dict[str, Any], cell_index: int
    ) -> tuple[NotebookNode, dict[str, Any]]:
        """Return the cell as students see it."""
        about = cell.metadata.get("nbgrader", {})
        if about.get("locked") and not about.get("solution"):
            self._remove_mark_scheme_region(cell)
        return cell, resources
