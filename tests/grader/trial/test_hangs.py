"""A hang names the student's line and loop, from the stacks and from what was handed in."""

from pathlib import Path

import pytest

from grader.course.submission import Submission
from grader.recording import Outcome, Recording, death_of
from grader.trial.endings import not_run
from grader.trial.hangs import WANTS, busy_wait, located
from sim.scenario_files import load_scenario
from sim.simulation import Simulation

AGENT = """\
import threading

def near(scan):
    found = []
    i = 0
    while i < len(scan):
        for reading in scan:
            found.append(reading)

    return found

class Agent:
    def __init__(self):
        threading.Thread(target=self.work()).start()

    def work(self):
        while True:
            pass
"""
CALLBACK = """\
Thread 0x01 (most recent call first):
  File "/opt/rclpy_virtual_time/host/virtual/kernel.py", line 9 in park
  File "agent.py", line 3 in near

Current thread 0x02 (most recent call first):
  File "/opt/lib/numpy/core.py", line 3 in append
  File "agent.py", line 8 in near
  File "/opt/lib/rclpy/executors.py", line 111 in await_or_execute
  File "agent.py", line 99 in main
"""
CONSTRUCTOR = """\
  File "agent.py", line 17 in work
  File "agent.py", line 14 in __init__
"""


THREAD = """\
Thread 0x01 (most recent call first):
  File "/opt/rclpy_virtual_time/host/virtual/kernel.py", line 9 in park
  File "/opt/lib/rclpy/executors.py", line 111 in wait_for_ready_callbacks
  File "agent.py", line 99 in main

Thread 0x02 (most recent call first):
  File "/opt/rclpy_virtual_time/host/virtual/messages.py", line 9 in publish
  File "agent.py", line 18 in work
"""


WAITS = """\
  File "/opt/lib/python3.11/threading.py", line 320 in wait
  File "agent.py", line 18 in work
  File "agent.py", line 14 in __init__
"""


def hung(folder: Path, stacks: str, kind: str = "hung", source: str = AGENT) -> Recording:
    path = folder / "agent.py"
    path.write_text(source)
    simulation = Simulation(load_scenario("demo_wall"))
    return located(not_run(simulation, Outcome(kind, "no answer", 0.0, stacks)), Submission(path))


def test_the_line_and_the_loop_are_named(tmp_path: Path) -> None:
    outcome = hung(tmp_path, CALLBACK).outcome
    death = death_of(outcome.detail)

    assert death is not None
    assert death.place == "a callback"
    assert [frame.line for frame in death.frames] == [8]
    assert death.frames[0].source == "found.append(reading)"
    assert death.loop == "line 6, `while i < len(scan):`"
    assert outcome.text == "the node did not come back from a callback (line 8, in near)"
    assert outcome.detail.endswith(CALLBACK)


def test_a_thread_that_is_called_instead_of_started_is_named(tmp_path: Path) -> None:
    death = death_of(hung(tmp_path, CONSTRUCTOR).outcome.detail)

    assert death is not None
    assert (death.place, death.loop) == ("the constructor", "line 17, `while True:`")
    assert "target" in death.advice


def test_a_constructor_that_waits_is_not_advised_to_spin(tmp_path: Path) -> None:
    outcome = hung(tmp_path, WAITS, "never_spun").outcome
    death = death_of(outcome.detail)

    assert death is not None
    assert (death.place, death.loop) == ("the constructor", "line 17, `while True:`")
    assert outcome.text.startswith("the node never spins: its program stays in the constructor")


def test_a_rate_wants_somebody_who_spins(tmp_path: Path) -> None:
    never = hung(tmp_path, '  File "agent.py", line 2 in go', "never_spun", "\nrate.sleep()")
    assert "Thread(target=rclpy.spin" in never.outcome.detail


def test_a_loop_beside_spin_is_told_what_it_wants(tmp_path: Path) -> None:
    recording = hung(tmp_path, THREAD)
    death = death_of(recording.outcome.detail)

    assert death is not None
    assert (death.place, death.advice) == ("the start-up", WANTS)
    assert "(line 17, `while True:`): give" in busy_wait(recording)


@pytest.mark.parametrize("stacks", ["", "nonsense", '  File "/x/rclpy/executors.py", line 1 in f'])
def test_stacks_without_a_line_of_the_students_stay_as_they_are(
    tmp_path: Path, stacks: str
) -> None:
    assert hung(tmp_path, stacks).outcome == Outcome("hung", "no answer", 0.0, stacks)
