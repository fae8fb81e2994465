"""With `--hide`, nothing of what a node said, did or met in a hidden trial reaches its student.

A node says a watermark through each of its channels. It is in nothing that is written for students,
and two nodes that differ in nothing but watermark, numbers and times get the same bytes.
"""

import base64
import io
import json
import re
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from arena import EXERCISE
from classes import stored

from grader.classroom.autograder import composed
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.write import write_results
from grader.classroom.row import StoredResult
from grader.course.students import student_key
from grader.course.submission import Submission
from grader.grading.grading import grade_submission
from grader.lms.book import Handed, StudentRow
from grader.nbgrader.cells import Wanted
from grader.nbgrader.judge import judge
from grader.nbgrader.marks import mark_of
from grader.nbgrader.table import output_of
from rclpy_virtual_time.link.hosts import ForkServer

NODE = Path(__file__).resolve().parent / "withheld" / "watermark.py"
KEY = student_key(b"a secret of a course", "ada", EXERCISE.slug)
ONLY = ("wiring", "clear_zone", "stop_zone")
MARKS = (("Xq7Zk_watermark_Vw3", 0.3172, 3), ("Yb", 0.2911, 5))  # words, numbers, times and sizes
ENDS = {  # how its trials end
    "raises": "exception", "in a function": "exception", "exits": "exited", "hangs": "hung",
    "goes on": "completed",
}  # fmt: skip
DEEP = 4  # layers of encodings


def graded(
    ends: str, mark: tuple[str, float, int], forkserver: ForkServer, folder: Path
) -> StoredResult:
    text = NODE.read_text().replace('"MARK", 0.125, 3, "raises"', f"{mark!r}"[1:-1] + f", {ends!r}")
    folder.mkdir()
    node = folder / EXERCISE.files[0]
    node.write_text(text)
    made = grade_submission(
        EXERCISE, Submission(node), forkserver, file=node.name, only=ONLY, seed=KEY,
        bags=folder / "bags",
    )  # fmt: skip
    return stored(
        "ada", EXERCISE.slug, made.as_dict(), recordings=folder / "bags", wall_s=10.0 * mark[2],
        attempts=mark[2], problem=mark[0], finished=f"2026-01-01T00:00:0{mark[2]}Z",
    )  # fmt: skip


def for_the_student(result: StoredResult, hide: str, out: Path) -> dict[str, bytes]:
    """Return what the student gets, by channel."""
    options = ResultOptions(
        hide=hide,
        students={"ada": StudentRow("ada", handed={EXERCISE.slug: Handed("moodle", "Ada", "7")})},
        published={("ada", EXERCISE.slug)},
    )
    write_results([result], out, options)
    places = ("feedback", "published", "moodle", "canvas", "gradescope")
    found = {
        path.relative_to(out).as_posix(): path.read_bytes()
        for place in places
        for path in sorted((out / place).rglob("*"))
        if path.is_file()
    }
    assert any(name.endswith("-feedback.zip") for name in found)
    for name in [name for name in found if name.endswith(".zip")]:
        with zipfile.ZipFile(io.BytesIO(found.pop(name))) as zipped:
            found |= {f"{name}/{each}": zipped.read(each) for each in zipped.namelist()}
    found["results.json"] = json.dumps(composed([result], [], options.hidden)).encode()
    with pytest.MonkeyPatch.context() as graded_already:
        graded_already.setattr("grader.nbgrader.judge.grade_files", lambda *_, **__: result.grading)
        seed = None if hide == "nothing" else KEY  # nbgrader hides what only a secret tells
        verdict = judge(EXERCISE, dict.fromkeys(result.file_names, ""), seed=seed)
    mark = mark_of(Wanted(EXERCISE.slug, ()), verdict, 100.0)
    found["notebook"] = json.dumps(output_of(mark, 100.0)).encode()
    return found


def holds(data: bytes, mark: str, deep: int = DEEP) -> bool:
    """Return whether data have a mark, encoded or packed in whatever way."""
    plain = mark.encode()
    wanted = [plain, plain[::-1], mark.encode("utf-16-le"), plain.hex().encode()]
    wanted += [base64.b64encode(bytes(i) + plain)[4 if i else 0 : -4] for i in range(3)]
    low = data.lower()
    if any(each.lower() in low for each in wanted):
        return True
    return deep > 0 and any(holds(each, mark, deep - 1) for each in _unpacked(data))


def _unpacked(data: bytes) -> Iterator[bytes]:
    if data[:2] == b"PK":
        with zipfile.ZipFile(io.BytesIO(data)) as zipped:
            yield from (zipped.read(name) for name in zipped.namelist())
    for start in re.finditer(rb"\x1f\x8b\x08|\x78[\x01\x5e\x9c\xda]", data):
        try:
            yield zlib.decompressobj(47).decompress(data[start.start() :], 10**7)
        except zlib.error:
            continue
    for text in re.findall(rb"[A-Za-z0-9+/_-]{24,}", data):
        padded = text.translate(bytes.maketrans(b"-_", b"+/")) + b"=="
        for start in range(4):
            yield base64.b64decode(padded[start : start + (len(padded) - start) // 4 * 4])
    for text in re.findall(rb"(?:[0-9a-f]{2}){12,}", data.lower()):
        yield bytes.fromhex(text.decode())


@pytest.mark.parametrize(
    "ends",
    [
        "raises",  # at its end: until then it says as much as one that goes on
        *(
            pytest.param(each, marks=pytest.mark.long)
            for each in ("goes on", "in a function", "exits", "hangs")
        ),
    ],
)
def test_a_watermark_reaches_no_student(ends: str, forkserver: ForkServer, tmp_path: Path) -> None:
    one, other = (graded(ends, mark, forkserver, tmp_path / mark[0]) for mark in MARKS)
    assert one.grading and other.grading
    outcomes = [[c["outcome"] for c in each.grading["checks"]] for each in (one, other)]
    assert outcomes[0] == outcomes[1]  # the one thing that a student learns
    assert "fail" in outcomes[0]
    assert ENDS[ends] in {run["outcome"] for run in one.grading["recordings"]}
    word, number, _ = MARKS[0]

    open_ = for_the_student(one, "nothing", tmp_path / "open")
    assert any(holds(data, word) for data in open_.values())  # so the search finds it
    for hide in ("worlds", "details", "worlds,field"):
        theirs = for_the_student(one, hide, tmp_path / hide)
        assert theirs.keys() == open_.keys()
        found = [name for name, data in theirs.items() if holds(data, word)]
        assert not found, hide
        assert not [name for name, data in theirs.items() if str(number).encode() in data]
        assert theirs == for_the_student(other, hide, tmp_path / f"{hide} of the other")


@pytest.mark.parametrize(
    "encode",
    [
        lambda d: d, lambda d: d[::-1], lambda d: d.hex().upper().encode(), base64.b64encode,
        zlib.compress, lambda d: base64.b64encode(b"xy" + d), base64.urlsafe_b64encode,
        lambda d: base64.b64encode(zlib.compress(d)), lambda d: zlib.compress(d[::-1]),
        lambda d: b"a" + zlib.compress(base64.b64encode(zlib.compress(d)).hex().encode()),
    ],
)  # fmt: skip
def test_the_search_finds_what_is_encoded(encode: Any) -> None:
    word = MARKS[0][0]
    assert holds(b"<p>" + encode(f"..{word}..".encode()) + b"</p>", word)
