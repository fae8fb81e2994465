"""One's own best drives: what is kept of them, and the reference's beside them."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
from driven import careful, drive_by, reckless, timid

from grader.course.exercises import Exercise, all_exercises, find_exercise
from grader.course.submission import find_submission
from grader.grading.best import Drive, best_table, drive_in, remember_best
from grader.grading.grading import Grading
from grader.grading.plugin import PASS, CheckResult
from grader.launchers import ForkServerPool
from grader.recording import Recording
from grader.trial.trials import NodeTrials
from sim.scenario_files import load_scenario

FIRST = find_exercise("1")
CART = load_scenario("avoid_cart")
WITH_BEST = [exercise for exercise in all_exercises() if exercise.best]


def graded(*recordings: Recording, won: int = 100) -> Grading:
    check = CheckResult("all", "All.", "core", won, won, PASS)
    return Grading(FIRST, "node.py", 1, (check,), recordings)


def test_the_best_of_each_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    assert best_table(FIRST) == []
    usual = drive_in(drive_by(careful, CART))
    assert usual == Drive(*FIRST.best["avoid_cart"])
    remember_best(graded(drive_by(timid, CART), drive_by(reckless, CART)))
    assert best_table(FIRST) == []  # one hardly moved, the other touched something
    short = msgspec.structs.replace(CART, duration=5.0)
    remember_best(graded(drive_by(careful, CART), won=5))
    assert best_table(FIRST) == []  # not all points
    remember_best(graded(drive_by(careful, CART)))
    remember_best(graded(drive_by(careful, short)))
    (row,) = best_table(FIRST)
    assert row.startswith("  avoid_cart   5.00 s ")
    assert row.endswith(f"reference {usual}")


@pytest.mark.long
@pytest.mark.parametrize("exercise", WITH_BEST, ids=lambda exercise: exercise.slug)
def test_the_references_drives_are_as_they_are_shown(
    exercise: Exercise, forkservers: ForkServerPool
) -> None:
    submission = find_submission(exercise.solutions, exercise.files[0], exercise.files[1:])
    with NodeTrials(submission, forkservers.of(exercise.libraries)) as trials:
        driven = {name: drive_in(trials.get(name)) for name in exercise.best}
    assert driven == {name: Drive(*known) for name, known in exercise.best.items()}
