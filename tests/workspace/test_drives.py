"""What a lesson's page prints of a drive, in CPython, against `course drive`: byte for byte."""

import contextlib
import json
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from grader import cli
from grader.course.exercises import ROOT
from grader.launchers import ForkServerPool
from workspace.build import course_files, lay
from workspace.runtime import REFUSED

FORKED = Path(__file__).with_name("forked.py")
LISTING = re.compile(r"(?ms)^```\{code-block\} python\n:caption: (\S+)\n\n(.*?)^```$")
# of the machine, not of the node
COMPUTE = re.compile(
    r"(?m)^  (Compute: |WARNING: (once|\d+ times) the node computed).*\n(?:\S.*\n)*"
)
DRIVEN = [
    ("loop", "one_beam_agent.py --scenario demo_wall"),
    ("loop", "one_beam_agent.py --scenario demo_wall --duration 4 --param decision:=table"),
    ("loop", "one_beam_agent.py --scenario demo_yard --duration 6 --lidar lds01"),
    ("loop", "one_beam_agent.py --scenario demo_wall --duration 4 --lidar wide --seed 7"),
    ("node", "nearest.py --scenario demo_wall --duration 4"),
    ("node", "nearest.py --scenario demo_wall --duration 4 --param eager:=false --log all"),
    ("state", "odometer.py --scenario goal_field_lost_odometry --duration 9"),
    ("frames", "mounted_agent.py --scenario avoid_field_turned --duration 6"),
    ("plans", "errand.py --scenario demo_open --duration 25 --param limit:=8.0"),
    ("real_time", "stale.py --scenario demo_wall --duration 10 --param depth:=5"),
    ("real_time", "beat.py --scenario demo_wall --duration 6 --param threads:=2"),
    ("awaiting", "awaiting.py --scenario demo_wall --duration 4"),
    ("emergency_stop", "gate.py --scenario demo_e_stop"),
    ("turtlebot", "first_metres.py --scenario demo_wall --duration 5 --param stamped:=false"),
    ("plans", "errand.py --scenario demo_open --duration 3 --param limit:=2.0 --param limt:=9.0"),
    ("parameters", "adjustable.py --scenario live_knob"),
    ("index", "wander.py --scenario demo_store --seed 1 --duration 10"),
    ("loop", "one_beam_agent.py --scenario demo_wall --at 4 --at 4.1"),
    # what goes wrong before a drive
    ("loop", "one_beam_agent.py"),
    ("loop", "one_beam_agent.py --scenario demo_wal"),
    ("loop", "one_beam_agent.py --scenari demo_wall"),
    ("loop", "one_beam_agent.py --scenario demo_wall --seed x"),
    ("loop", "one_beam_agent.py --scenario demo_wall --param threshold=1"),
    ("loop", "one_beam_agent.py --scenario demo_wall another.py"),
    ("loop", "one_beam_agent.py --scenario demo_wall --at 1 --at 2 --at 3"),
    ("loop", "one_beam_agent.py --scenario demo_wall --at 15.5"),
    ("loop", "one_beam_agent.py --help"),
]


def listing(page: str, name: str) -> str:
    found = LISTING.findall((ROOT / "lessons" / f"{page}.md").read_text("utf-8"))
    return dict(found)[name]


def said_by_page(folder: Path, orders: list[Any], *more: str) -> list[dict[str, Any]]:
    lay(folder, course_files())
    done = subprocess.run(
        [sys.executable, FORKED, folder, *more],
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),  # as a background job
        input="".join(f"{json.dumps(order)}\n" for order in orders),
        text=True,
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


@pytest.fixture
def typed(
    forkservers: ForkServerPool,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Callable[[str], str]:
    """Return what the command prints for what is typed, errors included."""
    warm = lambda libraries=(), **_: contextlib.nullcontext(forkservers.of(libraries))  # noqa: E731
    monkeypatch.setattr("grader.cli.drive.start_forkserver", warm)
    monkeypatch.setenv("COLUMNS", "80")

    def typed(command: str) -> str:
        monkeypatch.setattr("sys.argv", ["course", *command.split()])
        with pytest.raises(SystemExit):
            cli.main()
        return "".join(capsys.readouterr())

    return typed


def test_the_page_prints_what_course_drive_prints(
    typed: Callable[[str], str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    orders, expected = [], []
    for number, (page, command) in enumerate(DRIVEN):
        name, _, arguments = command.partition(" ")
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / name).write_text(listing(page, name), "utf-8")
        monkeypatch.chdir(folder)
        expected.append(typed(f"drive {command}"))
        orders.append({"file": str(folder / name), "arguments": arguments})
    found = [said["printed"] for said in said_by_page(tmp_path, orders)]
    for (_, command), here, there in zip(DRIVEN, found, expected, strict=True):
        assert COMPUTE.sub("", here) == COMPUTE.sub("", there), command
        assert here.startswith(("course: ", "Usage: ")) or COMPUTE.search(here), command


def test_options_without_sense_in_a_page_are_refused_with_a_sentence(tmp_path: Path) -> None:
    node = tmp_path / "one_beam_agent.py"
    node.write_text(listing("loop", node.name), "utf-8")
    wrong = [*(f"--scenario demo_wall {option}" for option in REFUSED), "--param='"]
    said = said_by_page(tmp_path, [{"file": str(node), "arguments": words} for words in wrong])
    for option, each in zip(REFUSED, said, strict=False):
        assert each == {"printed": f"course: {option}: {REFUSED[option]}\n"}
    assert said[-1] == {"printed": "course: No closing quotation\n"}
