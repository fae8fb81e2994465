"""The reference nodes on plain rclpy, as a student starts them: Ctrl-C, and they end tidily."""

import functools
import pickle
import signal
import types
from pathlib import Path

import numpy as np
import pytest
from processes import Process, Town

from grader.course.exercises import all_exercises

pytestmark = pytest.mark.long

PROGRAMS = [(e, file) for e in all_exercises() for file in e.files if "train" not in file]
REFERENCES = [exercise.solutions / file for exercise, file in PROGRAMS]
SKELETONS = [exercise.folder / file for exercise, file in PROGRAMS]
DRIVERS = [path for path in REFERENCES if "Twist" in path.read_text("utf-8")]

# What a Ctrl-C that comes in the wrong microsecond makes of rclpy itself, in any node.
RACES = (
    # Its handler can be faster than its own try_shutdown() (ros2/rclpy#1352).
    "rcl_shutdown already called on the given context",
    # pybind11 takes the KeyboardInterrupt for an argument that it can't convert.
    "RuntimeError: Unable to convert call argument",
)


# Of the scans of nodes/course.py, 5 m all around, this predicts 4 m/s: every node drives.
MODEL = types.SimpleNamespace(predict=functools.partial(np.mean, axis=1))


def start(town: Town, path: Path, *words: str) -> Process:
    """Start a node with a model, and with further arguments of ROS."""
    model_path = town.folder / f"{path.stem}.pkl"
    model_path.write_bytes(pickle.dumps(MODEL))
    return town.start(str(path), "--ros-args", "-p", f"model_path:={model_path}", *words)


def interrupt(nodes: dict[Path, Process]) -> None:
    """Press Ctrl-C in each, and see that none of them takes it for an error.

    One after the other: Fast DDS can wait for ever in a node that ends while it hears of others
    that come or go (eProsima/Fast-DDS#6513).
    """
    for path, node in nodes.items():
        node.popen.send_signal(signal.SIGINT)
        said = node.rest()
        if any(race in said for race in RACES) and said.count("Traceback") == 1:
            continue
        assert node.popen.returncode == 0, f"{path.name}:\n{said}"
        assert "Traceback" not in said, f"{path.name}:\n{said}"


def test_the_last_command_stops_the_robot(here: Town) -> None:
    course = here.start("course.py", *(path.stem for path in DRIVERS))
    course.ask("begin")
    nodes = {p: start(here, p, "-r", f"/cmd_vel:=/{p.stem}/cmd_vel") for p in DRIVERS}
    for path in nodes:
        course.next_json(f"/{path.stem}/cmd_vel", lambda twist: twist["largest"] > 0.1)
    interrupt(nodes)
    course.ask("rest")


@pytest.mark.parametrize("paths", [REFERENCES, SKELETONS], ids=["references", "skeletons"])
def test_without_a_message_they_end_too(here: Town, paths: list[Path]) -> None:
    course = here.start("course.py")
    nodes = {path: start(here, path) for path in paths}
    for path in nodes:
        course.ask(f"meet {path.stem}")
    interrupt(nodes)
