"""Write docs/listing-style.md: four textbook listings, each graded, and what to do about it.

The nodes are in docs/listings/. The scores, tables and messages on the page are the grader's own;
nothing is pasted. `python -m grader.authoring.listings` writes the page, `--check` tells whether it
is up to date.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from grader.course.exercises import ROOT, find_exercise
from grader.course.generated import write_or_check
from grader.course.submission import find_submission
from grader.errors import GraderError
from grader.grading.grading import Grading, grade_submission
from grader.grading.plugin import FAIL, CheckResult
from grader.link.hosts import ForkServer
from grader.report.terminal import printed
from sim.messages import EPOCH_NS

PAGE = ROOT / "docs" / "listing-style.md"
NODES = ROOT / "docs" / "listings"
BEGIN, END = "# the mistake", "# the end of it"  # around a listing's crucial lines
WIDTH = 100  # [characters] of the tables
HEAD = """\
# Four listings that look right

Much of what is printed about robots is written in one style: short, plausible, and right on the
author's desk. These nodes are in that style. Each is complete, runs, and has one mistake; below it
stands what the grader says of it, and what a student does about that.

Nobody typed the scores and messages: `python -m grader.authoring.listings` grades the nodes in
[docs/listings](listings) and writes this page, and a test fails when it is no longer what the
grader says. To see one for yourself, with a replay of every run:

    course grade 1 docs/listings/front_by_index.py --report report.html
"""


@dataclass(frozen=True)
class Listing:
    """One node in the listing style."""

    file: str
    exercise: str
    title: str
    mistake: str  # what is wrong, in a sentence or two
    acts: Mapping[str, str]  # failing check: what a student does about its message
    lesson: str  # what to remember


LISTINGS = (
    Listing(
        "front_by_index.py",
        "obstacle_avoidance",
        "The front is a slice of the list",
        "The front sector is a third of `ranges`, wherever that third may look. Here it is ±60°, "
        "and the task asks for ±90°; on a lidar that counts from 0 to 2π it would be the back.",
        {
            "sees_sides": "The message names the scan. Print the angles of the first and the last "
            "beam of the slice: they are not ±90°.",
        },
        "Compute the angle of each beam, `angle_min + i * angle_increment`, wrap it, and compare "
        "that with π/2. Then it does not matter how many beams there are, or where they begin.",
    ),
    Listing(
        "min_over_raw.py",
        "obstacle_avoidance",
        "min() of whatever came",
        "`min()` takes readings that say nothing for distances, finds no order among NaN, and "
        "raises when there is nothing to choose from.",
        {
            "invalid_readings": "0.05 m is below `range_min`: not a thing in front of the robot, "
            "but the sensor's word for an error. Keep only readings within the limits, and ±inf.",
            "blind": "The message says which line raised, and after which message. An empty list "
            "has no minimum; decide what a robot does that sees nothing (it stands), and test it.",
        },
        "Ask of each reading whether it says anything (REP-117) before you ask which is smallest.",
    ),
    Listing(
        "heading_without_yaw.py",
        "goal_seeking",
        "The heading error without the heading",
        "The robot turns by the bearing to the goal and never subtracts where it looks already. "
        "On its way it turns on and on; only goals straight ahead of its first pose are reached.",
        {
            "reaches_goal": "The distances say that it came no nearer, and the angle that it did "
            "not face the goal: look at the turning, not at the speed.",
            "reaches_any_goal": "The same fault from other starts; one correction mends both.",
            "turns_short_way": "Here stand the right sign, the heading error and what was sent. "
            "Compute the error of this moment by hand: the yaw is what is missing.",
            "bad_input": "The pose of 5.0 s has a yaw of NaN. A node that never reads the yaw "
            "takes it for a good one.",
        },
        "Heading error = bearing - yaw, wrapped to [-π, π]. Four messages, one line of code: the "
        "one that shows the wrong sign is the one to start with.",
    ),
    Listing(
        "no_stop_without_model.py",
        "ml_velocity",
        "No model, no command",
        "Without a model the callback returns, and nothing is published. A robot that was driving "
        "goes on with its last command for as long as its base allows. (Graded with the "
        "reference's training script beside it.)",
        {
            "no_model": "The run `ml_no_model` has no model file: the expected Twist is a zero, "
            "and nothing came. Let every way through the callback end at the `publish()`.",
        },
        "Saying nothing is not the same as saying stop.",
    ),
)


def page() -> str:
    """Grade the listings and return the page."""
    return "\n".join([HEAD, *(section(number, one) for number, one in enumerate(LISTINGS, 1))])


def grade_listing(listing: Listing) -> Grading:
    """Grade a listing, core and (if the core is full) field, with the reference's other files."""
    exercise = find_exercise(listing.exercise)
    others = exercise.files[1:]
    with (
        tempfile.TemporaryDirectory(prefix="course-listing-") as name,
        ForkServer(EPOCH_NS, libraries=exercise.libraries) as forkserver,
    ):
        folder = Path(name)
        for path in (NODES / listing.file, *(exercise.solutions / file for file in others)):
            shutil.copyfile(path, folder / path.name)
        submission = find_submission(folder / listing.file, others=others)
        return grade_submission(exercise, submission, forkserver, file=listing.file, field=True)


def main(arguments: list[str]) -> int:
    """Write the page, or with `--check` compare it; 1 if it is out of step."""
    command = "python -m grader.authoring.listings"
    pages = ((path, page()) for path in (PAGE,))  # graded only if the arguments are right
    return write_or_check(pages, command, arguments)


def section(number: int, listing: Listing) -> str:
    """Grade a listing and return its section of the page.

    Raises
    ------
    GraderError
        It fails other checks than those with advice, or the machine was too busy to judge.
    """
    grading = grade_listing(listing)
    if grading.faulty:
        raise GraderError(f"{listing.file}: not all checks could be judged; run this once more")
    failed = [check for check in grading.checks if check.outcome == FAIL]
    if {check.id for check in failed} != set(listing.acts):
        found = ", ".join(check.id for check in failed)
        raise GraderError(f"{listing.file}: fails {found}; expected {', '.join(listing.acts)}")
    exercise = grading.exercise
    return "\n".join(
        [
            f"## {number}. {listing.title}: {grading.score} of {grading.max_score} points\n",
            f"Exercise {exercise.number}, {exercise.title}: "
            f"[{listing.file}](listings/{listing.file}). {listing.mistake}\n",
            f"```python\n{crucial_lines(NODES / listing.file)}\n```\n",
            f"```text\n{_core_table(grading)}```\n",
            *(_advice(check, listing.acts[check.id]) for check in failed),
            f"\n{listing.lesson}\n",
        ]
    )


def crucial_lines(file: Path) -> str:
    """Return the lines between the marks, dedented."""
    lines = file.read_text("utf-8").splitlines()
    begin, end = (next(i for i, line in enumerate(lines) if line.strip() == mark)
                  for mark in (BEGIN, END))  # fmt: skip
    chosen = lines[begin + 1 : end]
    indent = len(lines[begin]) - len(BEGIN)
    return "\n".join(line[indent:] for line in chosen)


def _core_table(grading: Grading) -> str:
    core = [check.as_dict() for check in grading.checks if check.kind == "core"]
    return printed({**grading.as_dict(), "checks": core, "field_ready": None}, WIDTH)


def _advice(check: CheckResult, act: str) -> str:
    return f"- **{check.id}**: {check.message}  \n  *What to do:* {act}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
