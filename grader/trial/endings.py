"""How a trial ends: before its node ran, by itself, or with its node; and in which words."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from grader.course.submission import Submission
from grader.models.service import TooManyQuestions
from grader.recording import Outcome, Recording
from grader.trial.recorder import Command, Recorder
from grader.trial.staging import missing_file
from rclpy_virtual_time import Excess, Flood, HostForged, LogLine
from sim.scenario import Scenario
from sim.simulation import Simulation

AFTERMATH_NS = 10**9  # the robot rolls on for this long when its node is gone
GRACE = 1.0  # [s] for the end of a process that has hung up
STUCK = (
    "the node stopped for good: every thread waits for something that can't come any more "
    "(a blocking call() or wait in a callback waits for an answer that only the executor "
    "it blocks could deliver)"
)
BUSY_WAIT = "a loop in the node goes round without letting time pass"
NEVER_SPUN = "the program runs, but its node never spins"


def not_runnable(submission: Submission, scenario: Scenario) -> Outcome | None:
    """Return why a submission can't run in a scenario; None if there is no reason."""
    if submission.problem:
        return Outcome("unreadable", submission.problem)
    package = submission.package
    if package and package.problem and _launches(scenario):
        return Outcome("held" if package.held else "unreadable", package.problem)
    if missing := missing_file(scenario, submission):
        return Outcome("missing", missing)
    return None


def not_run(simulation: Simulation, outcome: Outcome) -> Recording:
    """Return the recording of a scenario in which no node ran."""
    return Recorder().freeze(simulation, outcome)


def is_halt(recording: Recording) -> bool:
    """Return whether a node hung, or ended before it was sent anything, or never spun."""
    outcome = recording.outcome
    if outcome.completed or outcome.kind == "real_time" or recording.scenario.training is not None:
        return False
    return outcome.kind in ("hung", "never_spun") or not recording.delivered


def roll_on(simulation: Simulation, reached: int, commands: Sequence[Command] = ()) -> None:
    """Let the robot roll on for a while after its node ended at `reached` [ns]."""
    until = max(simulation.now, min(reached + AFTERMATH_NS, simulation.end))
    simulation.advance(until, commands)


def misbehaviour(error: HostForged | Flood | Excess | TooManyQuestions) -> tuple[str, str]:
    """Return the kind and the text of an outcome."""
    if isinstance(error, Excess):
        return "flooded", f"the node took more of the machine than it may: {error}"
    kind = "forged" if isinstance(error, HostForged) else "flooded"
    return kind, f"the node sent more or other than a node can say: {error}"


def died_text(status: str) -> str:
    """Say by its exit status how a silent process ended."""
    return f"the node's process ended by itself ({status})"


def without_folder(outcome: Outcome, folder: Path) -> Outcome:
    """Show paths as the student knows them: the copy's folder changes from run to run."""
    prefix = f"{folder}/"
    return Outcome(
        outcome.kind,
        outcome.text.replace(prefix, ""),
        outcome.at,
        outcome.detail.replace(prefix, ""),
    )


def line_without_folder(line: LogLine, folder: Path) -> LogLine:
    """Show paths as the student knows them."""
    return LogLine(line.time, line.level, line.text.replace(f"{folder}/", ""))


def _launches(scenario: Scenario) -> bool:
    """Return whether a scenario starts what the submission's launch file starts."""
    return not scenario.program or any(not program.file for program in scenario.program)
