"""Take in what a class handed in, as the learning platforms and people hand it over.

Nothing here is trusted: an archive may be broken, locked, a bomb or a trap, a folder may hold links
to the instructor's files, and names are whatever students typed. Every file is accounted for: it is
graded, or the account says why not.
"""

from grader.classroom.intake.entries import HandedIn, SetAside, Student, Who
from grader.classroom.intake.exercise_files import Found, find_files, left_over
from grader.classroom.intake.names import student_id
from grader.classroom.intake.students import Intake, take_in

__all__ = [
    "Found", "HandedIn", "Intake", "SetAside", "Student", "Who", "find_files", "left_over",
    "student_id", "take_in",
]  # fmt: skip
