"""Is the exam the same for everybody? Grade right solutions in the worlds of many students.

Each student has different worlds, so a right solution must get full marks in all of them. Many
scenarios (open-loop benches, scripted runs) are the same for everybody: they are run for the first
students, and the recording then stands for every student whose robot would send the same. Both
assumptions are tested. What the robot sends is compared byte for byte while it drives a fixed
course without a node, and a recording is reused only after two students' runs were identical.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache

from grader.authoring.claims import Claim, claims, complete
from grader.authoring.proof import objections
from grader.course.exercises import find_exercise
from grader.course.students import student_key
from grader.course.submission import Submission
from grader.grading.grading import Grading, grade
from grader.grading.plugin import INCONCLUSIVE, PASS, SKIP
from grader.link.hosts import ForkServer
from grader.recording import Recording
from grader.trial.trials import NodeTrials
from sim.layout import layout_to_json
from sim.messages import EPOCH_NS
from sim.scenario import Scenario
from sim.scenario_files import load_scenario
from sim.simulation import Simulation

SECRET = b"not a secret: for measuring only"
ATTEMPTS = 3  # if the machine stalls
COURSE = ((0.3, 0.0), (0.4, 0.6), (0.2, -0.9), (0.5, 0.0))  # [m/s, rad/s] driven in turn
COURSE_NS = 100_000_000  # [ns] between two commands of the course


@dataclass(frozen=True)
class Verdict:
    """How one right solution did in one student's worlds."""

    student: int
    against: tuple[str, ...]  # what went wrong; () if nothing did
    runs: int  # scenarios judged
    own: int  # of which run for this student


def right_solutions(slug: str, *, variants: bool = True) -> list[Claim]:
    """Return the reference of an exercise, and its variants."""
    kinds = ("reference", "variant") if variants else ("reference",)
    return [claim for claim in claims(find_exercise(slug)) if claim.kind in kinds]


def examine(claim: Claim, students: Iterable[int], *, field: int = 0) -> Iterator[Verdict]:
    """Grade a right solution in the worlds of each student.

    Parameters
    ----------
    field
        For how many students, from the first on, the field checks are judged too (if the solution
        claims the badge).
    """
    libraries = claim.exercise.libraries
    with ForkServer(EPOCH_NS, libraries=libraries) as forkserver, complete(claim) as submission:
        shared = Shared()
        for student in students:
            yield _examine(claim, submission, student, forkserver, shared, student < field)


def _examine(
    claim: Claim,
    submission: Submission,
    student: int,
    forkserver: ForkServer,
    shared: Shared,
    field: bool,
) -> Verdict:
    seed = student_key(SECRET, f"student {student}", claim.exercise.slug)
    judged = field and claim.field_ready
    for _ in range(ATTEMPTS):
        trials = ThriftyTrials(submission, forkserver, seed=seed, shared=shared)
        with trials:
            grading = grade(claim.exercise, trials, file=claim.exercise.files[0], field=judged)
        if all(check.outcome != INCONCLUSIVE for check in grading.checks):
            break
        shared.forget()
    against = tuple(_against(claim, grading))
    return Verdict(student, against, len(grading.recordings), len(trials.made))


def _against(claim: Claim, grading: Grading) -> list[str]:
    """Return the objections to a grading, with the messages that the student would read.

    Checks that could not judge because the machine stalled say nothing about the worlds.
    """
    judged = [check for check in grading.checks if check.outcome != INCONCLUSIVE]
    if len(judged) < len(grading.checks) and all(check.outcome in (PASS, SKIP) for check in judged):
        return []
    said = [
        f"{check.id} in {check.scenario}: {check.message} (expected {check.expected}, "
        f"actual {check.actual}, at {check.time})"
        for check in grading.checks
        if check.outcome == "fail"
    ]
    found = objections(claim, grading)
    return [*found, *said] if found else []


# --- runs that stand for many students -----------------------------------------------------------


@dataclass
class _Known:
    recording: Recording
    confirmed: bool  # a second student's run came out the same


@dataclass
class Shared:
    """The recordings of one solution that stand for every student."""

    known: dict[str, _Known] = field(default_factory=dict)  # by scenario

    def get(self, scenario: str) -> Recording | None:
        """Return the recording of a scenario that may be used again, if there is one."""
        known = self.known.get(scenario)
        return known.recording if known is not None and known.confirmed else None

    def add(self, recording: Recording) -> None:
        """Note a run of a scenario that is the same for every student."""
        before = self.known.get(recording.name)
        same = before is not None and _fingerprint(before.recording) == _fingerprint(recording)
        self.known[recording.name] = _Known(recording, same)

    def forget(self) -> None:
        """Forget everything: the machine stalled, so it may be wrong."""
        self.known.clear()


@dataclass
class ThriftyTrials(NodeTrials):
    """Runs the scenarios that differ by student; reuses the recordings of those that don't."""

    shared: Shared = field(default_factory=Shared)
    made: list[str] = field(default_factory=list)  # scenarios run for this student

    def _run(self, scenario: Scenario) -> Recording:
        seed = self.seed_of(scenario)
        own = scenario.training is not None or is_own(scenario, seed)
        known = None if own else self.shared.get(scenario.name)
        if known is not None:
            return known
        recording = super()._run(scenario)
        self.made.append(scenario.name)
        if not own:
            self.shared.add(recording)
        return recording


def is_own(scenario: Scenario, seed: int) -> bool:
    """Tell whether the robot sends other messages with this seed than with the scenario's own."""
    simulation = Simulation(scenario, seed)
    layout, sent = _own_fingerprint(scenario.name)
    return layout_to_json(simulation.layout) != layout or fingerprint(simulation) != sent


def fingerprint(simulation: Simulation) -> str:
    """Return a hash of all that the robot sends and does on a fixed course, without a node."""
    end = round(simulation.scenario.duration * 1e9)
    commands = [
        (time, *COURSE[i // 10 % len(COURSE)]) for i, time in enumerate(range(0, end, COURSE_NS))
    ]
    result = hashlib.sha256()
    for message in simulation.advance(end, commands):
        result.update(f"{message.time} {message.topic} {message.type}".encode() + message.data)
    truth = simulation.truth()
    for array in (truth.x, truth.y, truth.yaw, truth.v, truth.w, truth.clearance, truth.contact):
        result.update(array.tobytes())
    return result.hexdigest()


@lru_cache(maxsize=256)
def _own_fingerprint(name: str) -> tuple[str, str]:
    simulation = Simulation(load_scenario(name))
    return layout_to_json(simulation.layout), fingerprint(simulation)


def _fingerprint(recording: Recording) -> str:
    """Return the digest that two students' recordings must share: of everything but the seed."""
    return replace(recording, seed=0).digest()
