"""A class to measure with: right, wrong, broken and hostile submissions for exercise 1."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

from grader.authoring.claims import claims
from grader.course.exercises import Exercise, find_exercise

NODE = """\
import os, signal, sys, threading
import rclpy
from rclpy.node import Node

class Agent(Node):
    def __init__(self):
        super().__init__('obstacle_avoidance_agent')

def main():
    rclpy.init()
    node = Agent()
    {deed}
    rclpy.spin(node)

if __name__ == '__main__':
    main()
"""
DEEDS = {  # what a hostile node does
    "kills_everybody": "os.kill(-1, signal.SIGKILL)",
    "kills_its_parent": "os.kill(os.getppid(), signal.SIGKILL)",
    "leaves": "os._exit(0)",
    "writes_endlessly": "print('x' * 50_000_000)",
    "fills_the_disk": "open('big', 'wb').write(bytes(500_000_000))",
    "forks": "[os.fork() for _ in range(20)]",
    "closes_everything": "os.closerange(0, 100)",
    "steals": "print(open('/etc/shadow').read())",
}


def make_class(folder: Path, size: int, slug: str = "obstacle_avoidance") -> Path:
    """Write `size` students' folders and archives; the same ones for the same size."""
    exercise = find_exercise(slug)
    texts = _texts(exercise)
    names = list(texts)
    for number in range(size):
        name = names[number % len(names)]
        student = f"{number:03} {name}" if number % 7 else f"Студент {number:03}"
        text = texts[name] + b"\n# %d\n" % number
        if number % 11 == 10:
            with zipfile.ZipFile(folder / f"{student}.zip", "w") as archive:
                archive.writestr(f"week 1/{exercise.files[0]}", text)
        else:
            (folder / student).mkdir()
            (folder / student / exercise.files[0]).write_bytes(text)
    _without_files(folder, names[0], exercise)
    return folder


def _texts(exercise: Exercise) -> dict[str, bytes]:
    first = exercise.files[0]
    solutions = [(claim.stem, claim.files[first].encode()) for claim in claims(exercise)]
    hostile = [(name, NODE.format(deed=deed).encode()) for name, deed in DEEDS.items()]
    broken = [("no_python", b"\x00\xff\x80"), ("cut_off", b"def main(:")]
    groups = [solutions, [*hostile, *broken]]
    mixed: dict[str, bytes] = {}
    for index in range(max(map(len, groups))):  # also a small class has some of each
        for group in groups:
            if index < len(group):
                mixed[f"{group[index][0]}"] = group[index][1]
    return mixed


def _without_files(folder: Path, name: str, exercise: Exercise) -> None:
    """Add some of whom nothing can be graded."""
    (folder / "nothing in it").mkdir()
    (folder / "another name").mkdir()
    (folder / "another name" / "my_robot.py").write_text("print('hello')\n")
    (folder / "broken.zip").write_bytes(b"PK\x03\x04 and no more")
    shutil.rmtree(folder / name, ignore_errors=True)
