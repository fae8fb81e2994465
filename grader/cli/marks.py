"""`course marks`: change the marks of a graded class, with a reason."""

from __future__ import annotations

import functools
import getpass
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from grader.cli.results import FAULT, FULL
from grader.errors import InputError
from grader.report.echo import echo

if TYPE_CHECKING:
    from grader.classroom.amendments.change import Change
    from grader.classroom.desk.asked import Named
    from grader.classroom.desk.marking import Marked, Marking

MOST = 20  # lines
AGAIN = "Now run `course autograde` again with the same downloads."
EXAMPLES = """\b
Examples:
  course marks waive graded blind --exercise 1 --all --why "the task was unclear"
  course marks set graded slow_zone 20 --student ann --why "right, the check was too strict"
  course marks late graded --exercise 1 --all --deadline 2026-05-04T23:59 --zone Europe/Berlin
      --per-day 10 --grace 15min --cap 50 --why "as in the syllabus"
  course marks score graded 85 --exercise 1 --student ann --why "handed in by e-mail"
  course marks undo graded 3 --why "a mistake of mine"
  course marks publish graded --section A --why "looked at"
  course marks assign graded "Ann Lee 71" s4711 --why "asked her"
  course marks accept graded ann my_agent.py --exercise 1 --why "the file is hers"
  course marks comment graded ann agent.py 12 "The lidar may be silent here."
  course marks request graded ann.txt
  course marks answer graded 7 "Looked at: the check is right."
  course report graded
"""

Command = TypeVar("Command", bound=Callable[..., Any])

exercise = click.option("--exercise", default="", help="Its name or number; if there are several.")


class _Number(click.ParamType[float]):
    """A number, as it is typed on the command line."""

    name = "number"

    def __init__(self, *most: float, whole: bool = False) -> None:
        self._most, self._whole = most, whole

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number."""
        from grader.lms.told import number, whole  # noqa: PLC0415

        try:
            return whole(value) if self._whole else number(value, *self._most)
        except InputError as error:
            return self.fail(str(error), param, ctx)


def _marking(command: Callable[..., int]) -> Callable[..., int]:
    """Add the argument FOLDER; the command gets the class in it, open for a change."""

    @functools.wraps(command)
    def opened(folder: Path, **options: Any) -> int:
        from grader.classroom.desk.marking import marking  # noqa: PLC0415
        from grader.classroom.progress import say  # noqa: PLC0415
        from grader.report.terminal import Console  # noqa: PLC0415

        with marking(folder) as class_:
            class_.say = functools.partial(say, Console())
            return command(class_, **options)

    return click.argument("folder", type=click.Path(path_type=Path))(opened)


def _whom(command: Callable[..., int]) -> Callable[..., int]:
    """Add the options that say whom a change is about; the command gets them as `named`."""

    @functools.wraps(command)
    def with_names(
        class_: Marking, students: tuple[str, ...], section: str, everybody: bool, **options: Any
    ) -> int:
        from grader.classroom.desk.asked import Named  # noqa: PLC0415

        return command(class_, named=Named(students, section, everybody), **options)

    named: Callable[..., int] = with_names
    for option in (
        click.option("--all", "everybody", is_flag=True, help="Everybody, also who comes later."),
        click.option("--section", default="", help="A section of the roster."),
        click.option("--student", "students", multiple=True, metavar="ID",
                     help="Folder, id, login, e-mail or name. May be repeated."),
    ):  # fmt: skip
        named = option(named)
    return named


by_option = click.option("--by", default="", metavar="NAME", help="Who; you, if it isn't said.")


def _reason(command: Command) -> Command:
    """Add the options of the log."""
    for option in (
        by_option,
        click.option("--why", required=True, metavar="TEXT", help="The reason, for the log."),
    ):
        command = option(command)
    return command


preview = click.option("--preview", is_flag=True, help="Only say whose points would change.")
may_lower = click.option("--may-lower", is_flag=True, help="Also where it costs points.")


@click.group("marks", epilog=EXAMPLES)
def marks() -> None:
    """Change the marks of a class that `course autograde` has graded into FOLDER.

    The gradings stay as they are. Each change goes into a log that only grows, with who, when and
    why; all results are then written anew. Nothing is graded, and no student's code runs.
    """


@marks.command("set")
@_marking
@click.argument("check")
@click.argument("points", type=_Number())
@exercise
@may_lower
@preview
@_whom
@_reason
def set_(
    class_: Marking, check: str, points: float, exercise: str, named: Named, may_lower: bool,
    preview: bool, why: str, by: str,
) -> int:  # fmt: skip
    """Set the POINTS of a CHECK; scores that would drop are left (see --may-lower)."""
    from grader.classroom.desk import asked  # noqa: PLC0415

    change = asked.set_check(class_, named, exercise, check, points, may_lower=may_lower)
    return _changed(class_, change, by, why, preview=preview)


@marks.command()
@_marking
@click.argument("check")
@exercise
@may_lower
@preview
@_whom
@_reason
def waive(
    class_: Marking, check: str, exercise: str, named: Named, may_lower: bool, preview: bool,
    why: str, by: str,
) -> int:  # fmt: skip
    """Leave a CHECK out of score and maximum, where that costs nobody points.

    The other checks count for more.
    """
    from grader.classroom.desk import asked  # noqa: PLC0415

    change = asked.waive(class_, named, exercise, check, may_lower=may_lower)
    return _changed(class_, change, by, why, preview=preview)


@marks.command()
@_marking
@click.argument("points", type=_Number())
@exercise
@preview
@_whom
@_reason
def score(
    class_: Marking, points: float, exercise: str, named: Named, preview: bool, why: str, by: str
) -> int:
    """Give students these POINTS in an exercise, whatever was graded, or nothing handed in."""
    from grader.classroom.desk import asked  # noqa: PLC0415

    change = asked.score(class_, named, exercise, points)
    return _changed(class_, change, by, why, preview=preview)


@marks.command()
@_marking
@exercise
@click.option("--per-day", type=_Number(100), required=True, metavar="PERCENT",
              help="Of the exercise's points, for each begun day; 0: nothing.")  # fmt: skip
@click.option("--deadline", default="", metavar="TIME", help="Such as 2026-05-04T23:59.")
@click.option("--zone", default="UTC", help="Of times without an offset, such as Europe/Berlin.")
@click.option("--grace", default="0", metavar="TIME", help="Costs nothing: 15min, 2h, 1d.")
@click.option("--cap", type=_Number(100), default=100, metavar="PERCENT",
              help="At most so much.")  # fmt: skip
@click.option("--times", type=click.Path(path_type=Path), metavar="FILE",
              help="CSV with id and time, or Moodle's grading worksheet.")  # fmt: skip
@preview
@_whom
@_reason
def late(
    class_: Marking, exercise: str, per_day: float, deadline: str, zone: str, grace: str,
    cap: float, times: Path | None, named: Named, preview: bool, why: str, by: str,
) -> int:  # fmt: skip
    """Take points off what was handed in late. The newest rule that is about a student counts.

    Times are those of the platform, as far as it has told them, or of --times. Without --deadline
    only what the platform itself calls late is late, and counts as one day.
    """
    from grader.classroom.desk import asked  # noqa: PLC0415

    rule = asked.late(
        class_, named, exercise, per_day, deadline=deadline, zone=zone, grace=grace, cap=cap,
        times=times,
    )  # fmt: skip
    return _changed(class_, rule, by, why, preview=preview)


@marks.command()
@_marking
@click.option("--exercise", "exercises", multiple=True, help="Its name or number; else all.")
@_whom
@_reason
def publish(class_: Marking, exercises: tuple[str, ...], named: Named, why: str, by: str) -> int:
    """Copy feedback pages into FOLDER/published, and keep them in step; `undo` takes them back."""
    from grader.classroom.desk import asked  # noqa: PLC0415

    change = asked.publish(class_, named, exercises)
    code = _told(class_.add(change, _who(by), why))
    pages: dict[str, int] = {}  # of exercises
    for page in sorted((class_.out / "published").glob("*/*.html")):
        pages[page.parent.name] = pages.get(page.parent.name, 0) + (page.name != "index.html")
    bare = [student for student, count in pages.items() if not count]
    echo(f"Students with published feedback: {len(pages) - len(bare)} ({class_.out / 'published'})")
    if bare:
        rest = f" and {len(bare) - MOST} more" if len(bare) > MOST else ""
        echo(f"Nothing handed in, or held, so an index without pages: "
             f"{', '.join(bare[:MOST])}{rest}")  # fmt: skip
    return code


@marks.command()
@_marking
@click.argument("entry", type=_Number(whole=True))
@preview
@_reason
def undo(class_: Marking, entry: int, preview: bool, why: str, by: str) -> int:
    """Have an ENTRY of the log no longer count. To bring it back, undo that."""
    from grader.classroom.amendments.change import Accept, Assign, Undo  # noqa: PLC0415

    undone = [each.change for each in class_.store.entries(entry) if each.number == entry]
    code = _changed(class_, Undo(entry), by, why, preview=preview)
    if undone and isinstance(undone[0], Accept | Assign) and not preview:
        echo(AGAIN)
    return code


@marks.command()
@_marking
@click.argument("entry")
@click.argument("people", nargs=-1, required=True, metavar="STUDENT...")
@_reason
def assign(class_: Marking, entry: str, people: tuple[str, ...], why: str, by: str) -> int:
    """Say that an ENTRY of a download is this STUDENT's, or a group's, for good.

    The next `course autograde` grades it as theirs, in all later downloads, too.
    """
    code = _told(class_.add(class_.assigned(entry, people), _who(by), why))
    echo(AGAIN)
    return code


@marks.command()
@_marking
@click.argument("student")
@click.argument("file")
@click.option("--exercise", required=True, help="Its name or number.")
@_reason
def accept(class_: Marking, student: str, file: str, exercise: str, why: str, by: str) -> int:
    """Say that a STUDENT's FILE is an exercise's, whatever it is called, for good.

    The next `course autograde` grades it; a newer file of that name counts, too.
    """
    who = class_.student(student)
    change = class_.accepted(who, file, class_.any_exercise(exercise))
    code = _told(class_.add(change, _who(by), why))
    echo(AGAIN)
    return code


@marks.command()
@_marking
@click.argument("student")
@click.argument("file")
@click.argument("line", type=_Number(whole=True))
@click.argument("words")
@exercise
@by_option
def comment(
    class_: Marking, student: str, file: str, line: int, words: str, exercise: str, by: str
) -> int:
    """Put WORDS on a LINE of a STUDENT's FILE; the feedback page has them."""
    from grader.classroom.desk import asked  # noqa: PLC0415

    change = asked.comment(class_, student, exercise, file, line, words)
    return _changed(class_, change, by, asked.READ, preview=False)


@marks.command()
@_marking
@click.argument("student")
@click.argument("points", nargs=-1, required=True, metavar="CRITERION=POINTS...")
@exercise
@by_option
def style(class_: Marking, student: str, points: tuple[str, ...], exercise: str, by: str) -> int:
    """Give points for style by FOLDER/rubric.toml; they stand beside those of the checks."""
    from grader.classroom.desk import asked  # noqa: PLC0415
    from grader.lms.told import number  # noqa: PLC0415

    given = {}
    for told in points:
        name, sign, value = told.rpartition("=")
        if not sign:
            raise InputError(f"{told!r}: expected CRITERION=POINTS, such as Names=3")
        given[name] = number(value)
    change = asked.style(class_, student, exercise, given)
    return _changed(class_, change, by, asked.READ, preview=False)


@marks.command()
@_marking
@click.argument("file", type=click.Path(path_type=Path))
@by_option
def request(class_: Marking, file: Path, by: str) -> int:
    """Log what a student asks to look at again: the text of the feedback page, by mail or FILE."""
    from grader.classroom.desk import asked  # noqa: PLC0415

    change = asked.request(class_, asked.text_of(file))
    return _changed(class_, change, by, asked.SENT, preview=False)


@marks.command()
@_marking
@click.argument("number", type=_Number(whole=True))
@click.argument("words")
@by_option
def answer(class_: Marking, number: int, words: str, by: str) -> int:
    """Answer the request that is entry NUMBER of the log; the feedback page has it."""
    from grader.classroom.desk import asked  # noqa: PLC0415

    change = asked.answer(class_, number, words)
    return _changed(class_, change, by, asked.READ, preview=False)


@marks.command()
@_marking
def write(class_: Marking) -> int:
    """Write all results anew, from the stored gradings and the log."""
    return _told(class_.write())


def _changed(class_: Marking, change: Change, by: str, why: str, *, preview: bool) -> int:
    """Make a change, or only say what it would come to."""
    if not preview:
        return _told(class_.add(change, _who(by), why))
    return _told(class_.preview(change), "Nothing is written. ")


def _who(by: str) -> str:
    return by if by.strip() else user()


def user() -> str:
    """Return who runs this."""
    try:
        return getpass.getuser()
    except (OSError, KeyError):  # no name for this user
        return "somebody"


def _told(done: Marked, preview: str = "") -> int:
    """Say what a change came to, or would come to, and return the exit code."""
    from grader.classroom.amendments.log import described  # noqa: PLC0415
    from grader.classroom.progress import say  # noqa: PLC0415
    from grader.report.terminal import Console  # noqa: PLC0415

    lines = []
    if done.entry is not None:
        lines.append(f"Entry {done.entry.number}: {described(done.entry.change)}")
    if done.entry is not None or preview:
        down = f", {done.lower} of them down" if done.lower else ""
        lines.append(f"{preview}Scores that change: {len(done.shifts)}{down}")
    lines += [f"  {shift}" for shift in done.shifts[:MOST]]
    if len(done.shifts) > MOST:
        lines.append(f"  and {len(done.shifts) - MOST} more; scores.csv has all")
    lines += [f"Note: {remark}" for remark in done.remarks[:MOST]]
    lines += [f"  missing: {each}" for each in done.missing[:MOST]]
    say(Console(), "\n".join(lines or ["Written."]))
    return FAULT if done.missing else FULL
