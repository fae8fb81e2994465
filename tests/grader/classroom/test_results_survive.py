"""What fails in the results costs only itself: it is named, and everything else is written."""

from collections.abc import Callable
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from made_results import classes

from grader.classroom.batch import GradedClass
from grader.classroom.results import feedback, write
from grader.classroom.results.write import Written, write_results
from grader.cli.batch import summary
from grader.errors import GraderError
from grader.lms.platforms import PLATFORMS


class Broken(Exception):
    """Something that nobody has thought of."""


def broken(*_: object, **__: object) -> Any:
    raise Broken("this <b>part</b>")


@pytest.fixture
def whole(tmp_path: Path) -> Callable[[], tuple[Path, Written, str]]:
    results, options = classes.whole_class()

    def written() -> tuple[Path, Written, str]:
        some = [each for each in results if each.student in ("ada", "ben", "chen")]
        done = write_results(some, tmp_path, options)
        return tmp_path, done, (tmp_path / "class.html").read_text("utf-8")

    return written


def everything(out: Path) -> set[str]:
    return {p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()}


def test_a_gradebook_that_fails_costs_only_its_platforms_files(
    whole: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, complete, _ = whole()
    before = everything(out)
    assert complete.missing == []
    monkeypatch.setattr(
        write,
        "PLATFORMS",
        [replace(p, gradebook=broken) if p.name == "Canvas" else p for p in PLATFORMS],
    )
    out, written, page = whole()

    assert written.missing == ["Canvas's files: Broken: this <b>part</b>"]
    # an old one would be taken for new
    assert everything(out) == {file for file in before if not file.startswith("canvas/")}
    assert "Canvas&#39;s files: Broken: this &lt;b&gt;part&lt;/b&gt;" in page
    assert "Not all results could be written" in page

    monkeypatch.undo()
    out, written, page = whole()
    assert written.missing == []
    assert everything(out) == before
    assert "Not all results" not in page


def test_a_class_page_that_fails_still_says_what_is_missing(
    whole: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(write, "class_page", broken)
    out, written, page = whole()

    assert [each.partition(":")[0] for each in written.missing] == ["class.html"]
    assert "class.html: Broken" in page
    assert (out / "scores.csv").is_file()
    assert (out / "feedback" / "ada" / "obstacle_avoidance.html").is_file()


@pytest.mark.parametrize("name", ["exercise_page", "index_page"])
def test_a_student_whose_pages_fail_is_alone(
    name: str, whole: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, _, _ = whole()
    before = everything(out)
    for page in (out / "feedback" / "ada").glob("*.html"):
        page.unlink()
    room = feedback if name == "exercise_page" else write
    real = getattr(room, name)

    def fails(whose: Any, *rest: Any) -> Any:
        is_ada = "ada" in (whose, getattr(whose, "student", ""))
        return broken() if is_ada else real(whose, *rest)

    monkeypatch.setattr(room, name, fails)
    out, written, page = whole()

    assert written.missing == ["the feedback of ada: Broken: this <b>part</b>"]
    assert "the feedback of ada" in page
    assert {file for file in before - everything(out) if "ada" not in file} == set()
    assert "could not make these pages" in (out / "feedback" / "ada" / "index.html").read_text()

    monkeypatch.undo()
    out, written, _ = whole()
    assert written.missing == []
    assert everything(out) == before


def test_the_terminal_names_what_is_missing(tmp_path: Path) -> None:
    lines, held = summary(GradedClass([], ["scores.csv: KeyError: 'a'"]), tmp_path)
    assert "  missing: scores.csv: KeyError: 'a'" in lines.splitlines()
    assert held == 0


def test_a_process_that_is_ended_from_outside_is_no_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    results, options = classes.whole_class()

    def gone(*_: object) -> Any:
        raise BrokenProcessPool("gone")

    monkeypatch.setattr(write.ProcessPoolExecutor, "map", gone)
    monkeypatch.setattr(write, "MANY", 1)
    with pytest.raises(GraderError, match=f"ended from outside.*course marks write {tmp_path}"):
        write_results(results, tmp_path, replace(options, workers=2))
