"""A node's answers to changes of its parameters while it ran (`parameter_setter.py`)."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Mapping
from dataclasses import dataclass

import msgspec

from grader.checks.commands import published
from grader.recording import Recording
from grader.recording.hands import SETTER
from sim.messages import STRING

ANSWERS = "/course_parameters"


class Described(msgspec.Struct, frozen=True):
    """A parameter's descriptor."""

    name: str
    type: int  # of rcl_interfaces/msg/ParameterType; 3 is a double
    limits: tuple[float, ...]  # the least and the greatest value; () for any
    description: str
    ignored: bool = False  # it also has a range of another type, which says nothing


class Answer(msgspec.Struct, frozen=True):
    """A node's answer to an order."""

    order: int
    accepted: bool | None = None  # None: it was asked for descriptors
    reason: str = ""
    described: tuple[Described, ...] = ()
    there: tuple[str, ...] = ()  # all that the node has, where it was asked for descriptors


@dataclass(frozen=True)
class Order:
    """A request about a node's parameters, and the answer."""

    at: float  # [s]
    text: str  # "speed:=0.2"
    wanted: Mapping[str, float | str]  # by name; empty: its descriptors
    answer: Answer | None  # None: it has said nothing


def orders(recording: Recording) -> list[Order]:
    """Return the orders of a scenario's setter, with the node's answers: a student's word.

    In real time, where programs start when they can, an order counts from its answer on.
    """
    answers: dict[int, Answer] = {}
    heard: dict[int, float] = {}
    for t, message in published(recording, ANSWERS, STRING):
        with contextlib.suppress(ValueError, RecursionError, OverflowError):
            answer = msgspec.convert(json.loads(message.data), Answer)
            answers.setdefault(answer.order, answer)
            heard.setdefault(answer.order, t)
    given = [
        (float(at), f"{part} (of {text})" if part != text else text, _wanted(part))
        for program in recording.scenario.program
        if program.file == SETTER
        for at, text in (order.split(maxsplit=1) for order in program.arguments[1:])
        for part in text.split(", ")
    ]
    return [
        Order(
            at if recording.live is None else heard.get(number, at),
            text,
            wanted,
            answers.get(number),
        )
        for number, (at, text, wanted) in enumerate(given)
    ]


def _wanted(text: str) -> dict[str, float | str]:
    pairs = (word.split(":=") for word in text.split() if ":=" in word)
    return {name: _value(value) for name, value in pairs}


def _value(text: str) -> float | str:
    """Return a double's value; of other types the text, as "2" of an int."""
    try:
        return text if text.lstrip("-").isdigit() else float(text.replace(".nan", "nan"))
    except ValueError:
        return text
