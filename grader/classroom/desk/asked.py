"""What a person asks for, at the command line or at the desk, as a change of the log.

Nothing here writes: `Marking.add` does, and `Marking.preview` says what it would come to. Where
there is nobody and nothing that is called so, or no such number, InputError says what there is.
"""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.classroom.amendments import change as changes
from grader.classroom.amendments.late import moment_of, times_of, zone_of
from grader.classroom.amendments.log import Entry, active
from grader.classroom.amendments.people import nearest
from grader.classroom.desk.marking import Marking
from grader.course.submission import read_regular_file
from grader.errors import InputError
from grader.lms.book import Task
from grader.lms.clean import visible
from grader.lms.told import number, span, words
from rclpy_virtual_time import FileReader

RUBRIC = "rubric.toml"  # in the folder of the class
READ, SENT = "looked at", "sent by the student"  # reasons, where none is asked for
MAX_WORDS = 2000  # [characters] of a comment, an answer, or what a student asks
MOST = 20_000  # [characters] of a request
LAST = "please look at"
FIELD = re.compile(rf"[>\s]*(student|exercise|check|moment|{LAST})\s*:[ \t]*(.*)", re.IGNORECASE)
QUOTED = re.compile(r"^[>\s]+")
EXPECTED = (
    "expected the text that a feedback page makes, with the lines Student, Exercise, Check, "
    "Moment and Please look at"
)


@dataclass(frozen=True)
class Named:
    """Whom a person names."""

    students: Sequence[str] = ()
    section: str = ""
    everybody: bool = False

    def whom(self, class_: Marking, task: Task | None = None) -> changes.Whom:
        return class_.whom(self.students, self.section, everybody=self.everybody, task=task)


# --- points --------------------------------------------------------------------------------------


def set_check(
    class_: Marking, named: Named, exercise: str, check: str, points: float, *, may_lower: bool
) -> changes.SetCheck:
    task = class_.exercise(exercise)
    whom = named.whom(class_, task)
    most = class_.check(task, check, whom)
    if points > most:
        raise InputError(f"{points:g} points: {check} of {task.slug} gives 0 to {most:g}")
    return changes.SetCheck(task.slug, check, points, whom, may_lower=may_lower)


def waive(
    class_: Marking, named: Named, exercise: str, check: str, *, may_lower: bool
) -> changes.Waive:  # fmt: skip
    task = class_.exercise(exercise)
    whom = named.whom(class_, task)
    class_.check(task, check, whom)
    return changes.Waive(task.slug, check, whom, may_lower=may_lower)


def score(class_: Marking, named: Named, exercise: str, points: float) -> changes.Score:
    task = class_.exercise(exercise)
    if not named.students:
        raise InputError("a score is one student's: expected --student ID (more than once)")
    whom = named.whom(class_, task)
    if points > task.points:
        raise InputError(f"{points:g} points: {task.slug} gives 0 to {task.points:g}")
    return changes.Score(task.slug, points, whom)


def late(
    class_: Marking, named: Named, exercise: str, per_day: float, *, deadline: str = "",
    zone: str = "UTC", grace: str = "0", cap: float = 100.0, times: Path | None = None,
) -> changes.Late:  # fmt: skip
    task = class_.exercise(exercise)
    whom = named.whom(class_)
    known = {} if times is None else times_of(times, zone, class_.students, class_.rows)
    if times is not None and not deadline:
        raise InputError("--times needs --deadline: late is what comes after it")
    zone_of(zone)  # it is one, also where it does not matter yet
    since = moment_of(deadline, zone) if deadline else ""
    return changes.Late(task.slug, per_day, since, span(grace), cap, zone, known, whom)


def publish(class_: Marking, named: Named, exercises: Sequence[str]) -> changes.Publish:
    slugs = tuple(class_.exercise(name).slug for name in exercises)
    return changes.Publish(slugs, named.whom(class_))


# --- words ---------------------------------------------------------------------------------------


def comment(
    class_: Marking, student: str, exercise: str, file: str, line: int, text: str
) -> changes.Comment:
    """Return words on a line of a student's file."""
    task, who = class_.exercise(exercise), class_.student(student)
    texts = class_.store.texts((who, task.slug))
    if file not in texts:
        raise nearest(file, texts, f"file of {who} in {task.slug}")
    last = len(lines_of(texts[file]))
    if line > last:
        raise InputError(f"line {line}: {file} of {who} has lines 1 to {last}")
    whom = Named([who]).whom(class_, task)
    return changes.Comment(task.slug, file, line, words(text, MAX_WORDS), whom)


def style(
    class_: Marking, student: str, exercise: str, given: Mapping[str, float]
) -> changes.Style:
    """Return points for style by the class's rubric."""
    task, rubric = class_.exercise(exercise), rubric_of(class_.out)
    if not rubric:
        raise InputError(
            f'expected a file {RUBRIC} in {class_.out}, with a table [points] and a line '
            '"WHAT IS LOOKED AT" = POINTS for each criterion'
        )  # fmt: skip
    for name in given:
        if name not in rubric:
            raise nearest(name, rubric, "criterion of the rubric")
    if missing := [name for name in rubric if name not in given]:
        raise InputError(f"the rubric's {missing[0]!r}: expected points from 0 to "
                         f"{rubric[missing[0]]:g}")  # fmt: skip
    for name, points in given.items():
        number(points, rubric[name])
    found = {name: (float(given[name]), most) for name, most in rubric.items()}
    return changes.Style(task.slug, found, Named([class_.student(student)]).whom(class_, task))


def rubric_of(out: Path) -> dict[str, float]:
    """Return the points that each criterion of style gives; {} if the class has no rubric."""
    try:
        points = tomllib.loads((out / RUBRIC).read_text("utf-8"))["points"]
        found = {str(name): number(most) for name, most in points.items()}
    except FileNotFoundError:
        return {}
    except (ValueError, KeyError, AttributeError) as error:  # of TOML, UTF-8, a long number, too
        raise InputError(
            f'{out / RUBRIC}: expected a table [points] with lines like "Names" = 4 ({error})'
        ) from None
    return found


# --- requests ------------------------------------------------------------------------------------


def request(class_: Marking, text: str) -> changes.Request:
    """Return what a student asks, by the text of the feedback page."""
    try:
        said = FileReader().read(fields_of, text, returns=dict[str, str])
    except FileReader.Refused as error:
        raise InputError(str(error)) from None
    who, task = class_.student(said["student"]), class_.exercise(said["exercise"])
    check = said.get("check", "")
    if check:
        class_.check(task, check, changes.Whom())
    moment = number(said["moment"].removesuffix("s")) if said.get("moment") else None
    whom = Named([who]).whom(class_, task)
    change = changes.Request(task.slug, check, moment, words(said[LAST], MAX_WORDS), whom)
    for entry in active(class_.entries):
        if entry.change == change:
            raise InputError(f"entry {entry.number} of the log is this request already")
    return change


def fields_of(text: str) -> dict[str, str]:
    """Return what a request's lines say, by their small names; a mail may quote them, and say more.

    It may be anything, and is read in a cell.

    Raises FileReader.Refused: it is no request.
    """
    found: dict[str, str] = {}
    for line in visible(text[:MOST]).splitlines():
        match = None if LAST in found else FIELD.fullmatch(line)
        if match:
            found.setdefault(match[1].lower(), match[2].strip())
        elif LAST in found:
            found[LAST] += " " + QUOTED.sub("", line)
    found = {name: " ".join(words.split()) for name, words in found.items()}
    if not all(found.get(name) for name in ("student", "exercise", LAST)):
        raise FileReader.Refused(f"this is no request: {EXPECTED}")
    return found


def text_of(file: Path) -> str:
    """Return the text of a file that a student has sent.

    Raises OSError: it can't be read, or is no regular file.
    """
    return read_regular_file(file, MOST).decode("utf-8-sig", "replace")


def answer(class_: Marking, number_: int, text: str) -> changes.Answer:
    """Return the answer to a request, by its number in the log."""
    for entry, asked, _ in requests(class_.entries):
        if entry.number == number_:
            said = words(text, MAX_WORDS)
            return changes.Answer(entry.number, asked.exercise, said, asked.whom)
    raise InputError(f"entry {number_} of the log is no request that counts")


def requests(entries: Sequence[Entry]) -> list[tuple[Entry, changes.Request, list[Entry]]]:
    """Return the requests that count, each with its answers, the newest first."""
    counting = active(entries)
    found = []
    for entry in reversed(counting):
        if isinstance(entry.change, changes.Request):
            mine = [each for each in counting if isinstance(each.change, changes.Answer)
                    and each.change.request == entry.number]  # fmt: skip
            found.append((entry, entry.change, mine))
    return found


def lines_of(text: bytes) -> list[str]:
    """Return the lines of what a student handed in, as Python counts them."""
    return re.split(r"\r\n|\r|\n", text.decode("utf-8", "replace").rstrip())
