"""What a form asks for, as a change of the log: through the functions that the commands call."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grader.classroom.amendments.change import Change, Undo
from grader.classroom.desk import asked
from grader.classroom.desk.marking import Marking
from grader.errors import InputError
from grader.lms.sheets import decoded
from grader.lms.told import number, whole

# What is written at once, since nobody's points depend on it; all else is shown first.
AT_ONCE = ("comment", "style", "answer", "request", "write")
REASONS = dict.fromkeys(AT_ONCE, asked.READ) | {"request": asked.SENT}
OWN = ("token", "revision", "sure")  # fields that are about the form


@dataclass(frozen=True)
class Person:
    """The sender of forms: an instructor or assistant at the desk, in one browser."""

    name: str
    token: str  # of this person's forms


@dataclass(frozen=True)
class Form:
    """The fields of a form, as they were sent."""

    fields: Mapping[str, Sequence[str]]

    @staticmethod
    def of(arguments: Mapping[str, list[bytes]], files: Mapping[str, list[Any]]) -> Form:
        """Return the form of a request; a file is a field, too."""
        sent = {name: [each.decode("utf-8", "replace") for each in values]
                for name, values in arguments.items()}  # fmt: skip
        for name, uploads in files.items():
            sent.setdefault(name, []).extend(decoded(each["body"]) for each in uploads)
        return Form(sent)

    def __getitem__(self, name: str) -> str:
        return next(iter(self.fields.get(name, ())), "").strip()

    def every(self, name: str) -> list[str]:
        """Return a field's texts, of which one may have several lines."""
        lines = (line.strip() for text in self.fields.get(name, ()) for line in text.splitlines())
        return [line for line in lines if line]

    @property
    def again(self) -> list[tuple[str, str]]:
        """The fields that make the same change."""
        return [(name, text) for name, texts in self.fields.items() if name not in OWN
                for text in texts]  # fmt: skip

    @property
    def why(self) -> str:
        return self["why"] or REASONS.get(self["kind"], "")


def change_of(class_: Marking, form: Form) -> Change:
    """Return the change that a form asks for.

    Raises InputError: it can't be.
    """
    who, exercise, student = form["who"], form["exercise"], form["student"]
    named = asked.Named(
        form.every("student") if who == "students" else (),
        form["section"] if who == "section" else "",
        who == "all",
    )
    match form["kind"]:
        case "set":
            points = number(form["points"])
            return asked.set_check(class_, named, exercise, form["check"], points,
                                   may_lower=bool(form["may_lower"]))  # fmt: skip
        case "waive":
            return asked.waive(class_, named, exercise, form["check"],
                               may_lower=bool(form["may_lower"]))  # fmt: skip
        case "score":
            return asked.score(class_, named, exercise, number(form["points"]))
        case "late":
            with _as_file(form["times"]) as times:
                return asked.late(
                    class_, named, exercise, number(form["per_day"], 100),
                    deadline=form["deadline"], zone=form["zone"] or "UTC",
                    grace=form["grace"] or "0", cap=number(form["cap"] or "100", 100), times=times,
                )  # fmt: skip
        case "publish":
            return asked.publish(class_, named, form.every("exercise"))
        case "undo":
            return Undo(whole(form["entry"]))
        case "assign":
            return class_.assigned(_line(class_, form).student or _line(class_, form).entry,
                                   form.every("person"))  # fmt: skip
        case "accept":
            line = _line(class_, form)
            return class_.accepted(line.student, line.file, class_.any_exercise(exercise))
        case "comment":
            file, place, words = form["file"], whole(form["line"]), form["words"]
            return asked.comment(class_, student, exercise, file, place, words)
        case "style":
            given = zip(form.every("criterion"), form.every("points"), strict=False)
            points_by = {name: number(points) for name, points in given}
            return asked.style(class_, student, exercise, points_by)
        case "request":
            return asked.request(class_, "\n".join(form.fields.get("text", ())))
        case "answer":
            return asked.answer(class_, whole(form["request"]), form["words"])
    raise InputError(f"unknown form {form['kind']!r}")


@contextlib.contextmanager
def _as_file(text: str) -> Iterator[Path | None]:
    with tempfile.TemporaryDirectory(prefix="course-") as folder:
        file = Path(folder, "times.csv")
        file.write_text(text, "utf-8")
        yield file if text else None


def _line(class_: Marking, form: Form) -> Any:
    """Return the line of the account that a form is about; its text may be no text of a form's."""
    lines = class_.options.account.lines
    place = whole(form["line"], 0)
    if place >= len(lines):
        raise InputError("the downloads were taken in again since; open the page again")
    return lines[place]
