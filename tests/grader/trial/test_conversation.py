"""A trial is a conversation: an end without pipes, whose host calls the judge, can hold it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from fake_host import SETTLED
from node_runs import short

from grader.course.submission import Submission
from grader.host.frames import Run, Settled, Start, ToJudge
from grader.link.exchange import Cost, HostDied
from grader.link.link import Conversation, Link, Result
from grader.link.log import LogLine
from grader.link.output import Output, in_order
from grader.recording import Recording
from grader.trial.virtual_time import run_trial

Node = Callable[[Callable[[ToJudge], Start | Run]], None]  # says what it has done; gets an order


class Quiet:
    """The host's side of an end that shares its thread with the judge."""

    def __init__(self) -> None:
        self.stdout, self.stderr = Output("stdout"), Output("stderr")

    def log(self) -> tuple[LogLine, ...]:
        return in_order(self.stdout, self.stderr)

    def stacks(self) -> str:
        return ""

    def wait(self, patience: float = 0.0) -> str:
        return "3"


class OneThread(Link):
    """The node runs on top of the judge: what it says goes straight into the conversation."""

    node: Node

    def converse(self, conversation: Conversation[Result]) -> Result:
        next(conversation)
        try:
            self.node(lambda said: conversation.send((said, Cost(0.0, 0.0)))[0])
            conversation.throw(HostDied())
        except StopIteration as end:
            return end.value
        raise AssertionError("a conversation with the dead")


class OneThreadLauncher:
    """Gives out one end."""

    def __init__(self, node: Node) -> None:
        self._node = node

    @contextmanager
    def host(self, folder: Path) -> Iterator[Link]:
        link = OneThread(Quiet())  # type: ignore[arg-type]
        link.node = self._node
        yield link


@pytest.fixture
def drive(tmp_path: Path) -> Callable[[Node], Recording]:
    file = tmp_path / "node.py"
    file.write_text("pass")
    return lambda node: run_trial(Submission(file), short(1.0), OneThreadLauncher(node))  # type: ignore[arg-type]


def test_a_node_on_the_judges_stack_drives_to_the_end(drive: Callable[[Node], Recording]) -> None:
    def node(say: Callable[[ToJudge], Start | Run]) -> None:
        order = say(SETTLED)
        while isinstance(order, Run):
            order = say(Settled(order.until, spinning=True, asleep=False, published=[]))

    recording = drive(node)
    assert recording.outcome.completed
    assert len(recording.of("/scan")) == 10


def test_a_node_on_the_judges_stack_that_leaves_has_died(
    drive: Callable[[Node], Recording],
) -> None:
    outcome = drive(lambda say: say(SETTLED) and None).outcome
    assert (outcome.kind, outcome.text) == (
        "died", "the node's process ended by itself (exit code 3)",
    )  # fmt: skip
