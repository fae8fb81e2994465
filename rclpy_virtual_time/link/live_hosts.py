"""The processes of a trial in real time: the radio, which has the robot's ends, and the programs.

They are started, brought together and heard; how long they had to wait for a CPU is measured.
"""

from __future__ import annotations

import contextlib
import math
import select
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeAlias

import msgspec

from rclpy_virtual_time.host import frames
from rclpy_virtual_time.host.sandbox.users import prefer, priority
from rclpy_virtual_time.link.domains import own_domain
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.exchange import Flood, HostDied, HostHung, decoded, status_text
from rclpy_virtual_time.link.host_process import HostProcess
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.pipes import Channel
from rclpy_virtual_time.link.real_clock import real_clock
from rclpy_virtual_time.link.run_queue import RunQueue
from rclpy_virtual_time.link.scratch import prefix
from rclpy_virtual_time.link.workplace import Workplace

SEND_LIMIT = 5.0  # [s] for a frame to a host
LEAST_WORK = 0.01  # [s] of CPU time: a program that starts up takes more
IDLE_START = 3.0  # [s] without CPU time after which a program won't begin to spin any more
MEETING_LIMIT = 10.0  # [s] for DDS to bring all ends together
REST = 0.001  # [s] between looks at the hosts, at least, however much they say
MAX_CHUNKS = 64  # read at once from one host
MAX_PULSE = 2 * 1024 * 1024  # [bytes] with all its endpoints
MAX_PULSES = 100  # of a program at a time: it sends ten a second
MAX_ENDPOINTS = 1_000  # of all programs: the radio would choke on more
SLOT, MAX_IN_SLOT = 10_000_000, 5  # [ns], messages of a topic in it that lenient hosts note
SPEAKS_ON = 1.0  # [s] after which a program that publishes, and does not spin, has started
NO_RADIO = "the robot's radio has died: nothing can be said of the node"


class Answerer(Protocol):
    """Answers what programs ask, each when its time has come [ns of the monotonic clock]."""

    @property
    def next_due(self) -> int | None:
        """When the next answer is due."""

    def ask(self, asked: frames.Question, now: int, who: Any) -> None:
        """Accept a program's question."""

    def due(self, now: int) -> list[tuple[Any, frames.Told]]:
        """Return the answers that are due, with the programs that they are for."""

    def begin(self, now: int) -> None:
        """Take note that the scenario begins."""


class LiveLink(Channel):
    """Frames to and from a host that speaks whenever it wants."""

    def __init__(
        self, host: HostProcess, decode: Callable[[bytes], Any], largest: int = frames.MAX_FRAME
    ) -> None:
        super().__init__(host)
        self._decode = decode
        self.largest = largest
        self.gone = False  # it has hung up
        self.descriptors = (host.link_in, host.stdout, host.stderr)

    def send(self, frame: frames.ToHost) -> None:
        """Send a frame; HostDied if the host has ended."""
        self._write(frames.encode(frame), real_clock.perf_counter() + SEND_LIMIT)

    def hear(self) -> list[Any]:
        """Return the frames that have come; Excess if the host takes too much of the machine."""
        self._patrol()
        try:
            for _ in range(MAX_CHUNKS):  # one that never ceases to write must not hold the judge
                self._read(self._host.link_in)
        except BlockingIOError:
            pass
        except HostDied:
            self.gone = True
        self.read_output()
        frames = []
        while (body := self._take_frame()) is not None:
            frames.append(decoded(body, self._decode))
        return frames

    def wait(self, patience: float) -> str:
        """Wait for the host's end, for `patience` [s]; say its exit status in words."""
        return status_text(self._host.wait(patience))

    def note_time(self, now: int) -> None:
        """Set the time [ns] of output from now on."""
        for output in (self.stdout, self.stderr):
            output.clock = now


@dataclass
class Program:
    """One of the node's programs."""

    start: frames.ProgramStart
    host: HostProcess
    link: LiveLink
    pulse: frames.Pulse = field(default_factory=lambda: frames.Pulse(0, 0.0, [], {}))
    topics: set[str] = field(default_factory=set)  # that it publishes on
    ended: frames.Ended | None = None
    left: int | None = None  # [ns] when it ended, while others went on
    idle_since: float = math.inf
    cpu: float = 0.0

    @property
    def over(self) -> bool:
        """The program has ended, or hung up."""
        return self.ended is not None or self.link.gone

    def ready(self, now: float) -> bool:
        """The program spins, has ended, or sleeps too long to spin at all."""
        if self.over or self.pulse.spinning:
            return True
        cpu = self.link.cpu()
        worked = math.isnan(cpu) or cpu - self.cpu >= LEAST_WORK  # NaN: the system doesn't tell
        if worked or self.idle_since == math.inf:
            self.cpu, self.idle_since = cpu, now
        return now - self.idle_since > IDLE_START


class LiveHosts:
    """The radio and the programs of one trial, in a DDS domain of their own.

    Parameters
    ----------
    folder
        The folder that they share.
    programs, offers
        What they run, and the topics that the robot publishes.
    seed
        Of the programs' `random`.
    answerer
        What they may ask.
    start_limit
        How long a program may take to begin to spin [s]: imports, models.
    lenient
        A loop that publishes without a wait is no flood, and has started though it never spins.
    """

    Program: TypeAlias = Program
    TURN: ClassVar = 0.02  # [s] between looks at the hosts, at most

    class Over(Exception):
        """A program has ended."""

    class NotReady(Exception):
        """A program does not begin to spin: it is "hung" or has "never_spun"."""

    def __init__(
        self,
        forkserver: ForkServer,
        folder: Path,
        programs: Sequence[frames.ProgramStart],
        offers: tuple[frames.Offer, ...],
        seed: int,
        answerer: Answerer,
        start_limit: float,
        *,
        lenient: bool = False,
    ) -> None:
        self.programs: list[Program] = []  # that have been started, in order
        self.radio: LiveLink
        self.endpoints: list[frames.EndpointReport] = []  # that the radio has dealt with
        self.epoch = 0  # [ns] since 1970 at the scenario's start; 0: not yet
        self._forkserver = forkserver
        self._folder, self._offers = folder, offers
        self._domain = 0  # of DDS
        self._seed = seed
        self._answerer = answerer
        self._start_limit = start_limit
        self._lenient = lenient
        self._first: dict[str, float] = {}  # [s] when a topic was heard first
        self._slots: dict[str, tuple[int, int]] = {}  # by topic: the latest, and messages in it
        self._all = contextlib.ExitStack()
        self._poll = select.poll()
        self._radio_host: HostProcess
        self._queues: dict[int, RunQueue] = {}  # by the host's number, since time counts for it
        self._waiting = sorted(programs, key=lambda program: program.start)
        self._place: Workplace
        self._connected: dict[str, int] = {}  # the radio's view
        self._asked = 0  # endpoints that it was told of
        self._heard: list[frames.Published] = []

    def __enter__(self) -> LiveHosts:
        self._domain = self._all.enter_context(own_domain())
        self._all.enter_context(priority())
        return self

    def __exit__(self, *_: object) -> None:
        self._all.close()

    @property
    def moments(self) -> list[int]:
        """When a program is to start or to be killed [ns]."""
        stops = [program.start.stop for program in self.programs]
        return [program.start for program in self._waiting] + [s for s in stops if s is not None]

    def open(self) -> None:
        """Start the radio and the programs that run from the beginning."""
        place = self._all.enter_context(tempfile.TemporaryDirectory(prefix=prefix()))
        self._radio_host = self._all.enter_context(self._forkserver.host_process(Path(place)))
        self.radio = LiveLink(self._radio_host, frames.decode_from_radio)
        self._register(self.radio)
        self._tell_radio(frames.TuneIn(self._domain, self._offers))
        self._place = self._all.enter_context(self._forkserver.workplace(self._folder))
        self.start_programs(0)

    def start_programs(self, now: int) -> None:
        """Start the programs that are due [ns]."""
        while self._waiting and self._waiting[0].start <= now:
            program = self._waiting.pop(0)
            host = self._all.enter_context(
                self._forkserver.host_process(self._place, priority=self.epoch > 0)
            )
            link = LiveLink(host, frames.decode_from_live, MAX_PULSE)
            self._register(link)
            self.programs.append(Program(program, host, link))
            with contextlib.suppress(HostDied):  # then it has hung up, which will be heard
                link.send(frames.Start((program,), 0, self._seed, self._offers, self._domain))

    def measure(self) -> None:
        """Measure from now on how long a host has to wait; a program as soon as it spins."""
        spinning = (p.host for p in self.programs if p.pulse.spinning and not p.over)
        for host in (self._radio_host, *spinning):
            if host.pid not in self._queues:
                self._queues[host.pid] = queue = RunQueue(host.pid, self.TURN)
                queue.worst()  # what was until now is not the trial's

    def stop_programs(self, now: int) -> None:
        """Kill the programs whose end is due [ns]."""
        for program in self.programs:
            if program.start.stop is not None and program.start.stop <= now:
                program.host.kill()

    def _register(self, link: LiveLink) -> None:
        for descriptor in link.descriptors:
            self._poll.register(descriptor, select.POLLIN)

    # --- how they come together ------------------------------------------------------------------

    def meet(self) -> None:
        """Wait until the programs spin and all ends have found each other; time begins then."""
        limit = real_clock.monotonic() + self._start_limit
        while not all(map(self._ready, self.programs)):
            self.listen(self.TURN)
            if real_clock.monotonic() > limit:
                raise self.NotReady("hung")
        if not self._first and not any(p.pulse.spinning for p in self.programs):  # just a job
            raise self.NotReady("never_spun")
        limit = real_clock.monotonic() + MEETING_LIMIT
        while not self._all_met():
            self.listen(self.TURN)
            if real_clock.monotonic() > limit:
                if any(program.over for program in self.programs):
                    break  # its ends will never be met
                raise TimeoutError("DDS did not bring the node and the robot together in time")
        alive = (program.host for program in self.programs if not program.over)
        for host in (self._radio_host, *alive):
            prefer(host.pid)
        self.epoch = real_clock.time_ns()
        self._answerer.begin(real_clock.monotonic_ns())
        self._heard = [said for said in self._heard if self._counts(said)]

    def _all_met(self) -> bool:
        if len(self.endpoints) < self._asked:
            return False
        wanted: dict[str, int] = {}
        offered = {offer.topic for offer in self._offers}
        for end in self.endpoints:
            served = end.kind == "subscription" and end.topic in offered
            if end.kind == "publisher" or served:
                name = f"{end.kind} {end.topic}"
                if not end.mismatch:
                    wanted[name] = wanted.get(name, 0) + 1
        services = {end.topic for end in self.endpoints if end.kind == "service"}
        asked = {end.topic for end in self.endpoints if end.kind == "client"} & services
        mine = all(self._connected.get(name, 0) >= n for name, n in wanted.items())
        theirs: dict[str, int] = {}
        for program in self.programs:
            for name, count in program.pulse.connected.items():
                theirs[name] = max(theirs.get(name, 0), count)
        needed = [*wanted, *(f"client {name}" for name in asked)]
        return mine and all(theirs.get(name, 0) > 0 for name in needed)

    # --- what they say ---------------------------------------------------------------------------

    def now(self) -> int:
        """Return the time since the scenario's start [ns]."""
        return real_clock.time_ns() - self.epoch if self.epoch else 0

    def transmit(self, deliveries: Sequence[frames.Delivery]) -> None:
        """Let the radio send messages of the robot."""
        self._tell_radio(frames.Transmit(tuple(deliveries)))

    def _tell_radio(self, frame: frames.ToHost) -> None:
        try:
            self.radio.send(frame)
        except (HostDied, HostHung):
            raise EngineError(NO_RADIO) from None

    def take_heard(self) -> list[frames.Published]:
        """Return what was heard since the last call, in order; times since 1970 [ns]."""
        heard, self._heard = self._heard, []
        return sorted(heard, key=lambda message: message.time)

    def waited(self, *, unseen_too: bool) -> float:
        """Return the longest wait for a CPU since the last call [s] (see `RunQueue.worst`)."""
        return max(queue.worst(unseen_too=unseen_too) for queue in self._queues.values())

    def still_wait(self) -> float:
        """Return the longest wait for a CPU that has not ended, as far as it was seen [s]."""
        return max((queue.pending() for queue in self._queues.values()), default=0.0)

    def cpu(self) -> float:
        """Return the CPU time of the programs [s]."""
        used = [program.link.cpu() for program in self.programs if not program.link.gone]
        return math.fsum(used) if used else 0.0

    def listen(self, patience: float) -> None:
        """Wait for the hosts to say something, `patience` [s] at most, and take it in."""
        due = self._answerer.next_due
        if due is not None:
            patience = min(patience, max(0.0, (due - real_clock.monotonic_ns()) / 1e9))
        for descriptor, event in self._poll.poll(max(1, math.ceil(patience * 1e3))):
            if not event & select.POLLIN:  # closed, for ever: it would end each wait at once
                self._poll.unregister(descriptor)
        real_clock.sleep(min(REST, patience))
        self._answer()
        now = self.now()
        for queue in self._queues.values():
            queue.look()
        for program in self.programs:
            program.link.note_time(now)
            self._hear_program(program)
        count = 0
        for frame in self.radio.hear():
            match frame:
                case frames.Tuned():
                    self.endpoints += frame.endpoints
                    self._connected = frame.connected
                case frames.HeardNow():
                    new = [m for m in frame.published if not self._lenient or self._has_room(m)]
                    count += len(new)
                    self._heard += filter(self._counts, new)
        if count > frames.MAX_PUBLISHED:
            raise Flood(f"more than {frames.MAX_PUBLISHED} messages at a time")
        self._limit_start_up()
        if self.radio.gone:
            raise EngineError(NO_RADIO)

    def _answer(self) -> None:
        """Send the programs their models' answers, when these are due."""
        for program, told in self._answerer.due(real_clock.monotonic_ns()):
            with contextlib.suppress(HostDied, HostHung):
                program.link.send(frames.Answers((told,)))

    def _hear_program(self, program: Program) -> None:
        heard = program.link.hear()
        if len(heard) > MAX_PULSES:
            raise Flood(f"more than {MAX_PULSES} pulses at a time")
        for frame in heard:
            match frame:
                case frames.Pulse():
                    program.pulse = frame
                    program.topics |= {e.topic for e in frame.endpoints if e.kind == "publisher"}
                    if frame.endpoints:
                        self._asked += len(frame.endpoints)
                        if self._asked > MAX_ENDPOINTS:
                            raise Flood(f"more than {MAX_ENDPOINTS} endpoints")
                        number = self.programs.index(program)
                        own = (msgspec.structs.replace(e, process=number) for e in frame.endpoints)
                        self._tell_radio(frames.Meet(tuple(own)))
                case frames.Asking():
                    for question in frame.asked:
                        self._answerer.ask(question, real_clock.monotonic_ns(), program)
                case frames.Ended():
                    program.ended = frame
        stopped = program.start.stop is not None and program.start.stop <= self.now()
        if program.over and not stopped and not self._others_go_on(program):
            raise self.Over

    def _others_go_on(self, program: Program) -> bool:
        """Return whether a program that has ended was one of several that are spared."""
        if not program.start.spared:
            return False
        if program.left is None and any(p.start.spared and not p.over for p in self.programs):
            program.left = self.now()
        return program.left is not None

    def _ready(self, program: Program) -> bool:
        now, topics = real_clock.monotonic(), program.topics & self._first.keys()
        speaks_on = any(now - self._first[topic] > SPEAKS_ON for topic in topics)
        return speaks_on or program.ready(now)

    def _has_room(self, published: frames.Published) -> bool:
        """Return whether to note a message: a robot's driver takes few in so short a time, too."""
        self._first.setdefault(published.topic, real_clock.monotonic())
        slot = published.time // SLOT
        latest, count = self._slots.get(published.topic, (slot, 0))
        self._slots[published.topic] = (slot, count + 1 if slot == latest else 1)
        return self._slots[published.topic][1] <= MAX_IN_SLOT

    def _counts(self, published: frames.Published) -> bool:
        """Return whether a message is worth noting.

        Between a program's start-up and the scenario's beginning no check asks for its messages.
        """
        return published.time >= self.epoch > 0 or self._said_in_start_up(published)

    def _said_in_start_up(self, published: frames.Published) -> bool:
        """Return whether a program said this before it began to spin, as far as is known."""
        who = [p.pulse for p in self.programs if published.topic in p.topics]
        return not who or any(not pulse.spun or published.time < pulse.spun for pulse in who)

    def _limit_start_up(self) -> None:
        """Flood if more was heard before time began than a node says at a time."""
        if self.epoch:
            return
        size = sum(len(m.data) for m in self._heard)
        if len(self._heard) > frames.MAX_PUBLISHED or size > frames.MAX_PUBLISHED_BYTES:
            raise Flood("too many or too large messages before it spins")
