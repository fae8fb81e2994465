"""The rows of kilted.md, each run plainly and in a drive, on the real rclpy that is here."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from grader.course.exercises import ROOT
from grader.course.submission import find_submission
from grader.drive import drive_node, scenario_for
from rclpy_virtual_time import ForkServer

DISTROS = ("jazzy", "kilted")
BEGIN = "import os, signal, threading, rclpy\nfrom std_msgs.msg import String\n"
INIT = "rclpy.init(); node = rclpy.create_node('n')\n"
CLIENT = "from std_srvs.srv import Trigger\nclient = node.create_client(Trigger, 'x')\n"
TIMER = """
from rclpy.timer import TimerInfo
def tick(info: TimerInfo): print('` and `'.join(n for n in dir(info) if n[0] != '_'))
node.create_timer(0.1, tick)
rclpy.spin_once(node, timeout_sec=20)
"""
SHUTDOWN = """
from rclpy.executors import MultiThreadedExecutor
executor, returned, called = MultiThreadedExecutor(2), threading.Event(), threading.Event()
executor.add_node(node)
def tick():
    called.set()
    print('returns' if returned.wait(2.0) else 'waits', flush=True)
node.create_timer(0.1, tick)
executor.spin_once(timeout_sec=20)
called.wait()
executor.shutdown(0.1)
returned.set()
"""
PROGRAMS = {  # a row's first words: what shows it, in its last printed line
    "`with rclpy.init(": "with rclpy.init(): pass\nprint(rclpy.ok() or 'shuts down')",
    "a timer's": INIT + TIMER,
    "the same": "from __future__ import annotations\n" + BEGIN + INIT + TIMER,
    "`client.call(": INIT + CLIENT + "print(client.call(Trigger.Request(), timeout_sec=0.1))",
    "`publisher.publish(": INIT + "publisher = node.create_publisher(String, 'x', 1)\n"
    "rclpy.shutdown(); publisher.publish(String())",
    "`rclpy.shutdown()` after": INIT + "threading.Timer(0.2, os.kill, (os.getpid(), 2)).start()\n"
    "try: rclpy.spin(node)\n"
    "except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):\n"  # whichever is first
    "  while rclpy.ok(): threading.Event().wait(0.01)\n"  # its own thread ends the context
    "  rclpy.shutdown(); print('nothing')",
    "`executor.create_task(": "from rclpy.executors import SingleThreadedExecutor\nrclpy.init()\n"
    "executor, ran = SingleThreadedExecutor(), []\n"
    "for number in range(3): executor.create_task(ran.append, number)\n"
    "for _ in range(3): executor.spin_once(timeout_sec=0.1)\nprint(ran)",
    "`MultiThreadedExecutor.": INIT + SHUTDOWN,
    "`with node.": INIT + CLIENT + "with client: pass\n"
    "try: client.service_is_ready()\nexcept rclpy.exceptions.InvalidHandle: print('destroyed')",
    "`create_subscription(": INIT
    + "node.create_subscription(String, 'x', print, 1, content_filter_options=None)\n"
    "print('there')",
    '`f"': INIT + "print(f\"{node.declare_parameter('p', 1.0).type_}\")",
    "`from rclpy.exp": "from rclpy.experimental import EventsExecutor\nprint('there')",
}


def rows() -> list[tuple[str, str, str]]:
    """Return each row's first cell, a distribution, and its cell."""
    table = re.findall(r"(?m)^\| (.+) \|$", (ROOT / "lessons/kilted.md").read_text("utf-8"))[1:]
    found = (line.split(" | ") for line in table)
    return [(what, *each) for what, *cells in found for each in zip(DISTROS, cells, strict=True)]


@pytest.mark.parametrize(("what", "distro", "cell"), rows())
def test_a_row_is_what_happens(
    what: str, distro: str, cell: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    ros = forkserver.ros
    if ros.distro != distro:
        pytest.skip(f"needs the real rclpy of {distro.capitalize()}: docs/instructors.md")
    (program,) = (text for begin, text in PROGRAMS.items() if what.startswith(begin))
    agent = tmp_path / "agent.py"
    agent.write_text(program if program.startswith("from __") else BEGIN + program, "utf-8")
    done = subprocess.run(
        [sys.executable, agent],
        env=os.environ | ros.variables() | {
            "PYTHONPATH": os.pathsep.join(map(str, ros.python_path)),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        },
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    drive = drive_node(find_submission(agent), scenario_for("demo_wall", duration=3.0), forkserver)
    printed = [line.text for line in drive.log if line.level == "stdout"]
    for plain, said in (
        (done.stdout, (done.stdout or done.stderr).strip().splitlines()[-1]),
        (printed, printed[-1] if printed else drive.outcome.text),
    ):
        shown = said if plain else re.sub(r"^[\w.]*?(\w+)([: ].*)?$", r"\1", said)  # its class
        assert f"`{shown}`" in cell, done.stderr + drive.outcome.detail
