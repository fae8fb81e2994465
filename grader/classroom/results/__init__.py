"""The results of a graded class: the class report, feedback pages, gradebooks."""

from grader.classroom.results.options import ResultOptions, column_titles
from grader.classroom.results.write import Written, write_results

__all__ = ["ResultOptions", "Written", "column_titles", "write_results"]
