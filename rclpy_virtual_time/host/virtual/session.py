"""One trial in the host: the link's far end, and the world of the kernel.

The judge owns time. It says "deliver these messages and go on until t"; the host lets the student's
program run until then, and answers with all that was published on the way.
"""

from __future__ import annotations

import collections
import contextlib
import itertools
import os
from collections.abc import Callable
from typing import Any

import msgspec

from ..desk import desk
from ..frames import (
    MAX_LEAD,
    MAX_NAME,
    Note,
    Question,
    Run,
    Settled,
    Slept,
    Start,
    Task,
    Told,
)
from ..tasks import carried_out
from ..wire import Turns, Wire, ended, sendable
from . import kernel as kernel_module
from .charge import Meter

FREE_MESSAGES = 1000  # of a loop that publishes and reads clocks, but never waits ...
PUBLISHING = 2_000_000  # [ns] ... before each costs this much: about 500 in a second


class Session(kernel_module.World):
    """Talks to the judge whenever the kernel comes to the end of the time it may spend."""

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self._marked = -1
        self.turns = Turns()
        self._looks = 0
        self._in_a_row = 0  # messages without a wait between them
        self._starting = False  # a first try, to learn how long the program's start-up takes
        self.kernel: kernel_module.Kernel
        self.bridge: Any = None
        self.clocks: Any = None
        self.programs: Any = None  # if there are several
        self.charge_compute = False  # from the scenario's start on
        self._tells_ends = False  # before time goes on
        self.ending = False  # the scenario is over, and the programs have been sent SIGINT
        self.interrupt: Callable[[], None] = lambda: None  # sends it
        self.looker: Any = None  # in a drive in which somebody looks into moments
        self._numbers = itertools.count()
        self._questions: list[Question] = []  # that the judge has not been told of
        self._agreed = 0  # [ns] what `until` was when the first of them was asked
        self._asking: dict[int, kernel_module.Waiters] = {}  # by question
        self._told: dict[int, Told] = {}
        self._notes: dict[tuple[str, str, str], Note] = {}
        self._news: dict[tuple[str, str, str], Note] = {}  # notes of which the judge does not know
        desk.ask = self.ask

    def start(self) -> Start:
        """Return what to run: the judge's first frame, unless that is a task."""
        frame = self._wire.receive()
        if isinstance(frame, Task):
            self._wire.send(carried_out(frame))
            frame = self._wire.receive()
        if not isinstance(frame, Start):
            raise ValueError("the first frame must say what to run")
        return frame

    def begin(self, lead: int) -> None:
        """Begin `lead` [ns] before the scenario; 0: find out how long before is needed.

        A robot that is switched on waits for its node. So the time in which a program sleeps before
        it first waits for work or speaks must not be the scenario's: the judge is told of it, and
        starts the program anew, so much earlier.
        """
        self.kernel.begin(-lead)
        self._starting = lead == 0 and self.programs is None
        self.until = MAX_LEAD if self._starting else 0

    def settled(self) -> None:
        """Collect the messages published at this moment."""
        kernel, bridge = self.kernel, self.bridge
        said = bridge.collect(self._time())
        self._in_a_row = self._in_a_row + said if kernel.reading else 0
        if self._in_a_row > FREE_MESSAGES:
            kernel.toll += said * PUBLISHING
        idle = not kernel.asleep and not self._asking
        if self._starting and (kernel.looks or bridge.published or idle):
            self._end_start()
        if self._tells_ends and bridge.endpoints:
            self.until = kernel.now

    def moved(self) -> None:
        """Time has moved: tell the clocks, and mark the output."""
        self.clocks.follow()
        self.mark()

    def note(self, note: Note) -> None:
        """Note something for a person; of several alike the longest, and how many there are."""
        about, line, more = (
            sendable(text)[:MAX_NAME] for text in (note.about, note.line, note.more)
        )
        note = msgspec.structs.replace(note, about=about, line=line, more=more)
        key = (note.kind, about, line)
        before = self._notes.get(key)
        if before is not None:
            longest = note if note.lasted >= before.lasted else before
            note = msgspec.structs.replace(longest, count=before.count + note.count)
        if note != before and (before or len(self._notes) < Note.MOST):
            self._notes[key] = self._news[key] = note

    def switched(self, before: object, after: object) -> None:
        """Give each of several programs its own globals."""
        if self.programs is not None:
            self.programs.switch(before, after)

    def ask(self, data: bytes) -> bytes:
        """Ask the judge, and wait as long as the answer takes."""
        if len(self._asking) >= Settled.MAX_QUESTIONS:
            raise RuntimeError(f"{Settled.MAX_QUESTIONS} threads ask the model at the same time")
        number = next(self._numbers)
        if not self._questions:  # the judge is told before time goes on
            self._agreed, self.until = self.until, self.kernel.now
        self._questions.append(Question(number, data))
        waiters: kernel_module.Waiters = collections.deque()
        self._asking[number] = waiters
        thread = self.kernel.me()
        thread.asks = True
        try:
            self.kernel.park(None, waiters)
        finally:
            thread.asks = False
        told = self._told.pop(number)
        if told.wait:
            self.kernel.sleep(told.wait / 1e9)
        return told.data

    def exchange(self) -> None:
        """Report to the judge; wait for its messages and its next moment."""
        bridge = self.bridge
        if self._questions and (self._starting or self.kernel.now < 0):
            self._ask_in_start()
            return
        if self._starting:
            self._end_start()
        if bridge.overflow:
            self.end("flooded", bridge.overflow)
            os._exit(0)
        self._wire.send(
            Settled(
                now=self.kernel.now,
                spinning=self.kernel.waiting or self.kernel.looks > self._looks,
                asleep=self.kernel.asleep or self.kernel.computing or bool(self._asking),
                published=bridge.take(),
                endpoints=bridge.new_endpoints(),
                asked=self._take_questions(),
                notes=self._take_notes(),
                moments=self.looker.news() if self.looker else [],
                parked=max(0, self.kernel.parked),
            )
        )
        self._looks = self.kernel.looks
        run = self._receive_run()
        for delivery in run.deliver:
            bridge.deliver(delivery.topic, delivery.data)
        self.until, self._tells_ends = run.until, run.ends
        if run.interrupt:
            self._interrupt()
        if self.charge_compute and self.kernel.meter is None:
            self.kernel.meter = Meter()

    def _interrupt(self) -> None:
        """Send the programs SIGINT, a nanosecond after all that counts."""
        self.ending = True
        self.kernel.now += 1
        self.moved()
        if self.kernel.computing:  # its thread has not parked
            self.kernel.call_at(self.kernel.now, self.interrupt)
        else:
            self.interrupt()

    def end(self, kind: str, text: str, detail: str = "") -> None:
        """Say that the student's program is over."""
        frame = ended(kind, text, detail, self._time())
        if self.bridge is not None:
            with contextlib.suppress(Exception):
                self.bridge.collect(self._time())
            frame = msgspec.structs.replace(
                frame,
                published=self.bridge.take(),
                endpoints=self.bridge.new_endpoints(),
                notes=self._take_notes(),
                moments=self.looker.news(all=True) if self.looker else [],
            )
        self._wire.send(frame)
        self.ending = True  # of all

    def leave_for_real_time(self, reason: str) -> None:
        """Say that this program can't run in virtual time; never returns."""
        self.end("real_time", reason)
        os._exit(0)

    def mark(self) -> None:
        """Note the time in stdout and stderr, if it has changed."""
        if self._time() == self._marked:
            return
        self._marked = self._time()
        self.turns.begin(self._marked)

    def _receive_run(self) -> Run:
        """Return the judge's next frame; threads that wait for an answer in it may go on, too."""
        run = self._wire.receive()
        if not isinstance(run, Run):
            raise ValueError("the judge can only say how to go on")
        for told in run.told:
            self._told[told.number] = told
            for waiter in self._asking.pop(told.number, ()):
                self.kernel.wake(waiter)
        return run

    def _take_questions(self) -> list[Question]:
        taken, self._questions = self._questions, []
        return taken

    def _take_notes(self) -> list[Note]:
        for note in self.bridge.notes(self.kernel):
            self.note(note)
        taken, self._news = list(self._news.values()), {}
        return taken

    def _ask_in_start(self) -> None:
        """Ask before the scenario: time has not begun, and the answer says what it takes."""
        asked = self._take_questions()
        self._wire.send(Settled(0, spinning=False, asleep=True, published=[], asked=asked,
                                starting=True))  # fmt: skip
        self._receive_run()
        self.until = self._agreed

    def _end_start(self) -> None:
        if self.kernel.now > 0:
            self._wire.send(Slept(self.kernel.now))
            os._exit(0)
        self._starting, self.until = False, 0

    def _time(self) -> int:
        """Return the scenario's time [ns]; it stays at 0 until the program has started."""
        return 0 if self._starting else max(0, self.kernel.now)
