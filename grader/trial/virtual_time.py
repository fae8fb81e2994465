"""One trial: one node, one scenario, in lock-step, in virtual time.

The robot's next message and the node's commands meet here: the host runs up to the time of the next
message, the simulation follows with the commands that came out, and hands over what it measured.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from grader.course.students import host_seed
from grader.course.submission import Submission
from grader.models.service import ModelService, TooManyQuestions
from grader.recording import COMPLETED, Ending, Outcome, Recording
from grader.trial import endings
from grader.trial.hangs import located
from grader.trial.recorder import MAX_BYTES, Recorder
from grader.trial.staging import stage
from rclpy_virtual_time import (
    Delivery,
    Discovery,
    Ended,
    Excess,
    Flood,
    HostDied,
    HostForged,
    HostHung,
    Launcher,
    Link,
    Run,
    Settled,
    Slept,
    Start,
    real_clock,
)
from sim.messages import EPOCH_NS, Message
from sim.scenario import Scenario
from sim.sensors import SENSOR_TOPICS
from sim.simulation import Simulation

END_NS, END_LIMIT = 10**9, 2.0  # [ns], [s of CPU time] that programs have after a SIGINT
# Without an event, time goes by in slices: many timers may take a slow machine seconds, and what a
# node publishes has to fit a frame. A prime number of ns: hardly one ends where a timer is due.
SLICE_NS = 249_999_991
BUSY = 3  # times its limit of wall time that a trial may wait for a CPU in all

Cost = Link.Cost
Said = Settled | Ended | Slept
Result = TypeVar("Result")
# yields what to send and the wall time for the answer [s]; gets the answer and what it cost
Conversation = Generator[tuple[Start | Run, float], tuple[Said, Cost], Result]


@dataclass(frozen=True)
class Limits:
    """Wall-clock limits of a trial [s]; a correct node stays far below them on a slow machine.

    What a busy machine keeps from the node does not count, up to three times the limit.
    """

    start: float = 20.0  # importing libraries, constructing nodes, loading models
    step: float = 5.0  # between one message and the node's being done with it
    total: float = 120.0
    published: int = MAX_BYTES  # [bytes]


def run_trial(
    submission: Submission,
    scenario: Scenario,
    launcher: Launcher,
    *,
    seed: int | None = None,
    arguments: Sequence[str] = (),
    limits: Limits | None = None,
    stamped: bool = False,
    files: Mapping[str, bytes] | None = None,
    charge_compute: bool = False,
    stdin: bytes = b"",
    keys: bytes = b"",
    env: Sequence[tuple[str, str]] = (),
    interrupt: bool = False,
    lead: int = 0,
    look: Sequence[float] = (),
) -> Recording:
    """Run a student's file in a scenario and return what happened.

    Raises GraderError: the grader or the machine failed; nothing can be said of the submission.

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
    keys
        What is typed to them instead, a key every half second.
    env
        What is added to their environment: names and values.
    interrupt
        When all is recorded, send the programs SIGINT, and note what comes of it.
    lead
        How long before the scenario to start the programs [ns], if that has been found out.
    look
        Moments [s] to look into; the launcher has to be able to (`Link.Moment.LIBRARY`).
    """
    problem = endings.not_runnable(submission, scenario)
    if problem is not None:
        return endings.not_run(Simulation(scenario, seed), problem)
    limits = limits or Limits()
    looks = tuple(asked_at(time, scenario) for time in look)
    while True:
        simulation = Simulation(scenario, seed)
        with (
            stage(submission, scenario, arguments, files) as staged,
            launcher.host(staged.folder) as link,
        ):
            recorder = Recorder(staged.called, stamped=stamped, most=limits.published, looks=looks)
            trial = _Trial(simulation, recorder, link, charged=charge_compute)
            trial.interrupt = interrupt
            start = Start(
                staged.programs,
                EPOCH_NS,
                host_seed(simulation.seed),
                staged.offers,
                lead=lead,
                charge_compute=charge_compute,
                stdin=stdin,
                discovery=_discovery(scenario),
                keys=keys,
                env=tuple(env),
                look=looks,
            )
            try:
                outcome = link.converse(trial.conversation(start, limits))
            except _Early as early:
                lead = early.lead
                continue
            return located(trial.recording(outcome, staged.folder), submission)


class _Early(Exception):
    """The program has to start before the scenario, because it sleeps before it spins or speaks."""

    def __init__(self, lead: int) -> None:
        super().__init__(f"{lead} ns")
        self.lead = lead  # [ns]


class _Trial:
    """A trial under way."""

    def __init__(
        self, simulation: Simulation, recorder: Recorder, link: Link, *, charged: bool
    ) -> None:
        self._simulation = simulation
        self._recorder = recorder
        self._charged = charged  # computing takes virtual time
        self.interrupt = False  # at the end
        self._ending: Ending | None = None
        self._link = link
        self._models = ModelService(simulation.scenario, simulation.seed, recorder.delivered)
        self._at = 0.0  # [s] the time that the node has come to
        self._heard: set[str] = set()  # topics of which each message is a turn of the node's
        self._spun = False
        self._waited = 0.0  # [s] for a CPU, by the node or the judge
        self._stuck: float | None = None  # [s] since when nothing in the node can ever run again

    def conversation(self, start: Start, limits: Limits) -> Conversation[Outcome]:
        """Run the trial to its end, frame by frame; return how it ended."""
        recorder, simulation, end = self._recorder, self._simulation, self._simulation.end
        self._heard.update(offer.topic for offer in start.offers if offer.latched)
        began_at = real_clock.perf_counter()
        try:
            first, cost = yield from self._start(start, limits.start)
            if isinstance(first, Slept):
                raise HostForged("a second early start") if start.lead else _Early(first.lead)
            answer: Settled | Ended = first
            pending = self._take(answer, cost, began=0, agreed=0)
            while isinstance(answer, Settled) and simulation.now < end:
                waited = min(self._waited, BUSY * limits.total)
                if real_clock.perf_counter() > began_at + limits.total + waited:
                    return self._outcome("slow", _too_slow(limits, self._simulation))
                began = simulation.now
                self._at = began / 1e9
                told = tuple(told for _, told in self._models.due(began))
                coming = simulation.next_event(self._heard)
                events = (coming, self._models.next_due, began + SLICE_NS)
                until = min(end, *(event for event in events if event))
                heard = (m for m in pending if m.topic in self._heard)
                deliver = tuple(Delivery(m.topic, m.data) for m in heard)
                frame = Run(until, deliver, told, ends=True)
                recorder.delivered += pending
                said, cost = yield frame, limits.step
                if isinstance(said, Slept):
                    raise HostForged("a start in the middle of the trial")
                answer = said
                pending = self._take(answer, cost, began, until)
        except HostHung as hung:
            text = "the node did not come back from a callback (or from its start-up)"
            return self._outcome("hung", text, hung.stacks)
        except HostDied:
            status = self._link.wait(endings.GRACE)
            return self._outcome("died", endings.died_text(status))
        except (HostForged, Flood, Excess, TooManyQuestions) as error:
            return self._outcome(*endings.misbehaviour(error))
        if isinstance(answer, Ended):
            return self._outcome(answer.kind, answer.text, answer.detail)
        # what publishes in a loop of its own, and has nothing to be called, needs no spin
        loops = recorder.published and all(e.kind == "publisher" for e in recorder.endpoints)
        if not self._spun and not (loops and self.interrupt):
            return self._outcome("never_spun", endings.NEVER_SPUN, self._link.stacks())
        if self._stuck is not None:
            return Outcome("stuck", endings.STUCK, self._stuck, self._link.stacks())
        if self.interrupt:
            self._ending = yield from self._interrupt(END_LIMIT)
        return self._outcome(COMPLETED, "")

    def _interrupt(self, limit: float) -> Conversation[Ending]:
        """Send SIGINT, and let the programs have a second to end.

        Meanwhile the robot says again what it said in its last second, and models answer. `limit`
        [s] is of CPU time in all, and of wall time for each answer, as a busy machine gives it.
        Nothing of this gets into the record, which is complete.
        """
        complete = len(self._models.inferences)
        end, until = self._simulation.end, self._simulation.end + END_NS
        again = [
            m
            for m in self._recorder.delivered
            if end - END_NS < m.time and m.topic in SENSOR_TOPICS
        ]
        spent = 0.0  # [s]
        recorder, now, interrupt = Recorder(), end, True
        due: list[Message] = []
        try:
            while True:
                told = tuple(told for _, told in self._models.due(now))
                upto = again[0].time + END_NS if again else until
                upto = min(upto, self._models.next_due or until)
                deliver = tuple(Delivery(message.topic, message.data) for message in due)
                said, cost = yield Run(upto, deliver, told, interrupt=interrupt), limit
                spent += cost.wall if math.isnan(cost.cpu) else cost.cpu
                if isinstance(said, Slept):
                    raise HostForged("a start after the end")
                reached = _reached(said, now, upto)
                recorder.note_endpoints(said.endpoints)
                recorder.hear(said.published, now, reached)
                now = reached
                if isinstance(said, Ended):
                    kind, text, detail = said.kind, said.text, said.detail
                    break
                if spent > limit:
                    raise HostHung(self._link.stacks())
                if now >= until:
                    kind, text, detail = "running", "", ""
                    break
                for question in said.asked:
                    self._models.ask(question, now)
                due = [message for message in again if message.time + END_NS == now]
                again, interrupt = again[len(due) :], False
        except HostHung as hung:
            kind, text, detail = "hung", f"it computes for more than {limit:.0f} s", hung.stacks
        except HostDied:
            kind, text, detail = "died", endings.died_text(self._link.wait(endings.GRACE)), ""
        except (HostForged, Flood, Excess, TooManyQuestions) as error:
            kind, text = endings.misbehaviour(error)
            detail = ""
        del self._models.inferences[complete:]
        outcome = Outcome(kind, text, now / 1e9, detail)
        return Ending(outcome, tuple(recorder.published))

    def _start(self, start: Start, limit: float) -> Conversation[tuple[Said, Cost]]:
        """Run the file up to the point where it waits; answer what it asks its models till then.

        However often it asks: limit [s] is for all of the start-up.
        """
        deadline = real_clock.perf_counter() + limit
        first, cost = yield start, limit
        while isinstance(first, Settled) and first.starting:
            if not first.asked or first.published:
                raise HostForged("a start-up without a question")
            told = tuple(self._models.at_once(question) for question in first.asked)
            left = deadline - real_clock.perf_counter()
            first, more = yield Run(0, told=told), left
            cost = Cost(cost.wall + more.wall, cost.cpu + more.cpu, cost.queued + more.queued)
        return first, cost

    def recording(self, outcome: Outcome, folder: Path) -> Recording:
        """Return the recording; paths in `folder` are shown as the student knows them."""
        link = self._link
        log = [endings.line_without_folder(line, folder) for line in link.log()]
        outcome = endings.without_folder(outcome, folder)
        truncated = link.stdout.truncated or link.stderr.truncated
        asked, ending = self._models.inferences, self._ending
        if ending is not None:
            end = self._simulation.end
            last = tuple(line for line in log if line.time > end)
            log = [line for line in log if line.time <= end]
            ending = Ending(endings.without_folder(ending.outcome, folder), ending.published, last)
        recording = self._recorder.freeze(
            self._simulation, outcome, log, truncated=truncated, asked=asked, charged=self._charged
        )
        return recording if ending is None else replace(recording, ending=ending)

    def _take(self, answer: Settled | Ended, cost: Cost, began: int, agreed: int) -> list[Message]:
        """Record a host's answer, let the robot follow it; return the robot's next messages."""
        recorder = self._recorder
        reached = _reached(answer, began, agreed)
        self._at = reached / 1e9
        recorder.note_endpoints(answer.endpoints)
        self._heard.update(e.topic for e in answer.endpoints if e.kind == "subscription")
        recorder.note(answer.notes)
        recorder.look(answer.moments)
        commands = recorder.hear(answer.published, began, reached)
        self._waited += cost.waited
        recorder.compute.append((began / 1e9, cost.wall, cost.cpu, cost.queued))
        coming = self._simulation.advance(reached, commands)
        unheard = [message for message in coming if message.time < agreed]  # or it were a turn
        recorder.delivered += unheard
        if isinstance(answer, Ended):
            endings.roll_on(self._simulation, reached)
            return []
        if answer.starting:
            raise HostForged("a start-up in the middle of the trial")
        for question in answer.asked:
            self._models.ask(question, reached)
        self._spun = self._spun or answer.spinning
        if answer.spinning or answer.asleep:
            self._stuck = None
        elif self._stuck is None:
            self._stuck = min(answer.parked, reached) / 1e9
        return coming[len(unheard) :]

    def _outcome(self, kind: str, text: str, detail: str = "") -> Outcome:
        return Outcome(kind, text, self._at, detail)


def asked_at(time: float, scenario: Scenario) -> int:
    """Return the moment [ns] at a time [s] of a scenario, the last of it if that is later.

    Times are shown in hundredths, and what is shown as that time is part of it.
    """
    return max(0, min(round(time * 100) * 10**7 + 5 * 10**6, round(scenario.duration * 1e9) - 1))


def _discovery(scenario: Scenario) -> Discovery:
    """Return the scenario's times of discovery in nanoseconds."""
    fault = scenario.faults.discovery
    program, end, latched = (
        (round(least * 1e9), round(max(least, most) * 1e9))
        for least, most in (fault.program, fault.end, fault.latched)
    )
    return Discovery(program, fault.late, end, latched)


def _too_slow(limits: Limits, simulation: Simulation) -> str:
    """Say that a node answered always, but took too long for it."""
    return (
        f"the node and its robot were not done after {limits.total:.0f} s: it had come to "
        f"{simulation.now / 1e9:.1f} s of {simulation.end / 1e9:.1f} s; does it compute or publish "
        "far more than it needs?"
    )


def _reached(answer: Settled | Ended, began: int, agreed: int) -> int:
    """Return the time that the host has reached, if it is the time agreed on."""
    # it asks a model, or begins to listen, before time goes on
    early = isinstance(answer, Settled) and (answer.asked or answer.endpoints)
    if isinstance(answer, Settled) and answer.now != agreed and not early:
        raise HostForged(f"time {answer.now} where {agreed} was agreed on")
    if not began <= answer.now <= agreed:
        raise HostForged(f"an end at {answer.now}, between {began} and {agreed}")
    return answer.now
