"""The grader's ends of exercise 6's service: what its server answers, and when its client asks.

The programs that hold these ends (`grader/hosted/supplied/detection_*.py`) run beside a student's,
in virtual time in the same process. So they only carry: a request to the grader's server is
answered here, and what the student's server answered is noted here, once for each time at which it
is asked.
"""

from __future__ import annotations

import json
from dataclasses import dataclass

from grader.hosted.fields import MAX_TEXT
from grader.hosted.questions import Question, Told
from grader.recording.inferences import Inference
from sim.faults import sensor_rng
from sim.messages import EPOCH_NS
from sim.scenario import ProgramSpec, Scenario

SERVICE = "/detect"  # where a question to a model has the model's file
DOUBLE, ASKER = "detection_double.py", "detection_asker.py"
REQUEST, TURN, ANSWER, UNTIL = "request", "turn", "answer", "until"
NEVER = 2**61  # [ns] after the end of every scenario
REFUSED, UNSURE = "refused", "unsure"  # answers without success
WELL_FORMED = ("fine", "same")
MALFORMED = {  # messages that come with success, though they are not what was agreed on
    "empty": "",
    "no_json": "box, 90 %",
    "half": '{"label": "box", "confid',
    "list": "[1, 2, 3]",
    "number": "42",
    "null": "null",
    "no_keys": "{}",
    "types": '{"label": 7, "confidence": "high", "stamp": null}',
    "nan": '{"label": "box", "confidence": NaN, "stamp": 1e999}',
    "long": json.dumps({"label": "box " * 5_000}),
    "unicode": '{"label": "Kiste \N{PACKAGE}", "confidence": "½"}',
}

# As JSON may be spelt, with room around it and more keys than those of the contract; who writes it
# anew, strips or shortens it spells it in another way.
SAME = (
    ' {"stamp": 1700000000.250, "label":"Kiste \N{PACKAGE}",  "confidence": 0.50, "notes": "'
    + "seen before; " * 20
    + '"}\n'
)


@dataclass
class Life:
    """One run of the grader's server.

    Its plan has one word for each request, the last for all that follow: a kind of answer, then `@`
    and its delay [s] if there is one (`fine@0.3`).
    """

    start: int  # [ns]
    stop: int  # [ns]
    plan: list[str]
    requests: int = 0  # so far

    def next(self) -> tuple[str, int]:
        """Return how the next request is answered: the kind, and its delay [ns]."""
        kind, _, delay = self.plan[min(self.requests, len(self.plan) - 1)].partition("@")
        self.requests += 1
        return kind, NEVER if kind == "never" else round(float(delay or 0) * 1e9)


def turns(scenario: Scenario) -> list[int]:
    """Return when the grader's client asks the student's server [ns]."""
    askers = [spec for spec in scenario.program if spec.file == ASKER]
    return [round((a.start + at) * 1e9) for a in askers for at in json.loads(_argument(a))]


class Partners:
    """Both ends in one trial."""

    def __init__(self, scenario: Scenario, seed: int) -> None:
        end = scenario.duration
        self._lives = [
            Life(round(s.start * 1e9), round((s.stop or end) * 1e9), _argument(s).split())
            for s in scenario.program
            if s.file == DOUBLE
        ]
        self._turns = turns(scenario)
        self._asked = 0  # turns so far
        self._answered: set[int] = set()
        self._seed = seed

    def ask(self, question: Question, now: int, began: int) -> tuple[Told, int, list[Inference]]:
        """Return the answer to a program, its delay [ns], and notes.

        Times [ns] are those of one clock; the scenario began at `began`.
        """
        notes = list[Inference]()
        match question.method:
            case "request":
                return self._serve(now, now - began)
            case "turn" if self._asked < len(self._turns):
                turn, self._asked = self._asked, self._asked + 1
                return Told(load=turn), max(0, began + self._turns[turn] - now), notes
            case "turn":
                return Told(), NEVER, notes
        turn = question.load
        if turn < self._asked and turn not in self._answered:
            self._answered.add(turn)
            message = question.features[:MAX_TEXT].decode(errors="replace")
            words, asked = (message, str(question.rows > 0).lower()), began + self._turns[turn]
            notes.append(Inference(ANSWER, SERVICE, asked, now, now - asked, labels=words))
        return Told(), 0, notes

    def _serve(self, now: int, at: int) -> tuple[Told, int, list[Inference]]:
        life = next((life for life in self._lives if life.start <= at < life.stop), None)
        if life is None:  # before the scenario, in real time
            return Told("there is no scan yet"), 0, []
        request = life.requests
        kind, took = life.next()
        if at + took >= life.stop:
            took = NEVER
        message = self._message(kind, request, at + took)
        problem = message if kind in (REFUSED, UNSURE) else ""
        note = Inference(REQUEST, SERVICE, now, now + took, took, labels=(message, kind))
        return Told(problem, labels=(message,)), took, [note]

    def _message(self, kind: str, request: int, at: int) -> str:
        """Return an answer's text; no two good ones are the same, but those of the kind `same`."""
        if kind == REFUSED:
            return "there is no scan yet"
        if kind == "same":
            return SAME
        if kind in MALFORMED:
            return MALFORMED[kind]
        # an unsure server names its best label, without success
        confidence = sensor_rng(self._seed, f"answer {request}").uniform(0.05, 0.95)
        stamp = (EPOCH_NS + at) / 1e9
        return json.dumps({"label": f"box {request}", "confidence": confidence, "stamp": stamp})


def _argument(spec: ProgramSpec) -> str:
    """Return the value of a program's one parameter."""
    return spec.arguments[-1].partition(":=")[2]
