"""What is written of a class: right formats, hostile names and messages, the same bytes again."""

import csv
import io
import json
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from made_results import OBSTACLES, book, check, classes, for_gradescope, result

from grader.classroom.amendments.marks import points_of, tasks_of, why_held
from grader.classroom.results import write
from grader.classroom.results.items import distribution, failures
from grader.classroom.results.options import ResultOptions
from grader.classroom.results.scores import scores_csv
from grader.classroom.results.write import write_results
from grader.classroom.row import HELD, RUNNING, StoredResult
from grader.lms.canvas import canvas_csv
from grader.lms.clean import cell, one_line, visible

FORMULAS = (
    "=1+1", "+1+1", "-A1", "@SUM(A1)", "\t=1", "\r=1", "\n=1", "  =1", "\uff1d1", "\u202e=1",
)  # fmt: skip
TEXTS = ("-1", "+49", "-1.5", "%0A", "|x", "a=b", "ada")  # which no spreadsheet runs
GRADEBOOKS = ("canvas/obstacle_avoidance.csv", "canvas/goal_seeking.csv")


def right(student: str, **parts: Any) -> StoredResult:
    return result(student, check("a", "pass", 60), check("b", "pass", 40), **parts)


def rows(text: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(text, newline="")))


# --- text made harmless --------------------------------------------------------------------


def test_formulas_are_changed_and_nothing_else() -> None:
    assert [text for text in FORMULAS if not cell(text).startswith("'")] == []
    assert [text for text in TEXTS if cell(text) != text] == []


def test_what_is_seen_has_no_control_characters() -> None:
    assert visible("a\x1b[31mb\x1b]0;title\x07c\x00\u202ed\r\ne\ufffe\ud800") == "abcd\ne"
    assert len(one_line("y" * 1000)) <= 120
    assert one_line(" a\n\tb ") == "a b"


# --- what counts ---------------------------------------------------------------------------


def test_held_gradings_have_no_points_anywhere() -> None:
    stalled = result("ada", check("a", "pass", 60), check("b", "inconclusive", 40))
    broken = result("ben", check("a", "pass", 60), check("b", "error", 40, message="KeyError"))
    died = result("chen", state=HELD, problem="the worker died three times")
    running = right("dan", state=RUNNING)
    nothing = result("eve")
    tasks = tasks_of([stalled])
    everyone = [stalled, broken, died, running, nothing, right("zoe")]
    for one in everyone[:-1]:
        assert points_of(one) is None
        assert for_gradescope([one], tasks) is None
    assert [row[0] for row in rows(canvas_csv(book(everyone), tasks[0]) or "")[2:]] == ["zoe"]
    table = csv.DictReader(io.StringIO(scores_csv(everyone, {})))
    states = {row["student"]: (row["state"], row["points"]) for row in table}
    assert states["ada"] == states["chen"] == states["eve"] == ("held", "")
    assert states["dan"] == ("running", "")
    assert states["zoe"] == ("graded", "100")


def test_the_reason_says_whose_fault_it_is_and_what_to_do() -> None:
    for held, reason, action in (
        ([check("b", "inconclusive", message="stood still for 2 s")],
         "The machine stalled during “The robot does b”: stood still for 2 s", "--retry-held"),
        ([check("b", "error", message="KeyError"), check("c", "error")],
         "The grader itself failed in “The robot does b” and 1 more: KeyError", "--regrade"),
    ):  # fmt: skip
        why = why_held(result("ada", *held))
        assert why.reason == reason
        assert action in why.action
    assert why_held(result("ada", state=HELD, problem="died")).reason == "died"
    missing = result("ada", state=HELD, problem="the archive is broken", file_names=())
    assert "run the batch again" in why_held(missing).action


def test_a_missing_library_costs_the_student_nothing() -> None:
    some = result(
        "ada", check("a", "pass", 45), check("b", "fail", 15), check("c", "unavailable", 40)
    )
    assert points_of(some) == 75.0
    (row,) = csv.DictReader(io.StringIO(scores_csv([some], {})))
    assert [row[k] for k in ("points", "max_points", "score", "max_score")] == [
        "75", "100", "45", "60",
    ]  # fmt: skip
    assert row["state"] == "provisional"


# --- formats -------------------------------------------------------------------------------


def test_gradescope_reads_its_results() -> None:
    one = result(
        "ada",
        check("a", "pass", 60),
        check("b", "fail", 40, message="\x1b[31mtoo fast\x00", expected="0 m/s", help="look"),
        check("f", "skip", 0, kind="field"),
        wall_s=2.4,
    )
    made = for_gradescope([one], tasks_of([one]))
    assert made is not None
    assert (made["score"], made["execution_time"], made["visibility"]) == (60.0, 2, "visible")
    assert [test["name"] for test in made["tests"]] == [
        "The robot does a.", "The robot does b.", "The robot does f.",
    ]  # fmt: skip
    first, second, third = made["tests"]
    assert (first["score"], first["max_score"], first["status"]) == (60, 60, "passed")
    assert (second["score"], second["max_score"], second["status"]) == (0, 40, "failed")
    assert second["output"] == "too fast\nExpected: 0 m/s\nLook at next: look"
    assert "score" not in third  # field checks have no points


def test_gradescope_waits_until_every_exercise_counts() -> None:
    other = replace(right("ada"), exercise="goal_seeking")
    tasks = tasks_of([right("ada"), other])
    both = for_gradescope([right("ada"), other], tasks)
    assert both is not None
    assert both["score"] == 200.0
    assert both["tests"][2]["name"].startswith("Goal seeking: ")
    assert for_gradescope([right("ada"), replace(other, state=HELD)], tasks) is None


# --- the exercise itself -----------------------------------------------------------------------


def test_how_often_each_check_failed_and_with_which_words() -> None:
    graded = [
        result(
            f"s{i}",
            check("easy", "pass", 20),
            check("hard", "pass" if i == 11 else "fail", 20, message=f"at {i}.5 s: too fast"),
            check("field", "skip" if i else "fail", 0, kind="field"),
        )
        for i in range(12)
    ]
    items = {item.id: item for item in failures(graded)}
    assert list(items) == ["easy", "hard", "field"]
    assert items["easy"].counts == "none"
    assert items["hard"].failed == items["hard"].times == 11
    assert items["hard"].often == "at 0.5 s: too fast"
    assert (items["field"].kind, items["field"].counts) == ("field", "1 failed, 11 skipped")


def test_scores_fall_into_tenths() -> None:
    marks = [0, 9, 10, 55, 99, 100, 100]
    graded = [result(str(m), check("a", "pass", m), check("b", "fail", 100 - m)) for m in marks]
    spread = distribution(graded, tasks_of(graded)[0])
    assert spread.bins == (2, 1, 0, 0, 0, 1, 0, 0, 0, 3)
    assert (spread.full, spread.median) == (2, 55)
    assert distribution([], tasks_of(graded)[0]).median is None


# --- the whole -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Path]]:
    results, options = classes.whole_class()
    out = tmp_path_factory.mktemp("whole")
    return out, write_results(results, out, options).files


def test_everything_is_written_below_out(whole: tuple[Path, list[Path]]) -> None:
    out, written = whole
    assert all(path.resolve().is_relative_to(out.resolve()) for path in written)
    there = {path for path in out.rglob("*") if path.is_file() and path.name[0] != "."}
    assert there == set(written)
    for name in ("class.html", "scores.csv", *GRADEBOOKS):
        assert out / name in there
    assert not (out / "feedback" / "ben" / "goal_seeking.html").exists()
    assert (out / "feedback" / "ben" / "obstacle_avoidance.html").is_file()


def test_the_same_results_make_the_same_bytes_in_any_order_and_by_several_processes(
    whole: tuple[Path, list[Path]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(write, "MANY", 1)
    out, written = whole
    results, options = classes.whole_class()
    write_results(results[::-1], tmp_path, replace(options, workers=2))
    for path in written:
        assert (tmp_path / path.relative_to(out)).read_bytes() == path.read_bytes(), path.name


def test_hostile_text_stays_text_in_every_file(whole: tuple[Path, list[Path]]) -> None:
    _, written = whole
    for path in written:
        text = path.read_text("utf-8")
        if path.suffix == ".html":
            assert text.count("<img") == 0, path
            assert text.count("</style>") == 1, path
            assert "<script>window" not in text
        if path.suffix == ".json":
            json.loads(text, parse_constant=pytest.fail)
        assert not re.search("[\x00-\x08\x0b\x0c\x0e-\x1f\u202a-\u202e]", text.lstrip("\ufeff")), (
            path
        )


def test_what_was_graded_and_is_now_held_is_taken_back(tmp_path: Path) -> None:
    write_results([right("ada")], tmp_path)
    page = tmp_path / "feedback" / "ada" / "obstacle_avoidance.html"
    assert page.is_file()
    write_results([right("ada", state=HELD)], tmp_path)
    assert not page.exists()
    assert "A person has to look" in (tmp_path / "feedback" / "ada" / "index.html").read_text()


def test_pages_are_made_again_only_for_another_result(tmp_path: Path) -> None:
    page = tmp_path / "feedback" / "ada" / "obstacle_avoidance.html"

    def written_again(one: StoredResult, hide: str = "nothing") -> bool:
        os.utime(page, (0, 0))
        assert page in write_results([one], tmp_path, ResultOptions(hide=hide)).files
        return page.stat().st_mtime > 0

    write_results([right("ada")], tmp_path)
    assert not written_again(right("ada"))
    assert written_again(result("ada", check("a", "fail", 100)))
    assert written_again(result("ada", check("a", "fail", 100)), hide="details")
    page.write_text("nonsense")
    assert written_again(result("ada", check("a", "fail", 100)), hide="details")


def test_an_empty_class_is_a_report_too(tmp_path: Path) -> None:
    write_results([], tmp_path)
    assert "Nothing is held" in (tmp_path / "class.html").read_text("utf-8")
    assert not (tmp_path / "canvas").exists()


def test_pages_load_nothing_and_run_nothing(whole: tuple[Path, list[Path]]) -> None:
    text = (whole[0] / "class.html").read_text("utf-8")
    assert "<script" not in text
    assert "https://" not in text
    assert not re.search(r"url\(|@import|<[a-z][^>]*\s(on\w+|style)=", text)
    assert "default-src 'none'" in text


def test_an_unconfirmed_score_is_provisional(tmp_path: Path) -> None:
    write_results([right("ada", verified=False), right("ben")], tmp_path)
    states = {r[0]: r[5] for r in rows((tmp_path / "scores.csv").read_text("utf-8-sig"))[1:]}
    assert states == {"ada": "provisional", "ben": "graded"}
    assert (tmp_path / "class.html").read_text().count("provisional") == 1


# --- what is hidden from students ---------------------------------------------------------------


def test_the_instructor_sees_what_is_hidden_from_students(tmp_path: Path) -> None:
    failed = check("slow_zone", "fail", message="too fast")
    ada = result("ada", failed, recordings=Path("recordings/ada"))
    results = [ada, result("ben", check("slow_zone", "pass"))]
    write_results(results, tmp_path, ResultOptions(hide="worlds"))
    assert (tmp_path / "replays" / "ada" / f"{OBSTACLES}.html").is_file()
    assert not (tmp_path / "replays" / "ben").exists()
