"""One trial: one node, one scenario, in lock-step, in virtual time.

The robot's next message and the node's commands meet here: the host runs up to the time of the next
message, the simulation follows with the commands that came out, and hands over what it measured.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from grader.course.submission import Submission
from grader.host.frames import Delivery, Ended, Run, Settled, Slept, Start
from grader.link.hosts import ForkServer, HostProcess
from grader.link.link import Cost, HostDied, HostForged, HostHung, Link
from grader.recording import COMPLETED, Outcome, Recording
from grader.trial.endings import (
    GRACE,
    NEVER_SPUN,
    STUCK,
    died_text,
    line_without_folder,
    misbehaviour,
    not_run,
    not_runnable,
    roll_on,
    without_folder,
)
from grader.trial.recorder import Flood, Recorder
from grader.trial.staging import check_folder, stage
from sim.messages import EPOCH_NS, Message
from sim.scenario import Scenario
from sim.simulation import Simulation

LOOK_EVERY = 64  # exchanges, at the node's folder


@dataclass(frozen=True)
class Limits:
    """Wall-clock limits of a trial [s]; a correct node stays far below them on a slow machine."""

    start: float = 20.0  # importing libraries, constructing nodes, loading models
    step: float = 5.0  # between one message and the node's being done with it
    total: float = 120.0


def run_trial(
    submission: Submission,
    scenario: Scenario,
    forkserver: ForkServer,
    *,
    seed: int | None = None,
    arguments: Sequence[str] = (),
    limits: Limits | None = None,
    stamped: bool = False,
    files: Mapping[str, bytes] | None = None,
    charge_compute: bool = False,
    stdin: bytes = b"",
) -> Recording:
    """Run a student's file in a scenario and return what happened.

    Parameters
    ----------
    seed
        Takes the place of the scenario's own.
    arguments
        Command line of the file, such as ["--ros-args", "-p", "max_speed:=0.3"].
    stamped
        The robot takes TwistStamped as well as Twist.
    files
        Further files that the node finds in its working folder: name and content.
    charge_compute
        The CPU time of the node costs virtual time: for practice, never for a grading.
    stdin
        What the node's programs may read from stdin.

    Raises
    ------
    GraderError
        The grader or the machine failed; nothing can be said of the submission.
    """
    problem = not_runnable(submission, scenario)
    if problem is not None:
        return not_run(Simulation(scenario, seed), problem)
    lead = 0
    while True:
        simulation = Simulation(scenario, seed)
        with (
            stage(submission, scenario, arguments, files) as staged,
            forkserver.host(staged.folder) as host,
        ):
            trial = _Trial(simulation, Recorder(stamped=stamped), host)
            start = Start(
                staged.programs,
                EPOCH_NS,
                simulation.seed,
                staged.offers,
                lead=lead,
                charge_compute=charge_compute,
                stdin=stdin,
            )
            try:
                outcome = trial.conduct(staged.folder, start, limits or Limits())
            except _Early as early:
                lead = early.lead
                continue
            return trial.recording(outcome, staged.folder)


class _Early(Exception):
    """The program sleeps before it spins or speaks: it has to be started before the scenario."""

    def __init__(self, lead: int) -> None:
        super().__init__(f"{lead} ns")
        self.lead = lead  # [ns]


class _Trial:
    """A trial under way."""

    def __init__(self, simulation: Simulation, recorder: Recorder, host: HostProcess) -> None:
        self._simulation = simulation
        self._recorder = recorder
        self._host = host
        self._link = Link(host)
        self._at = 0.0  # [s] the time that the node has come to
        self._spun = False
        self._stuck: float | None = None  # [s] since when nothing in the node can ever run again

    def conduct(self, folder: Path, start: Start, limits: Limits) -> Outcome:
        """Run the trial to its end, with the node in this folder; say how it ended."""
        recorder, simulation, end = self._recorder, self._simulation, self._simulation.end
        clock_end = time.perf_counter() + limits.total
        try:
            first, cost = self._link.start(start, limits.start)
            if isinstance(first, Slept):
                raise HostForged("a second early start") if start.lead else _Early(first.lead)
            answer: Settled | Ended = first
            pending = self._take(answer, cost, began=0, agreed=0)
            while isinstance(answer, Settled) and simulation.now < end:
                if time.perf_counter() > clock_end:
                    raise HostHung("")
                if len(recorder.compute) % LOOK_EVERY == 0:
                    check_folder(folder)
                began = simulation.now
                self._at = began / 1e9
                until = min(simulation.next_event() or end, end)
                frame = Run(until, tuple(Delivery(m.topic, m.data) for m in pending))
                recorder.delivered += pending
                answer, cost = self._link.run(frame, limits.step)
                pending = self._take(answer, cost, began, until)
        except HostHung as hung:
            text = "the node did not come back from a callback (or from its start-up)"
            return self._outcome("hung", text, hung.stacks)
        except HostDied:
            status = self._host.wait(GRACE)
            return self._outcome("died", died_text(status))
        except (HostForged, Flood) as error:
            return self._outcome(*misbehaviour(error))
        if isinstance(answer, Ended):
            return self._outcome(answer.kind, answer.text, answer.detail)
        if not self._spun:
            return self._outcome("never_spun", NEVER_SPUN)
        if self._stuck is not None:
            return Outcome("stuck", STUCK, self._stuck)
        return self._outcome(COMPLETED, "")

    def recording(self, outcome: Outcome, folder: Path) -> Recording:
        """Return the recording; paths in `folder` are shown as the student knows them."""
        link = self._link
        log = [line_without_folder(line, folder) for line in link.log()]
        outcome = without_folder(outcome, folder)
        return self._recorder.freeze(self._simulation, outcome, log, (link.stdout, link.stderr))

    def _take(self, answer: Settled | Ended, cost: Cost, began: int, agreed: int) -> list[Message]:
        """Note an answer, let the robot follow it; return the robot's next messages."""
        recorder = self._recorder
        reached = _reached(answer, began, agreed)
        self._at = reached / 1e9
        recorder.note_endpoints(answer.endpoints)
        commands = recorder.hear(answer.published, began, reached)
        recorder.compute.append((began / 1e9, cost.wall, cost.cpu, cost.queued))
        if isinstance(answer, Ended):
            roll_on(self._simulation, reached, commands)
            return []
        self._spun = self._spun or answer.spinning
        if answer.spinning or answer.asleep:
            self._stuck = None
        elif self._stuck is None:
            self._stuck = reached / 1e9
        return self._simulation.advance(reached, commands)

    def _outcome(self, kind: str, text: str, detail: str = "") -> Outcome:
        return Outcome(kind, text, self._at, detail)


def _reached(answer: Settled | Ended, began: int, agreed: int) -> int:
    """Return the time that the host has come to; it can't be any other than agreed on."""
    if isinstance(answer, Settled) and answer.now != agreed:
        raise HostForged(f"time {answer.now} where {agreed} was agreed on")
    if not began <= answer.now <= agreed:
        raise HostForged(f"an end at {answer.now}, between {began} and {agreed}")
    return answer.now
