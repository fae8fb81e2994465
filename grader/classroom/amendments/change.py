"""What a person may change: the entries of the log, by kind."""

from collections.abc import Mapping

import msgspec

from grader.lms.book import StudentRow


class Whom(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Whom a change is about: these students, or a section, or everybody, also who comes later."""

    students: tuple[str, ...] = ()  # as in `StoredResult`
    section: str = ""
    # the submission that a change was made for, by student; a later one is another
    versions: dict[str, str] = {}

    def includes(self, student: str, rows: Mapping[str, StudentRow]) -> bool:
        if self.students:
            return student in self.students
        if self.section:
            row = rows.get(student)
            return row is not None and row.person.section == self.section
        return True

    def __str__(self) -> str:
        if self.students:
            return ", ".join(self.students)
        return f"section {self.section}" if self.section else "everybody"


class _Change(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind"):
    """One entry's content."""


class SetCheck(_Change, frozen=True, tag="set"):
    """A check has these points, whatever it came to."""

    exercise: str
    check: str
    points: float
    whom: Whom = Whom()
    may_lower: bool = True


class Waive(_Change, frozen=True, tag="waive"):
    """A check counts neither for nor against: it is left out of score and maximum."""

    exercise: str
    check: str
    whom: Whom = Whom()
    may_lower: bool = True


class Late(_Change, frozen=True, tag="late"):
    """From the deadline on, each day that has begun costs a share of the exercise's points.

    Of several rules the newest that is about a student counts: so one gets more time.
    """

    exercise: str
    per_day: float  # [% of the exercise's points]
    deadline: str = ""  # ISO 8601 with an offset; "": only what a platform calls late
    grace: float = 0.0  # [s] after the deadline that cost nothing
    cap: float = 100.0  # [%] at most
    zone: str = "UTC"  # of times that have no offset
    times: dict[str, str] = {}  # of a file, by student; instead of the platform's
    whom: Whom = Whom()


class Score(_Change, frozen=True, tag="score"):
    """A student has these points in an exercise, whatever was graded; no late rule follows."""

    exercise: str
    points: float
    whom: Whom


class Publish(_Change, frozen=True, tag="publish"):
    """Feedback pages that students may see."""

    exercises: tuple[str, ...] = ()  # (): all
    whom: Whom = Whom()


class Assign(_Change, frozen=True, tag="assign"):
    """Entries of a download are these students', in all later downloads, too."""

    entries: tuple[str, ...]  # as `Entry.word` or its name has them
    was: str = ""  # the folder that they had until then
    whom: Whom = Whom()


class Accept(_Change, frozen=True, tag="accept"):
    """A file counts as an exercise's, whatever it is called."""

    exercise: str
    file: str  # as the student called it
    whom: Whom = Whom()


class Comment(_Change, frozen=True, tag="comment"):
    """Words on a line of a student's file, for the student to read."""

    exercise: str
    file: str
    line: int  # from 1
    words: str
    whom: Whom


class Style(_Change, frozen=True, tag="style"):
    """Points for style, beside those of the checks; the newest counts."""

    exercise: str
    given: dict[str, tuple[float, float]]  # criterion of the rubric: points, and out of how many
    whom: Whom

    @property
    def sums(self) -> tuple[float, float]:
        """Points, and out of how many."""
        won, most = zip(*self.given.values(), strict=True)
        return sum(won), sum(most)


class Request(_Change, frozen=True, tag="request"):
    """A student asks a person to look again; it changes nothing."""

    exercise: str
    check: str  # "": none in particular
    moment: float | None  # [s] of the run
    words: str  # the student's
    whom: Whom


class Answer(_Change, frozen=True, tag="answer"):
    """What a person answers to a request, for the student to read."""

    request: int  # its number in the log
    exercise: str
    words: str
    whom: Whom


class Undo(_Change, frozen=True, tag="undo"):
    """An earlier entry no longer counts; undoing an undo brings it back."""

    number: int

    def __str__(self) -> str:
        return f"entry {self.number} is undone"


class Unread(_Change, frozen=True, tag="unread"):
    """What the log has there can't be read; nothing writes one."""

    problem: str
    whom: Whom = Whom()

    def __str__(self) -> str:
        return f"can't be read: {self.problem}"


Words = Comment | Style | Answer  # what a student reads beside the points
Shown = SetCheck | Waive | Late | Score | Words  # that may change what a student reads
Change = Shown | Publish | Assign | Accept | Request | Undo | Unread
