"""What passed between a student's nodes and the grader's own server or client, by the judge."""

from __future__ import annotations

import math
from dataclasses import dataclass

from grader.models.partners import ANSWER, REFUSED, REQUEST, UNSURE, turns
from grader.recording import Inference, Recording

START_UP = 1.0  # [s] a program takes, in real time, to start and to be discovered
NEAR = 0.051  # [s] ages and waits within 50 ms of a limit may fall on either side


@dataclass(frozen=True)
class Request:
    """A request and its answer."""

    at: float  # [s]
    kind: str = ""  # of the answer, if the server is the grader's: fine, never, half, …
    answered: float = math.inf  # [s]; inf: never
    success: bool = False
    message: str = ""

    @property
    def took(self) -> float:
        """How long the answer took [s]."""
        return self.answered - self.at


def requests(recording: Recording) -> list[Request]:
    """Return the requests that reached the grader's server, in order."""
    found = []
    for each in recording.inferences:
        if each.method == REQUEST:
            at, answered, (message, kind) = each.asked / 1e9, each.answered / 1e9, _words(each)
            success = kind not in (REFUSED, UNSURE)
            came = answered <= recording.duration_s
            request = Request(at, kind, answered, success, message) if came else Request(at, kind)
            found.append(request)
    return found


def _words(each: Inference) -> tuple[str, str]:
    """Return an answer's message and kind; a bag may lack them."""
    message, kind, *_ = (*each.labels, "", "")
    return message, kind


def asked(recording: Recording) -> list[Request]:
    """Return the requests of the grader's client, with what the student's server answered."""
    found = {at: Request(at / 1e9) for at in turns(recording.scenario)}
    for each in recording.inferences:
        if each.method == ANSWER:
            message, success = _words(each)
            found[each.asked] = Request(
                each.asked / 1e9, "", each.answered / 1e9, success == "true", message
            )
    return [each for each in found.values() if each.at < recording.duration_s]
