"""A class of 60 in each format: every file accounted for, every row matched by id, nobody lost."""

from __future__ import annotations

import csv
import io
import tempfile
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from importers import Canvas, Moodle, MoodleAssignment
from made_results import book, check, result
from sixty import AGENTS, FORMATS, Download, Someone, everybody

from grader.classroom import account as fates
from grader.classroom.candidates import Class, find_class
from grader.classroom.marks import tasks_of
from grader.classroom.options import Options
from grader.classroom.results.scores import scores_csv
from grader.classroom.row import ABSENT, HELD, StoredResult
from grader.lms import nbgrader
from grader.lms.book import Book, Task
from grader.lms.canvas import canvas_csv
from grader.lms.moodle import grades_csv, worksheet_csv
from grader.lms.sheets import read_roster

PEOPLE = everybody()
SUBMITTED = [(p.login, slug) for p in PEOPLE for slug, file in AGENTS.items() if file in p.files]


@dataclass
class Taken:
    """A class taken in and, as if by the judge, graded: each submission has its own points."""

    download: Download
    found: Class
    people: dict[str, Someone]  # by the student's id
    texts: dict[tuple[str, str], bytes]  # login, exercise
    results: list[StoredResult]
    book: Book

    @property
    def counts(self) -> Counter[str]:
        return Counter(line.state for line in self.found.account.lines)


def points(login: str, slug: str) -> int:
    return int(login[1:]) + (1 if slug == "goal_seeking" else 20)


def take(format_: str, place: Path) -> Taken:
    download = FORMATS[format_](PEOPLE, place)
    roster = read_roster(download.rosters)
    options = Options(roster=roster, exercises=tuple(AGENTS))
    found = find_class(download.sources, place / "unpacked", options)
    by_email = {f"{p.login}@uni.edu": p for p in PEOPLE}
    by_login = {p.login: p for p in PEOPLE}
    people = {}
    for row in found.students:
        one = by_email.get(row.ids.get("email", "")) or by_login.get(row.ids.get("login", ""))
        if one is not None:
            people[row.student] = one
    texts: dict[tuple[str, str], bytes] = {}
    results: list[StoredResult] = []
    for (student, slug), candidate in found.candidates.items():
        if student not in people:
            continue
        login = people[student].login
        if candidate.found.files:
            won = points(login, slug)
            made = result(student, check("a", "pass", won), check("b", "fail", 100 - won))
            results.append(replace(made, exercise=slug))
            texts[login, slug] = candidate.read()[AGENTS[slug]]
        else:
            state = ABSENT if candidate.absent else HELD
            results.append(replace(result(student), exercise=slug, state=state))
    students = {row.student: row for row in found.students}
    made = book(results, students=students, roster=roster)
    return Taken(download, found, people, texts, results, made)


@pytest.fixture(params=FORMATS)
def taken(request: pytest.FixtureRequest, tmp_path: Path) -> Taken:
    return take(request.param, tmp_path)


def test_every_file_and_everybody_is_accounted_for(taken: Taken) -> None:
    # everybody: each of the 60 is one student, by an id, and nobody else is
    assert Counter(person.number for person in taken.people.values()) == Counter(range(60))
    assert len(taken.found.students) == 60
    assert all(row.ids for row in taken.found.students)
    # every submission is its author's, the newest, and complete
    wanted = {(p.login, slug): p.files[f] for p in PEOPLE for slug, f in AGENTS.items()
              if f in p.files}  # fmt: skip
    assert taken.texts == wanted
    # every upload has its line
    lines = taken.found.account.lines
    counts = taken.counts
    assert counts[fates.GRADED] == len(wanted)
    rest = sum(counts[fate] for fate in (fates.OLDER, fates.UNREADABLE))
    older = sum("older attempt" in line.reason for line in lines)
    strange = [
        line for line in lines if line.state in (fates.EXTRA, fates.UNKNOWN) and line.student
    ]
    assert len(wanted) + rest + older + len(strange) == taken.download.entries
    nobodys = [line for line in lines if line.state == fates.UNKNOWN and not line.student]
    assert len(nobodys) == taken.download.junk
    assert counts[fates.NOTHING] == 6
    assert counts[fates.STRANGER] == 0


def test_what_could_not_be_read_is_held_and_the_rest_is_not(taken: Taken) -> None:
    held = {taken.people[r.student].number for r in taken.results if r.state == HELD}
    assert held == {30, 31}
    absent = {taken.people[r.student].number for r in taken.results if r.state == ABSENT}
    assert absent >= set(range(20, 26))


def rows_by_id(taken: Taken) -> int:
    """Import the gradebooks by the platform's rules; return how many rows found their student."""
    matched = 0
    systems = taken.book.systems
    for task in tasks_of(taken.results):
        wanted = {login: float(points(login, slug)) for login, slug in SUBMITTED
                  if slug == task.slug}  # fmt: skip
        if "canvas" in systems:
            users = {100 + p.number: (f"{p.last}, {p.first}", p.login) for p in PEOPLE}
            titles = {71: ("Obstacle avoidance", "100"), 73: ("Week 3: Goal seeking", "50")}
            canvas = Canvas(users, titles)
            canvas.load(canvas_csv(taken.book, task) or "")
            scale = 1.0 if task.slug == "obstacle_avoidance" else 0.5
            got = {users[user][1]: float(new) for (user, _), new in canvas.changes.items()}
            assert got == {login: scale * won for login, won in wanted.items()}
            assert not (canvas.new_users or canvas.new_assignments or canvas.new_points)
        elif "worksheet" in systems:
            ids = {id_: login for (slug, login), id_ in taken.download.participants.items()
                   if slug == task.slug}  # fmt: skip
            sheet = MoodleAssignment(ids, 100.0)
            sheet.load(worksheet_csv(taken.book, task) or "")
            got = {user: grade for user, (grade, _) in sheet.grades.items()}
            assert got == wanted
            assert not sheet.skipped
            moodle = Moodle({f"{p.login}@uni.edu": p.login for p in PEOPLE})
            moodle.load(grades_csv(taken.book, task) or "")
            assert moodle.grades == wanted
        else:
            text = scores_csv(taken.results, [task, *_others(taken, task.slug)],
                              taken.book.students)  # fmt: skip
            lines = [line for line in csv.DictReader(io.StringIO(text))
                     if line["exercise"] == task.slug and line["points"]]  # fmt: skip
            ids = {line["id"]: float(line["points"]) for line in lines}
            known = {p.login: str(4000 + p.number) for p in PEOPLE}
            assert ids == {known[login]: won for login, won in wanted.items()}
            if "nbgrader" in systems:
                exported = csv.DictReader(
                    io.StringIO(nbgrader.gradebook(taken.book, [task])["nbgrader.csv"])
                )
                got = {line["student_id"]: float(line["score"]) for line in exported}
                assert got == wanted
            got = wanted
        matched += len(got)
    return matched


def _others(taken: Taken, slug: str) -> list[Task]:
    return [task for task in tasks_of(taken.results) if task.slug != slug]


def test_every_row_is_matched_by_id(taken: Taken) -> None:
    assert rows_by_id(taken) == len(SUBMITTED)


def main() -> None:
    """Print the table."""
    names = ["format", "files", "graded", "older", "not read", "held files", "nobody's",
             "students", "nothing", "rows by id"]  # fmt: skip
    print(" | ".join(names))
    for format_ in FORMATS:
        with tempfile.TemporaryDirectory() as place:
            taken = take(format_, Path(place))
            lines, counts = taken.found.account.lines, taken.counts
            older = sum("older attempt" in line.reason for line in lines) + counts[fates.OLDER]
            strange = sum(
                line.state in (fates.EXTRA, fates.UNKNOWN) and bool(line.student) for line in lines
            )
            nobodys = sum(line.state == fates.UNKNOWN and not line.student for line in lines)
            cells = [format_, taken.download.entries, counts[fates.GRADED], older,
                     counts[fates.UNREADABLE], strange, nobodys, len(taken.people),
                     counts[fates.NOTHING], f"{rows_by_id(taken)}/{len(SUBMITTED)}"]  # fmt: skip
            print(" | ".join(map(str, cells)))


if __name__ == "__main__":
    main()
