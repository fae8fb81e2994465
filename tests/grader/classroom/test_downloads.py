"""Downloads as people keep them: a folder too high, with odd names, beside the results."""

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from handing_in import AGENT, matched, put, roster_of, taken

from grader.classroom.account import Account, Line
from grader.classroom.intake.candidates import OTHER_CLASS, Class, find_class
from grader.classroom.intake.exercise_files import find_files
from grader.classroom.intake.students import take_in
from grader.classroom.options import Options
from grader.cli.batch import listing

GOAL = "goal_seeking_agent.py"
MOODLE = tuple(f"{who}_assignsubmission_file_/{AGENT}" for who in ("Ann Lee_11", "Bo Ray_12"))
CANVAS = (f"leeann_1_22_{AGENT}", f"raybo_2_23_{AGENT}")
CLONES = (f"avoid-ann/{AGENT}", "avoid-ann/.git/HEAD", f"avoid-bo/{AGENT}", "avoid-bo/.git/HEAD")
GRADESCOPE = (f"submission_1/{AGENT}",)
METADATA = "submission_1: {':submitters': [{':name': Ann}, {':name': Bo}]}\n"
EXCHANGE = (
    f"ann+01_loop+2026-05-04 10:00:00 UTC/{AGENT}", f"bo+01_loop+2026-05-04 10:00:00 UTC/{AGENT}",
)  # fmt: skip
PLATFORMS = {
    "Moodle": MOODLE, "Canvas": CANVAS, "GitHub Classroom": CLONES, "Gradescope": GRADESCOPE,
    "nbgrader": EXCHANGE,
}  # fmt: skip


def looked(sources: list[Path], tmp_path: Path, roster: str = "") -> Class:
    options = Options()
    if roster:
        options = replace(options, roster=roster_of(tmp_path, roster))
    return find_class(sources, tmp_path / "scratch", options)


def lines(account: Account, state: str) -> list[Line]:
    return [line for line in account.lines if line.state == state]


# --- a folder too high ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("platform", "packed"),
    [(platform, "") for platform in PLATFORMS]
    + [("Moodle", "CS1/"), ("Canvas", "CS1/A1-4711/"), ("Gradescope", "CS1/")],
)
def test_a_download_a_folder_deeper_is_held_and_stops_nobody(
    tmp_path: Path, platform: str, packed: str
) -> None:
    put(tmp_path / "in" / "ann", AGENT)
    more = {f"{packed}submission_metadata.yml": METADATA} if platform == "Gradescope" else {}
    eve = tmp_path / "in" / ("eve.zip" if packed else "eve")
    put(eve, *(packed + name for name in PLATFORMS[platform]), **more)
    found = looked([tmp_path / "in"], tmp_path)
    (told,) = lines(found.account, "not read")
    assert told.student == "eve" and told.held and "name it itself" in told.reason
    assert found.candidates["ann", "obstacle_avoidance"].read()[1] == ""
    assert "several students" in found.candidates["eve", "obstacle_avoidance"].read()[1]


def test_one_students_prefix_is_no_download(tmp_path: Path) -> None:
    put(tmp_path / "in" / "ann", CANVAS[0])
    put(tmp_path / "in" / "bo", f"Bo Ray_12_assignsubmission_file_{AGENT}", "repo/.git/HEAD")
    assert [student.problem for student in taken(tmp_path / "in").students] == ["", ""]


def test_the_results_beside_the_work_are_nobodys(tmp_path: Path) -> None:
    put(tmp_path / "in", f"ann/{AGENT}", "new/store.sqlite", "old/store.sqlite", "old/class.html")
    intake = take_in([tmp_path / "in"], tmp_path / "in" / "new" / "unpacked")
    assert [student.id for student in intake.students] == ["ann"]
    (told,) = intake.set_aside
    assert told.name == "old" and told.fault and "results of `course autograde`" in told.reason


# --- names ---------------------------------------------------------------------------------------


def test_names_of_zips_from_macos_and_linux(tmp_path: Path) -> None:
    path = put(tmp_path / "class.zip", f"XXXX/{AGENT}", f"YYYY/{AGENT}")
    data = path.read_bytes()  # both names are four bytes: UTF-8 without the flag, code page 437
    path.write_bytes(data.replace(b"XXXX", "Zoë".encode()).replace(b"YYYY", b"Zo\x89e"))
    assert [student.id for student in taken(path).students] == ["Zoë", "Zoëe"]


def test_moodle_leaves_out_apostrophes_and_adds_groups(tmp_path: Path) -> None:
    people = "name,id\nSeán O'Brien,1\nAnne-Marie Ray,2\nBo Ray,3\nAnn Lee,4\n"
    roster = roster_of(tmp_path, people)
    names = ("Seán OBrien", "Anne-Marie Ray", "Team-1-Bo Ray", "Team 2-Anne-Marie Ray")
    found = [matched(roster, "moodle", name, "99").people for name in names]
    wanted = ["Seán O'Brien", "Anne-Marie Ray", "Bo Ray", "Anne-Marie Ray"]
    assert [[person.name for person in people] for people in found] == [[name] for name in wanted]
    assert matched(roster, "moodle", "Team-Nobody", "99").people == ()
    assert matched(roster, "folder", "Team-1-Bo Ray").people == ()


# --- what a person has to look at ----------------------------------------------------------------


def test_another_work_of_that_name_from_another_download(tmp_path: Path) -> None:
    put(tmp_path / "hw1", f"leeann_1_90_{GOAL}")
    put(tmp_path / "hw3", f"leeann_1_80_{GOAL}", f"leeann_1_81_{AGENT}")
    found = looked([tmp_path / "hw1", tmp_path / "hw3"], tmp_path)
    (told,) = lines(found.account, "older version")
    assert told.fault and "another download" in told.reason
    for name in ("hw1", "hw3"):  # the same work twice is no question
        for path in (tmp_path / name).glob(f"*{GOAL}"):
            path.write_text("# the same\n")
    (told,) = lines(looked([tmp_path / "hw1", tmp_path / "hw3"], tmp_path).account, "older version")
    assert not told.fault


def test_a_list_says_what_will_be_held_and_why(tmp_path: Path) -> None:
    put(tmp_path / "in", f"ann/{AGENT}", "bo/essay.pdf")
    text, waiting = listing(looked([tmp_path / "in"], tmp_path))
    assert waiting == 1
    assert "will be held: bo  expected a file" in text and "there is essay.pdf" in text


def test_what_can_not_be_read_is_held_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put(tmp_path / "in", f"ann/{AGENT}", f"bo/{AGENT}", f"bo/closed/{GOAL}")
    walk = os.walk

    def closed(top: Path, **options: object) -> Iterator[tuple[str, list[str], list[str]]]:
        for where, folders, files in walk(top, **options):  # type: ignore[call-overload]
            if where.endswith("closed"):
                options["onerror"](PermissionError(13, "Permission denied", where))  # type: ignore[operator]
            else:
                yield where, folders, files

    monkeypatch.setattr(os, "walk", closed)
    ann, bo = taken(tmp_path / "in").students
    assert ann.problem == ""
    assert bo.problem == "bo/closed can't be read"
    assert find_files(bo, [AGENT]).files


def test_links_are_no_nothing(tmp_path: Path) -> None:
    put(tmp_path / "in", f"ann/{AGENT}")
    (tmp_path / "in" / "bo").mkdir()
    (tmp_path / "in" / "bo" / AGENT).symlink_to("/etc/passwd")
    (told,) = lines(looked([tmp_path / "in"], tmp_path).account, "not read")
    assert told.student == "bo" and told.held and "links" in told.reason


def test_a_roster_of_another_class_is_one_line(tmp_path: Path) -> None:
    put(tmp_path / "in", f"ann/{AGENT}", f"bo/{AGENT}")
    found = looked([tmp_path / "in"], tmp_path, "name,id\nCy,7\nDi,8\n")
    (told,) = found.account.faults
    assert told.reason == OTHER_CLASS and "roster.csv" in told.entry
