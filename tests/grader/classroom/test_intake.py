"""What a class hands in: odd names, odd archives, traps."""

import gzip
import hashlib
import os
import stat
import tarfile
import tempfile
import unicodedata
import zipfile
from pathlib import Path

import pytest
from handing_in import put, taken, tarred
from hypothesis import example, given, settings
from hypothesis import strategies as st

from grader.classroom.intake.exercise_files import find_files, find_sole
from grader.classroom.intake.handed_in import Student
from grader.course.submission import MAX_SIZE, read_regular_file
from grader.errors import InputError
from grader.lms import unpack
from grader.lms.names import student_id

AGENT = "agent.py"


@pytest.fixture
def handed_in(tmp_path: Path) -> Path:
    folder = tmp_path / "handed in"
    folder.mkdir()
    return folder


def the_one(handed_in: Path) -> Student:
    (student,) = taken(handed_in).students
    return student


def test_an_empty_file_is_no_work(handed_in: Path) -> None:
    put(handed_in, **{f"ann/{AGENT}": "\n \n"})
    student = the_one(handed_in)
    assert find_files(student, [AGENT]).problem == f"{AGENT} is empty; another copy is needed"
    put(handed_in, **{"ann/agent (1).py": "print()\n"})
    found = find_files(the_one(handed_in), [AGENT])
    assert found.files[AGENT].name == "agent (1).py"


@pytest.mark.parametrize(("text", "work"), [("x = 1\n", "robot.py"), ("# mine\n", ""), ("", "")])
def test_the_only_file_is_work_if_there_is_more_in_it_than_comments(
    handed_in: Path, text: str, work: str
) -> None:
    put(handed_in, **{"ann/robot.py": text})
    files = find_sole(the_one(handed_in), [AGENT]).files.values()
    assert [file.name for file in files] == ([work] if work else [])


def test_folders_and_archives_are_students(handed_in: Path) -> None:
    put(handed_in / "Zoë Ünal", **{AGENT: "1"})
    put(handed_in / "bob.zip", **{f"week 1/{AGENT}": "2"})
    put(handed_in / "eve.tar.gz", **{f"./{AGENT}": "3"})
    put(handed_in / "kim.tgz", **{AGENT: "4"})
    put(handed_in / "lea.tar", **{AGENT: "5"})
    put(handed_in / "mia.tar-12.gz", **{AGENT: "6"})  # Canvas, of another upload
    put(handed_in, "grades.csv", "__MACOSX/x", ".git/x")

    students = taken(handed_in).students

    assert [s.id for s in students] == ["Zoë Ünal", "bob", "eve", "kim", "lea", "mia"]
    assert [s.problem for s in students] == [""] * 6
    texts = [find_files(s, [AGENT]).files[AGENT].read_text() for s in students]
    assert texts == ["1", "2", "3", "4", "5", "6"]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("ann", "ann"), (unicodedata.normalize("NFD", "Änn Lee"), "Änn Lee"), ("..", "unnamed"),
        (".hidden", "hidden"), ("a/b\\c", "a_b_c"), ("a\nb\x1b[31m", "a_b_[31m"), ("\udcff", "_"),
        ("x" * 300, "x" * 80), ("aux", "_aux"),
        ("--checkpoint-action=exec=x", "checkpoint-action=exec=x"),
    ],
)  # fmt: skip
def test_ids_are_safe(name: str, expected: str) -> None:
    assert student_id(name) == expected


def test_no_class(handed_in: Path) -> None:
    with pytest.raises(InputError, match="expected a folder or an archive"):
        taken(handed_in)
    with pytest.raises(InputError, match="nothing is there"):
        taken(handed_in / "nowhere")


# --- traps ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["../evil.py", "/etc/evil.py", "C:\\evil.py", "a/../../evil.py"])
@pytest.mark.parametrize("kind", ["zip", "tar"])
def test_nothing_is_written_outside(handed_in: Path, name: str, kind: str) -> None:
    put(handed_in / f"eve.{kind}", **{name: "evil"})

    student = the_one(handed_in)

    assert "points outside" in student.problem
    assert not list(handed_in.parent.rglob("evil.py"))
    assert find_files(student, [AGENT]).problem == student.problem


def test_links_and_devices_in_archives_are_left_out(handed_in: Path) -> None:
    link, hard, pipe = (tarfile.TarInfo(name) for name in ("link.py", "hard.py", "pipe.py"))
    link.type, link.linkname = tarfile.SYMTYPE, "/etc/passwd"
    hard.type, hard.linkname = tarfile.LNKTYPE, "/etc/passwd"
    pipe.type = tarfile.FIFOTYPE
    work = tarfile.TarInfo(AGENT)
    tarred(handed_in / "eve.tar", (link, b""), (hard, b""), (pipe, b""), (work, b"1"))

    student = the_one(handed_in)

    assert student.problem == ""
    assert [file.name for file in student.files] == [AGENT]
    scratch = handed_in.parent / "scratch"
    assert [path.name for path in scratch.rglob("*") if path.is_file()] == [AGENT]


def test_links_in_zips_are_left_out(handed_in: Path) -> None:
    with zipfile.ZipFile(handed_in / "eve.zip", "w") as archive:
        link = zipfile.ZipInfo(AGENT)
        link.external_attr = (stat.S_IFLNK | 0o777) << 16
        archive.writestr(link, "/etc/passwd")

    student = the_one(handed_in)
    assert student.links  # so something was handed in, and a person looks
    assert "there are no files" in find_files(student, [AGENT]).problem


@pytest.mark.parametrize("suffix", [".zip", ".tar.gz"])
def test_bombs(handed_in: Path, suffix: str) -> None:
    put(handed_in / f"eve{suffix}", **{AGENT: bytes(20 * 1024 * 1024)})

    assert "larger unpacked than packed" in the_one(handed_in).problem
    assert sum(path.stat().st_size for path in handed_in.parent.rglob("agent.py")) <= unpack.SMALL


def test_bomb_in_what_is_skipped(handed_in: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unpack, "MAX_UNPACKED", 1024 * 1024)
    put(handed_in / "eve.tgz", **{".git/pack": bytes(8 * 1024 * 1024)})

    assert "not unpacked" in the_one(handed_in).problem


def test_too_many_members(handed_in: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unpack, "MAX_MEMBERS", 5)
    for name in ("a.zip", "b.tar"):
        put(handed_in / name, *(f"{n}.py" for n in range(6)))

    assert ["over 5 files" in s.problem for s in taken(handed_in).students] == [True, True]


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.zip", b""), ("a.zip", b"PK\x03\x04 cut off"), ("a.tar", b"\xff" * 2000),
        ("a.tar.gz", b"no gzip"), ("a.tgz", gzip.compress(b"no tar" * 500, mtime=0)),
        ("a.tar.gz", gzip.compress(bytes(10_000), mtime=0)[:-9]),
    ],
    ids=["empty", "cut zip", "no tar", "no gzip", "no tar in it", "cut gzip"],
)  # fmt: skip
def test_broken_archives(handed_in: Path, name: str, data: bytes) -> None:
    (handed_in / name).write_bytes(data)

    student = the_one(handed_in)
    problem = student.problem or find_files(student, [AGENT]).problem

    assert problem
    assert "\n" not in problem


def test_locked_archive(handed_in: Path) -> None:
    path = put(handed_in / "a.zip", **{AGENT: "1"})
    data = bytearray(path.read_bytes())
    data[6] |= 1  # the flag "encrypted", in the member's header and in the directory's
    data[data.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(data)

    assert "password" in the_one(handed_in).problem


def test_an_archive_in_an_archive_is_unpacked_and_no_deeper(handed_in: Path) -> None:
    inner = put(handed_in.parent / "inner.zip", **{AGENT: "1"}).read_bytes()
    deeper = put(handed_in.parent / "deeper.zip", **{"inner.zip": inner}).read_bytes()
    put(handed_in / "ann_123_assignsubmission_file" / "hw.zip", **{AGENT: "1"})
    put(handed_in / "bob.zip", **{"inner.zip": inner})
    put(handed_in / "cy.zip", **{"deeper.zip": deeper})

    ann, bob, cy = taken(handed_in).students

    assert find_files(ann, [AGENT]).files
    assert find_files(bob, [AGENT]).files
    assert "archives deeper inside are not unpacked" in find_files(cy, [AGENT]).problem


def test_links_out_of_a_folder_are_not_followed(handed_in: Path, tmp_path: Path) -> None:
    put(tmp_path, "secret.py", f"elsewhere/{AGENT}")
    (handed_in / "eve").mkdir()
    (handed_in / "eve" / AGENT).symlink_to(tmp_path / "secret.py")
    (handed_in / "eve" / "inside").symlink_to(tmp_path / "elsewhere")
    (handed_in / "mallory").symlink_to(tmp_path / "elsewhere")
    os.mkfifo(handed_in / "eve" / "pipe.py")

    eve, mallory = taken(handed_in).students

    problem = find_files(eve, [AGENT]).problem
    assert problem == f"expected a file {AGENT}; there are no files (links are not followed)"
    assert "link" in mallory.problem


def test_no_more_is_read_than_tells_that_it_is_too_much(tmp_path: Path) -> None:
    (tmp_path / "big.py").write_bytes(b"#" * (MAX_SIZE + 10))

    assert len(read_regular_file(tmp_path / "big.py")) == MAX_SIZE + 1


# --- which file counts ---------------------------------------------------------------------------


def test_the_file_nearest_to_the_top_counts(handed_in: Path) -> None:
    put(handed_in, *(f"ann/{where}/{AGENT}" for where in ("z", "a/deep", ".venv")))

    found = find_files(the_one(handed_in), [AGENT])

    assert found.files[AGENT] == handed_in / "ann" / "z" / AGENT


@pytest.mark.parametrize("name", ["Agent.PY", "agent (1).py", "agent-2.py", "agent - Copy.py"])
def test_names_that_are_as_good(handed_in: Path, name: str) -> None:
    put(handed_in / "ann", name)

    assert set(find_files(the_one(handed_in), [AGENT]).files) == {AGENT}


def test_a_wrong_name_is_told(handed_in: Path) -> None:
    put(handed_in / "ann", "my\nrobot.py", "notes.txt")

    problem = find_files(the_one(handed_in), [AGENT]).problem

    assert problem == r"expected a file agent.py; there is my\nrobot.py"


def test_other_files_come_from_beside_the_first(handed_in: Path) -> None:
    put(handed_in / "ann", "a/other.py", "b/other.py", **{f"b/{AGENT}": "agent"})

    found = find_files(the_one(handed_in), [AGENT, "other.py", "third.py"])

    assert {name: path.read_text() for name, path in found.files.items()} == {
        AGENT: "agent",
        "other.py": "# b/other.py\n",
    }


# --- however they are called ---------------------------------------------------------------------

PIECES = (
    "ada", "ADA", "Ada", "~", "~5a3861", "5a3861", " ", ".", "_", "\u202e", "\n", "zoe\u0308",
    "zo\u00eb", "\u00df", "ss", "-", "0123456789", "x" * 90, "\udcff", "<", "?",
)  # fmt: skip
SUFFIXES = ("", ".zip", ".ZIP", ".tar")
NAMES = st.tuples(
    st.lists(st.sampled_from(PIECES), min_size=1, max_size=3).map("".join),
    st.sampled_from(SUFFIXES),
).map("".join)


def mark(name: str) -> str:
    return hashlib.sha256(name.encode()).hexdigest()[:6]


def hand_in(folder: Path, name: str, content: bytes) -> None:
    """Hand in a folder, or an archive if it is called so; what is called a tar is a folder."""
    path = Path(f"{folder}/{name}")
    if path.name.lower().endswith(".zip"):
        path.write_bytes(put(folder.parent / "packed.zip", **{AGENT: content}).read_bytes())
    else:
        path.mkdir(parents=True)
        (path / AGENT).write_bytes(content)


def usable(name: str) -> bool:
    return not name.startswith(".") and len(name.encode("utf-8", "surrogateescape")) < 250


@settings(max_examples=40, deadline=None)
@given(st.lists(NAMES.filter(usable), min_size=2, max_size=6, unique=True))
@example(["ada", "ada.zip", f"ada~{mark('ada.zip')}"])
@example(["ada", "ada.zip", f"ada~{mark('ada.zip')}", f"ada~{mark('ada.zip')}.zip"])
@example(["ada", f"ADA~{mark('ada.zip').upper()}", "ada.zip"])
@example(["zo\u00eb", "zoe\u0308", "zo\u00eb.zip"])
def test_nobody_is_lost(names: list[str]) -> None:
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place, "in")
        folder.mkdir()
        for name in names:
            hand_in(folder, name, b"#" + name.encode("utf-8", "surrogateescape"))
        students, again = taken(folder).students, taken(folder).students

        ids = [student.id for student in students]
        assert len({each.casefold() for each in ids}) == len(names)
        assert [student.id for student in again] == ids
        found = {find_files(student, [AGENT]).files[AGENT].read_bytes() for student in students}
        assert found == {b"#" + name.encode("utf-8", "surrogateescape") for name in names}


def test_a_mark_can_not_be_taken_by_choosing_a_name(tmp_path: Path) -> None:
    victim = f"ada~{mark('ada.zip')}"
    for name in ("ada", "ada.zip"):
        hand_in(tmp_path / "in", name, name.encode())
    before = {s.id for s in taken(tmp_path / "in").students}
    assert victim in before

    hand_in(tmp_path / "in", victim, b"thief")
    after = {s.id: s for s in taken(tmp_path / "in").students}
    assert before < after.keys()
    kept = find_files(after[victim], [AGENT]).files[AGENT]
    assert kept.read_bytes() == b"ada.zip"
