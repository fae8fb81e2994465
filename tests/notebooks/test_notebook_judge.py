"""The judge of a notebook, asked in this process: what it answers, and how it tells of progress."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from grader.course.exercises import SOLUTIONS
from grader.errors import GraderError
from grader.launchers import ForkServerPool, launcher_pool
from grader.notebook import answers, judge
from grader.notebook.judge import carry_out
from grader.notebook.orders import (
    Answer,
    Drive,
    Driven,
    Grade,
    Graded,
    Look,
    Problem,
    Progressed,
    Warm,
)

AGENT = "obstacle_avoidance_agent.py"
RIGHT = SOLUTIONS / "obstacle_avoidance" / AGENT


@pytest.fixture(scope="module")
def forkservers() -> Iterator[ForkServerPool]:
    """A pool of their own: after a fault the judge ends all of its fork servers."""
    with launcher_pool() as found:
        yield found


def replays(page: str) -> list[dict[str, Any]]:
    found = re.search(r'id="payload">(.*?)</script>', page)
    assert found is not None
    return list(json.loads(found[1])["replays"])


def graded(answer: Answer | None) -> Graded:
    assert isinstance(answer, Graded), answer
    return answer


def test_progress_is_told_to_the_end(forkservers: ForkServerPool) -> None:
    sent: list[Any] = []
    order = Grade("1", str(RIGHT), AGENT, ("slow_zone", "invalid_readings"))
    answer = graded(carry_out(order, forkservers, sent.append))
    assert json.loads(answer.grading)["score"] == 25
    for what in ("trial", "check"):
        steps = [step for step in sent if isinstance(step, Progressed) and step.what == what]
        assert max(step.done for step in steps) == steps[-1].of
        assert len({step.of for step in steps}) == 1
    checks = [step.done for step in sent if step.what == "check"]
    assert checks == sorted(checks)


@pytest.mark.long
def test_a_notebook_carries_the_first_failure_first_and_not_more_than_it_can(
    forkservers: ForkServerPool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / AGENT
    text = RIGHT.read_text("utf-8")
    file.write_text(text.replace("STOP_DISTANCE = 0.5", "STOP_DISTANCE = 0.05"), "utf-8")
    order = Grade("1", str(file), AGENT)
    answer = graded(carry_out(order, forkservers, lambda _: None))
    shown = replays(answer.page)
    failed = [c for c in json.loads(answer.grading)["checks"] if c["outcome"] == "fail"]
    assert (shown[0]["scenario"], shown[0]["title"]) == (failed[0]["scenario"], answer.first)
    with_moments = [bool(replay["moments"]) for replay in shown]
    assert with_moments[0] and with_moments == sorted(with_moments, reverse=True)
    monkeypatch.setattr(answers, "MAX_REPLAYS", 1)
    (only,) = replays(graded(carry_out(order, forkservers, lambda _: None)).page)
    assert (len(shown) > 1, only["scenario"]) == (True, shown[0]["scenario"])


@pytest.mark.parametrize(
    ("order", "said"),
    [
        (Grade("qqqq", str(RIGHT), AGENT), "unknown exercise 'qqqq'; there are: obstacle"),
        (Drive("/no/such.py", "such.py", "demo_wall"), "such.py"),
        (Look("6", str(RIGHT), AGENT, tries=4), "do not drive by themselves"),
    ],
)
def test_wrong_orders_are_explained(forkservers: ForkServerPool, order: Any, said: str) -> None:
    answer = carry_out(order, forkservers, lambda _: None)
    assert isinstance(answer, Problem)
    assert said in answer.text
    assert not answer.fault


def test_after_a_fault_of_ours_the_fork_servers_are_new(
    forkservers: ForkServerPool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: Any, **__: Any) -> None:
        raise GraderError("no host for the node")

    assert carry_out(Warm(()), forkservers, lambda _: None) is None
    before = forkservers.of(())
    monkeypatch.setattr(judge, "grade_submission", broken)
    answer = carry_out(Grade("1", str(RIGHT), AGENT), forkservers, lambda _: None)
    assert answer == Problem("no host for the node", fault=True)
    assert forkservers.of(()) is not before


def test_a_search_tells_each_world_and_shows_the_smallest(
    forkservers: ForkServerPool, tmp_path: Path
) -> None:
    sent: list[Any] = []
    file = tmp_path / AGENT
    file.write_text(RIGHT.read_text("utf-8").replace("FULL_SPEED = 0.5", "FULL_SPEED = 0.7"))
    answer = carry_out(Look("1", str(file), AGENT, tries=4), forkservers, sent.append)
    assert isinstance(answer, Driven), answer
    assert answer.text.startswith("In an empty world: the node asks for 0.70 m/s at ")
    assert [(step.what, step.done, step.of) for step in sent] == [
        ("world", done, 4) for done in range(1, len(sent) + 1)
    ]
    assert replays(answer.page)[0]["title"] == "An empty world"
