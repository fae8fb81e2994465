"""The results of a graded class: the class report, feedback pages, gradebooks, JUnit."""

from grader.classroom.results.gradebook import column_titles
from grader.classroom.results.missing import Missing
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.write import Written, write_results

__all__ = ["Missing", "ResultOptions", "Written", "column_titles", "write_results"]
