"""The contract of model_server: what the server answers, and when its clients ask and publish."""

from __future__ import annotations

from grader.checks.case import Case, Runs
from grader.checks.contract import Contract
from grader.checks.words import follows
from grader.exercises.model_server import clients, server
from grader.recording import Recording

CONTRACT = Contract(drives=False)


def cases(recording: Recording) -> list[Case]:
    """Return the occasions of the server and of the clients, each beside the grader's other end."""
    return [*server.cases(recording), *clients.cases(recording)]


def keeps(runs: Runs, *tags: str, topic: str = "/detect", help: str) -> None:
    """Fail unless what is allowed is done, on each occasion with one of these tags."""

    def explain(case: Case) -> str:
        text = case.said.get("text")
        return f"Its message was “{text}”. {help}" if text else help

    follows(runs, *tags, topic=topic, explain=explain)
