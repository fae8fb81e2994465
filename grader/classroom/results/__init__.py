"""The results of a graded class: the class report, feedback pages, gradebooks, JUnit."""

from grader.classroom.results.options import ResultOptions
from grader.classroom.results.write import write_results

__all__ = ["ResultOptions", "write_results"]
