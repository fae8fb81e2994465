"""Show in the terminal what `course doctor` found."""

from __future__ import annotations

import contextlib
import importlib.metadata
from collections.abc import Mapping
from typing import TYPE_CHECKING

from rich.table import Table
from rich.text import Text

from grader.course.installed import never_run
from grader.report.facts import OUTCOMES
from grader.report.terminal import MAX_WIDTH, Console, is_ascii, printable
from rclpy_virtual_time import RosEnvironment

if TYPE_CHECKING:
    from rclpy_virtual_time import Diagnosis

EXTRAS: Mapping[str, tuple[str, ...]] = {  # what it is for: distributions
    "exercise 2, 5, 6, 8 and 9 (extra `ml`)": ("scikit-learn", "onnxruntime", "onnx", "skl2onnx"),
    "PyTorch and Keras in exercise 8 (extra `deep`)": ("torch", "keras"),
    "grading on a cluster (extra `cluster`)": ("distributed",),
    "the desk (extra `desk`)": ("tornado",),
    "notebooks (extra `notebooks`)": ("jupyterlab", "nbgrader"),
}
PRACTICE_HERE = (
    "course grade and course drive take the portable runtime instead: rclpy's own Python on a "
    "native half that is written in Python, in the same virtual time.",
    "It is for practice. Your instructor's grade comes from the real rclpy on Linux; "
    "docs/portable.md in the course's repository says how the two were compared.",
    "Nothing isolates a node here: your own code only. course autograde, --tier 2 and the fixture "
    "virtual_time need the real rclpy.",
)


def render_diagnosis(found: Diagnosis, console: Console) -> None:
    """Print the findings of `course doctor`."""
    width = min(console.width, MAX_WIDTH)
    console.print(_facts(found.python, found.ros or "not found", missing_extras()), width=width)
    layers = Table(box=None, padding=(0, 2, 0, 1), header_style="bold")
    for heading in ("Layer", "", "What it is for"):
        layers.add_column(heading)
    for layer in found.layers:
        sign, ascii_sign, _, style = OUTCOMES["pass" if layer.here else "fail"]
        mark = Text(ascii_sign if is_ascii(console) else sign, style=style)
        layers.add_row(layer.name, mark, layer.text)
    console.print()
    console.print(layers, width=width)
    console.print()
    for heading, sentences in (
        ("What a submission can still do here", found.gaps),
        ("What a class may fail on here", found.trouble),
    ):
        if sentences:
            console.print(Text(f" {heading}", style="bold"), width=width)
            bullets = Table(box=None, show_header=False, padding=(0, 1, 0, 1))
            for sentence in sentences:
                bullets.add_row("-", printable(sentence, console))
            console.print(bullets, width=width)
            console.print()
    if found.problem:
        said = Text(f" No node can run here: {printable(found.problem, console)}", style="bold red")
    elif found.foreign_code:
        said = Text(f" Your own code only: {found.foreign_code}", style="yellow")
    else:
        said = Text(" Other people's code may be graded here.", style="green")
    console.print(said, width=width)


def _facts(python: str, ros: str, extras: Mapping[str, tuple[str, ...]]) -> Table:
    facts = Table(box=None, show_header=False, padding=(0, 2, 0, 1))
    facts.add_row("Python", python)
    facts.add_row("ROS 2", ros)
    for what, missing in extras.items():
        facts.add_row(
            Text("missing" if missing else "installed", style="yellow" if missing else "green"),
            f"{what}: {', '.join(missing)}" if missing else what,
        )
    return facts


def render_practice(reason: str, console: Console) -> None:
    """Print the words of `course doctor` where the real rclpy can't run."""
    width = min(console.width, MAX_WIDTH)
    ros = "portable: rclpy's own Python, for practice"
    console.print(_facts(RosEnvironment.system_name(), ros, missing_extras()), width=width)
    console.print()
    if untried := never_run():
        console.print(Text(f" {untried}", style="bold yellow"), width=width)
        console.print()
    console.print(Text(f" The real rclpy can't run here: {reason}", style="yellow"), width=width)
    console.print()
    for line in PRACTICE_HERE:
        console.print(Text(f" {line}"), width=width)


def missing_extras() -> Mapping[str, tuple[str, ...]]:
    """Return the purpose of each extra, and its missing distributions."""
    return {what: tuple(filter(_is_missing, names)) for what, names in EXTRAS.items()}


def _is_missing(distribution: str) -> bool:
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        importlib.metadata.version(distribution)
        return False
    return True
