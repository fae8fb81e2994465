"""What grows is told; what is only noisy, or costs more for once, is not."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.recording import Endpoint, Recording, made_again, rise_of
from grader.recording.views import Floats

TIMES = np.arange(400) * 0.1  # [s]
NOISE = np.random.default_rng(3).exponential(0.001, len(TIMES))  # [s] of the machine


@pytest.mark.parametrize(
    ("cost", "rises"),
    [
        (lambda t: 0.001 + 0.0001 * t, True),  # a list that is searched
        (lambda t: 0.001 + 0.0 * t, False),
        (lambda t: np.where(t > 20.0, 0.009, 0.001), False),  # another stretch of road
        (lambda t: 0.003 - 0.00005 * t, False),
        (lambda t: 0.00001 * (1 + t), False),  # too little to be sure
    ],
)
def test_only_what_rises_all_the_time_is_a_rise(
    cost: Callable[[Floats], Floats], rises: bool
) -> None:
    rise = rise_of(TIMES, cost(TIMES) + NOISE)
    assert (rise is not None) == rises
    if rise is not None:
        assert rise.rate == pytest.approx(0.0001, rel=0.3)


def test_a_few_messages_show_no_rise() -> None:
    assert rise_of(TIMES[:190], 0.001 * TIMES[:190]) is None


@pytest.mark.parametrize(
    ("kind", "topic", "count", "said"),
    [
        ("client", "/detect", 11, ["11 clients of /detect"]),
        ("client", "/detect", 10, []),
        ("timer", "", 20, ["dozens of timers"]),
    ],
)
def test_ends_that_are_made_again_and_again(
    kind: str, topic: str, count: int, said: list[str]
) -> None:
    recording: Any = SimpleNamespace(endpoints=(Endpoint(kind, "/node", topic, ""),) * count)
    assert [many for _, many in made_again(recording)] == said


@pytest.mark.parametrize(("process", "ours"), [("", ""), ("node.py", "setter.py")])
def test_the_graders_own_ends_are_left_out_of_recordings_old_and_new(
    process: str, ours: str
) -> None:
    """Those of 1.0.0 know no program of an end, only its node."""
    theirs, setter = (
        Endpoint("client", node, "/t", "", process=each)
        for node, each in (("/node", process), ("/course_setter", ours))
    )
    programs = [SimpleNamespace(file="setter.py", supplied=True)]
    run: Any = SimpleNamespace(
        scenario=SimpleNamespace(program=programs), endpoints=(setter, theirs)
    )
    assert Recording.ends.func(run) == (theirs,)
