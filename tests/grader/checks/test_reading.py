"""What a node published is read, or fails the check."""

from types import SimpleNamespace

import pytest

from grader.checks.reading import published
from grader.checks.verdict import CheckFailed
from sim.messages import FLOAT64, Message, encode, typestore

TOPIC = "/closing_speed"


def message(data: bytes) -> Message:
    return Message(TOPIC, FLOAT64, 1_500_000_000, data)


def said(value: float) -> bytes:
    return encode(typestore().types[FLOAT64](data=value), FLOAT64)


@pytest.mark.parametrize("data", [b"", b"\0\1\0\0", said(0.5)[:-1]])
def test_what_cannot_be_read_fails(data: bytes) -> None:
    recording = SimpleNamespace(published=(message(data),), name="run")
    with pytest.raises(CheckFailed, match="a message on /closing_speed can't be read") as caught:
        published(recording, TOPIC, FLOAT64)
    assert caught.value.at == 1.5
