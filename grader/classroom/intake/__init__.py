"""Take in what a class handed in: every file is graded, or the account says why not."""

from grader.classroom.intake.exercise_files import Found, find_files, left_over
from grader.classroom.intake.handed_in import HandedIn, Student
from grader.classroom.intake.students import Intake, take_in, take_in_one

__all__ = [
    "Found",
    "HandedIn",
    "Intake",
    "Student",
    "find_files",
    "left_over",
    "take_in",
    "take_in_one",
]
