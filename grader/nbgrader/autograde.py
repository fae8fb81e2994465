"""The steps of `nbgrader autograde`: read the notebook, have its nodes judged, write the points.

Nothing that a student wrote is executed in this process or in a kernel; nodes run behind the
judge's isolation.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nbconvert.exporters import NotebookExporter
from nbformat import NotebookNode, v4
from nbgrader.api import Gradebook
from nbgrader.converters.base import NbGraderException
from nbgrader.preprocessors import NbGraderPreprocessor
from traitlets import Bool, Unicode

from grader.course.exercises import find_exercise
from grader.course.students import read_secret, student_key
from grader.errors import GraderError, InputError
from grader.grading.handed_in import isolation_problem
from grader.nbgrader.cells import Wanted, last_definitions, made_files, modules, wanted
from grader.nbgrader.gradebook import Place, trusted_cells, write_comment, write_mark
from grader.nbgrader.intake import read_cells
from grader.nbgrader.judge import Verdict, judge, lying_beside
from grader.nbgrader.late import look_at_due_date
from grader.nbgrader.marks import Mark, mark_of
from grader.nbgrader.restore import ABOUT, Trusted, restored, unreadable
from grader.nbgrader.table import output_of
from rclpy_virtual_time import FileReader

FILE = "course_file"  # in the resources: path of the notebook; what lies beside it comes along
NO_RESPONSE = "No response."  # nbgrader's own words

Resources = dict[str, Any]


class CourseExporter(NotebookExporter):  # type: ignore[misc]
    """Reads students' notebooks without trusting them; refuses machines with weak isolation."""

    def __init__(self, **traits: Any) -> None:
        super().__init__(**traits)
        settings = JudgeNodes(parent=self)
        try:
            problem = "" if settings.trust else isolation_problem()
            if settings.secret:
                read_secret(Path(settings.secret))
        except (GraderError, InputError) as error:
            problem = str(error)
        if problem:
            said = " ".join(problem.replace("--trust", "c.JudgeNodes.trust = True").split())
            self.log.error("Nothing was graded: %s", said)
            raise NbGraderException(said)

    def from_filename(
        self, filename: str, resources: Resources | None = None, **options: Any
    ) -> tuple[str, Resources]:
        """Convert a notebook; a submitted one is read by `RestoreCells`."""
        given = {FILE: filename, **({} if resources is None else resources)}
        if not any(isinstance(step, RestoreCells) for step in self._preprocessors):
            plain: tuple[str, Resources] = super().from_filename(filename, given, **options)
            return plain
        folder, name = os.path.split(filename)
        given["metadata"] = {"name": name.removesuffix(".ipynb"), "path": folder}
        made: tuple[str, Resources]
        made = self.from_notebook_node(v4.new_notebook(), given, **options)
        return made


class RestoreCells(NbGraderPreprocessor):  # type: ignore[misc]
    """Restores the submitted notebook (see grader.nbgrader.restore)."""

    def preprocess(self, nb: NotebookNode, resources: Resources) -> tuple[NotebookNode, Resources]:
        """Return the notebook to grade."""
        place = Place.of(resources)
        with Gradebook(place.db_url) as gradebook:
            trusted = trusted_cells(gradebook, place)
        try:
            return restored(read_cells(Path(resources[FILE])), trusted), resources
        except FileReader.Refused as problem:
            self.log.warning("%s of %s: %s", place.notebook, place.student, problem)
            return unreadable(str(problem), trusted), resources


class JudgeNodes(NbGraderPreprocessor):  # type: ignore[misc]
    """Has the `%%node` cells judged; nothing else writes points."""

    trust = Bool(
        False, help="Run submissions even where isolation is too weak: a throw-away machine."
    ).tag(config=True)
    secret = Unicode(
        "", help="File with the course's secret: each student gets different worlds."
    ).tag(config=True)

    def preprocess(self, nb: NotebookNode, resources: Resources) -> tuple[NotebookNode, Resources]:
        """Judge the notebook; show the judge's table in its test cells."""
        place = Place.of(resources)
        with Gradebook(place.db_url) as gradebook:
            due = gradebook.find_assignment(place.assignment).duedate
            look_at_due_date(place.assignment, due, self.log)
            trusted = trusted_cells(gradebook, place)
            asked = {cell.name: wanted(cell.source) for cell in trusted if cell.is_test}
            wants = [want for want in asked.values() if want]
            verdicts = self._verdicts(nb, place, wants, Path(resources[FILE]).parent)
            shown: set[str] = set()
            for known in trusted:
                cell = _cell(nb, known.name)
                if known.points is not None:
                    want = asked.get(known.name)
                    verdict = verdicts.get(want.exercise) if want else None
                    mark = _mark(known, cell, want, verdict)
                    write_mark(gradebook, place, known.name, mark)
                    if known.is_test and cell.cell_type == "code":
                        first = want is not None and want.exercise not in shown
                        remarks = verdict.remarks if verdict and first else ()
                        cell.outputs = [output_of(mark, known.points, remarks)]
                        shown |= {want.exercise} if want else set()
                if known.solution:
                    write_comment(gradebook, place, known.name, _comment(known, cell))
            gradebook.db.commit()
        return nb, resources

    def _verdicts(
        self, nb: NotebookNode, place: Place, asked: Sequence[Wanted], folder: Path
    ) -> dict[str, Verdict]:
        """Have each exercise judged once."""
        slugs = dict.fromkeys(want.exercise for want in asked)
        if problem := nb.metadata.get(ABOUT, {}).get("problem"):
            return {slug: Verdict(None, problem=problem) for slug in slugs}
        cells = [(cell.metadata.get(ABOUT, {}).get("was", cell.cell_type), cell.source)
                 for cell in nb.cells]  # fmt: skip
        return {slug: self._verdict(slug, cells, place, folder) for slug in slugs}

    def _verdict(
        self, slug: str, cells: Sequence[tuple[str, str]], place: Place, folder: Path
    ) -> Verdict:
        exercise = find_exercise(slug)
        names = dict.fromkeys((*exercise.files, *modules(cells)))
        files, remarks = last_definitions(cells, list(names))
        remarks += lying_beside(exercise, files, folder)
        seed = None
        if self.secret:
            seed = student_key(read_secret(Path(self.secret)), place.student, slug)
        if not any(name in files for name in exercise.files):
            there = ", ".join(made_files(cells))
            found = f"its cells write {there}" if there else "none of its cells writes a file"
            said = f"expected a cell that begins with %%node {exercise.files[0]} in this notebook"
            return Verdict(None, f"{said}; {found}", tuple(remarks))
        self.log.info("Judging %s of %s", slug, place.student)
        verdict = judge(exercise, files, seed=seed, folder=folder)
        if verdict.problem:
            self.log.error("%s of %s: %s", slug, place.student, verdict.problem)
        problem = verdict.problem if seed is None else verdict.problem and "the log says why"
        return Verdict(verdict.grading, problem, remarks=tuple(remarks))


def _cell(nb: NotebookNode, name: str) -> NotebookNode:
    return next(c for c in nb.cells if c.metadata.get("nbgrader", {}).get("grade_id") == name)


def _mark(known: Trusted, cell: NotebookNode, want: Wanted | None, verdict: Verdict | None) -> Mark:
    if want is not None and verdict is not None and known.points is not None:
        return mark_of(want, verdict, known.points)
    if known.is_answer and cell.metadata.get(ABOUT, {}).get("untouched"):
        return Mark(0.0, False)
    return Mark(None, True)  # an answer, or a test that the judge doesn't know: for a person


def _comment(known: Trusted, cell: NotebookNode) -> str:
    about = cell.metadata.get(ABOUT, {})
    if about.get("missing"):
        return "This cell was deleted." if known.is_answer else ""
    return NO_RESPONSE if about.get("untouched") else ""
