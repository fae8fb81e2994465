"""The pitfalls' nodes as parameters of tests, and their runs, each driven once."""

import functools

import pytest

from grader.authoring.pitfalls import PITFALLS, Pitfall, drive
from grader.recording import Recording
from rclpy_virtual_time.link.hosts import ForkServer

BY_NAME = {pitfall.name: pitfall for pitfall in PITFALLS}
WRONG = [(pitfall, node) for pitfall in PITFALLS for node in pitfall.wrong]
EVERY = [(pitfall, node) for pitfall in PITFALLS for node in pitfall.nodes]


def named(value: object) -> str:
    return value.name if isinstance(value, Pitfall) else str(value)


each_wrong = pytest.mark.parametrize(("pitfall", "node"), WRONG, ids=named)
each_node = pytest.mark.parametrize(("pitfall", "node"), EVERY, ids=named)
each_pitfall = pytest.mark.parametrize("pitfall", PITFALLS, ids=named)


def long_but_1(exercise: str) -> tuple[pytest.MarkDecorator, ...]:
    """Mark what takes long: all but exercise 1."""
    return () if exercise == "obstacle_avoidance" else (pytest.mark.long,)


class Runs:
    """The replayed runs, each driven once."""

    def __init__(self, forkserver: ForkServer) -> None:
        self.of = functools.cache(lambda name, node: drive(BY_NAME[name], node, forkserver))

    def wrong(self, name: str) -> Recording:
        return self.of(name, f"{name}_wrong")

    def right(self, name: str) -> Recording:
        return self.of(name, BY_NAME[name].right)
