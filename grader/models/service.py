"""The models that the judge keeps: it answers a node's questions, and notes when they were asked.

A node has the answer when the model's time is over, and not before. How often a model was loaded
and asked, and when, is the judge's own knowledge.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import replace

from grader.hosted.questions import Question, Told
from grader.hosted.supplied.kept import WRONG_SHAPE
from grader.models.arrived import Arrived
from grader.models.files import is_kept, probe
from grader.models.partners import SERVICE, TURN, UNTIL, Partners
from grader.recording.inferences import Inference
from rclpy_virtual_time import HostForged, Settled
from rclpy_virtual_time import Question as Asked
from rclpy_virtual_time import Told as Answer
from sim.faults import sensor_rng
from sim.messages import Message
from sim.scenario import Scenario

MAX_ASKED = 20_000  # questions in one trial
MOST_ROWS = 50_000  # of features in all of them: checks compare each command with each prediction
SPREAD = 0.04  # by which the times of a model that has several differ between students
DECODER = msgspec.msgpack.Decoder(Question)
MAX_REASON = 300  # [characters] of why a question was refused: it may quote the question
IN_START_UP = -1  # [ns] when a question was asked before the scenario


class TooManyQuestions(Exception):
    """The node asked its models more often than any node does."""


@dataclass
class ModelService:
    """The kept models of one trial.

    Parameters
    ----------
    scenario, seed
        Which models there are; with a seed that is not the scenario's own, their times differ.
    delivered
        What the node was sent, to date: models that take any features look at its scans.
    began
        What the clock [ns] says at the scenario's start; None: it begins later.
    """

    scenario: Scenario
    seed: int
    delivered: Sequence[Message] = ()
    began: int | None = 0
    inferences: list[Inference] = field(default_factory=list)
    # due [ns], …, to whom
    _owed: list[tuple[int, int, Any, Answer]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._models = {
            name: probe(model)
            for name, model in self.scenario.node.models.items()
            if is_kept(name, model)
        }
        self._arrived = Arrived(self.delivered)
        self._loads = dict.fromkeys(self._models, 0)
        self._sequence = itertools.count()
        self._partners = Partners(self.scenario, self.seed)
        self._early: list[tuple[Asked, Any]] = []  # turns before the scenario's start
        self._count = 0  # of questions
        self._rows = 0

    # --- asked while time goes by ----------------------------------------------------------------

    def ask(self, asked: Asked, now: int, who: Any = None) -> None:
        """Accept a question at a time [ns]; its answer is due later.

        Raises TooManyQuestions: there were more than MAX_ASKED, or more than MOST_ROWS of features.
        Raises HostForged: it is no question.
        """
        question = _question(asked)
        if question.method in (TURN, UNTIL) and self.began is None:
            if len(self._early) == Settled.MAX_QUESTIONS:
                raise TooManyQuestions(
                    f"more than {Settled.MAX_QUESTIONS} programs that wait to ask"
                )
            self._early.append((asked, who))
            return
        told, took = self._answer(question, now)
        heapq.heappush(self._owed, (now + took, next(self._sequence), who, _told(asked, told)))

    @property
    def next_due(self) -> int | None:
        """When the next answer is due [ns], if one is."""
        return self._owed[0][0] if self._owed else None

    def due(self, now: int) -> list[tuple[Any, Answer]]:
        """Return the answers that are due by now [ns], with whom they are for."""
        found = []
        while self._owed and self._owed[0][0] <= now:
            _, _, who, told = heapq.heappop(self._owed)
            found.append((who, told))
        return found

    # --- in real time, by a clock that began earlier ---------------------------------------------

    def begin(self, now: int) -> None:
        """Set the reading of the questions' clock [ns] at the scenario's start."""
        self.began = now
        for question, who in self._early:
            self.ask(question, now, who)

    def since_begin(self) -> list[Inference]:
        """Return the questions asked, with times from the scenario's start on."""
        began = self.began or 0
        return [
            replace(i, asked=max(IN_START_UP, i.asked - began),
                    answered=max(IN_START_UP, i.answered - began))
            for i in self.inferences
        ]  # fmt: skip

    # --- asked before time begins ----------------------------------------------------------------

    def at_once(self, asked: Asked) -> Answer:
        """Return the answer to a question of a start-up; it says how long the model takes."""
        told, took = self._answer(_question(asked), IN_START_UP)
        return _told(asked, told, wait=took)

    # --- what they say ---------------------------------------------------------------------------

    def _answer(self, question: Question, now: int) -> tuple[Told, int]:
        """Return the answer, and how long the model takes for it [ns]; note both."""
        self._rows += question.rows
        self._count += 1
        if self._count > MAX_ASKED:
            raise TooManyQuestions(f"more than {MAX_ASKED:,} questions to its models")
        if self._rows > MOST_ROWS:
            raise TooManyQuestions(f"more than {MOST_ROWS:,} rows of features for its models")
        if question.method == UNTIL:
            return Told(), max(0, (self.began or 0) + question.load - max(now, 0))
        if question.file == SERVICE:
            began = now + 1 if self.began is None else self.began
            told, took, notes = self._partners.ask(question, now, began)
            self.inferences += notes
            return told, took
        told, seconds = self._said(question)
        took = round(seconds * 1e9)
        numbers = np.frombuffer(told.numbers).reshape(told.shape) if told.numbers else np.empty(0)
        if numbers.ndim > 1:  # probabilities (rows, classes)
            numbers = numbers.max(axis=1)
        self.inferences.append(
            Inference(
                method=question.method,
                file=question.file,
                asked=now,
                answered=IN_START_UP if now == IN_START_UP else now + took,
                took=took,
                said=tuple(map(float, numbers)),
                labels=told.labels or self._words(question, told),
                failed=bool(told.problem),
            )
        )
        return told, took

    def _words(self, question: Question, told: Told) -> tuple[str, ...]:
        """Return which labels belong to these probabilities, if the model has words for any."""
        if question.method != "predict_proba" or told.problem:
            return ()
        predicted, _ = self._said(replace(question, method="predict"))
        return predicted.labels

    def _said(self, question: Question) -> tuple[Told, float]:
        model = self._models.get(question.file)
        if model is None:
            return Told(f"there is no model {question.file}"), 0.0
        if question.method == "load":
            self._loads[question.file] += 1
            model.loads = self._loads[question.file]
            return Told(load=model.loads), float(getattr(model, "load_seconds", 0.0))
        if not 1 <= question.load <= self._loads[question.file]:
            return Told(f"{question.file} was not loaded"), 0.0
        rows = np.frombuffer(question.features[: len(question.features) // 8 * 8])
        if not question.rows or not len(rows) or len(rows) % question.rows:
            return Told(WRONG_SHAPE, error="ValueError"), 0.0
        rows = rows.reshape(question.rows, -1)
        if self.scenario.node.models[question.file].any_features:
            rows = self._arrived.instead_of(rows)
        if rows.shape[1] == 1:  # a row, where a table is asked for
            return Told(WRONG_SHAPE, error="ValueError"), 0.0
        seconds = self._seconds(model, rows) if question.method == "predict" else 0.0
        try:
            with np.errstate(all="ignore"):
                answer = np.asarray(getattr(model, question.method)(rows))
        except Exception as error:  # a probe that raises does so on purpose
            return Told(str(error), type(error).__name__), seconds
        if answer.dtype.kind == "U":
            return Told(shape=answer.shape, labels=tuple(answer.tolist())), seconds
        numbers = answer.astype(float)
        return Told(
            shape=numbers.shape, numbers=numbers.tobytes(), dtype=answer.dtype.name
        ), seconds

    def _seconds(self, model: Any, rows: np.ndarray) -> float:
        if not hasattr(model, "takes"):
            return float(getattr(model, "seconds", 0.0))
        with np.errstate(all="ignore"):
            seconds = float(model.takes(rows))
        if self.seed == self.scenario.seed or len(model.seconds) == 1:
            return seconds
        rng = sensor_rng(self.seed, f"a model that takes {seconds}")
        return seconds * (1.0 + float(rng.uniform(-SPREAD, SPREAD)))


def _question(asked: Asked) -> Question:
    """Decode a question; HostForged if it isn't one."""
    try:
        return DECODER.decode(asked.data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise HostForged(str(error)[:MAX_REASON]) from None


def _told(asked: Asked, told: Told, wait: int = 0) -> Answer:
    return Answer(asked.number, msgspec.msgpack.encode(told), wait)
