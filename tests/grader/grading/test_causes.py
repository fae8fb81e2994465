"""The most probable cause: found by evidence, silent where there is none, never in the way."""

import re
from types import SimpleNamespace
from typing import Any

import pytest
from node_runs import RunNode

from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.grading.causes.cause import hint_for
from grader.grading.causes.find import find_cause
from grader.grading.causes.own_words import slip_in_file
from grader.grading.causes.rhythm import kept_waiting
from grader.grading.grading import grade
from grader.grading.plugin import CheckResult
from grader.recording import Outcome, Recording
from grader.trial.trials import SavedTrials
from sim.scenario_files import load_scenario

EXERCISE = find_exercise("obstacle_avoidance")


def check(id_: str, **more: str) -> CheckResult:
    """Return a check that failed."""
    return CheckResult(id_, "", "core", 0, 10, "fail", **more)  # type: ignore[arg-type]


NODE = """
class Agent(Echo):
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
        ("beams[:90] + beams[270:]", "nearest thing behind the robot"),
        ("beams", "anywhere around the robot"),
        ("beams[135:226]", "within about ±45°"),
        ("beams[178:183]", "compare degrees with radians"),
        ("[beams[0]]", "nearest thing in the first beam"),
        ("beams[180:]", "on the robot's left"),
    ],
)
def test_the_beams_that_a_node_reacts_to_are_named(
    run_node: RunNode, beams: str, said: str
) -> None:
    # decisions may be wrong as well: perception is judged first
    recording = run(run_node, beams, slow="0.25")
    failed = [check("slow_zone", scenario="avoid_zones"), check("only_linear_x")]

    cause = find_cause(EXERCISE, failed, [recording])

    assert cause is not None
    assert said in cause.text
    assert re.match(r"In all \d+ scans of avoid_zones the speed follows", cause.text)
    assert cause.hint is not None
    assert cause.hint.anchor == "hints.md#task-3-perceive"
    assert "\n" not in cause.hint.text  # the page's line breaks are not the reader's
    assert cause.explains == ("slow_zone",)


@pytest.mark.parametrize(("beams", "slow"), [("beams[90:271]", "0.3"), ("beams[90:271]", "0.6")])
def test_a_node_that_sees_right_reads_nothing_about_beams(
    run_node: RunNode, beams: str, slow: str
) -> None:
    recording = run(run_node, beams, slow)
    assert find_cause(EXERCISE, [check("slow_zone", scenario="avoid_zones")], [recording]) is None


def test_an_error_that_is_caught_again_and_again_is_quoted(run_node: RunNode) -> None:
    caught = "self.get_logger().error(repr(NameError('speed is not defined')))"
    recording = run(run_node, "beams[90:271]", publish=f"{PUBLISH}; {caught}")
    failed = [check("slow_zone", scenario="avoid_zones"), check("drives_on", scenario="another")]
    cause = find_cause(EXERCISE, failed, [recording])
    assert cause is not None
    times = len(recording.scans())
    said = f"The node logs this error {times} times in avoid_zones: NameError('speed is not def"
    assert cause.text.startswith(said)
    assert cause.explains == ("slow_zone",)  # the log of the other trial does not say so


@pytest.mark.parametrize(
    ("error", "said"),
    [
        ("ModuleNotFoundError('No module named \\'tensorflow\\'')", "`import keras` does without"),
        (
            "RuntimeError('Invalid device string: <rclpy.parameter.Parameter object at 0x1>')",
            ".value",
        ),
        ("RuntimeError('no camera')", ""),
    ],
)
def test_an_error_that_may_be_anything_needs_a_rule(
    run_node: RunNode, error: str, said: str
) -> None:
    logged = f"self.get_logger().error(repr({error}))"
    recording = run(run_node, "beams[90:271]", slow="0.3", publish=f"{PUBLISH}; {logged}")
    cause = find_cause(EXERCISE, [check("slow_zone", scenario="avoid_zones")], [recording])
    assert ("" if cause is None else cause.text).count("Perhaps") == bool(said)
    assert said in ("" if cause is None else cause.text)


@pytest.mark.parametrize("said", ["{error!r}", "TypeError: {error}"])
def test_what_a_model_raises_on_purpose_is_no_cause(run_node: RunNode, said: str) -> None:
    error = TypeError("the model can't say anything about these features")
    caught = f"self.get_logger().error({said.format(error=error)!r})"
    recording = run(run_node, "beams[90:271]", slow="0.3", publish=f"{PUBLISH}; {caught}")
    assert find_cause(EXERCISE, [check("slow_zone", scenario="avoid_zones")], [recording]) is None


@pytest.mark.parametrize(
    ("publish", "said"),
    [
        (f"{PUBLISH}; {PUBLISH}", "two commands for each scan"),
        (f"[{PUBLISH} for _ in range(40)]", "40 commands at one moment"),
        (
            f"import time; time.sleep(0.3); {PUBLISH}",
            "comes 0.30 s after the first scan, when 3 more have come",
        ),
    ],
)
def test_the_rhythm_of_the_commands_is_named(run_node: RunNode, publish: str, said: str) -> None:
    failed = [check("one_command_per_scan", scenario="avoid_zones")]
    cause = find_cause(EXERCISE, failed, [run(run_node, "beams[90:271]", publish=publish)])
    assert cause is not None
    assert said in cause.text


def test_a_death_is_the_cause_whatever_else_failed(run_node: RunNode) -> None:
    recording = run(run_node, "beams[400:401]")
    where = "line 29 of node.py, in on_scan:  near = min(beams[400:401])"
    failed = [check("slow_zone"), check("blind", scenario="avoid_zones", where=where)]

    cause = find_cause(EXERCISE, failed, [recording])

    assert cause is not None
    assert cause.text.startswith("The node dies in the callback of /scan: ValueError")
    assert "near = min(beams[400:401])" in cause.where


@pytest.mark.parametrize("exercise", all_exercises(), ids=lambda exercise: exercise.slug)
def test_every_hint_of_a_check_is_there(exercise: Exercise) -> None:
    checks = grade(exercise, SavedTrials([]), file="x.py", field=True).checks
    for check in checks:
        there = hint_for(exercise, [check]) or not check.hint
        assert there, f"{exercise.folder / 'hints.md'}: no hint {check.hint} ({check.id})"


DIES = """
class Agent(Echo):
    def __init__(self):
        super().__init__('agent')
        threading.Thread(target=self.work, daemon=True).start()
    def work(self):
        self.wrok()
rclpy.init()
rclpy.spin(Agent())
"""


def test_a_thread_that_died_is_named_with_its_line(run_node: RunNode) -> None:
    recording = run_node(DIES, load_scenario("avoid_zones"))
    failed = [check("clear_zone", scenario="avoid_zones"), check("drives_on", scenario="another")]
    cause = find_cause(EXERCISE, failed, [recording])
    assert cause is not None
    assert cause.explains == ("clear_zone",)
    assert "A thread of the node died at 0.00 s" in cause.text
    assert "has no attribute 'wrok'" in cause.text
    assert cause.where.endswith("in work")


@pytest.mark.parametrize(
    ("where", "said"),
    [
        ("", True),
        ("line 7 of agent.py, in f: self.report", True),
        ("line 9 of agent.py, in f: self.report(speed)", True),  # which line 7 hides
        ("line 9 of agent.py, in f: 1 / 0", False),
    ],
)
def test_a_slip_is_a_cause_unless_the_node_died_of_another_line(where: str, said: bool) -> None:
    text = "line 7: self.report gets a value here and hides the method report: "
    lines = [SimpleNamespace(level="stderr", text=f"{text}give one another name")]
    trial: Any = SimpleNamespace(log=lines)

    cause = slip_in_file(EXERCISE, [check("wiring", where=where)], {"x": trial})

    assert (cause is not None and cause.text.startswith("Line 7: self.report")) is said


@pytest.mark.parametrize("help_", ["It has to end.", "Does the loop of line 5, `while True:` end?"])
def test_a_hang_names_its_loop_once(help_: str) -> None:
    detail = "in the constructor\nagent.py, line 6, in work\n    pass\nloop: line 5, `while True:`"
    trial = SimpleNamespace(name="x", log=(), outcome=Outcome("hung", "hung", 0.0, detail))
    failed = [check("wiring", scenario="x", where="line 6", help=help_)]

    cause = find_cause(EXERCISE, failed, [trial])  # type: ignore[list-item]

    assert cause is not None
    assert cause.text.count("line 5, `while True:`") == 1


LOCK = "LOCK.acquire()"  # which the first call gets


@pytest.mark.parametrize(
    ("in_callback", "said"),
    [
        (LOCK, r"on_scan, called at 0.1\d s, waits in vain"),
        (
            "time.sleep(0.3)",
            r"on_scan takes 0.30 s, as at \d.\d\d s, and meanwhile /scan, a timer of 0.2 s ",
        ),
        ("time.sleep(0.04)", ""),
    ],
)
def test_a_callback_that_keeps_the_others_waiting_is_named(
    run_node: RunNode, in_callback: str, said: str
) -> None:
    node = NODE.format(beams="beams[90:271]", slow="0.15", publish=f"{PUBLISH}; {in_callback}")
    source = f"LOCK = threading.Lock()\n{node}".replace(
        "rclpy.spin(Agent())",
        "executor = MultiThreadedExecutor(2)\nagent = Agent()\n"
        "agent.create_timer(0.2, lambda: None)\nexecutor.add_node(agent)\nexecutor.spin()",
    )
    recording = run_node(source, load_scenario("avoid_zones"))
    causes = [
        kept_waiting(EXERCISE, [check("rate", scenario="avoid_zones", expected=expected)],
                     {"avoid_zones": recording})
        for expected in ("one every 50 ms ± 10 ms", "a command every 50 ms, no gap over 75 ms")
    ]  # fmt: skip
    cause = causes[0]
    assert [each and each.text for each in causes] == [cause and cause.text] * 2
    assert bool(cause) == bool(said)
    assert cause is None or re.match(said, cause.text)
    assert cause is None or re.match(r"line \d+ of \w+\.py, in on_scan$", cause.where)
