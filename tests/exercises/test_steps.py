"""Ten steps from the skeleton to the reference: no right step costs a point (before the cap).

After tasks 1 and 2 the checks of tasks 1 and 2 pass: a check belongs to the task that shows it.

A step fills in one block of the solution, in the order of the tasks, or the wiring first and then
from the last task to the first: from what is published back to what it is made of. In exercise 1,
whose blocks are few, there are rows of half a task, too.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import pytest

from grader.claims.claims import Claim, grade_claim
from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.skeletons import strip_solution
from grader.grading.grading import Grading, grade
from grader.launchers import ForkServerPool
from grader.trial.trials import SavedTrials

BLOCK = re.compile(
    r"^ *### BEGIN SOLUTION\n(?P<right>.*?)(?: *### SKELETON\n(?P<stub>.*?))? *### END SOLUTION\n",
    re.MULTILINE | re.DOTALL,
)
TASK = re.compile(r"TODO\(task (\d+)\)")
# what a beginner writes before the whole of a task: instead of its block
HALVES = {
    ("obstacle_avoidance", 3): (
        "return min(scan.ranges)",
        "return min(scan.ranges[90:271])",
        "return min((r for r in scan.ranges[90:271] if r >= scan.range_min), default=None)",
    ),
}


@dataclass(frozen=True)
class Block:
    """What a student writes in one place."""

    file: str
    place: int  # from the top of all files
    task: int  # the first that it is part of


@dataclass(frozen=True)
class Step:
    """What has been filled in so far, and with what."""

    what: str
    filled: frozenset[Block]
    half: tuple[Block, str] | None = None


def blocks(exercise: Exercise) -> list[Block]:
    """Return all blocks of an exercise, in the order of its files."""
    found: list[Block] = []
    for file in exercise.files:
        task = 1
        for match in BLOCK.finditer((exercise.solutions / file).read_text("utf-8")):
            tasks = [int(number) for number in TASK.findall(match["stub"] or "")]
            task = min(tasks, default=task)
            found.append(Block(file, len(found), task))
    return found


def steps(exercise: Exercise, order: str) -> Iterator[Step]:
    """Yield the steps from the skeleton to the reference."""
    there = blocks(exercise)
    filled: set[Block] = set()
    yield Step("the skeleton", frozenset())
    backwards = order == "backwards"
    for block in sorted(there, key=lambda b: -b.task if backwards and b.task > 1 else b.task - 99):
        for line in HALVES.get((exercise.slug, block.task), ()):
            yield Step(f"task {block.task}: {line}", frozenset(filled), (block, line))
        filled.add(block)
        yield Step(f"task {block.task}, block {block.place + 1}", frozenset(filled))


def files(exercise: Exercise, step: Step) -> dict[str, str]:
    """Return the texts of a step: the skeleton's, but for the blocks that are filled in."""
    there = iter(blocks(exercise))

    def text(match: re.Match[str]) -> str:
        block = next(there)
        if block in step.filled:
            return match["right"]
        if step.half is not None and step.half[0] == block:
            indent = match[0][: len(match[0]) - len(match[0].lstrip(" "))]
            return f"{indent}{step.half[1]}\n"
        return strip_solution(match[0])

    return {
        file: BLOCK.sub(text, (exercise.solutions / file).read_text("utf-8"))
        for file in exercise.files
    }


def grade_step(
    exercise: Exercise, step: Step, servers: ForkServerPool, only: Sequence[str] = ()
) -> Grading:
    """Grade the program of a step, by the core's checks or only some."""
    claim = Claim(exercise, "step", step.what, files(exercise, step))
    return grade_claim(claim, servers.of(exercise.libraries), only=only)


def test_the_last_step_is_the_reference_and_the_first_the_skeleton() -> None:
    for exercise in all_exercises():
        first, *_, last = steps(exercise, "tasks")
        for file, text in files(exercise, first).items():
            assert text == (exercise.folder / file).read_text("utf-8")
        for text in files(exercise, last).values():
            assert "TODO" not in text


@pytest.mark.long
@pytest.mark.parametrize("order", ["tasks", "backwards"])
@pytest.mark.parametrize("slug", [exercise.slug for exercise in all_exercises()])
def test_no_right_step_costs_a_point(slug: str, order: str, forkservers: ForkServerPool) -> None:
    exercise, best = find_exercise(slug), 0
    for step in steps(exercise, order):
        grading = grade_step(exercise, step, forkservers)
        print(f"{grading.raw_score:3} ({grading.score})  {step.what}")
        assert grading.raw_score >= best, step.what
        best = grading.raw_score


@pytest.mark.long
@pytest.mark.parametrize("slug", [exercise.slug for exercise in all_exercises()])
def test_tasks_1_and_2_pass_their_checks(slug: str, forkservers: ForkServerPool) -> None:
    exercise = find_exercise(slug)
    known = grade(exercise, SavedTrials([]), file="", field=False).checks
    due = [check.id for check in known if check.task in (1, 2)]
    *_, done = (s for s in steps(exercise, "tasks") if all(b.task <= 2 for b in s.filled))
    grading = grade_step(exercise, done, forkservers, due)
    assert [(c.id, c.message) for c in grading.checks if c.outcome != "pass"] == []
