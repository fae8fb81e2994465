"""What the command line takes and says to those who err, and a robot that is driven and put back.

Tests `sim.__main__`, `sim.live.cli` and, in a process, `options`, `parameters` and `run`.
"""

import json
import math
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from processes import ROOT, Town

from sim.live.cli import main, split_ros_args

MOST = 1000  # messages of odometry, 20 in a second


def test_arguments_of_ros_are_taken_out() -> None:
    line = "--clock --ros-args -p rate:=2.0 -- --seed 3 --ros-args -r a:=b"
    own, ros = split_ros_args(line.split())
    assert own == ["--clock", "--seed", "3"]
    assert ros == ["--ros-args", "-p", "rate:=2.0", "--", "--ros-args", "-r", "a:=b"]


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--scenaro", "demo_wall"], "unrecognized arguments: --scenaro demo_wall"),
        (["--foxglove", "70000"], "70000: expected a port, 0 - 65535"),
        (["--rate", "fast"], "invalid float value: 'fast'"),
        (["--once", "--duration", "3"], "not allowed with argument --once"),
    ],
)
def test_wrong_usage(
    arguments: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 2
    assert expected in capsys.readouterr().err


def test_without_rclpy_it_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "rclpy.py").write_text("raise ImportError('there is none')")
    found = subprocess.run(
        [sys.executable, "-m", "sim"],
        env={**os.environ, "PYTHONPATH": f"{tmp_path}:{ROOT}"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert found.returncode == 2
    assert found.stderr.startswith("mock_robot: rclpy was not found: install")
    assert "there is none" in found.stderr
    assert "/opt/ros/jazzy/setup.bash" in found.stderr


WRONG_VALUES = {
    "--scenario demo_wal": "no scenario is called 'demo_wal'; did you mean 'demo_wall'?",
    "--lidar lds03": "no lidar profile is called that; there is: default, lds01, lds02, wide",
    "--rate 2": "rate = 2.0: expected 1.0 without /clock",
    "--clock --rate 50": "Parameter rate out of range",
    "--clock --rate nan": "Parameter rate out of range",
    "--ros-args -p rate:=2": "expecting type",
    "--ros-args -p seed:=-1": "Parameter seed out of range",
    "--ros-args --no-such-flag": "rclpy does not start",
    "--record .": "exists; a bag is never overwritten",
}


def test_wrong_values_are_refused_in_one_line(here: Town) -> None:
    process = here.start("wrong_values.py", json.dumps(list(WRONG_VALUES)))
    for line, expected in WRONG_VALUES.items():
        end = process.next_json(line)
        assert end["code"] == 2, end
        assert expected in end["said"]
        assert end["said"].count("\n") == 1, end["said"]
    assert list(here.folder.glob("*.mcap")) == []


def test_it_is_driven_and_reset_puts_it_back_to_its_start(here: Town) -> None:
    """The one of DDS that `make test` runs: no moment in it is early or late."""

    robot, listener = here.robot(), here.listener()

    def comes_to(at_start: bool) -> bool:
        odometry = (listener.next_json("/odom") for _ in range(MOST))
        distances = (math.dist((odom["x"], odom["y"]), (3.0, 0.0)) for odom in odometry)
        return any((distance < 0.01) == at_start for distance in distances)

    teleop = here.teleop(0.3, 0.0)
    assert comes_to(at_start=False)
    listener.next_json("/scan")
    teleop.end(signal.SIGKILL)
    assert listener.ask("reset")["message"] == "demo_wall from its start, seed 1"
    assert comes_to(at_start=True)
    assert robot.end(signal.SIGINT) == 0
    assert "Traceback" not in robot.rest()
