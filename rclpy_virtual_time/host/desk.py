"""How a program asks the judge: bytes go there, and bytes come back when the judge says so."""

from __future__ import annotations

from collections.abc import Callable


def _nobody(_: bytes) -> bytes:
    raise RuntimeError("this model answers in a trial of the grader only")


class Desk:
    """Carries questions to the judge; a host puts its own way here."""

    ask: Callable[[bytes], bytes] = staticmethod(_nobody)


desk = Desk()


def ask_judge(question: bytes) -> bytes:
    """Ask the judge, and wait for the answer: programs call this."""
    return desk.ask(question)
