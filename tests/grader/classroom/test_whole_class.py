"""A whole class by each platform's download, with what people are like: nobody is another.

Each file says whose it is by a number, and the judge gives that many points.
"""

import csv
import io
import shutil
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
from fake_class import FILE, SLUG, grading
from handing_in import roster_of
from importers import MOODLE
from marked_class import give, points, scores

from grader.classroom.desk.marking import Marking, marking
from grader.classroom.queue.store import Store
from grader.classroom.queue.work import Unit, UnitResult
from grader.course.exercises import find_exercise
from grader.errors import InputError
from grader.lms.people import Roster, squeezed

SKELETON = (find_exercise(SLUG).folder / FILE).read_text("utf-8")
ODD = (
    "Ann Lee", "Ann Lee", "Jörg Müller", "Jörg Müller", "Seán O'Brien", 'Anne "Nan" Ray',
    "Bo Ray-Lee", "Al Sum", "Li Lei", "Zoë Ünal", "Max Con", "Eva 2 Roe",
)  # fmt: skip
MOST = 101  # points of these files; a mark is at most 100
LATE, AGAIN, MISNAMED, FINAL, PACKED, UNTOUCHED, ABSENT = 0, 4, 5, 6, 7, 8, 9  # by number


@dataclass(frozen=True)
class Student:
    number: int
    name: str

    @property
    def first(self) -> str:
        return self.name.rpartition(" ")[0]

    @property
    def last(self) -> str:
        return self.name.rpartition(" ")[2]

    @property
    def login(self) -> str:
        return f"u{self.number}"


def people(size: int) -> list[Student]:
    names = [*ODD, *(f"Given{n} Family{n}" for n in range(len(ODD), size))]
    return [Student(number, name) for number, name in enumerate(names[:size])]


def work(student: Student, version: int = 0) -> bytes:
    return f"# {student.number} {version}\nprint({student.number})\n".encode()


def files_of(student: Student, version: int) -> dict[str, bytes]:
    """What a student has handed in, by its name."""
    mine = work(student, version)
    match student.number:
        case 5:
            return {"my_agent.py": mine, FILE: SKELETON.replace("\n", "\r\n").encode()}
        case 6:
            return {"1234567_obstacle avoidance_agent_FINAL (1).py": mine}
        case 7:
            inner, outer = io.BytesIO(), io.BytesIO()
            with zipfile.ZipFile(inner, "w") as archive:
                archive.writestr(f"src/{FILE}", mine)
            with zipfile.ZipFile(outer, "w") as archive:
                archive.writestr("work.zip", inner.getvalue())
            return {"all.zip": outer.getvalue()}
        case 8:
            return {FILE: f"# not begun\n{SKELETON}".encode()}
    return {FILE: mine}


Put = Callable[[Path, Sequence[Student], int], None]


def in_folders(place: Callable[[Student, int], str]) -> Put:
    def put(folder: Path, students: Sequence[Student], version: int) -> None:
        for student in students:
            for name, data in files_of(student, version).items():
                path = folder / place(student, version) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data)

    return put


def canvas(folder: Path, students: Sequence[Student], version: int) -> None:
    for student in students:
        name = squeezed(student.last + student.first)
        for place, (called, data) in enumerate(files_of(student, version).items()):
            upload = 5000 + 1000 * version + 10 * student.number + place
            (folder / f"{name}_{1000 + student.number}_{upload}_{called}").write_bytes(data)


def gradescope(folder: Path, students: Sequence[Student], version: int) -> None:
    told = []
    for place, student in enumerate(students):
        mine = f"submission_{100 + 1000 * version + place}"
        in_folders(lambda *_, mine=mine: mine)(folder, [student], version)
        told.append(
            f"{mine}:\n  :submitters:\n  - :name: {student.name!r}\n    :sid: '{student.number}'\n"
            f"    :email: {student.login}@uni.edu\n"
        )
    (folder / "submission_metadata.yml").write_text("".join(told), "utf-8")


def github(folder: Path, students: Sequence[Student], version: int) -> None:
    in_folders(lambda student, _: f"hw1-{student.login}")(folder, students, version)
    for student in students:
        (folder / f"hw1-{student.login}" / ".git").mkdir()


def moodles(student: Student, version: int) -> str:
    name = student.name.replace("'", "").replace('"', "")
    return f"{name}_{700 + student.number}_assignsubmission_file"


def table(header: str, row: Callable[[Student], Sequence[object]]) -> Callable[..., str]:
    def text(students: Sequence[Student]) -> str:
        target = io.StringIO()
        csv.writer(target).writerows([header.split(","), *(row(each) for each in students)])
        return target.getvalue()

    return text


def worksheet(language: str) -> Callable[..., str]:
    hidden, *headings, _, yes, _, _ = MOODLE[language]
    most = "100,00" if language == "de" else "100.00"
    return table(",".join(headings), lambda s: (
        f"{hidden}{700 + s.number}", s.name, f"{s.login}@uni.edu", "-", "", most, yes, "-", "-"
    ))  # fmt: skip


PLATFORMS: dict[str, tuple[Put, Callable[..., str]]] = {
    "canvas": (canvas, table("Student,ID,SIS Login ID,Section", lambda s: (
        f"{s.last}, {s.first}", 1000 + s.number, s.login, "A"))),
    "moodle": (in_folders(moodles), worksheet("en")),
    "moodle in German": (in_folders(moodles), worksheet("de")),
    "gradescope": (gradescope, table("First Name,Last Name,SID,Email,Role", lambda s: (
        s.first, s.last, s.number, f"{s.login}@uni.edu", "Student"))),
    "github": (github, table("identifier,github_username,github_id,name", lambda s: (
        f"{s.login}@uni.edu", s.login, s.number, s.name))),
    "nbgrader": (in_folders(lambda s, v: f"{s.login}+loop+2026-05-0{v + 1} 10:00:00 UTC"),
                 table("id,name,login", lambda s: (s.number, s.name, s.login))),
    "folders": (in_folders(lambda s, _: s.login),
                table("id,name,login", lambda s: (s.number, s.name, s.login))),
}  # fmt: skip


def judge(unit: Unit) -> UnitResult:
    told = unit.files[FILE].decode().split()[1]
    return UnitResult(grading(score=int(told) % MOST))


@pytest.mark.parametrize("size", [len(ODD), pytest.param(120, marks=pytest.mark.long)])
@pytest.mark.parametrize("platform", PLATFORMS)
def test_everybody_is_themselves(
    platform: str, size: int, handed_in: Path, tmp_path: Path, grade_class: Any
) -> None:
    put, sheet = PLATFORMS[platform]
    everybody, out = people(size), tmp_path / "out"
    roster = roster_of(tmp_path, sheet(everybody))

    def hand_in(students: Sequence[Student], version: int) -> None:
        shutil.rmtree(handed_in)
        handed_in.mkdir()
        put(handed_in, students, version)

    def graded(**options: Any) -> dict[int, str]:
        """Grade the class; return the points by the roster's number, by the store's key."""
        grade_class(judge, roster=roster, **options)
        with Store(out / "store.sqlite") as store:
            rows = store.students()
        keys = {person.key: number for number, person in enumerate(roster.people)}
        table = points(out)
        return {keys[row.person.key]: table[row.student] for row in rows.values()
                if row.student in table and row.person.key in keys}  # fmt: skip

    here = [each for each in everybody if each.number not in (LATE, ABSENT)]
    hand_in(here, 0)
    expected = {each.number: str(each.number % MOST) for each in here} | {
        UNTOUCHED: "", LATE: "", ABSENT: "",
    }  # fmt: skip
    assert graded() == expected
    assert {row["state"] for row in scores(out).values()} == {"graded", "not handed in"}
    twin = folder_of(out, roster, 1)
    give(out, twin, 42)

    # another order, a late twin, everybody once more
    hand_in([each for each in reversed(everybody) if each.number != ABSENT], 1)
    expected |= {1: "42", LATE: "0"}
    assert graded() == expected
    assert folder_of(out, roster, 1) == twin

    # two alone: nothing is dropped without a word
    hand_in(everybody[AGAIN : AGAIN + 2], 2)
    with pytest.raises(InputError, match=r"nothing in it is of \d+ whose work is graded: .*--add"):
        graded()
    assert points(out)[twin] == "42"
    assert graded(add=True) == expected


def folder_of(out: Path, roster: Roster, number: int) -> str:
    with Store(out / "store.sqlite") as store:
        rows = store.students().values()
    (found,) = (each.student for each in rows if each.person.key == roster.people[number].key)
    return found


# --- whose is it? --------------------------------------------------------------------------------


def namesakes(handed_in: Path) -> tuple[list[Student], Roster]:
    """Hand in what two called Ann Lee have; the roster knows no numbers of Moodle's."""
    shutil.rmtree(handed_in)
    twins = people(3)
    in_folders(moodles)(handed_in, twins, 0)
    return twins, roster_of(handed_in.parent, "id,name\n0,Ann Lee\n1,Ann Lee\n2,Jörg Müller\n")


def test_who_can_not_be_told_is_held_until_a_person_says_it(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    (twins, roster), out = namesakes(handed_in), tmp_path / "out"
    grade_class(judge, roster=roster)
    held = {row["student"]: row["problem"] for row in scores(out).values()
            if row["state"] == "held"}  # fmt: skip
    assert sorted(held) == ["Ann Lee 700", "Ann Lee 701"]
    first, second = (folder_of(out, roster, number) for number in (0, 1))
    for problem in held.values():
        assert f"it may be {first} (0) or {second} (1)" in problem
    with marking(out) as class_:
        class_.add(class_.assigned("Ann Lee 700", ["0"]), "prof", "asked her")
        class_.add(class_.assigned("Ann Lee 701", ["1"]), "prof", "asked her")
    for version in (0, 1):  # in the next download, too
        in_folders(moodles)(handed_in, twins, version)
        grade_class(judge, roster=roster)
        assert points(out) == {first: "0", second: "1", "Jörg Müller": "2"}


def test_without_a_roster_a_namesake_is_nobody_known(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    shutil.rmtree(handed_in)
    late, there = people(2)
    in_folders(moodles)(handed_in, [there], 0)
    grade_class(judge)
    give(tmp_path / "out", "Ann Lee", 42)
    in_folders(moodles)(handed_in, [late], 0)
    grade_class(judge)
    mine = points(tmp_path / "out")
    assert mine.pop("Ann Lee") == "42"
    assert list(mine.values()) == ["0"]
    shutil.rmtree(handed_in)  # she alone, in a download of those who were late
    in_folders(moodles)(handed_in, [replace(late, number=3)], 0)
    for _ in range(2):
        grade_class(judge, add=True)
        assert points(tmp_path / "out")["Ann Lee"] == "42"
        (held,) = (row for row in scores(tmp_path / "out").values() if row["state"] == "held")
        assert "it may be Ann Lee or Ann Lee~" in held["problem"]


# --- groups --------------------------------------------------------------------------------------

TEAM = people(13)[10:13]  # of which the last is in no roster
ALONE = Student(4, "Seán O'Brien")
GROUPS: dict[str, tuple[str, str, Callable[..., str]]] = {
    "moodle": (
        f"Red Team_711_assignsubmission_file/{FILE}", f"Blue_712_assignsubmission_file/{FILE}",
        table("Identifier,Full name,Email address,Status,Group,Grade,Maximum Grade", lambda s: (
            f"Participant {700 + s.number}", s.name, f"{s.login}@x", "-", s.group, "", "100.00")),
    ),
    "canvas": (
        f"redteam_1010_5000_{FILE}", f"blue_LATE_1004_5001_{FILE}",
        table("name,canvas_user_id,user_id,login_id,sections,group_name,canvas_group_id,group_id",
              lambda s: (s.name, 1000 + s.number, "", s.login, "A", s.group, "", "")),
    ),
    "github": (
        f"hw1-red-team/{FILE}", f"hw1-blue/{FILE}",
        table("assignment_name,github_username,roster_identifier,student_repository_name,"
              "submission_timestamp,group_name",
              lambda s: ("hw1", s.login, s.name, f"hw1-{s.group.replace(' ', '-').lower()}",
                         "2026-05-04T10:00:00Z", s.group)),
    ),
    "gradescope": (
        f"submission_1/{FILE}", f"submission_2/{FILE}",
        table("Name,SID,Email", lambda s: (s.name, s.number, f"{s.login}@x")),
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Member(Student):
    group: str = ""


@pytest.mark.parametrize("platform", GROUPS)
def test_a_group_is_graded_once_for_each_of_its_members(
    platform: str, grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    shutil.rmtree(handed_in)
    red, blue, sheet = GROUPS[platform]
    for place, number in ((red, 30), (blue, 4)):
        (handed_in / place).parent.mkdir(parents=True, exist_ok=True)
        (handed_in / place).write_text(f"# {number}\n")
        if platform == "github":
            (handed_in / place).with_name(".git").mkdir()
    members = [Member(each.number, each.name, "Red Team") for each in TEAM]
    one = Member(ALONE.number, ALONE.name, "Blue")
    if platform == "gradescope":
        told = [f"submission_{n}:\n  :submitters:\n" + "".join(
            f"  - :name: {s.name!r}\n    :email: {s.login}@x\n" for s in theirs)
            for n, theirs in ((1, members[:2]), (2, [one]))]  # fmt: skip
        (handed_in / "submission_metadata.yml").write_text("".join(told), "utf-8")
    roster, out = roster_of(tmp_path, sheet([*members[:2], one])), tmp_path / "out"
    _, workers, _ = grade_class(judge, roster=roster, secret=b"0123456789abcdef")
    assert len(workers.students) == 2
    mine = [folder_of(out, roster, number) for number in range(3)]
    assert points(out) == dict(zip(mine, ("30", "30", "4"), strict=True))
    give(out, mine[1], 10)
    grade_class(judge, roster=roster, secret=b"0123456789abcdef")
    assert points(out) == dict(zip(mine, ("30", "10", "4"), strict=True))
    assert len(list((out / "sources").glob("*/class/*"))) == 2  # the group's once
    if platform == "github":
        assert scores(out)[mine[0]]["handed_in"] == "2026-05-04T10:00:00Z"


# --- what counts as work -------------------------------------------------------------------------


def test_a_misnamed_file_is_accepted_for_good(
    grade_class: Any, handed_in: Path, tmp_path: Path
) -> None:
    for name in ("robot.py", "old/mine.py"):
        (handed_in / "ann" / name).parent.mkdir(exist_ok=True)
        (handed_in / "ann" / name).write_text(f"# {len(name)}\nprint()\n")
    (handed_in / "ann" / FILE).write_text(f"{SKELETON}\n\n# later")
    (handed_in / "bob" / FILE).write_text("# 7\n")
    (handed_in / "eve" / FILE).write_text("# 9\n")
    out = tmp_path / "out"
    grade_class(judge)
    row = scores(out)["ann"]
    assert (row["state"], row["problem"]) == ("held", f"{FILE} is still the skeleton")

    def accept(class_: Marking, file: str) -> None:
        class_.add(class_.accepted("ann", file, class_.any_exercise("1")), "prof", "hers")

    with marking(out) as class_:
        with pytest.raises(
            InputError, match=r"unknown file of ann 'robots.py'; did you mean robot"
        ):
            accept(class_, "robots.py")
        accept(class_, "robot.py")
    grade_class(judge)
    assert points(out) == {"ann": "8", "bob": "7", "eve": "9"}
    (handed_in / "ann" / "robot.py").rename(handed_in / "ann" / "robot (1).py")
    (handed_in / "ann" / "robot (1).py").write_text("# 12\nprint()\n")
    grade_class(judge)
    assert points(out)["ann"] == "12"
    assert "accepted by a person" in (out / "intake.csv").read_text()
