"""Grade one submission: run the checks of an exercise on recordings and add up the points."""

from __future__ import annotations

import contextlib
import importlib.metadata
import math
import os
import platform
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import msgspec

from grader.course.exercises import Exercise
from grader.course.installed import COURSE
from grader.course.score import Score, score_of
from grader.course.students import Seed, public_seed
from grader.course.submission import Submission
from grader.errors import DiskFull, GraderError, is_disk_full
from grader.exercises import oracle_of
from grader.grading.causes.cause import Cause
from grader.grading.plugin import (
    ERROR,
    FAIL,
    INCONCLUSIVE,
    PASS,
    UNAVAILABLE,
    CheckPlugin,
    CheckResult,
)
from grader.grading.praise import praise_of, remarks_on
from grader.recording import Recording
from grader.trial.kept import KeptRecordings
from grader.trial.packages import unpacked
from grader.trial.progress import OnProgress, ignore
from grader.trial.trials import NodeTrials, TrialFault, Trials
from rclpy_virtual_time import Launcher

ATTEMPTS = 2
SEE_CAUSE = "See the cause."
REPORTED_PACKAGES = (
    "ros-jazzy-rclpy", "ros-kilted-rclpy", "numpy", "pymunk", "rosbags", "pytest",
    "scikit-learn", "onnxruntime", "torch", "keras",
)  # fmt: skip

# pytest's own plugins that have no effect here; each would cost every grading some time
UNUSED_PLUGINS = (
    "cacheprovider", "doctest", "faulthandler", "junitxml", "legacypath", "logging", "pastebin",
    "recwarn", "setuponly", "setupplan", "stepwise", "subtests", "terminal", "terminalprogress",
    "threadexception", "tmpdir", "unittest",
    "unraisableexception",  # collects garbage twice, 40 ms each
)  # fmt: skip


@dataclass(frozen=True)
class Grading:
    """The verdict on one submission."""

    exercise: Exercise
    file: str
    tier: int
    checks: tuple[CheckResult, ...]
    recordings: tuple[Recording, ...]
    isolation: str = ""
    practice: str = ""  # why it is for practice only; "" if it counts
    faults: tuple[TrialFault, ...] = ()  # trials in which the grader failed
    trial_notes: tuple[str, ...] = ()
    cause: Cause | None = None  # the most probable one of what failed

    @cached_property
    def result(self) -> Score:
        """Points, before and after the cap."""
        return score_of((check.as_dict() for check in self.checks), self.exercise.essential)

    @property
    def score(self) -> int:
        """Core points won, after the cap."""
        return int(self.result.points)

    @property
    def raw_score(self) -> int:
        """Core points won, before the cap."""
        return int(self.result.raw)

    @property
    def max_score(self) -> int:
        """Core points that could be won: checks that could not judge are left out."""
        return int(self.result.most)

    @property
    def field_ready(self) -> bool | None:
        """All field checks passed (with full core points); None if they were not run."""
        field = [check for check in self.checks if check.kind == "field"]
        if not field:
            return None
        return self.full and _passed(field)

    @property
    def full(self) -> bool:
        """The full core score, with every core check judged whose libraries are installed."""
        return _passed([check for check in self.checks if check.kind == "core"])

    @property
    def whole(self) -> bool:
        """The full core score, and no check was left out by `only`."""
        points = sum(check.max_points for check in self.checks if check.kind == "core")
        return self.full and points == self.exercise.max_points

    @property
    def faulty(self) -> bool:
        """The grader or the machine failed somewhere."""
        return any(check.outcome in (ERROR, INCONCLUSIVE) for check in self.checks)

    def notes(self) -> list[str]:
        """Return notes on the score, a sentence each."""
        told = self._praise()
        told += [_sentence(self.practice) + "."] if self.practice else []
        told += [f"{_sentence(fault)}. The score is provisional." for fault in self.faults]
        told += self.trial_notes
        real = [recording for recording in self.recordings if recording.live is not None]
        reason = next((r.live.reason for r in real if r.live is not None and r.live.reason), "")
        if not reason:
            return told
        return [
            *told,
            f"{len(real)} of {len(self.recordings)} trials ran in real time, with a robot that "
            f"runs by the clock: {reason}. The checks are the same.",
        ]

    def _praise(self) -> list[str]:
        """Return the praise of a program with all points, and remarks on it."""
        if not self.whole or not self.recordings:
            return []
        return [praise_of(self.recordings), *remarks_on(self.recordings)]

    def as_dict(self) -> dict[str, Any]:
        """Return the JSON object of this grading."""
        return {
            "exercise": self.exercise.slug,
            "file": self.file,
            "tier": self.tier,
            "score": self.score,
            "max_score": self.max_score,
            "raw_score": self.raw_score,  # before the cap
            "cap": self.result.note,  # why it is capped; empty if it isn't
            "provisional": self.faulty,  # a person has to look before the score counts
            "field_ready": self.field_ready,
            "isolation": self.isolation,
            "practice": self.practice,
            "notes": self.notes(),
            "cause": None if self.cause is None else msgspec.to_builtins(self.cause),
            "checks": [check.as_dict() for check in self.checks],
            "recordings": [_describe(recording) for recording in self.recordings],
            "versions": versions(),
        }


def grade(
    exercise: Exercise,
    trials: Trials,
    *,
    file: str,
    tier: int = 1,
    field: bool = False,
    only: Iterable[str] = (),
    isolation: str = "",
    practice: str = "",
    on_progress: OnProgress = ignore,
) -> Grading:
    """Run the checks of `exercise` on the recordings of `trials`.

    Raises InputError: `only` names a check that doesn't exist.
    Raises GraderError: the checks can't be run.
    Raises DiskFull: no space was left for a trial.
    """
    import pytest  # noqa: PLC0415  (0.1 s)

    plugin = CheckPlugin(
        trials,
        field=field,
        only=only,
        on_progress=on_progress,
        exercise=exercise.slug,
        essential=exercise.essential.checks if exercise.essential else (),
        oracle=oracle_of(exercise),
    )
    with _undisturbed():
        code = pytest.main(_arguments(exercise), plugins=[plugin])
    if plugin.interrupted:
        raise KeyboardInterrupt
    if plugin.fault is not None:
        raise plugin.fault
    faults = tuple(trials.faults())
    if full := next(filter(is_disk_full, faults), None):
        raise DiskFull(f"the disk is full: {full}") from full
    if code not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED) or not plugin.results:
        raise GraderError(f"the checks of {exercise.slug} can't be run (pytest: {code!r})")
    checks = sorted(plugin.results.values(), key=_place)
    recordings = tuple(trials.recordings())
    cause = _cause(exercise, checks, recordings)
    return Grading(
        exercise=exercise,
        file=file,
        tier=tier,
        checks=tuple(_helped(check, cause) for check in checks),
        recordings=recordings,
        isolation=isolation,
        practice=practice,
        faults=faults,
        trial_notes=tuple(trials.notes()),
        cause=cause,
    )


def _place(check: CheckResult) -> tuple[bool, float]:
    """Return a check's place in the list: by the README's tasks, then checks of all tasks."""
    return check.kind == "field", check.task or math.inf


def _cause(
    exercise: Exercise, checks: Sequence[CheckResult], recordings: Sequence[Recording]
) -> Cause | None:
    """Return the cause of the failures."""
    failed = [check for check in checks if check.outcome == FAIL]
    if not failed:
        return None
    from grader.grading.causes.find import find_cause  # noqa: PLC0415  (most nodes pass)

    return find_cause(exercise, failed, recordings)


def _helped(check: CheckResult, cause: Cause | None) -> CheckResult:
    """Return the check without its own help where the cause explains more."""
    if cause is None or check.id not in cause.explains:
        return check
    return replace(check, help=SEE_CAUSE)


def grade_submission(
    exercise: Exercise,
    submission: Submission,
    launcher: Launcher,
    *,
    file: str,
    field: bool = False,
    only: Iterable[str] = (),
    seed: Seed | None = None,
    bags: Path | None = None,
    tier: int = 1,
    on_progress: OnProgress = ignore,
    kept: KeptRecordings | None = None,
) -> Grading:
    """Run the student's node and judge it; repeated once if the machine stalled.

    `kept` has the recordings of earlier runs.

    Raises InputError: `only` names a check that doesn't exist.
    Raises GraderError: the grader or the machine failed; it says nothing about the submission.
    """
    only = tuple(only)
    submission = unpacked(submission, launcher)
    for _ in range(ATTEMPTS):
        with NodeTrials(
            submission,
            launcher,
            seed=seed,
            bags=bags,
            real_time=tier == 2,
            on_progress=on_progress,
            kept=kept,
        ) as trials:
            grading = grade(
                exercise,
                trials,
                file=file,
                tier=tier,
                field=field,
                only=only,
                isolation=launcher.isolation,
                practice=launcher.practice,
                on_progress=on_progress,
            )
        held = submission.package is not None and submission.package.held
        repeated = tier == 2 or any(r.live is not None and r.live.stall for r in grading.recordings)
        undecided = any(check.outcome == INCONCLUSIVE for check in grading.checks)
        if held or repeated or not undecided:
            break  # a trial in real time has been repeated already
        kept = kept and kept.anew()
    return grading


def versions() -> dict[str, str]:
    """Return the versions on which a verdict may depend."""
    found = {"python": platform.python_version()}
    for name in (COURSE, *REPORTED_PACKAGES):
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found


def _sentence(fault: TrialFault | str) -> str:
    text = str(fault)
    return text[0].upper() + text[1:]


def _passed(checks: list[CheckResult]) -> bool:
    """Return whether all passed that can be judged on this machine, and at least one can."""
    judged = [check for check in checks if check.outcome != UNAVAILABLE]
    return all(check.outcome == PASS for check in judged) and (bool(judged) or not checks)


def _arguments(exercise: Exercise) -> list[str]:
    return [
        *map(str, sorted(exercise.judge.glob("test_*.py"))),  # or pytest looks at each scenario
        "--import-mode=importlib",
        "--assert=plain",  # checks speak through fail(); rewriting would cost half a second
        "--capture=sys",
        f"--rootdir={exercise.judge}",
        f"--config-file={os.devnull}",
        "-W", "ignore",
        *(argument for name in UNUSED_PLUGINS for argument in ("-p", f"no:{name}")),
    ]  # fmt: skip


@contextlib.contextmanager
def _undisturbed() -> Iterator[None]:
    """Keep the environment's pytest settings and third-party plugins out of the checks."""
    names = ("PYTEST_ADDOPTS", "PYTEST_PLUGINS", "PYTEST_DISABLE_PLUGIN_AUTOLOAD")
    before = {name: os.environ.pop(name) for name in names if name in os.environ}
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    try:
        yield
    finally:
        os.environ.pop("PYTEST_DISABLE_PLUGIN_AUTOLOAD", None)
        os.environ.update(before)


def _describe(recording: Recording) -> dict[str, Any]:
    return {
        "scenario": recording.name,
        "title": recording.scenario.title,
        "seed": public_seed(recording.seed),
        "duration": recording.duration_s,
        "outcome": recording.outcome.kind,
        "bag": recording.bag,
        "real_time": None if recording.live is None else msgspec.to_builtins(recording.live),
    }
