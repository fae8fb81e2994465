"""A class of submissions that aim at the reporting ends with all its results."""

import csv
import subprocess
from pathlib import Path

import pytest
import reporting
from arena import EXERCISE, FULL, ROOT
from whole_class import COURSE, hand_in

from grader.classroom.queue.store import Store
from grader.classroom.row import GRADED

FILE = EXERCISE.files[0]
HONEST = (EXERCISE.solutions / FILE).read_bytes()
LIMIT = 3600  # [s]
MAX_PAGE = 8 * 1024 * 1024  # [bytes] of a feedback page, whatever a node says and does
SOME = ("quotes", "coding rot13", "surrogates", "null bytes", "unseen log", "no XML")


def assert_complete(out: Path) -> None:
    """Make sure that the class page, each gradebook and everybody's feedback are there."""
    page = (out / "class.html").read_text("ascii")
    assert "Not all results could be written" not in page
    with Store(out / "store.sqlite") as store:
        results = store.results()
    students = {one.student for one in results}
    rows = list(csv.DictReader((out / "scores.csv").read_text("utf-8-sig").splitlines()))
    assert len(rows) == len(results)
    formulas = [value for row in rows for value in row.values() if value[:1] in ("=", "+", "@")]
    assert not formulas
    gradebooks = list((out / "canvas").glob("*.csv"))
    assert gradebooks
    for file in gradebooks:
        assert len(file.read_text("utf-8").splitlines()) > 1
    assert len(list((out / "feedback").glob("*/index.html"))) == len(students)
    graded = [one for one in results if one.state == GRADED]
    pages = [path for path in (out / "feedback").glob("*/*.html") if path.name != "index.html"]
    assert len(pages) == len(graded)
    assert max(path.stat().st_size for path in pages) < MAX_PAGE


@pytest.mark.long
@pytest.mark.parametrize(
    "names",
    [
        SOME,
        pytest.param(
            tuple(reporting.submissions()),
            marks=pytest.mark.skipif(not FULL, reason="all of them: make attacks"),
        ),
    ],
    ids=["some", "all"],
)
def test_what_aims_at_the_reporting(names: tuple[str, ...], tmp_path: Path) -> None:
    files, folder, out = reporting.submissions(), tmp_path / "in", tmp_path / "out"
    for name in names:
        hand_in(folder, name, {FILE: files[name]})
    for name in reporting.NAMES[: len(names)]:
        hand_in(folder, name, {FILE: b"=1"})
    hand_in(folder, "honest", {FILE: HONEST})
    done = subprocess.run(
        [*COURSE, folder, "--out", out, "--exercise", EXERCISE.slug, "--workers", "2",
         "--canaries", "0", "--trust"],
        capture_output=True, text=True, check=False, cwd=ROOT, timeout=LIMIT,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.replace("\n", "").isprintable()
    assert_complete(out)
    with Store(out / "store.sqlite") as store:
        gradings = {one.student: one.grading for one in store.results() if one.attempts}
    assert gradings.pop("honest")["score"] == 100
    assert max(grading["score"] for grading in gradings.values()) <= 20
