"""What a student's server answers is hostile input: it fails the check, it never breaks it."""

from types import SimpleNamespace

import pytest

from grader.checks.verdict import CheckFailed
from grader.exercises.model_server.answers import read_detection, require_detection

GOOD = '{"label": "free", "confidence": 0.9, "stamp": 1.0}'


def ask(message: str) -> SimpleNamespace:
    return SimpleNamespace(message=message, what="asked at 1.0 s", at=1.0)


def test_a_detection_is_read() -> None:
    assert read_detection(None, ask(GOOD))["label"] == "free"


@pytest.mark.parametrize("message", ["", "free", "[1, 2]", "{}", "null", "[" * 100_000])
def test_anything_else_is_the_students_mistake(message: str) -> None:
    with pytest.raises(CheckFailed):
        read_detection(None, ask(message))


@pytest.mark.parametrize(
    "fields",
    [
        '"label": "a", "confidence": 1' + "0" * 400 + ', "stamp": 1.0',
        '"label": "a", "confidence": 0.5, "stamp": -1' + "0" * 400,
        '"label": "a", "confidence": true, "stamp": 1.0',
        '"label": "a", "confidence": "0.5", "stamp": 1.0',
        '"label": "\\ud800", "confidence": NaN, "stamp": 1.0',
        '"label": ' + "[" * 500 + "]" * 500 + ', "confidence": 0.5, "stamp": 1.0',
    ],
)
def test_odd_values_are_the_students_mistake(fields: str) -> None:
    odd = ask("{" + fields + "}")
    odd.answered, odd.success, odd.scan = True, True, object()
    with pytest.raises(CheckFailed, match="the server's message is not right"):
        require_detection(None, odd)
