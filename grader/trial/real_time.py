"""One trial in real time: the node as a process on DDS, beside a robot that keeps to the clock.

The judge runs the robot and its clock; a radio (rclpy_virtual_time.host.real_time.robot) has the
robot's ends of the topics, in a process of its own, and says when what came. The recording has the
form of any other.
"""

import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec

from grader.course.students import host_seed
from grader.course.submission import Submission
from grader.models.service import ModelService, TooManyQuestions
from grader.recording import COMPLETED, Live, Outcome, Recording
from grader.trial.endings import (
    BUSY_WAIT,
    GRACE,
    NEVER_SPUN,
    died_text,
    line_without_folder,
    misbehaviour,
    not_run,
    not_runnable,
    roll_on,
    without_folder,
)
from grader.trial.exclusive import TRIAL_LOCK
from grader.trial.hangs import located
from grader.trial.recorder import Command, Recorder
from grader.trial.staging import Stage, stage
from grader.trial.stalls import AnswerRate
from grader.trial.virtual_time import Limits
from rclpy_virtual_time import (
    Delivery,
    Excess,
    Flood,
    ForkServer,
    HostForged,
    LiveHosts,
    Note,
    real_clock,
)
from sim.messages import Message, typestore, with_epoch
from sim.scanner import Scanner
from sim.scenario import Scenario
from sim.simulation import Simulation

HUNG_AFTER = 5.0  # [s] in a callback at the scenario's end
STALL = 0.1  # [s] that a message of the robot may be late, or a ready thread wait for a CPU ...
STALL_SHARE = 0.8  # ... and in periods of the lidar: the answer has to come before the next scan
HEARTBEAT_NS = 100_000_000  # [ns] at most between two looks at the machine
PROMPT = 0.05  # [s] an answer that took longer may have had to wait
ATTEMPTS = 3  # of a trial on a machine that stalls
HUNG = "the node did not come back from a callback"
HUNG_AT_START = "the node did not come back from its start-up"


def run_live_trial(
    submission: Submission,
    scenario: Scenario,
    forkserver: ForkServer,
    *,
    seed: int | None = None,
    arguments: Sequence[str] = (),
    files: Mapping[str, bytes] | None = None,
    reason: str = "",
    stamped: bool = False,
    lenient: bool = False,
) -> Recording:
    """Run a student's file in a scenario in wall-clock time and return what happened.

    Raises GraderError: the grader or the machine failed; nothing can be said of the submission.

    Parameters
    ----------
    forkserver
        One for virtual time; its sister for real time is used.
    reason
        Why the trial isn't in virtual time, for the report.
    lenient
        Not for a grading: no second try, and a loop that publishes without a wait is no flood.

    The other parameters are those of `grader.trial.virtual_time.run_trial`. If the machine stalls,
    the trial is repeated; if it stalls again, the recording says so (`live.stall`).
    """
    shared = forkserver.live.shares_network
    for attempt in range(1 if lenient else ATTEMPTS):
        simulation = Simulation(scenario, seed)
        problem = not_runnable(submission, scenario)
        if problem is not None:
            return not_run(simulation, problem)
        with (
            TRIAL_LOCK.held(alone=attempt > 0, shared_network=shared),
            stage(submission, scenario, arguments, files) as staged,
        ):
            recorder = Recorder(staged.called, stamped=stamped)
            models = ModelService(scenario, simulation.seed, recorder.delivered, began=None)
            hosts = LiveHosts(
                forkserver.live, staged.folder, staged.programs, staged.offers,
                host_seed(simulation.seed), models, Limits.start / (1 + lenient), lenient=lenient,
            )  # fmt: skip
            trial = _LiveTrial(simulation, recorder, hosts, staged, models)
            recording = located(trial.run(reason), submission)
        if not recording.live or not recording.live.stall:
            break
    return recording


def _longest_stall(scenario: Scenario) -> float:
    """Return how long the machine may keep a trial waiting [s]."""
    if not scenario.lidar.enabled:
        return STALL
    return min(STALL, STALL_SHARE / Scanner.rate(scenario))


def _text_of_end(program: LiveHosts.Program) -> str:
    return program.ended.text if program.ended else died_text(program.link.wait(GRACE))


class _LiveTrial:
    """A trial under way."""

    def __init__(
        self,
        simulation: Simulation,
        recorder: Recorder,
        hosts: LiveHosts,
        staged: Stage,
        models: ModelService,
    ) -> None:
        self._simulation = simulation
        self._recorder = recorder
        self.hosts = hosts
        self._stage = staged
        self._models = models
        self._lateness = 0.0  # [s] of the robot's latest message
        self._answer_rate = AnswerRate()
        self._starved = 0.0  # [s] that a thread of a host has waited for a CPU, at worst
        self._hung_after = HUNG_AFTER  # [s]

    def run(self, reason: str) -> Recording:
        """Run the trial to its end."""
        stall = ""
        if reason.startswith(BUSY_WAIT):  # a scenario may be shorter than HUNG_AFTER
            self._hung_after = min(HUNG_AFTER, self._simulation.scenario.duration / 2)
        with self.hosts as hosts:
            try:
                hosts.open()
                typestore()  # it takes a while, once
                hosts.meet()
                self._drive()
                outcome = self._final_outcome()
            except LiveHosts.Over:
                outcome = self._end_outcome()
            except LiveHosts.NotReady as error:
                kind, text = str(error), HUNG_AT_START if str(error) == "hung" else NEVER_SPUN
                waits = next(p for p in hosts.programs if not p.pulse.spinning and not p.over)
                outcome = self._outcome(kind, text, waits.link.stacks())
            except (HostForged, Flood, Excess, TooManyQuestions) as error:
                outcome = self._outcome(*misbehaviour(error))
            except TimeoutError as error:
                stall, outcome = str(error), self._outcome("hung", str(error))
            self._starved = max(self._starved, hosts.still_wait())
            log = [line for program in hosts.programs for line in program.link.log()]
            links = [program.link for program in hosts.programs]
            truncated = any(link.stdout.truncated or link.stderr.truncated for link in links)
            for program in hosts.programs:
                self._recorder.note(program.pulse.notes)
                if program.left is not None:
                    file, entry = Path(program.start.file).name, program.start.entry
                    said = _text_of_end(program)[: Note.MAX_NAME]
                    note = Note("ended", file, entry, time=program.left, more=said)
                    self._recorder.note([note])
        self._recorder.note_endpoints(hosts.endpoints)
        limit = _longest_stall(self._simulation.scenario)
        if self._lateness > limit:
            stall = f"a message of the robot left {self._lateness:.3f} s late"
        elif self._starved > limit:
            stall = f"the node had to wait {self._starved:.3f} s for a CPU"
        live = Live(
            hosts.epoch or real_clock.time_ns(), reason, self._lateness, self._starved, stall
        )
        log.sort(key=lambda line: line.time)
        folder = self._stage.folder
        log = [line_without_folder(line, folder) for line in log]
        outcome = without_folder(outcome, folder)
        asked = self._models.since_begin()
        return self._recorder.freeze(
            self._simulation, outcome, log, live, asked, truncated=truncated
        )

    # --- the clock -------------------------------------------------------------------------------

    def _drive(self) -> None:
        """Let the robot live through the scenario, on time."""
        recorder, simulation, hosts = self._recorder, self._simulation, self.hosts
        pending = simulation.advance(0, self._take_heard())  # what was said in its start-up
        while True:
            self._transmit(pending)
            hosts.start_programs(simulation.now)
            hosts.stop_programs(simulation.now)
            if simulation.now >= simulation.end:
                return
            hosts.measure()
            began, until = simulation.now, self._next_moment()
            commands: list[Command] = []
            cpu = hosts.cpu()
            while (left := until - hosts.now()) > 0:
                hosts.listen(min(left / 1e9, hosts.TURN))
                commands += self._take_heard()
            self._lateness = max(self._lateness, (hosts.now() - until) / 1e9)
            answered = (commands[0][0] - began) / 1e9 if commands else None
            kind = frozenset(message.topic for message in pending)
            late = answered is None or answered > PROMPT
            missed = late and self._answer_rate.answers(kind)
            self._answer_rate.note(kind, answered=answered is not None)
            queued = hosts.waited(unseen_too=missed)
            self._starved = max(self._starved, queued)
            used = hosts.cpu() - cpu
            wall = min(used, (until - began) / 1e9) if answered is None else answered
            recorder.compute.append((began / 1e9, max(0.0, wall), used, queued))
            pending = simulation.advance(until, commands)

    def _next_moment(self) -> int:
        """Return when something is to be done next [ns], at the latest at the scenario's end."""
        now, end = self._simulation.now, self._simulation.end
        moments = [self._simulation.next_event(), *self.hosts.moments, now + HEARTBEAT_NS, end]
        return min(moment for moment in moments if moment is not None and now < moment <= end)

    def _transmit(self, messages: Sequence[Message]) -> None:
        if not messages:
            return
        real = [with_epoch(message, self.hosts.epoch) for message in messages]
        self._lateness = max(self._lateness, (self.hosts.now() - messages[0].time) / 1e9)
        self.hosts.transmit([Delivery(message.topic, message.data) for message in real])
        self._recorder.delivered += real

    def _take_heard(self) -> list[Command]:
        """Note the messages heard, at times from the scenario's start on that never go back."""
        last = self._recorder.published[-1].time if self._recorder.published else 0
        now = max(self.hosts.now(), last)
        timed = [
            msgspec.structs.replace(m, time=min(max(m.time - self.hosts.epoch, last), now))
            for m in self.hosts.take_heard()
        ]
        return self._recorder.hear(timed, last, now)

    # --- how it ended ----------------------------------------------------------------------------

    def _final_outcome(self) -> Outcome:
        programs = self.hosts.programs
        if not any(program.pulse.spinning for program in programs):
            return self._outcome("never_spun", NEVER_SPUN, programs[0].link.stacks())
        for program in programs:
            if program.start.stop is not None or program.over:
                continue
            if program.pulse.busy > self._hung_after:
                return self._outcome("hung", HUNG, program.link.stacks())
        return self._outcome(COMPLETED, "")

    def _end_outcome(self) -> Outcome:
        """Say how the program ended that has ended; let the robot roll on."""
        reached = max(self.hosts.now(), self._simulation.now)
        with contextlib.suppress(HostForged, Flood, TooManyQuestions):
            roll_on(self._simulation, min(reached, self._simulation.end), self._take_heard())
        program = next(p for p in self.hosts.programs if p.over and p.left is None)
        name = f"{Path(program.start.file).name}: " if len(self._stage.programs) > 1 else ""
        detail = program.ended.detail if program.ended else ""
        kind = program.ended.kind if program.ended else "died"
        return self._outcome(kind, name + _text_of_end(program), detail)

    def _outcome(self, kind: str, text: str, detail: str = "") -> Outcome:
        return Outcome(kind, text, min(self.hosts.now(), self._simulation.end) / 1e9, detail)
