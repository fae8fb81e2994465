"""One trial in real time: the node as a process on DDS, beside a robot that keeps to the clock.

The judge runs the robot and its clock; a radio (grader.host.radio) has the robot's ends of the
topics, in a process of its own, and says when what came. The recording has the form of any other.
"""

from __future__ import annotations

import contextlib
import math
import select
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from grader.crowd import CROWD
from grader.domains import own_domain
from grader.errors import GraderError
from grader.habit import Habit
from grader.host.frames import (
    MAX_PUBLISHED,
    MAX_PUBLISHED_BYTES,
    Delivery,
    Ended,
    EndpointReport,
    HeardNow,
    Meet,
    Offer,
    ProgramStart,
    Published,
    Pulse,
    Start,
    ToHost,
    Transmit,
    Tuned,
    TuneIn,
    decode_from_live,
    decode_from_radio,
)
from grader.host.privileges import prefer, priority
from grader.launch import HostProcess, Nursery
from grader.link import Channel, HostDied, HostForged, decoded
from grader.recording import COMPLETED, Live, Outcome, Recording
from grader.runqueue import RunQueue
from grader.scratch import prefix
from grader.staging import Stage, stage
from grader.submission import Submission
from grader.tape import MAX_ENDPOINTS, Command, Flood, Tape, not_run
from grader.trial import (
    GRACE,
    LOOK_EVERY,
    NEVER_SPUN,
    died_text,
    misbehaviour,
    not_runnable,
    prepared,
)
from sim.messages import EMPTY, OFFERED, Message, empty, typestore, with_epoch
from sim.scenario import Scenario
from sim.schedule import scan_rate

GO = Offer("/probe/go", EMPTY, True)  # tells programs of ours that time begins
SEND_LIMIT = 5.0  # [s] for a frame to a host
START_LIMIT = 20.0  # [s] for a program to begin to spin: imports, models
IDLE_START = 3.0  # [s] without CPU time after which a program won't begin to spin any more
MEETING_LIMIT = 10.0  # [s] for DDS to bring all ends together
HUNG_AFTER = 5.0  # [s] in a callback at the scenario's end
STALL = 0.1  # [s] that a message of the robot may be late, or a ready thread wait for a CPU ...
STALL_SHARE = 0.8  # ... and in periods of the lidar: the answer has to come before the next scan
HEARTBEAT_NS = 100_000_000  # [ns] at most between two looks at the machine
PROMPT = 0.05  # [s] an answer that took longer may have had to wait
TURN = 0.02  # [s] between looks at the hosts, at most
MAX_CHUNKS = 64  # read at once from one host
MAX_PULSES = 100  # of a program at a time: it sends ten a second
ATTEMPTS = 3  # of a trial on a machine that stalls
HUNG = "the node did not come back from a callback"
HUNG_AT_START = "the node did not come back from its start-up"


def run_live_trial(
    submission: Submission,
    scenario: Scenario,
    nursery: Nursery,
    *,
    seed: int | None = None,
    arguments: Sequence[str] = (),
    stamped: bool = False,
    files: Mapping[str, bytes] | None = None,
    reason: str = "",
) -> Recording:
    """Run a student's file in a scenario in wall-clock time and return what happened.

    Parameters
    ----------
    nursery
        One for virtual time; its sister for real time is used.
    reason
        Why the trial isn't in virtual time, for the report.

    The other parameters are those of `grader.trial.run_trial`. If the machine stalls, the trial is
    repeated; if it stalls again, the recording says so (`live.stall`).

    Raises
    ------
    GraderError
        The grader or the machine failed; nothing can be said of the submission.
    """
    for attempt in range(ATTEMPTS):
        simulation = prepared(scenario, seed)
        problem = not_runnable(submission, scenario)
        if problem is not None:
            return not_run(simulation, problem)
        with (
            CROWD.joined(alone=attempt > 0),
            stage(submission, scenario, arguments, files) as staged,
            own_domain() as domain,
        ):
            trial = _LiveTrial(Tape(simulation, stamped=stamped), nursery.live, staged, domain)
            recording = trial.run(reason)
        if not recording.live or not recording.live.stall:
            break
    return recording


def _longest_stall(scenario: Scenario) -> float:
    """Return how long the machine may keep a trial waiting [s]."""
    if not scenario.lidar.enabled:
        return STALL
    return min(STALL, STALL_SHARE / scan_rate(scenario))


class LiveLink(Channel):
    """Frames to and from a host that speaks whenever it wants."""

    def __init__(self, host: HostProcess, decode: Callable[[bytes], Any]) -> None:
        super().__init__(host)
        self._decode = decode
        self.gone = False  # it has hung up
        self.descriptors = (host.link_in, host.stdout, host.stderr)

    def send(self, frame: ToHost) -> None:
        """Send a frame; HostDied if nobody is there."""
        self._write(frame, time.perf_counter() + SEND_LIMIT)

    def hear(self) -> list[Any]:
        """Return the frames that have come."""
        try:
            for _ in range(MAX_CHUNKS):  # one that never ceases to write must not hold the judge
                self._read(self._host.link_in)
        except BlockingIOError:
            pass
        except HostDied:
            self.gone = True
        self._drain_all()
        frames = []
        while (body := self._take_frame()) is not None:
            frames.append(decoded(body, self._decode))
        return frames

    def note_time(self, now: int) -> None:
        """Say what time it is [ns]: output that comes from now on was said then."""
        for output in (self.stdout, self.stderr):
            output.clock = now


@dataclass
class _Program:
    """One of the node's programs."""

    start: ProgramStart
    host: HostProcess
    link: LiveLink
    pulse: Pulse = field(default_factory=lambda: Pulse(0, 0.0, [], {}))
    topics: set[str] = field(default_factory=set)  # that it publishes on
    ended: Ended | None = None
    idle_since: float = math.inf
    cpu: float = 0.0

    def ready(self, now: float) -> bool:
        """It spins, has ended, or sleeps so long that it won't spin any more."""
        if self.ended is not None or self.link.gone or self.pulse.spinning:
            return True
        cpu = self.link.cpu()
        if not cpu - self.cpu < 0.01 or self.idle_since == math.inf:
            self.cpu, self.idle_since = cpu, now
        return now - self.idle_since > IDLE_START


class _Over(Exception):
    """A program has ended."""


class _NotReady(Exception):
    """A program does not begin to spin; the text says why not."""


class _LiveTrial:
    """A trial on its way."""

    def __init__(self, tape: Tape, nursery: Nursery, staged: Stage, domain: int) -> None:
        self.tape = tape
        self._nursery = nursery
        self._stage = staged
        self._domain = domain
        self._hosts = contextlib.ExitStack()
        self._poll = select.poll()
        self._radio: LiveLink
        self._radio_host: HostProcess
        self._queues: dict[int, RunQueue] = {}  # by the host's number, since time counts for it
        self._programs: list[_Program] = []
        self._waiting = sorted(staged.programs, key=lambda program: program.start)
        self._user = 0
        self._epoch = 0  # [ns] since 1970 at the scenario's start; 0: not yet
        self._connected: dict[str, int] = {}  # the radio's view
        self._reports: list[EndpointReport] = []  # that the radio has dealt with
        self._asked = 0  # endpoints that it was told of
        self._heard: list[Published] = []
        self._lateness = 0.0  # [s] of the robot's latest message
        self._habit = Habit()
        self._starved = 0.0  # [s] that a thread of a host has waited for a CPU, at worst

    def run(self, reason: str) -> Recording:
        """Run the trial to its end."""
        stall = ""
        with priority(), self._hosts:
            try:
                self._open()
                self._meet()
                self._drive()
                outcome = self._final_outcome()
            except _Over:
                outcome = self._end_outcome()
            except _NotReady as error:
                kind = "hung" if str(error) == HUNG_AT_START else "never_spun"
                stacks = self._programs[0].link.stacks() if kind == "hung" else ""
                outcome = self._outcome(kind, str(error), stacks)
            except (HostForged, Flood) as error:
                outcome = self._outcome(*misbehaviour(error))
            except TimeoutError as error:
                stall, outcome = str(error), self._outcome("hung", str(error))
            log = [line for program in self._programs for line in program.link.log()]
            output = [o for p in self._programs for o in (p.link.stdout, p.link.stderr)]
        limit = _longest_stall(self.tape.simulation.scenario)
        if self._lateness > limit:
            stall = f"a message of the robot left {self._lateness:.3f} s late"
        elif self._starved > limit:
            stall = f"the node had to wait {self._starved:.3f} s for a CPU"
        epoch = self._epoch or time.time_ns()
        live = Live(epoch, reason, self._lateness, self._starved, stall)
        log.sort(key=lambda line: line.time)
        return self.tape.freeze(outcome, self._stage.folder, log, output, live)

    # --- the hosts -------------------------------------------------------------------------------

    def _open(self) -> None:
        """Start the radio and the programs that run from the beginning."""
        place = self._hosts.enter_context(tempfile.TemporaryDirectory(prefix=prefix()))
        self._radio_host = self._hosts.enter_context(self._nursery.host(Path(place)))
        self._radio = LiveLink(self._radio_host, decode_from_radio)
        self._register(self._radio)
        self._radio.send(TuneIn(self._domain, (*self._stage.offers, GO)))
        self._user = self._hosts.enter_context(self._nursery.user())
        self._start_programs(0)

    def _start_programs(self, now: int) -> None:
        while self._waiting and self._waiting[0].start <= now:
            program = self._waiting.pop(0)
            host = self._hosts.enter_context(
                self._nursery.host(self._stage.folder, self._user, prompt=self._epoch > 0)
            )
            link = LiveLink(host, decode_from_live)
            self._register(link)
            seed = self.tape.simulation.seed
            link.send(Start((program,), 0, seed, self._stage.offers, self._domain))
            self._programs.append(_Program(program, host, link))

    def _measure(self) -> None:
        """Measure from now on how long a host has to wait; a program as soon as it spins."""
        spinning = (program.host for program in self._programs if program.pulse.spinning)
        for host in (self._radio_host, *spinning):
            if host.pid not in self._queues:
                self._queues[host.pid] = queue = RunQueue(host.pid, TURN)
                queue.worst()  # what was until now is not the trial's

    def _stop_programs(self, now: int) -> None:
        for program in self._programs:
            if program.start.stop is not None and program.start.stop <= now:
                program.host.kill()

    def _register(self, link: LiveLink) -> None:
        for descriptor in link.descriptors:
            self._poll.register(descriptor, select.POLLIN)

    def _meet(self) -> None:
        """Wait until the programs spin and all ends have found each other; time begins then."""
        limit = time.monotonic() + START_LIMIT
        while not all(program.ready(time.monotonic()) for program in self._programs):
            self._listen(TURN)
            if time.monotonic() > limit:
                raise _NotReady(HUNG_AT_START)
        if not any(program.pulse.spinning for program in self._programs):  # some just do a job
            raise _NotReady(NEVER_SPUN)
        limit = time.monotonic() + MEETING_LIMIT
        while not self._all_met():
            self._listen(TURN)
            if time.monotonic() > limit:
                raise TimeoutError("DDS did not bring the node and the robot together in time")
        typestore()  # it takes a while, once
        for host in (self._radio_host, *(program.host for program in self._programs)):
            prefer(host.pid)
        self._epoch = time.time_ns()
        self._radio.send(Transmit((Delivery(GO.topic, empty()),)))
        heard = sorted(self._heard, key=lambda m: m.time)
        for published in filter(self._said_in_start_up, heard):
            self._note([msgspec.structs.replace(published, time=self._epoch)])
        self._heard = []

    def _all_met(self) -> bool:
        if len(self._reports) < self._asked:
            return False
        wanted: dict[str, int] = {}
        for end in self._reports:
            served = end.kind == "subscription" and end.topic in (*OFFERED, GO.topic)
            if end.kind == "publisher" or served:
                name = f"{end.kind} {end.topic}"
                if not end.mismatch:
                    wanted[name] = wanted.get(name, 0) + 1
        services = {end.topic for end in self._reports if end.kind == "service"}
        asked = {end.topic for end in self._reports if end.kind == "client"} & services
        mine = all(self._connected.get(name, 0) >= n for name, n in wanted.items())
        theirs: dict[str, int] = {}
        for program in self._programs:
            for name, count in program.pulse.connected.items():
                theirs[name] = max(theirs.get(name, 0), count)
        needed = [*wanted, *(f"client {name}" for name in asked)]
        return mine and all(theirs.get(name, 0) > 0 for name in needed)

    # --- the clock -------------------------------------------------------------------------------

    def _now(self) -> int:
        """Return the time since the scenario's start [ns]."""
        return time.time_ns() - self._epoch if self._epoch else 0

    def _drive(self) -> None:
        """Let the robot live through the scenario, on time."""
        tape, simulation = self.tape, self.tape.simulation
        pending = simulation.advance(0)
        while True:
            self._transmit(pending)
            self._start_programs(simulation.now)
            self._stop_programs(simulation.now)
            if simulation.now >= tape.end:
                return
            self._measure()
            until = min(self._next_moment(simulation.now), tape.end)
            commands: list[Command] = []
            cpu = self._cpu()
            kind = frozenset(message.topic for message in pending)
            began = simulation.now
            answered = math.nan
            while (left := until - self._now()) > 0:
                self._listen(min(left / 1e9, TURN))
                commands += self._take_heard()
                if commands and math.isnan(answered):
                    answered = (commands[0][0] - began) / 1e9
            self._lateness = max(self._lateness, (self._now() - until) / 1e9)
            missed = not answered <= PROMPT and self._habit.answers(kind)
            self._habit.note(kind, answered=not math.isnan(answered))
            queued = max(queue.worst(believed=missed) for queue in self._queues.values())
            self._starved = max(self._starved, queued)
            used = self._cpu() - cpu
            wall = min(used, (until - began) / 1e9) if math.isnan(answered) else answered
            tape.compute.append((began / 1e9, max(0.0, wall), used, queued))
            if len(tape.compute) % LOOK_EVERY == 0:
                tape.check_folder(self._stage.folder)
            pending = simulation.advance(until, [c for c in commands if c[0] <= until])

    def _next_moment(self, now: int) -> int:
        moments = [self.tape.simulation.next_event(), *(p.start for p in self._waiting)]
        moments.append(now + HEARTBEAT_NS)
        moments += [p.start.stop for p in self._programs]
        return min((m for m in moments if m is not None and m > now), default=self.tape.end)

    def _transmit(self, messages: Sequence[Message]) -> None:
        if not messages:
            return
        real = [with_epoch(message, self._epoch) for message in messages]
        self._lateness = max(self._lateness, (self._now() - messages[0].time) / 1e9)
        self._radio.send(Transmit(tuple(Delivery(m.topic, m.data) for m in real)))
        self.tape.delivered += real

    # --- what comes from the hosts ---------------------------------------------------------------

    def _listen(self, patience: float) -> None:
        """Wait for the hosts to say something, `patience` [s] at most, and take it in."""
        self._poll.poll(max(1, math.ceil(patience * 1e3)))
        now = self._now()
        for queue in self._queues.values():
            queue.look()
        for program in self._programs:
            program.link.note_time(now)
            self._hear_program(program)
        for frame in self._radio.hear():
            match frame:
                case Tuned():
                    self.tape.note_endpoints(frame.endpoints)
                    self._reports += frame.endpoints
                    self._connected = frame.connected
                case HeardNow():
                    self._heard += filter(self._counts, frame.published)
        if self._radio.gone:
            raise GraderError("the robot's radio has died: nothing can be said of the node")

    def _hear_program(self, program: _Program) -> None:
        frames = program.link.hear()
        if len(frames) > MAX_PULSES:
            raise Flood(f"more than {MAX_PULSES} pulses at a time")
        for frame in frames:
            match frame:
                case Pulse():
                    program.pulse = frame
                    program.topics |= {e.topic for e in frame.endpoints if e.kind == "publisher"}
                    self._hear_start_up(frame.unheard)
                    if frame.endpoints:
                        self._asked += len(frame.endpoints)
                        if self._asked > MAX_ENDPOINTS:  # the radio would choke on them
                            raise Flood(f"more than {MAX_ENDPOINTS} endpoints")
                        self._radio.send(Meet(tuple(frame.endpoints)))
                case Ended():
                    program.ended = frame
        stopped = program.start.stop is not None and program.start.stop <= self._now()
        if (program.ended or program.link.gone) and not stopped:
            raise _Over

    def _counts(self, published: Published) -> bool:
        """Tell whether a message is worth noting.

        Between a program's start-up and the scenario's beginning nobody asks what it says.
        """
        return self._epoch > 0 or self._said_in_start_up(published)

    def _said_in_start_up(self, published: Published) -> bool:
        """Tell whether a program said this before it began to spin, as far as is known."""
        who = [p.pulse for p in self._programs if published.topic in p.topics]
        return not who or any(not pulse.spun or published.time < pulse.spun for pulse in who)

    def _hear_start_up(self, unheard: Sequence[Published]) -> None:
        if self._epoch:
            return
        self._heard += unheard
        size = sum(len(m.data) for m in self._heard)
        if len(self._heard) > MAX_PUBLISHED or size > MAX_PUBLISHED_BYTES:
            raise Flood("too many or too large messages before it spins")

    def _take_heard(self) -> list[Command]:
        heard, self._heard = self._heard, []
        return self._note(heard)

    def _note(self, heard: Sequence[Published]) -> list[Command]:
        """Note messages with the time of the scenario; slightly late ones came just now."""
        last = self.tape.published[-1].time if self.tape.published else 0
        now = max(self._now(), last)
        timed = [
            msgspec.structs.replace(m, time=min(max(m.time - self._epoch, last), now))
            for m in sorted(heard, key=lambda m: m.time)
        ]
        return self.tape.hear(timed, last, now)

    def _cpu(self) -> float:
        used = [p.link.cpu() for p in self._programs if not p.link.gone]
        return math.fsum(used) if used else 0.0

    # --- how it ended ----------------------------------------------------------------------------

    def _final_outcome(self) -> Outcome:
        if not any(program.pulse.spinning for program in self._programs):
            return self._outcome("never_spun", NEVER_SPUN)
        for program in self._programs:
            if program.start.stop is not None:
                continue
            if program.pulse.busy > HUNG_AFTER:
                return self._outcome("hung", HUNG, program.link.stacks())
        return self._outcome(COMPLETED, "")

    def _end_outcome(self) -> Outcome:
        """Say how the program ended that has ended; let the robot roll on."""
        reached = max(self._now(), self.tape.simulation.now)
        with contextlib.suppress(HostForged, Flood):
            self.tape.roll_on(min(reached, self.tape.end), self._take_heard())
        program = next(p for p in self._programs if p.ended or p.link.gone)
        name = f"{Path(program.start.file).name}: " if len(self._stage.programs) > 1 else ""
        if program.ended is None:
            return self._outcome("died", name + died_text(program.host.wait(GRACE)))
        end = program.ended
        return self._outcome(end.kind, name + end.text, end.detail)

    def _outcome(self, kind: str, text: str, detail: str = "") -> Outcome:
        return Outcome(kind, text, min(self._now(), self.tape.end) / 1e9, detail)
