"""However folders and archives are called, every student of a class survives."""

import hashlib
import tempfile
import zipfile
from pathlib import Path

from hypothesis import example, given, settings
from hypothesis import strategies as st

from grader.classroom.intake.exercise_files import find_files
from grader.classroom.intake.handed_in import Student
from grader.classroom.intake.students import take_in

AGENT = "agent.py"
PIECES = (
    "ada", "ADA", "Ada", "~", "~5a3861", "5a3861", " ", ".", "_", "\u202e", "\n", "zoe\u0308",
    "zo\u00eb", "\u00df", "ss", "-", "0123456789", "x" * 90, "\udcff", "<", "?",
)  # fmt: skip
SUFFIXES = ("", ".zip", ".ZIP", ".tar")
NAMES = st.tuples(
    st.lists(st.sampled_from(PIECES), min_size=1, max_size=3).map("".join),
    st.sampled_from(SUFFIXES),
).map("".join)


def find_students(folder: Path, scratch: Path) -> list[Student]:
    return take_in([folder], scratch).students


def mark(name: str) -> str:
    return hashlib.sha256(name.encode()).hexdigest()[:6]


def hand_in(folder: Path, name: str, content: bytes) -> None:
    """Hand in a folder, or an archive if it is called so; archives of tar are empty."""
    path = Path(f"{folder}/{name}")
    if path.name.lower().endswith(".zip"):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(AGENT, content)
        return
    path.mkdir()
    (path / AGENT).write_bytes(content)


def usable(name: str) -> bool:
    return not name.startswith(".") and len(name.encode("utf-8", "surrogateescape")) < 250


@settings(max_examples=150, deadline=None)
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
        students = find_students(folder, Path(place, "scratch"))
        again = find_students(folder, Path(place, "again"))

        ids = [student.id for student in students]
        assert len({each.casefold() for each in ids}) == len(names)
        assert [student.id for student in again] == ids
        found = {find_files(student, [AGENT]).files[AGENT].read_bytes() for student in students}
        assert found == {b"#" + name.encode("utf-8", "surrogateescape") for name in names}


def test_a_mark_can_not_be_taken_by_choosing_a_name(tmp_path: Path) -> None:
    victim = f"ada~{mark('ada.zip')}"
    for name in ("ada", "ada.zip"):
        hand_in(tmp_path, name, name.encode())
    before = {s.id for s in find_students(tmp_path, tmp_path / ".scratch")}
    assert victim in before

    hand_in(tmp_path, victim, b"thief")
    after = {s.id: s for s in find_students(tmp_path, tmp_path / ".scratch")}
    assert before < after.keys()
    kept = find_files(after[victim], [AGENT]).files[AGENT]
    assert kept.read_bytes() == b"ada.zip"
