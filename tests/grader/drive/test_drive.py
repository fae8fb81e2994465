"""Driving any node: the scenario with changes, and the summary."""

import io
import re
import sys
from ctypes import c_double
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import pytest
from drives import drive_file, summary
from node_runs import PREAMBLE, RunNode, short

from grader.course.submission import Submission
from grader.drive import (
    arguments_of,
    drive_node,
    read_env,
    read_keys,
    read_params_files,
    read_stdin,
    scenario_for,
)
from grader.drive.summary import NO_MAIN
from grader.errors import InputError
from grader.recording import Outcome, Recording
from grader.trial.virtual_time import Limits
from rclpy_virtual_time import Start
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario import Transforms
from sim.scenario_files import load_scenario


def test_without_changes_it_is_the_scenario_with_transforms() -> None:
    scenario = scenario_for("demo_wall")
    assert scenario.transforms.enabled
    assert msgspec.structs.replace(scenario, transforms=Transforms()) == load_scenario("demo_wall")


def test_another_lidar_and_duration() -> None:
    changed = scenario_for("demo_wall", lidar="lds01", duration=3.5)
    assert (changed.lidar.profile, changed.duration) == ("lds01", 3.5)


def test_goals_are_spread_over_the_drive() -> None:
    script = scenario_for("demo_wall", duration=9.0, goals=[(1, 2), (3, 4), (5, 6)]).script

    assert [(event.at, event.goal) for event in script] == [
        (0.5, (1, 2, 0.0)),
        (3.5, (3, 4, 0.0)),
        (6.5, (5, 6, 0.0)),
    ]


def test_goals_replace_those_of_the_scenario_only() -> None:
    before = load_scenario("goal_arrival").script
    after = scenario_for("goal_arrival", goals=[(1, 2)]).script

    assert [event for event in after if event.goal is None] == [
        event for event in before if event.goal is None
    ]
    assert [event.goal for event in after if event.goal is not None] == [(1, 2, 0.0)]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        *(({"lidar": name}, "unknown lidar profile") for name in ("lds1", "", "../default")),
        *(({"duration": each}, "--duration") for each in (float("nan"), float("inf"), 0.0, -1.0)),
    ],
)
def test_changes_that_make_no_scenario(change: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        scenario_for("demo_wall", **change)


def test_parameters_remappings_and_files_become_arguments() -> None:
    assert arguments_of([]) == []
    assert arguments_of(
        ["speed:=0.3", "a.b_c:=two words"], ["/scan:=/lidar", "__node:=me"], [Path("x/p.yaml")]
    ) == [
        "--ros-args", "-r", "/scan:=/lidar", "-r", "__node:=me",
        "--params-file", "p.yaml", "-p", "speed:=0.3", "-p", "a.b_c:=two words",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "param", ["", "x", "x=1", ":=1", "x:=", "-x:=1", "a b:=1", "1x:=1", "x: =1"]
)
def test_malformed_parameters(param: str) -> None:
    with pytest.raises(InputError, match="expected NAME:=VALUE"):
        arguments_of([param])


@pytest.mark.parametrize("rule", ["", "/scan", "/scan:=", ":=/scan", "/scan=/lidar", "a b:=c"])
def test_malformed_remappings(rule: str) -> None:
    with pytest.raises(InputError, match="expected FROM:=TO"):
        arguments_of([], [rule])


@pytest.fixture
def drive(run_node: RunNode) -> Recording:
    return run_node("rclpy.init(); rclpy.spin(Echo())", short(1.0))


def test_the_summary(drive: Recording, capsys: pytest.CaptureFixture[str]) -> None:
    said = summary(drive, capsys)

    assert said.startswith("echo.py in demo_wall Topics")
    assert "-> /cmd_vel geometry_msgs/msg/Twist reliable 10 messages (10.0 Hz)" in said
    assert "<- /scan sensor_msgs/msg/LaserScan reliable 10 messages (10.0 Hz)" in said
    assert "1.0 s simulated; the node ran to the end" in said
    assert "drove 0.00 m" in said


def test_the_summary_tells_of_a_death_and_of_the_last_words(
    run_node: RunNode, capsys: pytest.CaptureFixture[str]
) -> None:
    source = """
        class Dies(Echo):
            def on_scan(self, scan):
                distance = None
                print("looking")
                return distance < 0.5
        rclpy.init()
        rclpy.spin(Dies())
        """
    said = summary(run_node(source, short(0.5)), capsys)

    assert "in the callback of /scan node.py, line " in said
    assert "return distance < 0.5 distance = None try:" in said and said.count("TypeError") == 1
    assert "What the node said 0.01 s looking" in said
    assert "Traceback" not in said


def test_what_is_wrong_with_the_topics(
    run_node: RunNode, capsys: pytest.CaptureFixture[str]
) -> None:
    said = summary(
        run_node(
            """
            rclpy.init(); node = Node('wrong')
            node.create_subscription(String, '/scan', print, 10)
            node.create_subscription(LaserScan, '/laser', print, 10)
            node.create_publisher(Twist, '/cmd_vel', 10)
            from lifecycle_msgs.msg import TransitionEvent
            from lifecycle_msgs.srv import GetState
            from rclpy.lifecycle import LifecycleNode
            managed = LifecycleNode('managed')
            managed.create_publisher(String, '/said', 10)
            node.create_subscription(TransitionEvent, '/managed/transition_event', print, 10)
            node.create_client(GetState, '/managed/get_state')
            node.create_client(GetState, '/missing/get_state')
            from example_interfaces.action import Fibonacci
            from rclpy.action import ActionClient
            ActionClient(node, Fibonacci, 'count')
            node.create_timer(0.0005, lambda: said.publish(String()))
            said = node.create_publisher(String, '/often', 10)
            rclpy.spin(node)
            """,
            short(0.5),
        ),
        capsys,
    )

    assert said.count("WARNING: nobody offers this service") == 1
    assert "client /count example_interfaces/action/Fibonacci WARNING: nobody offers this" in said
    assert said.count("a second flood the network") == 1
    assert said.count("WARNING: nobody publishes this topic") == 1
    assert "WARNING: nothing arrives: the robot publishes sensor_msgs/msg/LaserScan" in said
    assert "WARNING: nobody publishes this topic; the robot publishes /scan" in said
    assert "the robot got no command" in said


def as_float(number: int) -> str:
    """Return what C reads from an object of this Python where a float has its value."""
    return f"{c_double.from_address(id(number) + 16).value:.3g}"


def test_ends_that_are_alike_are_one_line_and_no_lidar_says_where_there_is_one(
    run_node: RunNode, capsys: pytest.CaptureFixture[str]
) -> None:
    source = """
        rclpy.init(); node = Node('many')
        for _ in range(40): node.create_subscription(LaserScan, '/scan', print, 10)
        rclpy.spin(node)
        """
    said = summary(run_node(source, short(1.5, "demo_open")), capsys)
    assert said.count("<- /scan") == 1
    assert "reliable 0 messages, 40 times WARNING: the robot sends nothing here in" in said
    assert "in demo_open; it does in demo_" in said


LOOP = """
rclpy.init(); node = Echo(); twist = Twist(); twist.linear.x = 0.2
def loop():
    while rclpy.ok(): node.publisher.publish(twist)
"""


@pytest.mark.parametrize(
    "how",
    ["loop()", "threading.Thread(target=loop).start(); rclpy.spin(node)",
     "node.create_timer(0.1, loop); rclpy.spin(node)"],
)  # fmt: skip
def test_a_loop_without_a_sleep_drives_in_real_time(
    how: str, tmp_path: Path, forkserver: ForkServer, capsys: pytest.CaptureFixture[str]
) -> None:
    more: dict[str, Any] = {"limits": Limits(1.0, 1.0), "on_second_look": lambda: None}
    recording = drive_file(tmp_path, forkserver, LOOP + how, **more)
    said = summary(recording, capsys)
    assert recording.truth.v[-1] == pytest.approx(0.2)
    assert "1.0 s of real time;" in said
    assert ", `while rclpy.ok(): node.publisher.publish(twist)`): give such a loop a ti" in said
    assert re.search(r"-> /cmd_vel geometry_msgs/msg/Twist reliable (more than )?[\d,]+ m", said)


def test_what_hangs_in_real_time_too_is_shown_with_its_topics(
    tmp_path: Path,
    forkserver: ForkServer,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Limits, "start", 4.0)
    source, limits = "rclpy.init(); node = Echo()\nwhile True: pass", Limits(start=1.0)
    once = drive_file(tmp_path, forkserver, source, limits=limits)  # as where there is no real time
    assert "Topics not known: a node says" in summary(once, capsys)
    more: dict[str, Any] = {"limits": limits, "on_second_look": lambda: None}
    said = summary(drive_file(tmp_path, forkserver, source, **more), capsys)
    assert "-> /cmd_vel geometry_msgs/msg/Twist" in said
    assert ", and not in real time either" in said


PROBLEMS = {  # a node's source: what stands below its topics, in part
    "an int": ("m.linear.x = 1", f"linear.x is {as_float(1)} at 0.10 s, garbage"),
    "a negative int": ("m.linear.x = -1", f"linear.x is {as_float(-1)} at 0.10 s"),
    "a bool": ("m.angular.z = True", f"angular.z is {as_float(True)} at 0.10 s, garbage"),
    "a float32": ("import numpy; m.linear.x = numpy.float32(0.3)", "garbage: the field holds"),
    "a float64": ("import numpy; m.linear.x = numpy.float64(0.3)", ""),
    "one command": ("m.linear.x = 0.3; times = 1", "the robot stopped at 0.60 s: it obeys a"),
    "a pause": ("m.linear.x = 0.3; period = 0.6", "0.60 s no other came until 1.20 s. Publish"),
    "a last zero": ("times = 1", ""),
    "a car's": (
        "from ackermann_msgs.msg import AckermannDriveStamped as Drive\n"
        "n.create_publisher(Drive, '/drive', 10)",
        "nobody listens here: the robot takes geometry_msgs/msg/Twist on /cmd_vel",
    ),
    "another type": (
        "c = rclpy.Context(); c.init(); n2 = rclpy.create_node('n2', context=c)\n"
        "n2.create_publisher(String, 'cmd_vel', 10)",
        "the robot does not hear this",
    ),
    "QoS of its own": (
        "n.create_publisher(String, 'x', rclpy.qos.qos_profile_sensor_data)\n"
        "n.create_subscription(String, 'x', print, 10)",
        "nothing arrives: best effort publisher and reliable subscription",
    ),
    "liveliness": (
        "manual = rclpy.qos.LivelinessPolicy.MANUAL_BY_TOPIC\n"
        "qos = rclpy.qos.QoSProfile(depth=5, liveliness=manual)\n"
        "n.create_subscription(LaserScan, 'scan', print, qos)",
        "reliable 0 messages WARNING: nothing arrives: publisher's liveliness is",
    ),
    "no goals": ("n.create_subscription(String, '/goal_pose', print, 10)", "nothing arrives: the"),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_what_a_person_would_not_see(
    run_node: RunNode, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    source, problem = PROBLEMS[name]
    recording = run_node(
        "rclpy.init(); n = Node('n'); m = Twist(); times, period = 100, 0.1\n"
        "p = n.create_publisher(Twist, '/cmd_vel', 10)\n"
        f"{source}\n"
        "def tick():\n"
        "    global times\n"
        "    times -= 1\n"
        "    if times >= 0: p.publish(m)\n"
        "n.create_timer(period, tick); rclpy.spin(n)",
        short(1.5),
    )
    said = summary(recording, capsys)

    assert recording.outcome.completed, recording.outcome
    assert said.count("WARNING") == (1 if problem else 0), said
    assert problem in said


@pytest.mark.parametrize(
    ("source", "says", "never"),
    [
        ("m.publish(String()); time.sleep(0.4)", "ended by itself at 0.4 s", "Hz"),
        ("time.sleep(1.2); sys.exit()", "the program ended by itself at 1.2 s", "exited"),
        ("time.sleep(1.2); sys.exit(1)", "the node ended at 1.2 s: exited: sys.exit(1)", "itself"),
        (
            "n.create_subscription(String, '/said', print, 10); m.publish(String())",
            "up to 1 m",
            "Hz",
        ),
        ("n.create_publisher(String, '/said', 10)", "0 messages together", "Hz"),
        ("os.environ['A']", "--env A=VALUE` sets this one", "dict has no such key"),
        ("sys.argv[1]", "course drive --param NAME:=VALUE", "empty scan"),
        ("import curses; raise curses.error('x')", "a node that reads stdin", "nobody types"),
    ],
)
def test_what_is_said_of_a_program_that_ends(
    run_node: RunNode, capsys: pytest.CaptureFixture[str], source: str, says: str, never: str
) -> None:
    recording = run_node(
        "import os, sys; rclpy.init(); n = Node('n')\n"
        "n.create_subscription(LaserScan, '/scan', print, 10)\n"
        f"m = n.create_publisher(String, '/said', 10); rclpy.spin_once(n)\n{source}",
        short(3.0),
    )
    said = summary(recording, capsys)

    assert says in said
    assert never not in said
    assert "WARNING" not in said, said


@pytest.mark.parametrize("end", ["", "node.create_subscription(String, '/x', print, 1)"])
def test_a_loop_that_only_publishes_needs_no_spin(
    end: str, tmp_path: Path, forkserver: ForkServer, capsys: pytest.CaptureFixture[str]
) -> None:
    recording = drive_file(
        tmp_path,
        forkserver,
        f"""
        rclpy.init(); node = Node('loop'); pub = node.create_publisher(Twist, '/cmd_vel', 1)
        {end}
        try:
            while rclpy.ok(): pub.publish(Twist()); time.sleep(0.1)
        except KeyboardInterrupt: print('bye')
    """,
    )
    assert recording.outcome.kind == ("never_spun" if end else "completed")
    assert ("(Ctrl-C) 1.00 s bye" in summary(recording, capsys)) == (not end)


@pytest.mark.parametrize(("source", "asks"), [("def main(): pass", True), ("print(1)", False)])
def test_a_program_without_a_node_and_a_word_may_lack_its_guard(
    run_node: RunNode, capsys: pytest.CaptureFixture[str], source: str, asks: bool
) -> None:
    assert (NO_MAIN in summary(run_node(source, short(0.5)), capsys)) is asks


def test_texts_of_students_are_not_markup(
    drive: Recording, capsys: pytest.CaptureFixture[str]
) -> None:
    outcome = Outcome("exception", "[bold]E[/] \x1b[31m", 0.5, "[/] \x1b]0;title\x07 detail")
    started = replace(drive, outcome=outcome)
    nothing = replace(started, endpoints=(), delivered=(), published=(), duration_s=0.0)
    said = summary(nothing, capsys)

    assert "the node created no publisher and no subscription" in said

    assert "[bold]E[/]" in said
    assert "\x1b" not in said
    assert "\x07" not in said


def test_parameter_files_that_cannot_be_laid_beside_the_node(tmp_path: Path) -> None:
    for folder in "ab":
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "p.yaml").write_text("x: 1")
    here, there = tmp_path / "a/p.yaml", tmp_path / "b/p.yaml"

    assert read_params_files([here], ["node.py"]) == {"p.yaml": b"x: 1"}
    with pytest.raises(InputError, match="same name"):
        read_params_files([here, there], [])
    with pytest.raises(InputError, match="same name"):
        read_params_files([here], ["p.yaml"])
    with pytest.raises(InputError, match="No such file"):
        read_params_files([tmp_path / "none.yaml"], [])


def test_what_is_to_be_read_from_stdin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "typed.txt"
    file.write_bytes(b"0.3\n")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"0.4\n")))

    assert read_stdin(None) == b""
    assert read_stdin(str(file)) == b"0.3\n"
    assert read_stdin("-") == b"0.4\n"
    with pytest.raises(InputError, match="No such file"):
        read_stdin(str(tmp_path / "none"))
    file.write_bytes(b"x" * (Start.MAX_STDIN + 1))
    with pytest.raises(InputError, match="expected at most"):
        read_stdin(str(file))


def test_a_node_with_foreign_topics_and_a_parameter_file(
    tmp_path: Path, forkserver: ForkServer
) -> None:
    recording = drive_file(
        tmp_path,
        forkserver,
        """
        class Foreign(Echo):
            def __init__(self):
                Node.__init__(self, 'foreign')
                speed = self.declare_parameter('speed', 0.0).value
                self.twist = Twist(); self.twist.linear.x = speed
                self.publisher = self.create_publisher(Twist, 'robot/drive', 10)
                self.create_subscription(LaserScan, '/lidar', self.on_scan, 10)
            def on_scan(self, scan):
                self.publisher.publish(self.twist)
        rclpy.init(); rclpy.spin(Foreign())
        """,
        arguments=arguments_of(
            [], ["robot/drive:=/cmd_vel", "/lidar:=/scan"], [Path("elsewhere/p.yaml")]
        ),
        files={"p.yaml": b"foreign:\n  ros__parameters:\n    speed: 0.25\n"},
    )

    assert recording.outcome.completed, recording.outcome
    assert set(recording.twists().linear_x) == {0.25}
    assert len(recording.twists().t) == 10


ASKS = """
rclpy.init(); node = Echo()
print('said', input('speed? '), sys.stdin.readline().strip())
rclpy.spin(node)
"""


def test_a_node_that_asks_for_input_with_and_without_it(
    tmp_path: Path, forkserver: ForkServer
) -> None:
    answered = drive_file(tmp_path, forkserver, ASKS, stdin="0.3\nfäst\n".encode())
    assert answered.outcome.completed, answered.outcome
    assert answered.log[0].text == "speed? said 0.3 fäst"

    outcome = drive_file(tmp_path, forkserver, ASKS).outcome
    assert outcome.kind == "exception"
    assert outcome.text.startswith("EOFError: EOF when reading a line")
    assert "--stdin FILE" in outcome.text


TELEOPERATES = """
import select, termios, tty
rclpy.init()
node = Node('teleop')
settings = termios.tcgetattr(sys.stdin)
began = node.get_clock().now()

def key(seconds):
    tty.setraw(sys.stdin.fileno())
    ready, _, _ = select.select([sys.stdin], [], [], seconds)
    found = sys.stdin.read(1) if ready else ''
    termios.tcsetattr(sys.stdin, termios.TCSADRAIN, settings)
    return found

while rclpy.ok():
    found = key(0.1)
    if found:
        print(repr(found), round((node.get_clock().now() - began).nanoseconds / 1e9, 1))
    if found == 'q':
        break
print(sys.stdin.isatty(), os.isatty(0), os.environ['ROBOT'])
"""


def test_keys_come_to_a_terminal_in_virtual_time(tmp_path: Path, forkserver: ForkServer) -> None:
    file = tmp_path / "teleop.py"
    file.write_text(PREAMBLE + TELEOPERATES, "utf-8")
    typed = {"env": read_env(["ROBOT=a=b"]), "keys": read_keys(r"w\x71")}
    recording = drive_node(Submission(file), short(2.0), forkserver, **typed)
    said = [line.text for line in recording.log if line.level == "stdout"]
    assert said == ["'w' 0.5", "'q' 1.0", "True True a=b"], recording.outcome


@pytest.mark.parametrize(
    ("read", "bad"),
    [(read_env, ["A"]), (read_env, ["1A=2"]), (read_env, ["A=" + "x" * 2000]),
     (read_keys, "w" * 5000)],
)  # fmt: skip
def test_keys_and_variables_that_can_not_be_given(read: Any, bad: Any) -> None:
    with pytest.raises(InputError):
        read(bad)
