"""Virtual time for all threads of one process: one runs at a time, time moves when all are parked.

A *baton* goes round: only its holder executes Python. A thread that has to wait parks and hands the
baton to whoever can run, first come, first served; when nobody can, everything has settled and time
jumps to the next moment at which something happens. So the same program with the same events gives
the same run, on any machine.
"""

from __future__ import annotations

import _thread
import collections
import contextlib
import heapq
import itertools
from collections.abc import Callable, Iterator
from typing import TypeVar

from ..frames import Note
from .charge import Meter

Result = TypeVar("Result")

IDLE_POLLS = 3  # looks with a timeout of zero in which nothing happens ...
IDLE_STEP = 1_000_000  # [ns] ... after which this much time goes by: a busy loop costs time
READING = 1_000  # [ns] between two readings of a clock: the step of datetime; a float's is 238
AHEAD = 100 * READING  # that clocks may be ahead of time, after which it catches up

# The kernel replaces these for everybody else.
real_allocate_lock = _thread.allocate_lock
real_get_ident = _thread.get_ident


class VirtualThread:
    """What the kernel knows of one thread."""

    def __init__(self) -> None:
        self.gate = real_allocate_lock()  # opened by the thread that hands over the baton
        self.gate.acquire()
        self.ticket = 0  # goes up at each wake-up, which makes old queue entries void
        self.woken = False  # woken by a thread (True) or by the deadline (False)
        self.seen = -1  # epoch at this thread's last look
        self.idle: dict[object, tuple[int, int]] = {}  # poll key: (epoch, idle looks in it)
        self.done = False
        self.program: object = None  # the emulated process it belongs to
        self.joiners: Waiters = collections.deque()
        self.interrupts: list[Callable[[], None]] = []  # to run before it goes on (see interrupt)
        self.parked = False  # no thread has woken it yet
        self.asks = False  # it waits for the world, which will answer
        self.since = 0  # [ns] when it was parked last
        self.until: int | None = None  # [ns] at which it will have been parked long enough
        self.goes_on_waiting = False  # it was woken for its interrupts only


class _Call:
    """An action at a time, in the place of a thread that wakes up."""

    ticket = 0

    def __init__(self, action: Callable[[], None]) -> None:
        self.action = action


Waiter = tuple[VirtualThread, int]
Waiters = collections.deque[Waiter]


class World:
    """What happens outside the process; the kernel asks it where time may go."""

    until = 0  # [ns] time may go up to here without asking

    def settled(self) -> None:
        """Everything that can run at this moment has run."""

    def moved(self) -> None:
        """Time has moved."""

    def switched(self, before: object, after: object) -> None:
        """The baton has passed from a thread of one program to one of another."""

    def note(self, note: Note) -> None:
        """A person should know of this."""

    def exchange(self) -> None:
        """Time has come to `until`: let the world act and move `until` on."""
        raise NotImplementedError


class Kernel:
    """The clock and the baton."""

    def __init__(self, world: World | None = None) -> None:
        self.world = world or World()
        self.begin(0)
        self.epoch = 0  # goes up whenever anything may have changed for a poller
        self.pollers: list[Waiter] = []  # executors and selectors: they look for themselves
        self.looks = 0  # how often they looked
        self._ready: collections.deque[VirtualThread] = collections.deque()
        self._timed: list[tuple[int, int, VirtualThread | _Call, int]] = []
        self._sequence = itertools.count()
        self.threads = {real_get_ident(): VirtualThread()}
        self.program: object = None  # whose thread holds the baton
        self.meter: Meter | None = None  # if computing costs time
        self.computing = False  # time goes by for what a thread has computed

    # --- for the threads -------------------------------------------------------------------------

    def me(self) -> VirtualThread:
        """Return the calling thread's record."""
        return self.threads[real_get_ident()]

    def begin(self, now: int) -> None:
        """Begin at a time [ns].

        What clocks show until the first wait lies just before it, so that a timer made meanwhile
        shows at its first call that its period is over.
        """
        self.now = now  # [ns] since the start of the scenario
        self.parked = now  # [ns] when a thread parked last
        self._first = now - AHEAD  # [ns] what a clock shows at least
        self._shown = self._first  # [ns] the latest time that one has shown
        self._limit = 0  # [ns] see _find_limit; 0: not known
        self.reading = False  # a thread parks only because a clock catches up with its readings
        self.toll = 0  # [ns] what it has to pay then

    def show(self) -> int:
        """Return what a clock shows [ns]: each reading is later than the one before.

        `now` stands still meanwhile, until a reading comes to what is due next: that comes first.
        """
        self.charge()
        time = max(self._first, self._shown + READING)
        if time > self.now and time >= (self._limit or self._find_limit()):
            self.reading, due, self.toll = True, time + self.toll, 0
            try:
                self.park(due)
            finally:
                self.reading = False
            time = max(self._first, self._shown + READING)
        self._shown = time
        return time

    @property
    def present(self) -> int:
        """The latest time that there has been [ns], by `now` or a clock: waits begin here."""
        return max(self.now, self._shown)

    def after(self, seconds: float) -> int:
        """Return the time [ns] that is `seconds` from now; any wait at all takes 1 ns."""
        self.charge()
        if seconds <= 0:
            return self.now
        return self.present + max(1, round(seconds * 1e9))

    def charge(self) -> None:
        """Let time catch up with computing, if computing costs time."""
        if self.meter is not None and not self.computing:
            self._pay(self.meter.whole())

    def park(self, deadline: int | None = None, waiters: Waiters | None = None) -> bool:
        """Give the baton away until woken (True) or until the deadline [ns] (False).

        Raises BaseException: what an interrupt raised (see `interrupt`).
        """
        thread = self.me()
        while True:
            woken = self.park_once(deadline, waiters)
            if not thread.goes_on_waiting:
                return woken
            if deadline is not None and deadline <= self.now:
                return False

    def park_once(self, deadline: int | None = None, waiters: Waiters | None = None) -> bool:
        """Do as `park`, but come back after an interrupt, too."""
        thread = self.me()
        thread.woken = thread.goes_on_waiting = False
        thread.parked, thread.since, thread.until = True, self.now, deadline
        self.parked = self.now
        self._limit = 0
        if waiters is not None:
            waiters.append((thread, thread.ticket))
        if deadline is not None:
            entry = (deadline, next(self._sequence), thread, thread.ticket)
            heapq.heappush(self._timed, entry)
        self._switch(thread)
        while thread.interrupts:
            thread.interrupts.pop(0)()
        return thread.woken

    def interrupt(self, thread: VirtualThread, action: Callable[[], None]) -> None:
        """Run `action` in a thread before it does anything else, as a signal's handler.

        A thread that waits goes on waiting afterwards, unless `action` raises.
        """
        if thread is self.me() and not thread.parked:
            action()
            return
        thread.interrupts.append(action)
        if thread.parked:
            self.wake((thread, thread.ticket))
            thread.goes_on_waiting = True

    def call_at(self, time: int, action: Callable[[], None]) -> None:
        """Let `action` happen at a time [ns]; it must not block."""
        heapq.heappush(self._timed, (time, next(self._sequence), _Call(action), _Call.ticket))
        self._limit = 0

    def wake(self, waiter: Waiter, woken: bool = True) -> bool:
        """Make a parked thread runnable; False if something else was faster."""
        thread, ticket = waiter
        if thread.ticket != ticket:
            return False
        thread.ticket += 1
        thread.woken, thread.parked = woken, False
        self._ready.append(thread)
        return True

    def sleep(self, seconds: float) -> None:
        """Park for a time."""
        self.park(self.after(seconds))

    def poll(
        self,
        key: object,
        look: Callable[[], Result | None],
        deadline: int | None = None,
        next_due: Callable[[], int | None] = lambda: None,
    ) -> Result | None:
        """Look, each time something has happened, until there is a result.

        `look` never blocks. None comes back at the deadline [ns]. `next_due` tells when `look` may
        succeed by the passing of time alone (a timer).
        """
        thread = self.me()
        while True:
            self._let_others_run(thread)
            self.charge()
            thread.seen = self.epoch
            self.looks += 1
            try:
                result = look()
            except Exception:  # an executor that is shut down: a loop around it is a busy one
                if self._too_idle(thread, (key, "fails")):
                    self.park(self.now + IDLE_STEP)
                raise
            if result is not None:
                thread.idle.pop(key, None)
                return result
            if deadline is not None and deadline <= self.now:
                if not self._too_idle(thread, key):
                    return None
                deadline = self.now + IDLE_STEP
            self.pollers.append((thread, thread.ticket))
            times = [time for time in (deadline, next_due()) if time is not None]
            self.park_once(min(times, default=None))

    # --- for modules that start threads ----------------------------------------------------------

    def add(self) -> VirtualThread:
        """Announce a thread; it runs when its turn comes."""
        thread = VirtualThread()
        thread.program = self.program
        self._ready.append(thread)
        return thread

    def forget(self, thread: VirtualThread) -> None:
        """Take back an announced thread that could not be started."""
        thread.done = True
        self._ready.remove(thread)

    def enter(self, thread: VirtualThread) -> None:
        """Wait, in the new thread, for its first turn."""
        self.threads[real_get_ident()] = thread
        thread.gate.acquire()
        self._resume(thread)

    def leave(self, thread: VirtualThread) -> None:
        """End the thread: the baton goes on for good."""
        thread.done = True
        thread.ticket += 1
        del self.threads[real_get_ident()]
        for joiner in thread.joiners:
            self.wake(joiner)
        self._pick().gate.release()

    # --- for the emulation of processes ----------------------------------------------------------

    @contextlib.contextmanager
    def acting_as(self, program: object) -> Iterator[None]:
        """Let the calling thread belong to another program for a while."""
        thread = self.me()
        own, thread.program = thread.program, program
        self._resume(thread)
        try:
            yield
        finally:
            thread.program = own
            self._resume(thread)

    def kill(self, program: object) -> None:
        """Never run the threads of a program again, wherever they wait."""
        for thread in self.threads.values():
            if thread.program is program:
                thread.ticket += 1
        self._ready = collections.deque(t for t in self._ready if t.program is not program)

    # --- the baton -------------------------------------------------------------------------------

    @property
    def waiting(self) -> bool:
        """Whether an executor or event loop is waiting for work."""
        return any(thread.ticket == ticket for thread, ticket in self.pollers)

    @property
    def asleep(self) -> bool:
        """Whether a thread is waiting for a time."""
        return any(thread.ticket == ticket for _, _, thread, ticket in self._timed)

    def _let_others_run(self, thread: VirtualThread) -> None:
        if self._ready:
            self._ready.append(thread)
            self._switch(thread)

    def _switch(self, thread: VirtualThread) -> None:
        chosen = self._pick()
        if chosen is not thread:
            chosen.gate.release()
            thread.gate.acquire()
            self._resume(thread)

    def _resume(self, thread: VirtualThread) -> None:
        if thread.program is not self.program:
            before, self.program = self.program, thread.program
            self.world.switched(before, self.program)

    def _pick(self) -> VirtualThread:
        while True:
            if self._ready:
                self.epoch += 1
                return self._ready.popleft()
            poller = self._curious_poller()
            if poller is not None:
                return poller
            self._advance()

    def _curious_poller(self) -> VirtualThread | None:
        """Return a poller that has not yet looked at the present state of things."""
        self.pollers = [(t, ticket) for t, ticket in self.pollers if t.ticket == ticket]
        for index, (thread, _) in enumerate(self.pollers):
            if thread.seen != self.epoch:
                del self.pollers[index]
                thread.ticket += 1
                thread.parked = False
                return thread
        return None

    def _advance(self) -> None:
        """Move time: to the next wake-up, or to the world's next event."""
        news = self.meter is not None and self._pay(self.meter.rounded())
        self.world.settled()
        if news:
            return  # pollers look first
        self._go_on()
        if self.meter is not None:
            self.meter.restart()

    def _find_limit(self) -> int:
        """Find how far clocks may be ahead: until something is due after this moment [ns]."""
        times = [self.now + AHEAD, self.world.until]
        times += [time for time, _, thread, ticket in self._timed if thread.ticket == ticket]
        self._limit = min(time for time in times if time > self.now)
        return self._limit

    def _go_on(self) -> None:
        while self._timed and self._timed[0][2].ticket != self._timed[0][3]:
            heapq.heappop(self._timed)
        until = self.world.until
        due = self._timed[0][0] if self._timed else until
        self.epoch += 1
        if due < until:
            self._move_to(due)
            _, _, thread, ticket = heapq.heappop(self._timed)
            if isinstance(thread, _Call):
                thread.action()
            else:
                self.wake((thread, ticket), woken=False)
        else:
            self._move_to(until)
            self.world.exchange()

    def _pay(self, due: int) -> bool:
        """Let the time [ns] go by that computing took; True if the world acted meanwhile.

        What the program said while it computed, it said at the end; that is taken now.
        """
        self.computing = True
        end = self.now + due
        acted = False
        while end > self.world.until:
            self._move_to(self.world.until)
            self.world.exchange()
            self.epoch += 1
            acted = True
        self._move_to(end)
        self.world.settled()
        self.computing = False
        if self.meter is not None:
            self.meter.restart()
        return acted

    def _move_to(self, time: int) -> None:
        if time > self.now:
            self.now = self._first = time
            self._limit = 0
            self.world.moved()

    def _too_idle(self, thread: VirtualThread, key: object) -> bool:
        epoch, looks = thread.idle.get(key, (self.epoch, 0))
        looks = looks + 1 if epoch == self.epoch else 1
        thread.idle[key] = (self.epoch, looks)
        return looks >= IDLE_POLLS
