"""What a class hands in: odd names, odd archives, traps."""

import gzip
import io
import os
import stat
import tarfile
import unicodedata
import zipfile
from pathlib import Path

import pytest

from grader.classroom.intake.exercise_files import find_files, sole_work
from grader.classroom.intake.handed_in import Student
from grader.classroom.intake.students import take_in
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


def find_students(folder: Path, scratch: Path) -> list[Student]:
    return take_in([folder], scratch).students


def unpacked(handed_in: Path) -> list[Path]:
    scratch = handed_in.parent / "scratch"
    return [path for path in scratch.rglob("*") if path.is_file()]


def the_one(handed_in: Path) -> Student:
    (student,) = find_students(handed_in, handed_in.parent / "scratch")
    return student


def zipped(path: Path, **files: bytes) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return path


def tar_with(path: Path, *members: tuple[tarfile.TarInfo, bytes]) -> None:
    with tarfile.open(path, "w:gz" if path.suffix in (".gz", ".tgz") else "w") as archive:
        for info, data in members:
            info.size = len(data)
            archive.addfile(info, io.BytesIO(data))


def test_an_empty_file_is_no_work(handed_in: Path) -> None:
    (handed_in / "ann").mkdir()
    (handed_in / "ann" / AGENT).write_text("\n \n")
    student = the_one(handed_in)
    assert find_files(student, [AGENT]).problem == f"{AGENT} is empty; ask for another copy"
    (handed_in / "ann" / "agent (1).py").write_text("print()\n")
    found = find_files(the_one(handed_in), [AGENT])
    assert found.files[AGENT].name == "agent (1).py"


@pytest.mark.parametrize(("text", "work"), [("x = 1\n", "robot.py"), ("# mine\n", ""), ("", "")])
def test_the_only_file_is_work_if_there_is_more_in_it_than_comments(
    handed_in: Path, text: str, work: str
) -> None:
    (handed_in / "ann").mkdir()
    (handed_in / "ann" / "robot.py").write_text(text)
    assert sole_work(the_one(handed_in)) == work


def test_folders_and_archives_are_students(handed_in: Path) -> None:
    (handed_in / "Zoë Ünal").mkdir()
    (handed_in / "Zoë Ünal" / AGENT).write_bytes(b"1")
    zipped(handed_in / "bob.zip", **{f"week 1/{AGENT}": b"2"})
    tar_with(handed_in / "eve.tar.gz", (tarfile.TarInfo(f"./{AGENT}"), b"3"))
    tar_with(handed_in / "kim.tgz", (tarfile.TarInfo(AGENT), b"4"))
    tar_with(handed_in / "lea.tar", (tarfile.TarInfo(AGENT), b"5"))
    (handed_in / "grades.csv").write_text("not a student")
    (handed_in / "__MACOSX").mkdir()
    (handed_in / ".git").mkdir()

    students = find_students(handed_in, handed_in.parent / "scratch")

    assert [s.id for s in students] == ["Zoë Ünal", "bob", "eve", "kim", "lea"]
    assert [s.problem for s in students] == [""] * 5
    texts = [find_files(s, [AGENT]).files[AGENT].read_bytes() for s in students]
    assert texts == [b"1", b"2", b"3", b"4", b"5"]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("ann", "ann"),
        (unicodedata.normalize("NFD", "Änn Lee"), "Änn Lee"),
        ("..", "unnamed"),
        (".hidden", "hidden"),
        ("a/b\\c", "a_b_c"),
        ("a\nb\x1b[31m", "a_b_[31m"),
        ("\udcff", "?"),
        ("x" * 300, "x" * 80),
        ("aux", "_aux"),
        ("--checkpoint-action=exec=x", "checkpoint-action=exec=x"),
    ],
)
def test_ids_are_safe(name: str, expected: str) -> None:
    assert student_id(name) == expected.replace("?", "_")


def test_no_class(handed_in: Path) -> None:
    with pytest.raises(InputError, match="expected a folder or an archive"):
        find_students(handed_in, handed_in)
    with pytest.raises(InputError, match="nothing is there"):
        find_students(handed_in / "nowhere", handed_in)


@pytest.mark.parametrize("name", ["../evil.py", "/etc/evil.py", "C:\\evil.py", "a/../../evil.py"])
@pytest.mark.parametrize("kind", ["zip", "tar"])
def test_nothing_is_written_outside(handed_in: Path, name: str, kind: str) -> None:
    if kind == "zip":
        zipped(handed_in / "eve.zip", **{name: b"evil"})
    else:
        tar_with(handed_in / "eve.tar", (tarfile.TarInfo(name), b"evil"))

    student = the_one(handed_in)

    assert "points outside" in student.problem
    assert not list(handed_in.parent.rglob("evil.py"))
    assert find_files(student, [AGENT]).problem == student.problem


def test_links_and_devices_in_archives_are_left_out(handed_in: Path) -> None:
    link, hard, pipe = (tarfile.TarInfo(name) for name in ("link.py", "hard.py", "pipe.py"))
    link.type, link.linkname = tarfile.SYMTYPE, "/etc/passwd"
    hard.type, hard.linkname = tarfile.LNKTYPE, "/etc/passwd"
    pipe.type = tarfile.FIFOTYPE
    tar_with(
        handed_in / "eve.tar",
        (link, b""), (hard, b""), (pipe, b""), (tarfile.TarInfo(AGENT), b"1"),
    )  # fmt: skip
    student = the_one(handed_in)

    assert student.problem == ""
    assert [file.name for file in student.files] == [AGENT]
    assert [path.name for path in unpacked(handed_in)] == [AGENT]


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
    bomb = bytes(20 * 1024 * 1024)
    if suffix == ".zip":
        zipped(handed_in / "eve.zip", **{AGENT: bomb})
    else:
        tar_with(handed_in / "eve.tar.gz", (tarfile.TarInfo(AGENT), bomb))

    student = the_one(handed_in)

    assert "larger unpacked than packed" in student.problem
    assert sum(path.stat().st_size for path in handed_in.parent.rglob("agent.py")) <= unpack.SMALL


def test_bomb_in_what_is_skipped(handed_in: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unpack, "MAX_UNPACKED", 1024 * 1024)
    tar_with(handed_in / "eve.tgz", (tarfile.TarInfo(".git/pack"), bytes(8 * 1024 * 1024)))

    assert "not unpacked" in the_one(handed_in).problem


def test_too_many_members(handed_in: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unpack, "MAX_MEMBERS", 5)
    zipped(handed_in / "a.zip", **{f"{n}.py": b"" for n in range(6)})
    tar_with(handed_in / "b.tar", *[(tarfile.TarInfo(f"{n}.py"), b"") for n in range(6)])

    students = find_students(handed_in, handed_in.parent / "scratch")

    assert ["over 5 files" in s.problem for s in students] == [True, True]


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.zip", b""),
        ("a.zip", b"PK\x03\x04 cut off"),
        ("a.tar", b"\xff" * 2000),
        ("a.tar.gz", b"no gzip"),
        ("a.tgz", gzip.compress(b"no tar" * 500, mtime=0)),
        ("a.tar.gz", gzip.compress(bytes(10_000), mtime=0)[:-9]),
    ],
    ids=["empty", "cut zip", "no tar", "no gzip", "no tar in it", "cut gzip"],
)
def test_broken_archives(handed_in: Path, name: str, data: bytes) -> None:
    (handed_in / name).write_bytes(data)

    student = the_one(handed_in)
    problem = student.problem or find_files(student, [AGENT]).problem

    assert problem
    assert "\n" not in problem


def test_locked_archive(handed_in: Path) -> None:
    path = zipped(handed_in / "a.zip", **{AGENT: b"1"})
    data = bytearray(path.read_bytes())
    data[6] |= 1  # the flag "encrypted", in the member's header and in the directory's
    data[data.index(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(data)

    assert "password" in the_one(handed_in).problem


def test_an_archive_in_an_archive_is_unpacked_and_no_deeper(handed_in: Path) -> None:
    inner = zipped(handed_in.parent / "inner.zip", **{AGENT: b"1"}).read_bytes()
    deeper = zipped(handed_in.parent / "deeper.zip", **{"inner.zip": inner}).read_bytes()
    (handed_in / "ann_123_assignsubmission_file").mkdir()
    zipped(handed_in / "ann_123_assignsubmission_file" / "hw.zip", **{AGENT: b"1"})
    zipped(handed_in / "bob.zip", **{"inner.zip": inner})
    zipped(handed_in / "cy.zip", **{"deeper.zip": deeper})

    ann, bob, cy = find_students(handed_in, handed_in.parent / "scratch")

    assert find_files(ann, [AGENT]).files
    assert find_files(bob, [AGENT]).files
    assert "archives deeper inside are not unpacked" in find_files(cy, [AGENT]).problem


def test_the_file_nearest_to_the_top_counts(handed_in: Path) -> None:
    for where, text in (("ann/z", b"2"), ("ann/a/deep", b"3"), ("ann/.venv", b"4")):
        (handed_in / where).mkdir(parents=True)
        (handed_in / where / AGENT).write_bytes(text)

    found = find_files(the_one(handed_in), [AGENT])

    assert found.files[AGENT].read_bytes() == b"2"


@pytest.mark.parametrize("name", ["Agent.PY", "agent (1).py", "agent-2.py", "agent - Copy.py"])
def test_names_that_are_as_good(handed_in: Path, name: str) -> None:
    (handed_in / "ann").mkdir()
    (handed_in / "ann" / name).write_bytes(b"1")

    assert set(find_files(the_one(handed_in), [AGENT]).files) == {AGENT}


def test_a_wrong_name_is_told(handed_in: Path) -> None:
    (handed_in / "ann").mkdir()
    (handed_in / "ann" / "my\nrobot.py").write_bytes(b"1")
    (handed_in / "ann" / "notes.txt").write_bytes(b"1")

    problem = find_files(the_one(handed_in), [AGENT]).problem

    assert problem == r"expected a file agent.py; there is my\nrobot.py"


def test_other_files_come_from_beside_the_first(handed_in: Path) -> None:
    for where in ("a", "b"):
        (handed_in / "ann" / where).mkdir(parents=True)
        (handed_in / "ann" / where / "other.py").write_text(where)
    (handed_in / "ann" / "b" / AGENT).write_text("agent")

    found = find_files(the_one(handed_in), [AGENT, "other.py", "third.py"])

    assert {name: path.read_text() for name, path in found.files.items()} == {
        AGENT: "agent",
        "other.py": "b",
    }


def test_links_out_of_a_folder_are_not_followed(handed_in: Path, tmp_path: Path) -> None:
    secret = tmp_path / "secret.py"
    secret.write_text("secret")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / AGENT).write_text("secret")
    (handed_in / "eve").mkdir()
    (handed_in / "eve" / AGENT).symlink_to(secret)
    (handed_in / "eve" / "inside").symlink_to(tmp_path / "elsewhere")
    (handed_in / "mallory").symlink_to(tmp_path / "elsewhere")
    os.mkfifo(handed_in / "eve" / "pipe.py")

    eve, mallory = find_students(handed_in, tmp_path / "scratch")

    problem = find_files(eve, [AGENT]).problem
    assert problem == f"expected a file {AGENT}; there are no files (links are not followed)"
    assert "link" in mallory.problem
    with pytest.raises(OSError):
        read_regular_file(handed_in / "eve" / AGENT)
    with pytest.raises(OSError):
        read_regular_file(handed_in / "eve" / "pipe.py")


def test_no_more_is_read_than_tells_that_it_is_too_much(tmp_path: Path) -> None:
    (tmp_path / "big.py").write_bytes(b"#" * (MAX_SIZE + 10))

    assert len(read_regular_file(tmp_path / "big.py")) == MAX_SIZE + 1
