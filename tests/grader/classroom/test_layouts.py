"""Downloads of learning platforms, with names as they write them and as students spoil them."""

import json
import os
import pwd
from pathlib import Path

import pytest
from handing_in import AGENT, faults, graded, put, taken

from grader.classroom.intake.exercise_files import find_files
from grader.course.exercises import EXERCISES
from grader.errors import InputError
from grader.lms import unpack


@pytest.fixture
def download(tmp_path: Path) -> Path:
    folder = tmp_path / "download"
    folder.mkdir()
    return folder


# --- Canvas --------------------------------------------------------------------------------------


def test_canvas_files_carry_their_students(download: Path) -> None:
    put(
        download,
        f"leecarla_12345_678901_{AGENT}",
        "petersdan_LATE_2222_678950_obstacle_avoidance_agent-1.py",
        f"müllerzoë_333_678902_{AGENT}",
        f"anon_aB3xY_678903_{AGENT}",
    )
    intake = taken(download)
    assert graded(intake) == {
        "leecarla_12345": f"leecarla_12345_678901_{AGENT}",
        "petersdan_2222": "petersdan_LATE_2222_678950_obstacle_avoidance_agent-1.py",
        "müllerzoë_333": f"müllerzoë_333_678902_{AGENT}",
        "anon_aB3xY": f"anon_aB3xY_678903_{AGENT}",
    }
    late = {s.id: s.files[0].entry.late for s in intake.students}
    assert late["petersdan_2222"] is True
    assert late["leecarla_12345"] is False


def test_of_several_versions_canvas_received_last_counts(download: Path) -> None:
    put(
        download,
        f"leecarla_12345_678901_{AGENT}",
        "leecarla_12345_700002_obstacle_avoidance_agent-2.py",
        "leecarla_12345_690000_obstacle_avoidance_agent-1.py",
        "leecarla_LATE_12345_678905_notes.txt",
    )
    (lee,) = taken(download).students
    found = find_files(lee, [AGENT])
    assert found.files[AGENT].name.startswith("leecarla_12345_700002")
    assert len(found.older) == 2


def test_nobody_can_hand_in_for_another(download: Path) -> None:
    put(download, f"eve_66_900_bob_55_901_{AGENT}", f"bob_55_800_{AGENT}")
    intake = taken(download)
    assert {s.id: [f.name for f in s.files] for s in intake.students} == {
        "bob_55": [AGENT],
        "eve_66": [f"bob_55_901_{AGENT}"],
    }


def test_what_was_typed_into_canvas_is_told(download: Path) -> None:
    put(download, f"ann_1_2_{AGENT}", "bob_55_text.html", "cy_LATE_56_link.html", "readme")
    intake = taken(download)
    assert "there is text typed into Canvas.html" in graded(intake)["bob_55"]
    assert "there is web address.html" in graded(intake)["cy_56"]
    assert "a file of nobody's" in faults(intake)["readme"]


# --- Moodle --------------------------------------------------------------------------------------


def test_moodle_folders_and_flat_files(download: Path) -> None:
    put(
        download,
        f"Ann Lee_4711_assignsubmission_file/{AGENT}",
        f"Bob-Jan O'Neill_4712_assignsubmission_file_/week 1/{AGENT}",
        f"Zoë Ünal_4713_assignsubmission_file_{AGENT}",
        f"Participant_4714_assignsubmission_file/{AGENT}",
        "Cy Dee_4715_assignsubmission_onlinetext/onlinetext.html",
    )
    intake = taken(download)
    assert sorted(graded(intake)) == [
        "Ann Lee", "Bob-Jan O'Neill", "Cy Dee", "Participant 4714", "Zoë Ünal",
    ]  # fmt: skip
    assert "there is onlinetext.html" in graded(intake).pop("Cy Dee")
    assert all(AGENT in text for text in graded(intake).values())
    assert {s.who[0].id for s in intake.students} == {"4711", "4712", "4713", "4714", "4715"}


def test_anonymous_submissions_of_moodle_are_no_one_person(tmp_path: Path) -> None:
    sources = [
        put(tmp_path / f"week{number}", f"Participant_{number}_assignsubmission_file/{AGENT}")
        for number in (41, 52)
    ]
    sheet = tmp_path / "grades.csv"
    sheet.write_text("Identifier,Status,Grade\nParticipant 41,x,\nParticipant 43,,\n")
    intake = taken(*sources, roster=sheet)
    people = {student.id: student.person is not None for student in intake.students}
    assert people == {"Participant 41": True, "Participant 43": True, "Participant 52": False}


@pytest.mark.parametrize("chosen", ["leecarla_12345_99999999", "leecarla_12345"])
def test_nobody_hands_in_for_another_by_a_name_with_ids(download: Path, chosen: str) -> None:
    put(download, f"leecarla_12345_678901_{AGENT}")
    put(download / f"{chosen}_777_888_mine.zip", **{AGENT: "# evil\n"})
    intake = taken(download)
    assert len(intake.students) == 1
    assert "evil" not in graded(intake)["leecarla_12345"]
    assert ["can't be told" in reason for reason in faults(intake).values()] == [True]
    roster = download.parent / "gradebook.csv"  # which has both
    roster.write_text('Student,ID\n"Lee, Carla",12345\n' + f"{chosen},777\n")
    both = taken(download, roster=roster)
    assert "evil" not in graded(both)["Carla Lee"]
    assert len(faults(both)) == 1


# --- nbgrader, GitHub Classroom, Gradescope ------------------------------------------------------


@pytest.mark.parametrize("course", ["", "course101/"])
def test_the_exchange_of_nbgrader(download: Path, course: str) -> None:
    put(
        download,
        f"{course}inbound/ann+lee@uni.edu+loop+2026-05-04 10:11:12.123456 UTC+abc_-1/{AGENT}",
        f"{course}inbound/ann+lee@uni.edu+loop+2026-05-04 09:00:00.000000 UTC+zzz/{AGENT}",
        f"{course}inbound/bob+loop+2026-05-03 10:11:12.1 UTC/{AGENT}",
        f"{course}outbound/loop/01_loop.ipynb",
    )
    source = download / course if course else download
    intake = taken(source)
    assert graded(intake)["ann+lee@uni.edu"].startswith(
        f"{course}inbound/ann+lee@uni.edu+loop+2026-05-04 10:11"
    )
    assert "bob" in graded(intake)
    assert not faults(intake)
    older = [each for each in intake.set_aside if "older attempt" in each.reason]
    assert len(older) == 1
    assert intake.students[1].files[0].entry.time == "2026-05-03 10:11:12.1 UTC"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs root")
def test_in_the_exchange_nobody_hands_in_under_anothers_name(download: Path) -> None:
    put(
        download,
        f"inbound/nobody+loop+2026-05-04 10:11:12.1 UTC/{AGENT}",
        f"inbound/nobody+loop+2026-05-04 12:00:00.1 UTC+later/{AGENT}",
        f"inbound/bob+loop+2026-05-04 10:11:12.1 UTC/{AGENT}",
        "outbound/loop/01_loop.ipynb",
    )
    for name, uid in (("10:11:12.1 UTC", pwd.getpwnam("nobody").pw_uid), ("later", 12345)):
        (folder,) = (download / "inbound").glob(f"nobody*{name}")
        os.chown(folder, uid, uid)
    intake = taken(download)
    assert set(graded(intake)) == {"nobody", "bob"}
    assert "10:11" in graded(intake)["nobody"]
    assert [reason.split(",")[0] for reason in faults(intake).values()] == ["belongs to user 12345"]


def test_collected_work_of_nbgrader(download: Path) -> None:
    put(download, *(f"{side}/ann/loop/{AGENT}" for side in ("submitted", "autograded", "feedback")),
        "source/loop/01.ipynb", "gradebook.db",
        **{"submitted/ann/loop/timestamp.txt": "2026-05-04 10:11:12.123456 UTC\n"})  # fmt: skip
    intake = taken(download)
    assert list(graded(intake)) == ["ann"]
    assert intake.students[0].files[0].entry.time.startswith("2026-05-04")
    assert not faults(intake)


@pytest.mark.parametrize(
    ("place", "names"),
    [
        ("hw1-submissions", ["hw1-ann/.git/HEAD", f"hw1-ann/{AGENT}"]),
        ("inbound", [f"ann+loop+2026-05-04 10:11:12 UTC/{AGENT}"]),
        ("submitted", [f"ann/loop/{AGENT}"]),
        ("course/HW 1", [f"ann_1_assignsubmission_file/{AGENT}"]),
        ("export", [f"ann_1_2_{AGENT}"]),
    ],
)
def test_the_folder_above_a_download_is_no_student(
    download: Path, place: str, names: list[str]
) -> None:
    put(download, *(f"{place}/{name}" for name in names), "__MACOSX/._x", ".DS_Store")
    intake = taken(download)
    assert [student.id.removesuffix("_1") for student in intake.students] == ["ann"]
    assert len(graded(intake)) == 1
    assert not faults(intake)


def test_a_class_of_one_keeps_its_student(download: Path) -> None:
    put(download, f"ann/submitted/src/{AGENT}", "ann/submitted/doc/a.md")
    assert graded(taken(download)) == {"ann": f"ann/submitted/src/{AGENT}"}
    put(download, f"bob/week 1/{AGENT}")
    assert list(graded(taken(download))) == ["ann", "bob"]


def test_clones_of_github_classroom(tmp_path: Path) -> None:
    named, other = tmp_path / "week-1-submissions", tmp_path / "clones"
    for folder, users in ((named, ["ann-lee"]), (other, ["ann-lee", "ann-bo"])):
        for user in users:
            put(folder, f"week-1-{user}/.git/HEAD", f"week-1-{user}/{AGENT}")
    put(named, f"week-1-cy/{AGENT}")  # a copy, without git
    assert list(graded(taken(named))) == ["ann-lee", "cy"]
    assert len(graded(taken(other))) == 2
    assert all(".git" not in f.name for s in taken(other).students for f in s.files)


METADATA = """---
submission_101:
  :submitters:
  - :name: Ann Lee
    :sid: '4001'
    :email: ann@uni.edu
  :created_at: 2026-05-04 10:11:12.123456000 -07:00
submission_102:
  :submitters:
  - :name: Bob Ray
    :sid: '4002'
    :email: bob@uni.edu
  - :name: Cy Dee
    :sid: '4003'
    :email: cy@uni.edu
submission_103:
  :submitters:
  - :name: Gone
    :sid: '4004'
"""


def test_an_export_of_gradescope(download: Path) -> None:
    names = [f"submission_{n}/{AGENT}" for n in (101, 102, 104)]
    intake = taken(put(download, *names, **{"submission_metadata.yml": METADATA}))
    assert graded(intake) == {
        "Ann Lee": f"submission_101/{AGENT}",
        "Bob Ray": f"submission_102/{AGENT}",
        "Cy Dee": f"submission_102/{AGENT}",  # a group: it counts for both
    }
    assert "does not say whose" in faults(intake)["submission_104"]
    assert "no such folder; it is of Gone" in faults(intake)["submission_103"]
    assert intake.students[0].who[0].email == "ann@uni.edu"


def test_of_two_submissions_to_gradescope_the_later_counts(download: Path) -> None:
    times = ("2026-03-29 02:30:00.0 +02:00", "2026-03-29 01:45:00.0 Z", "2026-03-28T20:00:00-04:00")
    told = [f"submission_{n}:\n  :submitters:\n  - :name: No\n    :sid: 0012\n"
            f"  :created_at: {time}\n" for n, time in enumerate(times)]  # fmt: skip
    names = [f"submission_{n}/{AGENT}" for n in range(3)]
    intake = taken(put(download, *names, **{"submission_metadata.yml": "".join(told)}))
    assert graded(intake) == {"No": f"submission_1/{AGENT}"}
    assert intake.students[0].who[0].id == "0012"  # as it is written, in no other number's form


@pytest.mark.parametrize("text", ["- 1\n", "a: [", "!!python/object/apply:os.system [id]", "\0"])
def test_metadata_that_are_none(download: Path, text: str) -> None:
    put(download, f"submission_1/{AGENT}", **{"submission_metadata.yml": text})
    with pytest.raises(InputError, match="expected Gradescope's metadata"):
        taken(download)


# --- notebooks -----------------------------------------------------------------------------------


def notebook(*cells: str) -> str:
    made = [{"cell_type": "code", "metadata": {}, "outputs": [], "source": c} for c in cells]
    return json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": made})


def test_nodes_in_notebooks_are_files(download: Path) -> None:
    skeleton = (EXERCISES / "goal_seeking" / "goal_seeking_agent.py").read_text()
    untouched = f"%%node goal_seeking_agent.py\n{skeleton}\n"
    mine = f"%%node {AGENT}\n# mine\n"
    files = {
        "ann_1_2_01_loop.ipynb": notebook("1/0", f"%%node {AGENT}\n# first\n", mine, untouched),
        "bob_2_3_01_loop.ipynb": notebook(untouched),
        "cy_3_4_01_loop.ipynb": "{",
        "dee_4_5_01_loop.ipynb": notebook(mine),
        f"dee_4_6_{AGENT}": "# loose\n",
    }
    intake = taken(put(download, **files))
    assert graded(intake)["ann_1"] == "mine"
    (aside,) = intake.set_aside  # nothing is lost without a line
    assert (aside.name, aside.fault) == ("ann_1: 01_loop.ipynb", False)
    assert aside.reason == f"2 cells write {AGENT}; the last, cell 3, counts."
    assert "still the skeleton" in graded(intake)["bob_2"]
    assert graded(intake)["cy_3"].startswith("01_loop.ipynb: it is not JSON")
    assert graded(intake)["dee_4"] == "loose"
    assert not find_files(intake.students[0], ["goal_seeking_agent.py"]).files


# --- all of them ---------------------------------------------------------------------------------


def test_a_download_may_stay_packed(tmp_path: Path) -> None:
    flat = put(tmp_path / "submissions.zip", f"leecarla_12345_678901_{AGENT}", "__MACOSX/._x")
    deep = put(tmp_path / "moodle.tgz", f"all/everything/Bob_22_assignsubmission_file/{AGENT}")
    intake = taken(flat, deep)
    assert sorted(graded(intake)) == ["Bob", "leecarla_12345"]


@pytest.mark.parametrize("name", ["nowhere", "notes.txt", "class.rar", "broken.zip"])
def test_what_is_no_download(tmp_path: Path, name: str) -> None:
    if name != "nowhere":
        (tmp_path / name).write_bytes(b"nothing")
    with pytest.raises(InputError, match=r"expected (a folder|what the)|broken archive"):
        taken(tmp_path / name)


def test_one_cannot_keep_out_the_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unpack, "CUT", 1024 * 1024)
    files = {
        f"ann_1_2_{AGENT}": "# fine\n",
        f"eve_2_3_{AGENT}": b"#" * 8 * 1024 * 1024,
        "eve_2_4_bomb.zip": bytes(16 * 1024 * 1024),
    }
    intake = taken(put(tmp_path / "class.zip", **files))
    assert graded(intake)["ann_1"] == "fine"
    assert "broken archive" in intake.students[1].problem
    assert sum("cut off" in reason for reason in faults(intake).values()) == 2


@pytest.mark.parametrize(
    ("names", "why"),
    [
        (("\U0001f980" * 90,), "File name too long"),
        (("notes", "notes/mine.py"), "can't be written"),
        (("notes\\..\\..\\..\\x.py",), "points outside"),
    ],
    ids=["too long", "file and folder", "outside"],
)
def test_an_impossible_name_cannot_keep_out_the_others(
    tmp_path: Path, names: tuple[str, ...], why: str
) -> None:
    room = "Eve Bad_102_assignsubmission_file"
    others = [f"{who}_assignsubmission_file/{AGENT}" for who in ("Ann Lee_101", "Zoe Ok_103")]
    every = (others[0], *(f"{room}/{name}" for name in names), others[1])
    intake = taken(put(tmp_path / "class.zip", *every))
    assert {"Ann Lee", "Zoe Ok"} <= graded(intake).keys()
    assert any(why in reason for reason in faults(intake).values())
    assert not list(tmp_path.rglob("x.py"))


def test_links_in_a_download_are_not_followed(download: Path, tmp_path: Path) -> None:
    put(tmp_path, f"secret/{AGENT}", "secret.py")
    for name in ("Eve_1_assignsubmission_file", "submission_9", "week-eve"):
        (download / name).symlink_to(tmp_path / "secret")
    (download / f"eve_1_2_{AGENT}").symlink_to(tmp_path / "secret.py")
    assert {"a link" in text for text in graded(taken(download)).values()} == {True}


def test_the_roster_may_lie_beside_the_work(download: Path) -> None:
    rows = "id,name,section\n1,ann,A\n2,Bob Ray,B\n"
    put(download, f"ann/{AGENT}", "notes.pdf", **{"class.csv": rows})
    intake = taken(download, roster=download / "class.csv")
    assert faults(intake).keys() == {"notes.pdf"}
    assert {s.id: s.person.section for s in intake.students if s.person} == {
        "ann": "A",
        "Bob Ray": "B",
    }


def test_canvas_archives_are_unpacked(download: Path) -> None:
    put(download / "ann_1_22_homework.zip", **{f"src/{AGENT}": "# packed\n"})
    put(download, "bob_2_23_homework.rar", "cy_3_24_homework.7z")
    intake = taken(download)
    assert graded(intake)["ann_1"] == "packed"
    assert (
        "homework.rar: an archive that is not read; ask for one of .zip" in graded(intake)["bob_2"]
    )
    assert "homework.7z" in graded(intake)["cy_3"]


def test_two_assignments_of_moodle_are_one_class(tmp_path: Path) -> None:
    one = put(tmp_path / "one", f"Ann Lee_4711_assignsubmission_file/{AGENT}")
    two = put(tmp_path / "two", "Ann Lee_5822_assignsubmission_file/goal_seeking_agent.py")
    (ann,) = taken(one, two).students
    assert find_files(ann, [AGENT]).files
    assert find_files(ann, ["goal_seeking_agent.py"]).files
