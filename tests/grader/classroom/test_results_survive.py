"""What fails in the results costs only itself: it is named, and everything else is written."""

from __future__ import annotations

import csv
import errno
import html
import importlib.util
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from grader.classroom.batch import GradedClass
from grader.classroom.progress import summary
from grader.classroom.results import Missing, ResultOptions, Written, exports, write, write_results
from grader.classroom.results import class_page as class_page_module
from grader.classroom.results import exercise_section as exercise_section_module
from grader.classroom.results.clean import folder_name
from grader.classroom.results.similarity import MOST, tokens
from grader.classroom.row import GRADED, StoredResult

_CLASSES = Path(__file__).resolve().parents[2] / "browser" / "classes.py"
_spec = importlib.util.spec_from_file_location("classes", _CLASSES)
assert _spec and _spec.loader
classes: Any = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(classes)

GRADEBOOKS = {  # the function that fails, and the files that it makes
    "scores_csv": ["scores.csv"],
    "canvas_csv": ["canvas/obstacle_avoidance.csv", "canvas/goal_seeking.csv"],
    "grades_csv": ["moodle/obstacle_avoidance.csv", "moodle/goal_seeking.csv"],
    "junit_xml": ["junit.xml"],
}
FILES = tuple(file for files in GRADEBOOKS.values() for file in files)
SECTIONS = ("_top", "_held", "_overview", "_students", "_notes")
PARTS = ("_scores", "_slowest", "_checks", "_similar", "item_analysis")
CODINGS = (
    b"# coding: rot13\n", b"# coding: undefined\n", b"# coding: idna\n", b"# coding: base64\n",
    b"# -*- coding: zlib -*-\n", b"\xef\xbb\xbf# coding: latin-1\n", b"#!/bin/sh\n# coding: mbcs\n",
    b"# coding: unicode_escape\nx = '\\", b"# coding: utf-16\nx = 1\n", b"# coding: punycode\n",
)  # fmt: skip


class Broken(Exception):
    """Something that nobody has thought of."""


def small_class() -> tuple[list[StoredResult], ResultOptions]:
    results, options = classes.whole_class()
    return [each for each in results if each.student in ("ada", "ben", "chen")], options


def broken(*_: object, **__: object) -> Any:
    raise Broken("this <b>part</b>")


@pytest.fixture
def whole(tmp_path: Path) -> Callable[[], tuple[Path, Written, str]]:
    def written() -> tuple[Path, Written, str]:
        results, options = small_class()
        done = write_results(results, tmp_path, options)
        return tmp_path, done, (tmp_path / "class.html").read_text("utf-8")

    return written


def everything(out: Path) -> set[str]:
    return {p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()}


@pytest.mark.parametrize("name", GRADEBOOKS)
def test_a_gradebook_that_fails_costs_only_itself(
    name: str, whole: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, complete, _ = whole()
    before = everything(out)
    assert complete.missing == []
    monkeypatch.setattr(exports, name, broken)

    out, written, page = whole()

    lost = GRADEBOOKS[name]
    assert written.missing == [Missing(file, "Broken: this <b>part</b>") for file in lost]
    assert everything(out) == before - set(lost)  # an old one would be taken for new
    assert f"{lost[0]}: Broken: this &lt;b&gt;part&lt;/b&gt;" in page
    assert "Not all results could be written" in page

    monkeypatch.undo()
    out, written, page = whole()
    assert written.missing == []
    assert everything(out) == before
    assert "Not all results" not in page


@pytest.mark.parametrize("name", SECTIONS)
def test_a_section_that_fails_costs_only_itself(
    name: str, whole: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, _, before = whole()
    monkeypatch.setattr(class_page_module, name, broken)
    out, written, page = whole()

    (missing,) = written.missing
    assert "class.html" in missing.part
    assert str(missing) in html.unescape(page)
    for heading in ("Overview", "Students", "Notes of the batch", "Checks, the most failed first"):
        assert heading in page
    assert page.count("<section") >= before.count("<section")
    assert all((out / file).is_file() for file in FILES)


@pytest.mark.parametrize("name", PARTS)
def test_a_part_of_an_exercise_that_fails_costs_only_itself(
    name: str, whole: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exercise_section_module, name, broken)
    _, written, page = whole()

    assert len(written.missing) == 2  # one in each exercise
    assert page.count("The grader could not make this part") == 2
    headings = ("Scores", "Slowest gradings", "Nearly the same")
    assert all(page.count(f"<h3>{heading}</h3>") == 2 for heading in headings)


def test_a_class_page_that_fails_as_a_whole_still_says_what_is_missing(
    whole: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(write, "class_page", broken)
    out, written, page = whole()

    assert [each.part for each in written.missing] == ["class.html"]
    assert "class.html: Broken" in page
    assert all((out / file).is_file() for file in FILES)
    assert (out / "feedback" / "ada" / "obstacle_avoidance.html").is_file()


def test_a_feedback_page_that_fails_costs_only_itself(
    whole: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, _, _ = whole()
    before, real = everything(out), write.exercise_page
    monkeypatch.setattr(
        write,
        "exercise_page",
        lambda result, *rest: broken() if result.student == "ada" else real(result, *rest),
    )
    (out / ".pages.json").unlink()
    out, written, page = whole()

    assert {each.part for each in written.missing} == {
        "the feedback page of ada in 1 · Obstacle avoidance",
        "the feedback page of ada in 3 · Goal seeking",
    }
    assert everything(out) == before
    shown = (out / "feedback" / "ada" / "obstacle_avoidance.html").read_text("utf-8")
    assert "The grader could not make the page with your checks" in shown
    assert "the feedback page of ada in 3" in page

    monkeypatch.undo()
    out, written, _ = whole()  # a lost page is made again, though nothing in it has changed
    assert written.missing == []
    shown = (out / "feedback" / "ada" / "obstacle_avoidance.html").read_text("utf-8")
    assert "The grader could not make" not in shown


@pytest.mark.parametrize("name", ["index_page", "results_json"])
def test_other_files_of_a_student_fail_alone(
    name: str, whole: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, _, _ = whole()
    before = everything(out)
    room = write if name == "index_page" else exports
    real = getattr(room, name)

    def fails(*given: Any) -> Any:
        whose = given[0] if name == "index_page" else given[0][0].student
        return broken() if whose == "ada" else real(*given)

    monkeypatch.setattr(room, name, fails)
    out, written, _ = whole()

    assert len(written.missing) == 1
    assert "of ada" in written.missing[0].part
    lost = {"gradescope/ada/results.json"} if name == "results_json" else set()
    assert everything(out) == before - lost


def make(page: Any) -> list[Missing]:
    if page.result.student == "ada":
        os._exit(9)
    page.path.write_text("made")
    return []


def test_a_page_that_kills_its_process_costs_only_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    results, options = small_class()
    monkeypatch.setattr(write, "MANY", 1)
    monkeypatch.setattr(write._Page, "make", make)
    monkeypatch.setattr(write.multiprocessing, "get_context", lambda _: _forked())
    written = write_results(results, tmp_path, replace(options, workers=2))

    assert {each.why for each in written.missing} == {"its process died while making it"}
    assert len(written.missing) == 2
    graded = [r for r in results if r.state == GRADED and r.student == "ben"]
    assert graded
    assert (tmp_path / "feedback" / "ben" / "obstacle_avoidance.html").read_text() == "made"


def _forked() -> Any:
    import multiprocessing.context  # noqa: PLC0415  (so that the patch above is inherited)

    return multiprocessing.context.ForkContext()


@pytest.mark.parametrize(
    "odd",
    [
        {"score": [], "checks": 7},
        {"checks": [{"id": "a", "outcome": [], "points": {}}], "versions": 3},
        {"versions": [1], "checks": [{"id": "a", "max_points": "x", "outcome": "pass"}]},
    ],
)
def test_a_stored_grading_that_is_nonsense_is_held(odd: dict[str, Any], tmp_path: Path) -> None:
    results, options = small_class()
    first = next(r for r in results if r.state == GRADED)
    changed = [replace(r, grading=odd) if r is first else r for r in results]
    written = write_results(changed, tmp_path, options)

    rows = list(csv.reader((tmp_path / "scores.csv").read_text("utf-8-sig").splitlines()))
    assert len(rows) > len(results) - 5
    assert written.missing
    assert all(first.student in each.part or "class.html" in each.part for each in written.missing)


def test_a_full_disk_is_no_missing_part(whole: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> str:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(exports, "junit_xml", full)
    with pytest.raises(OSError, match="No space left"):
        whole()


def test_the_terminal_names_what_is_missing(tmp_path: Path) -> None:
    lines, held = summary(GradedClass([], [Missing("scores.csv", "KeyError: 'a'")]), tmp_path)
    assert "  missing: scores.csv: KeyError: 'a'" in lines.splitlines()
    assert held == 0


@pytest.mark.parametrize("first", CODINGS)
def test_no_first_line_stops_the_search_for_similar_files(first: bytes) -> None:
    assert isinstance(tokens(first + b"import rclpy\nprint('\xff')\n"), list)


@pytest.mark.parametrize("unit", [b"(", b"$", b"\\\n", b"a ", b"\0", b"0_", b"'''\n"])
def test_no_file_takes_long_to_compare(unit: bytes) -> None:
    assert len(tokens(unit * (1024 * 1024 // len(unit)))) <= MOST


def test_nobody_can_choose_a_name_that_leads_to_anothers_folder() -> None:
    unsafe = "Zoë"
    copied = folder_name(unsafe)
    assert folder_name(copied) != copied
