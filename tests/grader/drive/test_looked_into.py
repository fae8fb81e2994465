"""Moments that somebody looks into: the same run, and what its recording says."""

from __future__ import annotations

import importlib
import math
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drives import drive_file

from grader.claims.claims import Claim, claims, complete
from grader.course.exercises import all_exercises, find_exercise
from grader.drive import drive_node, scenario_for, tables_of
from grader.launchers import ForkServerPool
from grader.recording import Recording
from grader.trial.virtual_time import asked_at
from rclpy_virtual_time.host.frames import Moment, Value
from rclpy_virtual_time.link.hosts import ForkServer
from sim.messages import Message
from sim.scenario import Scenario
from sim.scenario_files import scenario_names

THREADS = {
    "obstacle_avoidance": ("multithreaded_groups", "worker_thread_queue", "spin_once_loop"),
    "slow_model": ("thread_pool",),
    "model_server": ("coroutine_client", "threaded_server"),
}
TOGETHER = {"model_server": "detect_together", "goal_seeking": "goal_arrival"}
HIDDEN = ("/rosout", "/parameter_events")


@pytest.fixture(scope="session")
def looker(forkservers: ForkServerPool) -> ForkServer:
    """A warm fork server whose hosts can look into moments."""
    return forkservers.of((Moment.LIBRARY,))


def in_words(message: Message, what: str = "words") -> Any:
    """Return a recorded message as a moment has it."""
    from rclpy.serialization import deserialize_message  # noqa: PLC0415

    from rclpy_virtual_time.host import in_words  # noqa: PLC0415

    package, kind, name = message.type.split("/")
    found = deserialize_message(
        message.data, getattr(importlib.import_module(f"{package}.{kind}"), name)
    )
    return in_words.words(found, 1000) if what == "words" else in_words.parts_of(found)


def topic_of(message: Message) -> str:
    return message.topic.removeprefix("/from_node")


def said(recording: Recording, begin: int, end: int) -> list[tuple[int, str, str]]:
    found = [m for m in recording.published if begin <= m.time <= end and m.topic not in HIDDEN]
    return [(m.time, topic_of(m), in_words(m)) for m in found]


def compared(recording: Recording, program: str, moment: Moment) -> list[str]:
    """Return what a moment says and the recording doesn't, or the other way round."""
    wrong, ends = [], [end for end in recording.endpoints if end.kind == "publisher"]
    mine = {end.topic for end in ends if end.process == program}
    mine -= {end.topic for end in ends if end.process != program}
    if not moment.time <= moment.asked:
        wrong.append(f"began at {moment.time}")
    if moment.kind == "subscription":
        came = [m for m in recording.messages if topic_of(m) == moment.about]
        last = [m for m in came if m.time <= moment.time][-1:]
        here = moment.fields
        if [in_words(m, "fields") for m in last] != [here]:
            wrong.append(f"{moment.about}: {here}, not {list(map(in_words, last))}")
    sent = [(each.time, each.topic, each.text) for each in moment.sent]
    there = said(recording, moment.time, 10**18)
    wrong += [f"never sent: {each}" for each in sent if each not in there]
    own = said(recording, moment.time + 1, moment.asked)
    own = [each for each in own if each[1] in mine][1 - Moment.MOST :]
    wrong += [f"left out: {each}" for each in own if each not in sent]
    return wrong


def solutions() -> Iterator[Claim]:
    for exercise in all_exercises():
        stems = THREADS.get(exercise.slug, ())
        yield from (c for c in claims(exercise) if c.kind == "reference" or c.stem in stems)


def scenario_of(slug: str) -> Scenario:
    """Return a scenario of an exercise's checks in which its programs drive."""
    if slug in TOGETHER:
        return scenario_for(TOGETHER[slug])
    names = sorted(path.stem for path in find_exercise(slug).judge.glob("scenarios/*.toml"))
    loaded = (scenario_for(name) for name in names if name in scenario_names())
    return next(each for each in loaded if each.training is None and each.duration >= 3)


@pytest.mark.long
@pytest.mark.parametrize("claim", list(solutions()), ids=lambda claim: claim.name)
def test_twenty_moments_are_what_the_recording_says(
    claim: Claim, forkservers: ForkServerPool
) -> None:
    scenario = scenario_of(claim.exercise.slug)
    plain = forkservers.of(claim.exercise.libraries)
    looking = forkservers.of((*claim.exercise.libraries, Moment.LIBRARY))
    at = [random.Random(f"{claim.name} {i}").uniform(0.4, scenario.duration) for i in range(20)]
    with complete(claim) as submission:
        before = drive_node(submission, scenario, plain)
        recording = drive_node(submission, scenario, looking, look=at)
    assert recording.digest() == before.digest()
    assert not before.moments
    last = {(program, moment.asked): moment for program, moment in recording.moments}
    wrong = [each for (program, _), moment in last.items()
             for each in compared(recording, program, moment)]  # fmt: skip
    asked = {moment.asked for _, moment in recording.moments}
    assert asked == {asked_at(time, scenario) for time in at}
    assert wrong == []


RAISES = """
class Agent(Echo):
    def __init__(self):
        super().__init__('agent')
        self.count, self.speed = 0, 0.5

    def on_scan(self, scan):
        self.count += 1
        left = 4 - self.count
        command = Twist()
        command.linear.x = self.speed
        self.publisher.publish(command)
        self.share(left)

    def share(self, left):
        return 1 / left

rclpy.init(); rclpy.spin(Agent())
"""
TWO = """
class Agent(Echo):
    def __init__(self):
        super().__init__('agent')
        self.nearest = 0.0
        self.create_timer(0.06, self.tick)

    def on_scan(self, scan):
        self.nearest = min(scan.ranges)

    def tick(self):
        self.publisher.publish(Twist())

rclpy.init(); rclpy.spin(Agent())
"""
# What is its own tells on /evil whenever a line of it runs.
EVIL = """
ran = []
class Meta(type):
    def __getattribute__(cls, name): ran.append(name); return type.__getattribute__(cls, name)
    def __eq__(cls, other): ran.append('class eq'); return True
    def __hash__(cls): ran.append('class hash'); return 1
    def __instancecheck__(cls, other): ran.append('instance'); return True
class Evil(metaclass=Meta):
    __slots__ = ('slot', '__dict__')
    def __getattribute__(self, name): ran.append(name); return object.__getattribute__(self, name)
    def __repr__(self): ran.append('repr'); return 'evil'
    def __eq__(self, other): ran.append('eq'); return True
    __str__ = __len__ = __iter__ = __hash__ = __repr__
    @property
    def __class__(self): ran.append('class'); return int
class Long(list):
    __len__ = __iter__ = __repr__ = lambda self: ran.append('list')
class Word(str):
    __str__ = __repr__ = __getitem__ = __len__ = lambda *_: ran.append('str')
class Failed(Exception):
    def __str__(self): ran.append('exception'); return '?'

class Agent(Node):
    def __init__(self):
        super().__init__('agent')
        self.evil, self.long, self.word = object.__new__(Evil), Long([1]), Word('w')
        self.many, self.table = list(range(10**6)), dict.fromkeys(range(10**6))
        self.deep, self.huge, self.text = [[[[[[[[1]]]]]]]], 1 << 10**6, '\\x1b[2J' * 10**6
        self.itself, self.near = {}, __import__('numpy').float32(2.5)
        self.itself['itself'] = self.itself
        self.__dict__[Word('odd')] = 1
        self.__dict__.update({f'field_{i}': i for i in range(10**5)})
        self.said = self.create_publisher(String, '/evil', 10)
        self.create_timer(0.1, self.tick)

    def tick(self):
        mine = self.evil
        self.said.publish(String(data=repr(len(ran))))
        if self.get_clock().now().nanoseconds % 10**9 > 8 * 10**8:
            raise Failed(mine)

rclpy.init(); rclpy.spin(Agent())
"""


def looked(
    tmp_path: Path, looker: ForkServer, source: str, *at: float
) -> tuple[Recording, list[Moment]]:
    """Drive a node's text for a second, with and without looking: it is the same run."""
    plain, recording = (drive_file(tmp_path, looker, source, look=look) for look in ((), at))
    assert plain.digest() == recording.digest()
    assert plain.outcome == recording.outcome
    return recording, [moment for _, moment in recording.moments]


def test_what_came_what_changed_what_left_and_what_was_raised(
    tmp_path: Path, looker: ForkServer
) -> None:
    recording, [second, last] = looked(tmp_path, looker, RAISES, 0.15, 0.9)
    shown = round(second.time / 1e9, 2)
    assert shown * 1e9 < second.time  # and it is that moment's, all the same
    [again] = looked(tmp_path, looker, RAISES, shown)[1]
    assert again.time == second.time
    at = [random.Random(i).uniform(0, 1) for i in range(20)]
    _, moments = looked(tmp_path, looker, RAISES, *at)
    assert not any(compared(recording, "foreign.py", each) for each in (second, last, *moments))
    kept = {value.name: (value.before, value.text) for value in second.values}
    assert kept == {"count": ("1", "2"), "speed": ("0.5", "0.5")}
    [sent] = second.sent
    assert (sent.topic, sent.places[0].function) == ("/cmd_vel", "on_scan")
    assert [(value.name, value.text) for value in sent.places[0].values] == [("left", "2")]
    assert last.raised == "ZeroDivisionError('division by zero')"
    assert [place.function for place in last.raised_in] == ["share", "on_scan"]
    [table] = tables_of(recording, [0.9, 0.15])
    marked = {row["name"]: row["cells"] for row in table["rows"] if row["marked"]}
    assert marked["count"] == ["1 → 2", "3 → 4"]
    assert "speed" not in marked


def test_two_moments_show_one_function(tmp_path: Path, looker: ForkServer) -> None:
    """Whichever began last by each of them; and which reading of a scan was the nearest."""
    recording, _ = looked(tmp_path, looker, TWO, 0.62, 0.75)
    for at, began in ((0.62, "on_scan"), (0.75, "tick")):
        [table] = tables_of(recording, [at])
        assert table["rows"][0]["cells"][0].startswith(began)
        for name in table["functions"]:
            [of_one] = tables_of(recording, [at], name)
            assert of_one["functions"][0] == name == of_one["rows"][0]["cells"][0].split()[0]
        assert tables_of(recording, [at], "no_such") == [table]
    assert set(table["functions"]) == {"on_scan", "tick"}
    [table] = tables_of(recording, [0.62, 0.75])
    rows = {row["name"]: row["cells"] for row in table["rows"]}
    marked = {row["name"] for row in table["rows"] if row["marked"]}
    assert [cell.partition(" ")[0] for cell in rows["Function"]] == ["on_scan"] * 2
    assert [cell.partition(" ")[0] for cell in rows["Also by then"]] == ["tick"] * 2
    scans = recording.scans()
    for cell, t in zip(rows["nearest"], rows["Began"], strict=True):
        scan = next(each for each in scans if f"{each.t:.3f} s" == t)
        i = int(np.argmin(scan.ranges))
        where = f"{scan.ranges[i]:.3f} m at {round(math.degrees(scan.angles[i]), 1) + 0.0}°"
        assert cell == f"{where}, ranges[{i}]; 360 of 360 are in range"
    assert marked == set()  # it stands, and that a stamp or a time is another tells nothing


def test_no_line_of_the_program_runs_and_much_is_cut_short(
    tmp_path: Path, looker: ForkServer
) -> None:
    recording, [moment, last] = looked(tmp_path, looker, EVIL, 0.5, 0.95)
    assert {in_words(m) for m in recording.of("/evil")} == {"String(data='0')"}
    kept = {value.name: value.text for value in moment.values}
    assert (kept["evil"], kept["long"], kept["word"]) == ("<Evil>", "<Long>", "<Word>")
    assert kept["near"] == "2.5"
    assert kept["many"] == "[0, 1, 2, … 999,995 more, 999998, 999999]"
    assert kept["huge"] == "<int of 1000001 bits>"
    assert kept["text"].endswith("(4,000,000 in all)")
    assert last.raised == "Failed(<Evil>)"
    assert len(moment.values) == len(last.values) == Value.MOST


def test_only_a_launcher_that_is_made_for_it_can_look(
    tmp_path: Path, forkserver: ForkServer
) -> None:
    recording = drive_file(tmp_path, forkserver, RAISES, look=[0.5])
    assert recording.outcome.kind == "died"
    assert not recording.published
    assert not recording.moments
