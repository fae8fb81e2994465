"""Nothing that others wrote reaches a terminal as anything but text, whatever command prints it."""

import ast
import os
import pty
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from command_line import ROOT, SHORT

from rclpy_virtual_time import readable

EVIL = "\x1b]0;OWNED\x07\x1b[2J\x1b[31m[bold]hi[/nope] \x9b31m \u202eevil\x1bP+q\x1b\\\x08\x0e\x85"
NAME = "a\x1b[2J\x1b]0;OWNED\x07[bold]\u202e\x9b31mb"
AGENT = "obstacle_avoidance_agent.py"
NODE = f"""
import sys
import rclpy
from geometry_msgs.msg import Twist
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
EVIL = {EVIL!r}
class N(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.pub = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.cb, 10)
        self.declare_parameter("x" + EVIL, EVIL)
    def cb(self, scan):
        self.get_logger().error(EVIL)
        print(EVIL, flush=True)
        print(EVIL, file=sys.stderr, flush=True)
        raise ValueError(EVIL)
rclpy.init()
rclpy.spin(N())
"""
TEST = """
def test_it(drive):
    run = drive("agent.py", scenario="demo_wall", duration=0.5)
    assert run.log == [], "\\n".join(run.log)

def test_a_name(drive):
    drive("{name}.py", scenario="demo_wall")
"""
# what Rich and click write: colours, the cursor in its line, a line cleared, the cursor hidden
OURS = re.compile(r"\x1b\[(?:[0-9;]*m|[0-9]*[ABCDGK]|\?25[lh])")


def on_terminal(*command: object, cwd: Path = ROOT) -> str:
    """Return what a command writes to its terminal."""
    ours, theirs = pty.openpty()
    environment = {**os.environ, "COLUMNS": "120", "TERM": "xterm", "PYTHONUTF8": "1"}
    with subprocess.Popen(
        [*map(os.fsencode, map(str, command))], stdin=theirs, stdout=theirs, stderr=theirs,
        cwd=cwd, env=environment, start_new_session=True,
    ) as process:  # fmt: skip
        os.close(theirs)
        said = bytearray()
        while True:
            try:
                chunk = os.read(ours, 65536)
            except OSError:  # its end has closed
                break
            if not chunk:
                break
            said += chunk
        process.wait(timeout=120)
    os.close(ours)
    return said.decode("utf-8", "replace")


def foreign(said: str) -> str:
    """Return what is no text, nor the sequences that Rich writes."""
    left = OURS.sub("", said.replace("\r\n", "\n").replace("\r", ""))
    return "".join(c for c in left if c != "\n" and readable(c) != c)


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("terminal")
    for student in ("honest", NAME):
        (folder / "class" / student).mkdir(parents=True)
        (folder / "class" / student / f"{NAME}.py").write_text("x = 1\n")
    with zipfile.ZipFile(folder / "class" / f"{NAME}.zip", "w") as archive:
        archive.writestr(f"{NAME}/{AGENT}", "x")
        archive.writestr(f"../{NAME}", "x")
    (folder / "class" / f"{NAME}.txt").write_text("x")
    (folder / "roster.csv").write_text(f'id,name,section\n{NAME},"{NAME}",{NAME}\n', "utf-8")
    (folder / "broken.csv").write_text(f"{NAME}\n{NAME}\n", "utf-8")
    (folder / AGENT).write_text(NODE, "utf-8")
    (folder / "agent.py").write_text(NODE, "utf-8")
    (folder / f"{NAME}.py").write_text(NODE, "utf-8")
    (folder / "test_it.py").write_text(
        TEST.replace("{name}", NAME.encode("unicode_escape").decode())
    )
    (folder / f"{NAME}.mcap").write_bytes(b"\x89MCAP0\r\n" + EVIL.encode())
    return folder


COMMANDS: dict[str, tuple[str, ...]] = {
    "no command": (NAME,),
    "option": ("grade", f"--{NAME}"),
    "grade": ("grade", "1", AGENT, "--only", "stop_zone"),
    "grade a name": ("grade", "1", f"{NAME}.py"),
    "grade an exercise": ("grade", NAME, AGENT),
    "grade one check": ("grade", "1", AGENT, "--only", NAME),
    "grade as JSON": ("grade", "1", AGENT, "--only", "stop_zone", "--json", "-"),
    "drive": ("drive", AGENT, *SHORT),
    "drive a name": ("drive", f"{NAME}.py", *SHORT),
    "drive a scenario": ("drive", AGENT, "--scenario", NAME),
    "search": ("search", AGENT, "--exercise", "1", "--tries", "3"),
    "search a name": ("search", f"{NAME}.py", "--exercise", "1", "--tries", "3"),
    "dataset": ("dataset", "--out", f"{NAME}/x.npz"),
    "check-bag": ("check-bag", f"{NAME}.mcap"),
    "doctor": ("doctor", NAME),
    "list": ("list", "--copy", NAME),
    "autograde, list": ("autograde", "class", "--list"),
    "autograde, roster": ("autograde", "class", "--list", "--roster", "roster.csv"),
    "autograde, broken roster": ("autograde", "class", "--list", "--roster", "broken.csv"),
    "autograde a file": ("autograde", f"class/{NAME}.txt", "--list"),
    "autograde an archive": ("autograde", f"class/{NAME}.zip", "--list"),
    "autograde nothing": ("autograde", NAME, "--list"),
    "marks": ("marks", NAME, "--list"),
    "report": ("report", NAME),
    "release": ("release", NAME),
    "new": ("new", NAME),
}


@pytest.mark.long
@pytest.mark.parametrize("name", COMMANDS)
def test_no_command_lets_anything_but_text_through(name: str, work: Path) -> None:
    said = on_terminal(sys.executable, "-m", "grader.cli", *COMMANDS[name], cwd=work)
    assert said.strip()
    assert foreign(said) == ""
    assert "Traceback" not in said or name in ("drive", "grade", "search")


@pytest.mark.long
def test_pytest_with_the_fixture_lets_nothing_but_text_through(work: Path) -> None:
    command = (sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "test_it.py")
    said = on_terminal(*command, cwd=work)
    assert "1 failed" in said or "2 failed" in said
    assert foreign(said) == ""


def test_a_terminal_in_ascii_gets_ascii() -> None:
    script = f"from grader.report.echo import echo; echo({NAME + chr(0xDC80) + 'é'!r})"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, check=True, cwd=ROOT,
        env={**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"},
    )  # fmt: skip
    assert done.stdout == b"a[bold]b??\n"


# what may write by itself, and why nothing foreign passes
WRITERS = {
    "grader/report/echo.py": "the one way",
    "grader/report/terminal.py": "the one console",
    "grader/hosted/supplied/": "in a host, whose output the judge takes",
    "grader/drive/summary.py": "each line is made printable",
    "grader/notebook/": "into notebooks, through `plain`",
    "rclpy_virtual_time/testing/virtual_time.py": "its output is made readable",
    "rclpy_virtual_time/conform/": "contributors' own files",
    "grader/authoring/": "contributors' own files",
    "grader/course/generated.py": "the project's own files",
    "grader/advice/hints.py": "behind the wall: the judge reads it",
    "rclpy_virtual_time/host/": "behind the wall: the judge reads it",
    "rclpy_virtual_time/link/ros_environment.py": "before a run, of the machine",
    "grader/models/": "answers for another process",
}


def test_nothing_else_writes_to_a_terminal() -> None:
    found = set()
    for file in sorted([*ROOT.glob("grader/**/*.py"), *ROOT.glob("rclpy_virtual_time/**/*.py")]):
        place = file.relative_to(ROOT).as_posix()
        if any(place.startswith(known) for known in WRITERS):
            continue
        for node in ast.walk(ast.parse(file.read_bytes())):
            text = ast.unparse(node) if isinstance(node, ast.Call | ast.ImportFrom) else ""
            if re.match(r"print\(|click\.s?echo|sys\.std(out|err)\.write|from rich\.console", text):
                found.add(f"{place}: {text[:60]}")
    assert found == set()
