"""The most probable cause: found by evidence, silent where there is none, never in the way."""

import re
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
from node_runs import RunNode

from grader.authoring.causes import known_toml, misled, stale
from grader.course.exercises import all_exercises, find_exercise
from grader.grading.causes import find_cause
from grader.grading.causes.cause import hint_for
from grader.grading.causes.habits import _waits_or_never_uses
from grader.grading.causes.known import (
    KNOWN,
    MOST,
    catalogue,
    fingerprint,
    known_cause,
    told_as,
)
from grader.recording import Outcome, Recording
from grader.recording.inferences import Inference
from sim.scenario_files import load_scenario

EXERCISE = find_exercise("obstacle_avoidance")


@dataclass(frozen=True)
class Check:
    """A check that failed."""

    id: str
    message: str = ""
    actual: str = ""
    time: float | None = None
    scenario: str | None = None
    kind: str = "core"
    outcome: str = "fail"
    help: str = ""
    where: str = ""


NODE = """
class Agent(Node):
    def __init__(self):
        super().__init__('agent')
        self.publisher = self.create_publisher(Twist, '/cmd_vel', 10)
        self.create_subscription(LaserScan, '/scan', self.on_scan, 10)
    def on_scan(self, scan):
        beams = list(scan.ranges)
        near = min({beams})
        twist = Twist()
        twist.linear.x = 0.0 if near < 0.5 else {slow} if near < 1.0 else 0.5
        {publish}
rclpy.init()
rclpy.spin(Agent())
"""
PUBLISH = "self.publisher.publish(twist)"


def run(run_node: RunNode, beams: str, slow: str = "0.15", publish: str = PUBLISH) -> Recording:
    source = NODE.format(beams=beams, slow=slow, publish=publish)
    return run_node(source, load_scenario("avoid_zones"))


@pytest.mark.parametrize(
    ("beams", "said"),
    [
        ("beams[:90] + beams[270:]", "first beam for straight ahead"),
        ("beams", "anywhere around the robot"),
        ("beams[135:226]", "within about ±45°"),
        ("beams[178:183]", "compare degrees with radians"),
        ("[beams[0]]", "only looks at the first beam"),
        ("beams[180:]", "on its left"),
        ("beams[90:181]", "right half of what is ahead"),
    ],
)
def test_the_beams_that_a_node_reacts_to_are_named(
    run_node: RunNode, beams: str, said: str
) -> None:
    # decisions may be wrong as well: perception is judged first
    recording = run(run_node, beams, slow="0.25")
    failed = [Check("slow_zone", scenario="avoid_zones"), Check("only_linear_x")]

    cause = find_cause(EXERCISE, failed, [recording])

    assert cause is not None
    assert said in cause.text
    assert cause.hint is not None
    assert cause.hint.anchor == "hints.md#task-2-perceive"
    assert "\n" not in cause.hint.text  # the page's line breaks are not the reader's
    assert cause.explains == ("slow_zone",)


@pytest.mark.parametrize(("beams", "slow"), [("beams[90:271]", "0.3"), ("beams[90:271]", "0.6")])
def test_who_sees_right_is_not_told_about_beams(run_node: RunNode, beams: str, slow: str) -> None:
    failed = [Check("slow_zone", scenario="avoid_zones")]
    assert find_cause(EXERCISE, failed, [run(run_node, beams, slow)]) is None


def test_an_error_that_is_caught_again_and_again_is_quoted(run_node: RunNode) -> None:
    caught = "self.get_logger().error(repr(NameError('speed is not defined')))"
    recording = run(run_node, "beams[90:271]", publish=f"{PUBLISH}; {caught}")
    cause = find_cause(EXERCISE, [Check("slow_zone", scenario="avoid_zones")], [recording])
    assert cause is not None
    assert "again and again: NameError('speed is not defined')" in cause.text


def test_two_commands_for_each_scan_are_named(run_node: RunNode) -> None:
    recording = run(run_node, "beams[90:271]", publish=f"{PUBLISH}; {PUBLISH}")
    failed = [Check("one_command_per_scan", scenario="avoid_zones")]
    cause = find_cause(EXERCISE, failed, [recording])
    assert cause is not None
    assert "two commands for each scan" in cause.text


def test_a_loop_that_publishes_is_named(run_node: RunNode) -> None:
    recording = run(run_node, "beams[90:271]", publish=f"[{PUBLISH} for _ in range(40)]")
    cause = find_cause(EXERCISE, [Check("one", scenario="avoid_zones")], [recording])
    assert cause is not None
    assert "40 commands within one callback" in cause.text


def test_a_client_that_waits_for_its_answer_is_told(run_node: RunNode) -> None:
    recording = run(run_node, "beams[90:271]")
    said = Check("never_blocks", actual="none; it had asked /detect", scenario="avoid_zones")
    cause = find_cause(find_exercise("model_server"), [said], [recording])
    assert cause is not None
    assert "call_async()" in cause.text


def test_a_death_is_the_cause_whatever_else_failed(run_node: RunNode) -> None:
    recording = run(run_node, "beams[400:401]")
    where = "line 33 of node.py, in on_scan:  near = min(beams[400:401])"
    failed = [Check("slow_zone"), Check("blind", scenario="avoid_zones", where=where)]

    cause = find_cause(EXERCISE, failed, [recording])

    assert cause is not None
    assert cause.text.startswith("The node dies in the callback of /scan: ValueError")
    assert "near = min(beams[400:401])" in cause.where


# --- known mistakes ------------------------------------------------------------------------------

STOPS_LATE = [Check("stop_zone", "“0.49 m ahead”", "0.15 m/s", 1.613), Check("no_contact")]


def test_known_mistakes_are_found_by_their_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    known = {fingerprint(STOPS_LATE, {}): ["Stops late.", "Counts in feet."]}
    monkeypatch.setattr("grader.grading.causes.known.catalogue", lambda _: known)

    cause = known_cause(EXERCISE, STOPS_LATE, {})
    other = [Check("stop_zone", "“0.49 m ahead”", "0.20 m/s", 1.613), Check("no_contact")]

    assert cause is not None
    assert cause.text == "One of two, perhaps: the node stops late, or the node counts in feet."
    assert known_cause(EXERCISE, other, {}) is None


def test_what_too_many_mistakes_share_is_not_told() -> None:
    rows = [(f"Mistake {i}.", "abc") for i in range(MOST + 1)]
    assert known_toml("x", rows).count("Mistake") == 0
    assert known_toml("x", rows[:MOST]).count("Mistake") == MOST


def test_who_answers_otherwise_later_is_not_taken_for_it(run_node: RunNode) -> None:
    failed = [Check("stop_zone", "“0.49 m ahead”", "0.15 m/s", 1.613, "avoid_zones")]
    prints = {
        fingerprint(failed, {"avoid_zones": run(run_node, "beams[90:271]", slow)})
        for slow in ("0.15", "0.15", "0.2")
    }
    assert len(prints) == 2


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_the_tables_can_be_read_and_every_hint_is_there(exercise) -> None:  # type: ignore[no-untyped-def]
    from grader.grading.causes.cause import _places  # noqa: PLC0415

    assert catalogue(exercise.slug)
    assert (KNOWN / f"{exercise.slug}.toml").stat().st_size < 40_000
    for check in _places()[exercise.slug]:
        assert hint_for(exercise, [Check(check)]), check


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_every_known_mistake_is_a_mutants(exercise) -> None:  # type: ignore[no-untyped-def]
    assert stale(exercise) == []
    assert all(re.fullmatch("[0-9a-f]{16}", key) for key in catalogue(exercise.slug))


def test_a_mutant_that_is_told_anothers_mistake_is_noticed() -> None:
    own, other = sorted({text for texts in catalogue(EXERCISE.slug).values() for text in texts})[:2]
    cause = f"Most probably: {told_as(other)}."
    assert misled(EXERCISE, own, cause) == [other]
    assert misled(EXERCISE, own, f"{cause}, or {told_as(own)}") == []
    assert misled(EXERCISE, own, "The node dies in the callback of /scan.") == []
    assert misled(EXERCISE, own, "") == []


def test_no_failure_has_no_cause() -> None:
    assert find_cause(EXERCISE, [], []) is None


def test_who_never_stops_is_told_of_the_order_of_the_comparisons(run_node: RunNode) -> None:
    order = f"twist.linear.x = twist.linear.x or 0.15; {PUBLISH}"
    recording = run(run_node, "beams[90:271]", publish=order)
    failed = [Check("stop_zone", scenario="avoid_zones"), Check("only_linear_x")]

    cause = find_cause(EXERCISE, failed, [recording])

    assert cause is not None
    assert "ask `distance < 0.5` before" in cause.text
    assert cause.explains == ("stop_zone",)


DIES = """
import threading
class Agent(Node):
    def __init__(self):
        super().__init__('agent')
        self.publisher = self.create_publisher(Twist, '/cmd_vel', 10)
        self.create_subscription(LaserScan, '/scan', self.on_scan, 10)
        threading.Thread(target=self.work, daemon=True).start()
    def work(self):
        self.wrok()
    def on_scan(self, scan):
        self.publisher.publish(Twist())
rclpy.init()
rclpy.spin(Agent())
"""


def test_a_thread_that_died_is_named_with_its_line(run_node: RunNode) -> None:
    recording = run_node(DIES, load_scenario("avoid_zones"))
    cause = find_cause(EXERCISE, [Check("clear_zone", scenario="avoid_zones")], [recording])
    assert cause is not None
    assert "A thread of the node died" in cause.text
    assert "has no attribute 'wrok'" in cause.text
    assert cause.where.endswith("in work")


def test_a_late_answer_is_named(run_node: RunNode) -> None:
    recording = run(run_node, "beams[90:271]", publish=f"import time; time.sleep(0.3); {PUBLISH}")
    failed = [Check("one_command_per_scan", scenario="avoid_zones")]
    cause = find_cause(EXERCISE, failed, [recording])
    assert cause is not None
    assert "comes 0.30 s after the first scan, when 3 more have come" in cause.text


@pytest.mark.parametrize(
    ("step", "until", "said"),
    [(0.05, 30.0, "the model answers"), (0.05, 0.1, "the control loop stops"), (0.2, 30.0, "lock")],
)
def test_how_control_and_inference_get_into_each_others_way(
    step: float, until: float, said: str
) -> None:
    ends = np.arange(1, 140) * 10**9 // 5
    asked = [Inference("predict", "m.pkl", int(t), int(t) + 10**9 // 5, 10**9 // 5) for t in ends]
    times = np.arange(0.2, 0.2 + until, step)[: int(until / step)]
    trial = SimpleNamespace(
        outcome=Outcome("completed"), inferences=asked, duration_s=30.0, live=None, delivered=(),
        times=lambda _: times[times < 30], log=(),
        twists=lambda: SimpleNamespace(linear_x=np.zeros(len(times)), values=np.zeros((1, 6))),
    )  # fmt: skip
    recordings = {"slow_leader": trial}

    text = _waits_or_never_uses(recordings)  # type: ignore[arg-type]

    assert said in text


@pytest.mark.parametrize("help_", ["It has to end.", "Does the loop of line 5, `while True:` end?"])
def test_a_hang_names_its_loop_once(help_: str) -> None:
    detail = "in the constructor\nagent.py, line 6, in work\n    pass\nloop: line 5, `while True:`"
    trial = SimpleNamespace(name="x", outcome=Outcome("hung", "hung", 0.0, detail))
    failed = [Check("wiring", scenario="x", where="line 6", help=help_)]

    cause = find_cause(EXERCISE, failed, [trial])  # type: ignore[list-item]

    assert cause is not None
    assert cause.text.count("line 5, `while True:`") == 1
