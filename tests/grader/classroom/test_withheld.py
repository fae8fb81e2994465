"""What an instructor may keep from students, and what that leaves of a page."""

import json

import pytest
from made_results import check, result

from grader.classroom.results.options import ResultOptions
from grader.errors import InputError
from grader.grading.withheld import for_students

HELP = "From 0.5 m itself to below 1.0 m, of the smallest distance ahead."  # a check's own
SECRET = check(
    "b", "fail", 40, message="0.42 m ahead", expected="0.00 m/s", actual="0.50 m/s",
    time=2.2, scenario="avoid_zones", help=HELP,
    where="line 3 of a.py, in f:  go(d)   [d = 0.42]", log="2.20 s  info: I see 0.42",
)  # fmt: skip


@pytest.mark.parametrize(
    ("hide", "there", "not_there"),
    [
        ("nothing", ("4711", "0.42 m ahead", "I see 0.42", "avoid_field_lds01"), ()),
        (
            "worlds",
            ("The robot does b.", HELP, "died of an exception"),
            ("4711", "avoid_", "0.42", "0.00", "0.50", "2.2", "a.py", "stops late", "grew"),
        ),
        ("field", ("4711", "0.42 m ahead"), ("field_lds01", '"kind": "field"', "grew")),
        (
            "details,field",
            (HELP, "The robot does b."),
            ("4711", "avoid_", "0.42", "0.00", "0.50", "2.2", "field", "stops late", "exception"),
        ),
    ],
)
def test_what_is_hidden_is_nowhere(
    hide: str, there: tuple[str, ...], not_there: tuple[str, ...]
) -> None:
    one = result("ada", check("a", "pass", 60), SECRET, check("f", "fail", 0, kind="field"))
    assert one.grading is not None
    runs = [
        {"scenario": name, "title": name, "seed": 4711, "outcome": "exception", "bag": "/b"}
        for name in ("avoid_zones", "avoid_field_lds01")
    ]
    cause = {"text": "stops late", "kind": "core", "where": "line 3 of a.py   [d = 0.42]"}
    grew = ["In avoid_zones, the list seen_0.42 grew."]
    one.grading.update(recordings=runs, field_ready=False, cause=cause, notes=grew)
    shown = for_students(one.grading, ("agent.py",), ResultOptions(hide=hide).hidden)
    text = json.dumps({key: value for key, value in shown.items() if key != "field_ready"})
    for word in there:
        assert word in text
    for word in ("/home/prof", "/b", *not_there):  # no path of the instructor's machine
        assert word not in text
    assert (shown["field_ready"] is None) == ("field" in hide)


def test_a_help_that_quotes_the_node_is_withheld() -> None:
    failed = check("b", "fail", 40, help="Is /seen_0_42 misspelt? It is /scan.")
    grading = {"exercise": "obstacle_avoidance", "checks": [failed]}
    assert for_students(grading, (), {"worlds"})["checks"][0]["help"] == ""


def test_an_unknown_word_to_hide_is_refused() -> None:
    with pytest.raises(InputError, match=r"'detials'; did you mean details\?"):
        ResultOptions(hide="field,detials")
