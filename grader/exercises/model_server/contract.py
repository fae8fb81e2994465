"""The contract of model_server: what the server answers, and when its clients ask and publish."""

from __future__ import annotations

from functools import partial

from grader.checks.case import Case
from grader.checks.contract import Contract
from grader.checks.verbs import follows
from grader.exercises.model_server import clients, server
from grader.recording import Recording

CONTRACT = Contract(drives=False)
keeps = partial(follows, topic="/detect")


def cases(recording: Recording) -> list[Case]:
    """Return the occasions of the server and of the clients, each beside the grader's other end."""
    return [*server.cases(recording), *clients.cases(recording)]
