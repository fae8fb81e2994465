"""What an instructor may keep from students, and what that leaves of a page."""

from __future__ import annotations

import json
from typing import Any

import pytest
from made_results import check, result

from grader.classroom.results import ResultOptions
from grader.classroom.results.withheld import for_students
from grader.errors import InputError

# --- text made harmless --------------------------------------------------------------------

# --- what students don't see -----------------------------------------------------------------

SECRET = check(
    "b", "fail", 40, message="0.42 m ahead", expected="0.00 m/s", actual="0.50 m/s",
    time=2.2, scenario="avoid_zones", help="compare with 0.5 m",
    where="line 3 of a.py, in f:  go(d)   [d = 0.42]", log="2.20 s  info: I see 0.42",
)  # fmt: skip


def hiding(hide: str) -> dict[str, Any]:
    one = result("ada", check("a", "pass", 60), SECRET, check("f", "fail", 0, kind="field"))
    assert one.grading is not None
    runs = [
        {"scenario": name, "title": name, "seed": 4711, "outcome": "completed", "bag": "/b"}
        for name in ("avoid_zones", "avoid_field_lds01")
    ]
    cause = {"text": "stops late", "kind": "core", "where": "line 3 of a.py   [d = 0.42]"}
    one.grading.update(recordings=runs, field_ready=False, cause=cause)
    return for_students(one.grading, ("agent.py",), ResultOptions(hide=hide).hidden)


def test_students_never_see_the_instructors_paths() -> None:
    shown = json.dumps(hiding("nothing"))
    assert "/home/prof" not in shown
    assert "/b" not in shown
    assert "4711" in shown
    assert "0.42 m ahead" in shown


def test_hidden_worlds_leave_the_lines_and_not_their_values() -> None:
    shown = hiding("worlds")
    failed = next(c for c in shown["checks"] if c["id"] == "b")
    assert (failed["where"], failed["log"]) == ("line 3 of a.py, in f:  go(d)", "")
    assert shown["cause"]["where"] == "line 3 of a.py"
    assert shown["cause"]["text"] == "stops late"


def test_hidden_details_leave_no_cause() -> None:
    shown = hiding("details")
    assert shown["cause"] is None
    assert "0.42" not in json.dumps(shown)


def test_hidden_field_checks_leave_no_trace() -> None:
    shown = hiding("field")
    assert [c["id"] for c in shown["checks"]] == ["a", "b"]
    assert "field_lds01" not in json.dumps(shown)
    assert shown["field_ready"] is None


def test_hidden_worlds_have_neither_name_nor_seed() -> None:
    shown = json.dumps(hiding("worlds"))
    for word in ("4711", "avoid_zones", "avoid_field_lds01"):
        assert word not in shown
    assert "0.42 m ahead" in shown


def test_hidden_details_leave_title_and_next_step() -> None:
    shown = json.dumps(hiding("details,field"))
    for word in ("4711", "avoid_", "0.42", "0.00 m/s", "0.50 m/s", "2.2", '"kind": "field"'):
        assert word not in shown
    assert "compare with 0.5 m" in shown
    assert "The robot does b." in shown


def test_an_unknown_word_to_hide_is_refused() -> None:
    with pytest.raises(InputError, match=r"'detials'; did you mean details\?"):
        ResultOptions(hide="field,detials")
