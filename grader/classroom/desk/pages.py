"""The pages of the desk. Each is made of the class's store, as the commands read it."""

import contextlib
import functools
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from grader.classroom.amendments.apply import version_of
from grader.classroom.amendments.change import Comment, Style
from grader.classroom.amendments.log import Entry, active, described, undone_by
from grader.classroom.amendments.marks import checks_of, is_held, tasks_of, why_held
from grader.classroom.desk import asked
from grader.classroom.desk.forms import AT_ONCE, Form, Person, change_of
from grader.classroom.desk.marking import Marked, Marking, is_about, marking, reading
from grader.classroom.results.page import render
from grader.classroom.row import StoredResult
from grader.course.exercises import all_exercises
from grader.errors import InputError
from grader.lms.book import StudentRow
from grader.lms.clean import visible

Html = str
MOST_LINES = 3000  # of a file
MOST_SHIFTS = 30
STALE = (
    "Somebody has changed these marks since you opened the page. Nothing of yours was written. "
    "Look at what is new, and do it again if it is still right."
)
AGAIN = "The next course autograde with the same downloads grades it so."
_read: dict[Path, tuple[str, list[StoredResult]]] = {}  # the last time; 500 take half a second
_writing = threading.Lock()


class Stale(Exception):
    """What a form was made of is no longer so; `page` says what is new."""

    def __init__(self, page: Html) -> None:
        super().__init__()
        self.page = page


class _View:
    """A class for one page."""

    def __init__(self, class_: Marking, person: Person) -> None:
        self.class_ = class_
        self.person = person
        self.results = class_.counting()
        self.tasks = {task.slug: task for task in tasks_of(self.results)}
        self.entries = class_.entries
        self.held = [each for each in self.results if is_held(each)]
        lines = enumerate(class_.options.account.lines)
        self.faults = [(place, line) for place, line in lines if line.fault]
        self.requests = asked.requests(self.entries)
        self.revision = functools.cache(self._revision)

    def render(self, template: str, title: str, **about: Any) -> Html:
        return render(f"desk_{template}.html", title, desk=True, view=self, **about)

    @property
    def people(self) -> list[tuple[str, str]]:
        """Everybody's key, and name in the roster."""
        every = sorted({*self.class_.students, *self.class_.rows})
        return [(each, self.row(each).person.label) for each in every if not self.row(each).unsure]

    def row(self, student: str) -> StudentRow:
        return self.class_.rows.get(student) or StudentRow(student)

    def _revision(self, student: str = "") -> str:
        """Return what a form about a student, or about several, is made of: "ENTRY-HASH"."""
        last = self.entries[-1].number if self.entries else 0
        return f"{last}-{self.class_.revision([student] if student else ())}"

    def log(self, student: str = "") -> list[tuple[Entry, str, int]]:
        """Return the log, the newest first, in words, and by which entry each is undone, or 0."""
        undone = dict(undone_by(self.entries))
        return [
            (each, described(each.change), undone.get(each.number, 0))
            for each in reversed(self.entries)
            if not student or is_about(each, student, self.class_.rows)
        ]


@contextlib.contextmanager
def _view(out: Path, person: Person) -> Iterator[_View]:
    with reading(out) as class_:
        stamp = class_.store.stamp()
        known, results = _read.get(out, ("", []))
        if known == stamp:
            class_.results = results
        else:
            _read[out] = stamp, class_.results
        yield _View(class_, person)


# --- pages ---------------------------------------------------------------------------------------


def entered(name: str) -> Html:
    """Return the page that leads a person to the desk."""
    return render("desk_enter.html", "Desk", desk=True, name=name)


def refused(why: str) -> Html:
    return render("desk_refused.html", "Desk", desk=True, why=why)


def class_page(out: Path, person: Person, find: str, section: str) -> Html:
    """Return everybody, or those who are called so, with their points."""
    with _view(out, person) as view:
        by_key = {each.key: each for each in view.results}
        found = []
        for student in view.class_.students:
            row = view.row(student)
            words = " ".join([student, row.person.name, *row.person.ids.values()]).casefold()
            if find.casefold() in words and section in ("", row.person.section):
                mine = [(by_key.get((student, slug)), task) for slug, task in view.tasks.items()]
                found.append((student, row, mine))
        return view.render("class", "Desk", found=found, find=find, section=section)


def held_page(out: Path, person: Person) -> Html:
    """Return what is held or not understood, with what can be done about it."""
    with _view(out, person) as view:
        lines = list(enumerate(view.class_.options.account.lines))
        held = [
            (one, view.tasks[one.exercise], why_held(one), view.row(one.student).unsure,
             [(place, line) for place, line in lines if line.student == one.student])
            for one in view.held
        ]  # fmt: skip
        return view.render("held", "Held", held=held, exercises=all_exercises())


def requests_page(out: Path, person: Person) -> Html:
    """Return what students ask to look at again."""
    with _view(out, person) as view:
        return view.render("requests", "Requests")


def marks_page(out: Path, person: Person) -> Html:
    """Return the log, and forms for several students at once."""
    with _view(out, person) as view:
        checks = {
            slug: {str(check.get("id")): check for one in view.class_.results
                   if one.exercise == slug for check in checks_of(one)}
            for slug in view.tasks
        }  # fmt: skip
        return view.render("marks", "Marks", checks=checks)


def student_page(out: Path, person: Person, student: str, exercise: str) -> Html:
    """Return a student's work in an exercise: replay and file, side by side, and what to do."""
    with _view(out, person) as view:
        mine = {each.exercise: each for each in view.results if each.student == student}
        if exercise not in mine:
            raise InputError(f"nobody called {student!r} has a result in {exercise!r}")
        result = mine[exercise]
        words = [
            entry.change for entry in active(view.entries)
            if isinstance(entry.change, Comment | Style) and entry.change.exercise == exercise
            and student in entry.change.whom.students
        ]  # fmt: skip
        styles = [each.given for each in words if isinstance(each, Style)]
        return view.render(
            "student",
            f"{student}: {view.tasks[exercise].title}",
            student=student,
            row=view.row(student),
            result=result,
            task=view.tasks[exercise],
            others=[(each, view.tasks[each.exercise]) for each in mine.values()],
            points=next((was, now) for one, was, now in view.class_.points(student)
                        if one.exercise == exercise),
            checks=checks_of(result),
            has_replay=_replay_of(view, student, exercise) is not None,
            files=_files(view, student, exercise),
            comments=[
                each for each in words  # lines of an earlier submission are others
                if isinstance(each, Comment)
                and each.whom.versions.get(student, "") == version_of(result)
            ],
            rubric=asked.rubric_of(out),
            given=styles[-1] if styles else {},
            asked=[each for each in view.requests
                   if student in each[1].whom.students and each[1].exercise == exercise],
            log=view.log(student),
        )  # fmt: skip


def replay(out: Path, person: Person, student: str, exercise: str) -> Html:
    """Return a student's feedback page as it is, with the replays; it is not the desk's own."""
    with _view(out, person) as view:
        page = _replay_of(view, student, exercise)
        if page is None:
            raise InputError("there is no such page")
        return page.read_text("utf-8", "replace")


def _replay_of(view: _View, student: str, exercise: str) -> Path | None:
    if student not in view.class_.students or exercise not in view.tasks:
        return None
    folders = (view.class_.out / each for each in (view.class_.options.replays_in, "feedback"))
    pages = (folder / student / f"{exercise}.html" for folder in folders)
    return next(filter(Path.is_file, pages), None)


def _files(view: _View, student: str, exercise: str) -> list[tuple[str, list[str], int]]:
    """Return the student's files: name, the first lines, and how many more there are."""
    texts = view.class_.store.texts((student, exercise))
    lines = {name: asked.lines_of(text) for name, text in texts.items()}
    return [
        (name, [visible(line) for line in each[:MOST_LINES]], max(0, len(each) - MOST_LINES))
        for name, each in lines.items()
    ]


# --- changes -------------------------------------------------------------------------------------


def changed(out: Path, person: Person, form: Form) -> Html:
    """Make a change, or show what it would come to.

    Raises Stale: the marks are no longer those that the form was made of.
    Raises InputError: it can't be.
    Raises GraderError: somebody else is writing just now.
    """
    scope, (last, _, seen) = form["scope"], form["revision"].partition("-")
    sure = form["sure"] or form["kind"] in AT_ONCE
    with contextlib.ExitStack() as stack:
        if sure:
            stack.enter_context(_writing)  # somebody else at the desk; a command is not waited for
        class_ = stack.enter_context(marking(out) if sure else reading(out))
        view = _View(class_, person)
        if seen != view.revision(scope).partition("-")[2]:
            known = int(last) if last.isdecimal() else 0
            new = [each for each in view.log(scope) if each[0].number > known]
            raise Stale(view.render("stale", "Not written", why=STALE, new=new, form=form,
                                    back=_back(form)))  # fmt: skip
        if form["kind"] == "write":
            return _done(view, form, class_.write(), what="all results", sure=True)
        change = change_of(class_, form)
        if scope and list(getattr(getattr(change, "whom", None), "students", ())) != [scope]:
            raise InputError(f"the form is {scope}'s, and this is about others")
        if not sure:
            done = class_.preview(change)
            return _done(view, form, done, what=described(change), sure=False)
        done = class_.add(change, person.name, form.why)
        return _done(_View(class_, person), form, done, what=described(change), sure=True)


def _done(view: _View, form: Form, done: Marked, *, what: str, sure: bool) -> Html:
    return view.render(
        "changed", "Written" if sure else "Preview", form=form, done=done, what=what, sure=sure,
        most=MOST_SHIFTS, later=AGAIN if form["kind"] in ("assign", "accept") else "",
        back=_back(form), revision=view.revision(form["scope"]),
    )  # fmt: skip


def _back(form: Form) -> str:
    back = form["back"]
    return back if back.startswith("/") and not back.startswith("//") and "\\" not in back else "/"
