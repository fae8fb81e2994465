"""Trials in real time: what virtual time can't carry, and how such trials end."""

import os
import re
import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from node_runs import PREAMBLE, RunNode, short

from grader.course.exercises import find_exercise
from grader.course.submission import Submission
from grader.errors import GraderError
from grader.grading.grading import grade_submission
from grader.recording import Recording
from grader.trial.real_time import _LiveTrial
from grader.trial.trials import NodeTrials
from grader.trial.virtual_time import Limits
from rclpy_virtual_time.link.hosts import ForkServer
from sim.messages import Message

RunLive = Callable[..., Recording]


# --- what virtual time can't carry ---------------------------------------------------------------

UNVIRTUAL = {
    "EventsExecutor": """
        from rclpy.experimental.events_executor import EventsExecutor
        rclpy.init(); executor = EventsExecutor(); executor.add_node(Echo()); executor.spin()
    """,
    "while not done": """
        rclpy.init(); node = Echo()
        threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
        while not getattr(node, 'done', False): pass
    """,
}


@pytest.mark.parametrize("style", UNVIRTUAL)
def test_what_virtual_time_cannot_carry_is_noticed(style: str, run_node: RunNode) -> None:
    recording = run_node(UNVIRTUAL[style], limits=Limits(start=1.0, step=1.0, total=5.0))
    assert recording.outcome.kind in ("real_time", "hung")


OWN_EXECUTOR = """\
from rclpy.experimental.events_executor import EventsExecutor
executor = EventsExecutor()
executor.add_node(node)
executor.spin()
"""


@pytest.mark.long
def test_it_is_graded_in_real_time_and_the_report_says_so(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    exercise = find_exercise("obstacle_avoidance")
    source = (exercise.solutions / exercise.files[0]).read_text()
    (spin,) = re.findall(r"(?m)^ *while rclpy\.ok\(\):\n.*spin_once.*\n", source)
    own = textwrap.indent(OWN_EXECUTOR, " " * 12)
    file = tmp_path / exercise.files[0]
    file.write_text(source.replace(spin, own))
    grading = grade_submission(
        exercise, Submission(file), forkserver, file=file.name, only=["clear_zone"]
    )

    outcomes = {check.id: check.outcome for check in grading.checks}
    assert "fail" not in outcomes.values()
    assert outcomes["wiring"] == "pass"
    (note,) = grading.as_dict()["notes"]
    assert "ran in real time" in note
    assert all(recording.live is not None for recording in grading.recordings)


@pytest.mark.long
def test_a_busy_wait_runs_in_real_time(forkserver: ForkServer, tmp_path: Path) -> None:
    file = tmp_path / "node.py"
    file.write_text(PREAMBLE + textwrap.dedent(UNVIRTUAL["while not done"]))
    limits = Limits(start=1.0, step=1.0, total=5.0)
    with NodeTrials(Submission(file), forkserver, limits=limits) as trials:
        first, second = trials.get("avoid_infinity"), trials.get("avoid_blind")

    for recording in (first, second):
        assert recording.outcome.completed
        assert recording.live is not None and "without letting time pass" in recording.live.reason
        assert len(recording.twists().t) == len(recording.scans())


def test_a_node_that_never_gets_started_is_not_run_again_and_again(
    forkserver: ForkServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Limits, "start", 0.5)
    file = tmp_path / "node.py"
    file.write_text("while True: pass")
    with NodeTrials(Submission(file), forkserver, limits=Limits(start=0.5, step=1.0)) as trials:
        first = trials.get("avoid_infinity")
        monkeypatch.setattr("grader.trial.trials.run_trial", None)
        second = trials.get("avoid_blind")

    assert [first.outcome.kind, second.outcome.kind] == ["hung", "hung"]
    assert second.duration_s == 0.0


def test_a_killed_node_has_died_and_the_robot_comes_to_rest(run_live: RunLive) -> None:
    recording = run_live("""
        class Shot(Echo):
            scans = 0
            def on_scan(self, scan):
                twist = Twist(); twist.linear.x = 0.3; self.publisher.publish(twist)
                self.scans += 1
                if self.scans == 8: os.kill(os.getpid(), 9)
        rclpy.init(); rclpy.spin(Shot())
    """, short(4.0))  # fmt: skip

    truth, robot = recording.truth, recording.scenario.robot
    assert (recording.outcome.kind, "signal 9" in recording.outcome.text) == ("died", True)
    assert truth.v.max() > 0.1
    still_driven = recording.twists().t[-1] + robot.command_timeout
    rest = still_driven + 0.3 / robot.max_acceleration + 0.05
    assert np.all(truth.v[truth.t / 1e9 > rest] == 0.0)
    assert truth.v[-1] == 0.0


def test_a_killed_robot_is_no_verdict_on_the_node(
    run_live: RunLive, monkeypatch: pytest.MonkeyPatch
) -> None:
    transmit = _LiveTrial._transmit
    sent = []

    def shot(trial: _LiveTrial, messages: Sequence[Message]) -> None:
        transmit(trial, messages)
        sent.append(messages)
        if len(sent) == 5:
            trial.hosts.radio._host.kill()

    monkeypatch.setattr(_LiveTrial, "_transmit", shot)
    with pytest.raises(GraderError, match="the robot's radio has died"):
        run_live("rclpy.init(); rclpy.spin(Echo())", short(5.0))


AUTOGROUP = Path("/proc/self/autogroup")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may go before others")
@pytest.mark.skipif(not AUTOGROUP.exists(), reason="this kernel has no autogroups")
def test_robot_and_node_go_before_the_programs_of_other_sessions(
    run_live: RunLive, monkeypatch: pytest.MonkeyPatch
) -> None:
    transmit = _LiveTrial._transmit
    groups = {}

    def looking(trial: _LiveTrial, messages: Sequence[Message]) -> None:
        transmit(trial, messages)
        for host in (trial.hosts.radio._host, trial.hosts.programs[0].host):
            groups[host.pid] = Path(f"/proc/{host.pid}/autogroup").read_text().split()[-2:]

    mine = AUTOGROUP.read_text()
    monkeypatch.setattr(_LiveTrial, "_transmit", looking)
    run_live("rclpy.init(); rclpy.spin(Echo())", short(0.2))
    assert list(groups.values()) == [["nice", "-20"]] * 2
    assert AUTOGROUP.read_text() == mine
