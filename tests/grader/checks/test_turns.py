"""Which commands belong to which scan, in real time."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grader.checks.turns import answered_in_turn

SCANS = np.arange(20) / 10  # [s]
END = 2.0  # [s]


def recording(commands: Any, live: object = "live", queued: float = 0.0) -> Any:
    return SimpleNamespace(
        live=live,
        compute=SimpleNamespace(time=SCANS, queued=np.full(len(SCANS), queued)),  # in each turn
        duration_s=END,
        times=lambda topic: SCANS,
        twists=lambda: SimpleNamespace(t=np.asarray(commands, float)),
    )


@pytest.mark.parametrize(
    ("commands", "count"),
    [
        (SCANS + 0.01, 20),
        (SCANS + 0.15, 20),  # each when the next scan is there already
        (SCANS[:18] + 0.15, 18),  # the last two answers come after the end
        (SCANS[:16] + 0.15, 0),  # four scans were never answered
        (SCANS - 0.01, 0),  # before its scan
        (SCANS + 0.7, 0),  # seven scans late is no answer
        (np.append(SCANS + 0.01, 1.99), 0),  # one too many
        ([], 0),
    ],
)
def test_answers_count_in_turn_if_they_come_in_time(commands: Any, count: int) -> None:
    assert answered_in_turn(recording(commands)) == count


def test_a_node_that_had_to_wait_for_a_cpu_may_answer_later() -> None:
    late = SCANS[:13] + 0.7  # seven turns later
    scans = SCANS[:13]
    for queued, count in ((0.0, 0), (0.02, 0), (0.04, 13)):
        short = recording(late, queued=queued)
        short.times = lambda topic: scans
        assert answered_in_turn(short) == count


def test_in_virtual_time_nothing_is_late() -> None:
    assert answered_in_turn(recording(SCANS + 0.01, live=None)) == 0
