"""Questions of a program to models that the judge keeps, or to a program of the grader's."""

from __future__ import annotations

from typing import Annotated

import msgspec

from grader.hosted.fields import Name, Nanoseconds, Text
from rclpy_virtual_time import ask_judge

MAX_ROWS = 1_000  # of features in one question
MAX_COLUMNS = 64  # features in a row


class Question(msgspec.Struct, array_like=True, frozen=True):
    """A question to a model that the judge keeps, or from a program of the grader's."""

    method: Annotated[
        str, msgspec.Meta(pattern="^(load|predict|predict_proba|request|turn|answer|until)$")
    ]
    file: Name  # of the model, or the service
    load: Nanoseconds = (
        0  # which load of it answers; 0 while it is loaded; of answers: which turn; when
    )
    rows: Annotated[int, msgspec.Meta(ge=0, le=MAX_ROWS)] = 0  # of answers: 1 with success
    features: bytes = b""  # (rows, columns) float64; of answers: the message


class Told(msgspec.Struct, array_like=True, frozen=True):
    """A model's answer."""

    problem: Text = ""  # what it raises; "" if it doesn't
    error: str = ""  # the type of that exception, by the name that it has in `raises`
    load: Nanoseconds = 0
    shape: tuple[int, ...] = ()
    numbers: bytes = b""  # float64
    dtype: str = "float64"  # of what the model says
    labels: tuple[str, ...] = ()


def wait_until(at: float) -> None:
    """Wait for a time [s] of the trial, whenever the program itself began."""
    ask(Question("until", "", round(at * 1e9)))


def ask(question: Question) -> Told:
    """Ask the judge, and wait for the answer: programs call this."""
    return msgspec.msgpack.decode(ask_judge(msgspec.msgpack.encode(question)), type=Told)
