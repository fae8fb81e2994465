"""What a node said around a moment."""

from dataclasses import replace

from grader.recording import Outcome, Recording
from grader.recording.words import told_lines, words_of
from grader.trial.endings import not_run
from rclpy_virtual_time.link.log import LogLine
from sim.messages import Message, encode, typestore
from sim.scenario_files import load_scenario
from sim.simulation import Simulation

ARRAY = "diagnostic_msgs/msg/DiagnosticArray"


def recording(*lines: tuple[float, str, str], published: tuple[Message, ...] = ()) -> Recording:
    log = tuple(LogLine(round(t * 1e9), level, text) for t, level, text in lines)
    empty = not_run(Simulation(load_scenario("demo_wall")), Outcome("completed"))
    return replace(empty, log=log, published=published)


def test_the_lines_of_the_moment_are_quoted() -> None:
    found = recording((0.5, "info", "early"), (2.0, "info", "now"), (2.1, "info", "late"))
    assert words_of(found, 2.0) == ["2.00 s  info: now"]


def test_warnings_go_before_chatter_and_are_not_repeated() -> None:
    found = recording(
        (1.5, "error", "no model"), (1.8, "stdout", "hello"), (1.9, "error", "no model")
    )
    assert words_of(found, 2.0) == ["1.90 s  error: no model"]
    assert words_of(found, None)[-1] == "1.90 s  error: no model"


def test_stacks_that_the_judge_asked_for_are_not_the_nodes_words() -> None:
    told = ('  File "agent.py", line 7 in on_scan', "  Garbage-collecting", "")
    found = recording(*((2.0, "stderr", line) for line in told))
    assert words_of(found, 2.0) == told_lines(found.log) == []


def test_the_newest_diagnostic_is_quoted_and_bytes_that_are_none_are_not() -> None:
    types = typestore().types
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](0, 0), "")
    status = types["diagnostic_msgs/msg/DiagnosticStatus"](0, "brake", "stale_scan", "", [])
    data = encode(types[ARRAY](header, [status]), ARRAY)
    good = Message("/diagnostics", ARRAY, 10**9, data)
    bad = Message("/diagnostics", ARRAY, 10**9, b"nonsense")

    assert words_of(recording(published=(good,)), 2.0) == ["1.00 s  /diagnostics brake: stale_scan"]
    assert words_of(recording(published=(bad,)), 2.0) == []


def test_the_last_words_are_those_at_the_end() -> None:
    found = recording((0.5, "info", "first"), (2.0, "stdout", "printed"))
    assert told_lines(found.log)[-1:] == ["2.00 s  printed"]
