"""The command `python -m sim`: the mock robot as a live ROS 2 node."""

import argparse
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from sim.errors import InputError
from sim.live.options import Options

WRONG_USAGE = 2
FOXGLOVE_PORT = 8765
NO_RCLPY = (
    "rclpy was not found: install ROS 2 Jazzy's wheels in a virtual environment with "
    "`pip install '.[ros]'`, or source /opt/ros/jazzy/setup.bash"
)
EXAMPLES = """\
examples:
  python -m sim --scenario demo_wall
  python -m sim --scenario avoid_store --lidar wide --seed 7 --foxglove
  python -m sim --scenario goal_turns --wait --once --record turns
  python -m sim --scenario demo_yard --clock --rate 2.0
  python -m sim --ros-args -r __ns:=/robot_1 -p scenario:=demo_open
"""


def main(args: Sequence[str] | None = None) -> int:
    """Run the robot until it ends; return the exit code: 0, or 2 for wrong usage.

    Parameters
    ----------
    args
        Without the program's name; by default those of the command line.
    """
    own, ros_args = split_ros_args(sys.argv[1:] if args is None else args)
    options = _options(own)
    with _signals() as stop:
        try:
            from rclpy import init  # noqa: F401, PLC0415  (a system's rclpy may be an empty shell)
        except ImportError as error:
            return _wrong(f"{NO_RCLPY} ({error})")
        from sim.live.run import run  # noqa: PLC0415

        try:
            run(options, ros_args, stop.asked)
        except InputError as error:
            return _wrong(str(error))
    return 0


def split_ros_args(args: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return our arguments and those for ROS, which go from `--ros-args` to `--` or the end."""
    own: list[str] = []
    ros: list[str] = []
    target = own
    for word in args:
        if word == "--ros-args":
            target = ros
        target.append(word)
        if target is ros and word == "--":
            target = own
    return own, ros


def _options(args: list[str]) -> Options:
    parser = argparse.ArgumentParser(
        prog="mock_robot" if Path(sys.argv[0]).stem == "mock_robot" else "python -m sim",
        description="The course's mock robot as a ROS 2 node, in real time: start it in one "
        "terminal, and your node in another.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--scenario", metavar="NAME", default="demo_wall", help="name or TOML file (%(default)s)")
    add("--lidar", metavar="PROFILE", help="default, lds01, lds02 or wide (the scenario's)")
    add("--seed", type=int, metavar="N", help="draws start, clutter and noise (the scenario's)")
    add("--clock", action="store_true", help="send /clock: all stamps are in simulated time")
    add("--rate", type=float, default=1.0, metavar="X", help="speed, 0.1 - 10; needs --clock")
    add("--wait", action="store_true", help="begin when somebody subscribes to a sensor")
    ends = parser.add_mutually_exclusive_group()
    ends.add_argument("--duration", type=float, metavar="S", help="end after S seconds (never)")
    ends.add_argument("--once", action="store_true", help="end after the scenario's own duration")
    add("--record", type=Path, metavar="BAG", help="write all that is sent and heard to a new bag")
    add(
        "--foxglove",
        type=_port,
        nargs="?",
        const=FOXGLOVE_PORT,
        metavar="PORT",
        help=f"show the scene to Foxglove on this machine ({FOXGLOVE_PORT}; 0: any free port)",
    )
    add("--ros-args", metavar="…", help="arguments of ROS: -p rate:=2.0, -r __ns:=/robot_1, …")
    values = vars(parser.parse_args(args))
    del values["ros_args"]  # only for --help: split_ros_args has taken them
    return Options(**values)


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"{text}: expected a port, 0 - 65535")
    return int(text)


class _Stop:
    """Remembers whether a signal asked the robot to end."""

    def __init__(self) -> None:
        self._signal: int | None = None

    def asked(self) -> bool:
        return self._signal is not None

    def ask(self, number: int, frame: Any) -> None:
        self._signal = number


@contextmanager
def _signals() -> Iterator[_Stop]:
    """Turn Ctrl+C and SIGTERM (launch, systemd, docker) into a clean shutdown."""
    stop = _Stop()
    before = {number: signal.signal(number, stop.ask) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _wrong(text: str) -> int:
    print(f"mock_robot: {text}", file=sys.stderr)
    return WRONG_USAGE
