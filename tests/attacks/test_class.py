"""A class of hostile submissions ends with all its results, and costs honest ones nothing.

`make test-long` grades a few that aim at the reporting. `make attacks` (`COURSE_ATTACKS=full`)
grades all of these, and sends every hostile file through `course autograde`, with honest
submissions among them, for one worker and for two.
"""

import csv
import json
import subprocess
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import reporting
from arena import EXERCISE, FULL, HOSTILE, ROOT
from whole_class import COURSE, hand_in, hand_in_hostile, honest

from grader.classroom.row import GRADED, StoredResult
from grader.classroom.store import Store, stable

FILE = EXERCISE.files[0]
HONEST = (EXERCISE.solutions / FILE).read_bytes()
LIMIT = 3600  # [s]
MAX_PAGE = 8 * 1024 * 1024  # [bytes] of a feedback page, whatever a node says and does
SOME = ("quotes", "coding rot13", "surrogates", "null bytes", "unseen log", "no XML")
Key = tuple[str, str]


def run_batch(folder: Path, out: Path, *options: str) -> subprocess.CompletedProcess[str]:
    given = ("--canaries", "0", "--trust", *options)
    return subprocess.run(
        [*COURSE, str(folder), "--out", str(out), *given],
        capture_output=True, text=True, check=False, cwd=ROOT, timeout=LIMIT,
    )  # fmt: skip


def stored(out: Path) -> dict[Key, StoredResult]:
    """Return what was handed in and graded or held, by student and exercise."""
    with Store(out / "store.sqlite") as store:
        results = store.results()
    return {(one.student, one.exercise): one for one in results if one.attempts}


def verdicts(out: Path, students: Iterable[str]) -> dict[Key, str]:
    wanted = set(students)
    return {key: json.dumps(stable(one)) for key, one in stored(out).items() if key[0] in wanted}


def assert_complete(out: Path) -> None:
    """Make sure that the class page, each gradebook and everybody's feedback are there."""
    page = (out / "class.html").read_text("ascii")
    assert "Not all results could be written" not in page
    with Store(out / "store.sqlite") as store:
        results = [one for one in store.results() if not one.canary]
    students = {one.student for one in results}
    rows = list(csv.DictReader((out / "scores.csv").read_text("utf-8-sig").splitlines()))
    assert len(rows) == len(results)
    formulas = [value for row in rows for value in row.values() if value[:1] in ("=", "+", "@")]
    assert not formulas
    for name in ("canvas", "moodle"):
        for file in (out / name).glob("*.csv"):
            assert len(file.read_text("utf-8").splitlines()) > 1
        assert list((out / name).iterdir())
    suites = ET.parse(out / "junit.xml").getroot().findall("testsuite")
    assert len(suites) == len(results)
    assert len(list((out / "feedback").glob("*/index.html"))) == len(students)
    graded = [one for one in results if one.state == GRADED]
    pages = [path for path in (out / "feedback").glob("*/*.html") if path.name != "index.html"]
    assert len(pages) == len(graded)
    assert max(path.stat().st_size for path in pages) < MAX_PAGE


def assert_survives_the_reporting(folder: Path, out: Path) -> None:
    hand_in(folder, "honest", {FILE: HONEST})
    done = run_batch(folder, out, "--exercise", EXERCISE.slug, "--workers", "2")
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.replace("\n", "").isprintable()
    assert_complete(out)
    gradings = {one.student: one.grading for one in stored(out).values()}
    assert gradings.pop("honest")["score"] == 100
    assert max(grading["score"] for grading in gradings.values()) <= 20


@pytest.mark.long
def test_some_that_aim_at_the_reporting(tmp_path: Path) -> None:
    files = reporting.submissions()
    for name in SOME:
        hand_in(tmp_path / "in", name, {FILE: files[name]})
    for name in reporting.NAMES[:6]:
        hand_in(tmp_path / "in", name, {FILE: b"=1"})
    assert_survives_the_reporting(tmp_path / "in", tmp_path / "out")


@pytest.mark.long
@pytest.mark.skipif(not FULL, reason="all that aim at the reporting: make attacks")
def test_all_that_aim_at_the_reporting(tmp_path: Path) -> None:
    for name, content in reporting.submissions().items():
        hand_in(tmp_path / "in", name, {FILE: content})
    for name in reporting.NAMES:
        hand_in(tmp_path / "in", name, {FILE: b"=1"})
    assert_survives_the_reporting(tmp_path / "in", tmp_path / "out")


# --- honest ones among hostile ones ----------------------------------------------------------


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> dict[Key, str]:
    """What honest submissions are worth when they are graded one by one, with nobody else."""
    folder = tmp_path_factory.mktemp("alone")
    for student, files in honest().items():
        hand_in(folder / "in", student, files)
    run_batch(folder / "in", folder / "out", "--workers", "1", "--no-bags")
    found = verdicts(folder / "out", honest())
    assert len(found) == len(honest())
    return found


@pytest.mark.long
@pytest.mark.skipif(not FULL, reason="every hostile file at once: make attacks")
@pytest.mark.parametrize("workers", [1, 2])
def test_honest_ones_among_hostile_ones(
    workers: int, alone: dict[Key, str], tmp_path: Path
) -> None:
    students = hand_in_hostile(tmp_path / "in", HOSTILE, FILE)
    for student, files in honest().items():
        hand_in(tmp_path / "in", student, files)
    out = tmp_path / "out"
    done = run_batch(tmp_path / "in", out, "--workers", str(workers))

    assert done.returncode in (0, 1), done.stdout + done.stderr  # 1 if a person has to look
    assert {student for student, _ in stored(out)} == {*students, *honest()}
    assert verdicts(out, honest()) == alone
    assert_complete(out)
