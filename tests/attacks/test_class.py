"""A class of hostile submissions ends with all its results, on this machine or on a full disk.

`make test` grades those that aim at the reporting; `COURSE_ATTACKS=full` (`make attacks`) sends
every hostile file through `course autograde`, with honest ones among them.
"""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from arena import EXERCISE, FULL, HERE, HOSTILE, ROOT

from grader.classroom.row import GRADED, StoredResult
from grader.classroom.store import Store

FILE = EXERCISE.files[0]
HONEST = (EXERCISE.solutions / FILE).read_text("utf-8")
COURSE = [sys.executable, "-m", "grader.cli", "autograde"]
LIMIT = 3600  # [s]
# What they are worth, at most, comes from the arena's tests; here it is what becomes of the others.
REPORTING = {
    "coding rot13": b"# coding: rot13\n",
    "coding undefined": b"# coding: undefined\nimport rclpy\n",
    "coding idna": b"#!/usr/bin/env python3\n# -*- coding: idna -*-\n",
    "coding base64": b"# coding: base64\naW1wb3J0\n",
    "coding of nothing": b"# coding: \x1b[31m<b>\n",
    "two encodings": b"\xef\xbb\xbf# coding: latin-1\nimport rclpy\n",
    "not UTF-8": "# Zoë\nimport rclpy\n".encode("latin-1"),
    "null bytes": b"import rclpy\0\n" * 100,
    "brackets": b"(" * 200_000,
    "deep blocks": b"".join(b" " * i + b"if 1:\n" for i in range(120)),
    "errors only": b"$" * 900_000,
    "huge name": b"a" * 900_000 + b"\n",
    "surrogates": b"raise SystemExit('\\ud800\\udfff \\x1b[31m </script><b>')\n",
    "name of an error": b"class Evil(Exception):\n    def __str__(self): raise Evil\nraise Evil\n",
    "=1+1": b"raise ValueError('=cmd|calc!A0')\n",
}


def kit() -> str:
    """Return what puts the hostile files' kit in front of them: here each is one file."""
    texts = {name: (HERE / f"{name}.py").read_text("utf-8") for name in ("kit", "seeing")}
    return (
        "import sys as _s, types as _t\n"
        f"for _n, _x in {texts!r}.items():\n"
        "    _m = _s.modules[_n] = _t.ModuleType(_n)\n"
        "    _m.__file__ = __file__\n"
        "    exec(_x, _m.__dict__)\n"
    )


def hand_in(folder: Path, name: str, content: bytes) -> None:
    (folder / name).mkdir(parents=True)
    (folder / name / FILE).write_bytes(content)


def command(folder: Path, out: Path, *options: str) -> list[str]:
    given = ("--exercise", EXERCISE.slug, "--canaries", "0", "--trust")
    return [*COURSE, str(folder), "--out", str(out), *given, *options]


def stored(out: Path) -> dict[str, StoredResult]:
    with Store(out / "store.sqlite") as store:
        return {result.student: result for result in store.results()}


def assert_complete(out: Path, students: list[str]) -> None:
    """Make sure that the class page, each gradebook and everybody's feedback are there."""
    page = (out / "class.html").read_text("utf-8")
    assert "Not all results could be written" not in page
    rows = list(csv.DictReader((out / "scores.csv").read_text("utf-8-sig").splitlines()))
    assert sorted(row["student"].lstrip("'") for row in rows) == sorted(students)
    for name in ("canvas.csv", "moodle.csv", "junit.xml"):
        assert (out / name).stat().st_size > 0
    assert len(list((out / "feedback").glob("*/index.html"))) == len(students)
    graded = [one for one in stored(out).values() if one.state == GRADED]
    assert len(list((out / "feedback").glob(f"*/{EXERCISE.slug}.html"))) == len(graded)
    assert len(list((out / "gradescope").glob("*/results.json"))) == len(graded)


@pytest.mark.parametrize("workers", [2])
def test_what_aims_at_the_reporting(workers: int, tmp_path: Path) -> None:
    for name, content in REPORTING.items():
        hand_in(tmp_path / "in", name, content)
    hand_in(tmp_path / "in", "honest", HONEST.encode())
    out = tmp_path / "out"
    done = subprocess.run(
        command(tmp_path / "in", out, "--workers", str(workers)),
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip

    assert done.returncode == 0, done.stdout + done.stderr
    assert "\x1b" not in done.stdout
    assert_complete(out, [*REPORTING, "honest"])
    grading = stored(out)["honest"].grading
    assert grading is not None
    assert grading["score"] == 100
    scores = {name: one.grading["score"] for name, one in stored(out).items() if one.grading}
    assert {scores[name] for name in REPORTING} == {0}


@pytest.mark.skipif(not FULL, reason="every hostile file, for an hour: make attacks")
def test_every_hostile_file_in_one_class(tmp_path: Path) -> None:
    for path in HOSTILE:
        text = path.read_text("utf-8")
        hand_in(tmp_path / "in", path.stem, (kit() + text).encode())
    for number in range(3):
        hand_in(tmp_path / "in", f"honest{number}", f"# {number}\n{HONEST}".encode())
    out = tmp_path / "out"
    done = subprocess.run(
        command(tmp_path / "in", out, "--workers", "2"),
        capture_output=True, text=True, check=False, cwd=ROOT, timeout=LIMIT,
    )  # fmt: skip

    students = [*(path.stem for path in HOSTILE), *(f"honest{number}" for number in range(3))]
    assert done.returncode in (0, 1), done.stdout + done.stderr
    assert_complete(out, students)
    for number in range(3):
        grading = stored(out)[f"honest{number}"].grading
        assert grading is not None
        assert grading["score"] == 100


def mounted(*steps: list[str], place: Path, size: str) -> subprocess.CompletedProcess[str]:
    """Run steps with a disk of that size at `place`, which only they see."""
    script = [f"mount -t tmpfs -o size={size} none {place} || exit 9"]
    script += [" ".join(f"'{word}'" for word in step) + "; echo exit code $?" for step in steps]
    rights = [] if os.getuid() == 0 else ["--map-root-user"]
    return subprocess.run(
        ["unshare", "--mount", *rights, "sh", "-c", "\n".join(script)],
        capture_output=True, text=True, check=False, cwd=ROOT,
    )  # fmt: skip


def test_a_full_disk_ends_the_batch_and_the_next_run_goes_on(tmp_path: Path) -> None:
    place, taken = tmp_path / "disk", tmp_path / "taken"
    place.mkdir()
    if shutil.which("unshare") is None or mounted(["true"], place=place, size="1m").returncode:
        pytest.skip("no mounts on this machine")
    for name in ("ann", "bob", "eve"):
        hand_in(tmp_path / "in", name, f"# {name}\n{HONEST}".encode())
    batch = command(tmp_path / "in", place / "out")
    done = mounted(
        batch,
        ["mount", "-o", "remount,size=200m", str(place)],
        batch,
        ["cp", "-r", str(place / "out"), str(taken)],
        place=place,
        size="2m",
    )  # two gradings with their recordings don't fit

    first, _, second, _ = (line for line in done.stdout.splitlines() if line.startswith("exit"))
    assert (first, second) == ("exit code 2", "exit code 0"), done.stdout + done.stderr
    (said,) = done.stderr.splitlines()
    assert "the disk is full" in said
    assert "run the same command again" in said
    assert_complete(taken, ["ann", "bob", "eve"])
    gradings = [one.grading for one in stored(taken).values()]
    assert [grading and grading["score"] for grading in gradings] == [100, 100, 100]
