"""Right nodes with something between them and one of their topics: mistakes that add something.

A wrapper is the node's own text with an operator, and the hook that puts it in place, before the
line that starts the program. The host runs it like any student's file.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from grader.authoring.claims import Claim
from grader.authoring.mutate import hooks, operators
from grader.course.exercises import Exercise, Topic
from grader.exercises import contract_of

GUARD = re.compile(r"^if __name__ == ", re.MULTILINE)
SECONDS = (0.1, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0)
FEW = (1, 2, 3, 5)
MANY = (10, 30, 100)

ON_MESSAGES: dict[str, tuple[float, ...]] = {
    "Late": FEW,
    "OneIn": (2, 3, 5),
    "DropsOneIn": (2, 5, *MANY),
    "OldOneIn": (2, 5, *MANY),
    "Holds": SECONDS,
    "AtMostEvery": SECONDS,
    "IgnoresFirst": (*FEW, 10),
    "IgnoresAfter": (1, 5, *MANY),
    "DeafAfter": SECONDS,
    "Latches": (),
    "Twice": (),
    "Reorders": (),
}
HEARD: dict[str, tuple[float, ...]] = {"Expires": SECONDS}
STAMPED: dict[str, tuple[float, ...]] = {"OnlyNewer": ()}
ON_NUMBERS: dict[str, tuple[float, ...]] = {
    "Times": (-1.0, 0.5, 0.9, 1.1, 2.0),
    "Plus": (-0.05, 0.05),
    "Clips": (0.1, 0.4),
    "Quantises": (0.01, 0.1),
    "DeadBand": (0.05, 0.2),
    "Sticks": (0.01, 0.05, 0.2),
    "LowPass": (0.1, 0.5, 0.9),
    "FallsAtMost": (0.045, 0.1),
    "RisesAtMost": (0.045, 0.1),
    "LeastOf": (2, 3, 10),
    "ZeroFor": SECONDS,
    "NotZeroFor": SECONDS,
}
ON_READINGS: dict[str, tuple[float, ...]] = {
    "Times": (0.01, 0.9, 1.1, 100.0),
    "Plus": (-0.05, 0.05),
    "Clips": (1.5, 3.5, 11.9),
    "NanIs": (0.0, 12.0, float("inf")),
    "Quantises": (0.02, 0.25),
    "Sticks": (0.05, 0.5),
    "LowPass": (0.3, 0.9),
    "FallsAtMost": (0.05, 0.5),
    "RisesAtMost": (0.05, 0.5),
    "LeastOf": (2, 5),
}
TURN = "angular.z"
FIELDS: dict[str, tuple[str, ...]] = {  # the numbers of a message that mean something here
    "geometry_msgs/msg/Twist": ("linear.x", TURN),
    "std_msgs/msg/Float64": ("data",),
    "nav_msgs/msg/Odometry": ("pose.pose.position.x", "pose.pose.orientation.z"),
    "geometry_msgs/msg/PoseStamped": ("pose.position.y",),
}
READINGS = {"sensor_msgs/msg/LaserScan": ("ranges",)}
HAS_HEADER = ("sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry")


@dataclass(frozen=True)
class Wrapper:
    """One operator at one end of a node."""

    file: str  # of the exercise
    hears: bool
    topic: str
    field: str  # of the message; "" for an operator on messages
    operator: str
    number: float | None  # its argument

    @property
    def name(self) -> str:
        """For tables, and for the list of the equivalent ones."""
        number = "" if self.number is None else f" {self.number:g}"
        place = f"{self.topic} {self.field}".strip()
        return f"{'hears' if self.hears else 'says'} {place} {self.operator}{number}"

    @property
    def source(self) -> str:
        """The text that goes into the node's file."""
        hook = hooks.hears if self.hears else hooks.says
        change = changes()[self.operator]
        parts = [operators.Operator, change, hook]
        make = f"Operator({repr_of(self.number or 0.0)}, {change.__name__})"
        if self.field:
            parts.append(hooks.at)
            make = f"at({self.field!r}, lambda: {make})"
        code = "\n\n".join(_source(part) for part in parts)
        end = "hears" if self.hears else "says"
        return (
            f"# --- a wrapper: {self.name} ---\n"
            "import copy\nimport math\nfrom collections.abc import Callable\n"
            "from typing import Any\n\nimport rclpy.node\n\n\n"
            f"{code}\n\n{end}(rclpy.node.Node, {self.topic!r}, {make})\n\n\n"
        )


@cache
def changes() -> dict[str, Any]:
    """Return the operators by the names that they have in tables: "LowPass" is low_pass."""
    found = inspect.getmembers(operators, inspect.isfunction)
    return {name.title().replace("_", ""): function for name, function in found}


@cache
def _source(part: Any) -> str:
    return inspect.getsource(part)


def repr_of(number: float) -> str:
    """Return a number as Python source."""
    return repr(number) if abs(number) != float("inf") else f'float("{number}")'


def wrappers(exercise: Exercise) -> Iterator[Wrapper]:
    """Return every operator that makes sense at each topic of an exercise."""
    seen: set[tuple[str, str]] = set()
    turns = contract_of(exercise).limits.turning > 0.0  # elsewhere angular.z is always 0
    for topic in exercise.topics:
        file = _file_of(exercise, topic)
        last = topic.name.rpartition("/")[2]
        if (file, last) in seen:  # the same in another role
            continue
        seen.add((file, last))
        hears = topic.direction == "subscribe"
        kinds = [("", ON_MESSAGES)]
        kinds += [("", HEARD)] if hears else []
        kinds += [("", STAMPED)] if topic.type in HAS_HEADER else []
        fields = [f for f in FIELDS.get(topic.type, ()) if f != TURN or turns]
        kinds += [(field, ON_NUMBERS) for field in fields]
        kinds += [(field, ON_READINGS) for field in READINGS.get(topic.type, ())]
        for field, table in kinds:
            for operator, grid in table.items():
                for number in grid or (None,):
                    yield Wrapper(file, hears, topic.name, field, operator, number)


def wrapped(right: Claim, wrapper: Wrapper) -> Claim:
    """Return a right solution with a wrapper around it.

    Raises
    ------
    ValueError
        The file has no line that begins with `if __name__ == `.
    """
    text = right.files[wrapper.file]
    places = [match.start() for match in GUARD.finditer(text)]
    if not places:
        raise ValueError(f"{right.name}: {wrapper.file} has no `if __name__ == …` to wrap before")
    files: dict[str, Any] = dict(right.files)
    files[wrapper.file] = text[: places[-1]] + wrapper.source + text[places[-1] :]
    return replace(
        right,
        kind="mutant",
        stem=f"{right.stem} {wrapper.name}",
        files=files,
        about=wrapper.name,
        field_ready=False,
    )


def _file_of(exercise: Exercise, topic: Topic) -> str:
    """Return the file of the node that has this topic: names of both end with the same word."""
    word = topic.node.rpartition("_")[2]
    named = [file for file in exercise.files if word and file.endswith(f"_{word}.py")]
    return named[0] if named else exercise.files[0]


def every(right: Claim) -> Iterator[Claim]:
    """Return a right solution in every wrapper."""
    for wrapper in wrappers(right.exercise):
        yield wrapped(right, wrapper)
