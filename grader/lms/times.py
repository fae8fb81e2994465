"""When somebody handed in, and how much longer they had, as far as a platform's sheets say so."""

from __future__ import annotations

from grader.lms.moodle import GRADE, IDENTIFIER, MOMENT, SUBMITTED
from grader.lms.people import Person, Roster, trailing


def times(roster: Roster, person: Person, own: str) -> tuple[str, str]:
    """Return the time of a submission and the end of an extension, each "" if none is told.

    Parameters
    ----------
    roster
        With the assignment's sheet: Moodle's grading worksheet, GitHub Classroom's grades.
    person
        Whose submission it is.
    own
        The assignment's own id of it: the participant's number, or the repository.
    """
    for sheet in roster.sheets:
        for row, place in zip(sheet.rows, sheet.people, strict=True):
            if roster.people[place] != person:
                continue
            if sheet.kind == "worksheet" and own == trailing(sheet.cell(row, IDENTIFIER)):
                told = sheet.cell(row, SUBMITTED)
                before = " ".join(row[: sheet.small.index(GRADE)])  # its status among them
                more = MOMENT.search(before)
                return ("" if told == "-" else told), (more[0] if more else "")
            if own.casefold() == sheet.cell(row, "student_repository_name").casefold() != "":
                return sheet.cell(row, "submission_timestamp"), ""
    return "", ""
