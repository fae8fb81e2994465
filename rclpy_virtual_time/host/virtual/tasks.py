"""Put the kernel under rclpy's tasks: callbacks and coroutines that an executor may run.

Written against rclpy 7.1 (Jazzy) and 9.1 (Kilted).
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import msgspec
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.task import Future, Task
from rclpy.timer import Timer

from ..frames import Note
from ..imports import host, place_of
from .kernel import IDLE_STEP, Kernel, real_get_ident

YIELDS = 10  # of a coroutine at one moment, after which it costs time to give way
YIELDED = object()
SHORT = 50_000_000  # [ns] that a callback may last without a word
LONG = 1_000_000_000  # [ns] after which one that waits, with no time set, waits for good
SLEEP = 10 * LONG  # [ns] and one that waits for as long may outlast the drive
PENDING = (  # where rclpy's clients keep the futures of their answers
    "_pending_requests",
    "_pending_goal_requests",
    "_pending_result_requests",
    "_pending_cancel_requests",
)

_waiting: dict[Any, int] = {}  # coroutines, and since when [ns]
# by task: its thread, when it began [ns], and the epoch of the thread's last look for work then
_running: dict[int, tuple[int, int, int]] = {}


def install(kernel: Kernel) -> None:
    """Let coroutines that give way cost time, and futures tell the kernel that they are done."""
    cls: Any = Task
    call = cls.__call__

    def virtual_call(self: Any) -> Any:
        self._course_queued = False
        if self in _waiting and (note := _wait(self, _waiting.pop(self), kernel.now)):
            kernel.world.note(note)
        thread, begin = kernel.me(), kernel.now
        seen = thread.seen
        _running[id(self)] = real_get_ident(), begin, seen
        try:
            result = call(self)
        finally:
            del _running[id(self)]
        blocked = kernel.now - begin >= SHORT and thread.seen == seen  # nobody spun inside
        if blocked and (note := _block(self, begin, kernel.now)):
            kernel.world.note(note)
        waits_for = None if self.done() else _waits_for(self)
        if isinstance(waits_for, Future):
            _waiting[self] = kernel.now
        if waits_for is YIELDED:
            moment, count = getattr(self, "_course_yields", (kernel.now, 0))
            self._course_yields = (kernel.now, count + 1 if moment == kernel.now else 1)
            if count >= YIELDS:  # `while not done: await asyncio.sleep(0)` must end
                self._course_yields = (kernel.now, 0)
                kernel.sleep(IDLE_STEP / 1e9)
        return result

    future: Any = Future
    notify = future._schedule_or_invoke_done_callbacks

    def virtual_notify(self: Any) -> None:
        kernel.epoch += 1  # a coroutine may be waiting for this future
        notify(self)

    cls.__call__ = virtual_call
    future._schedule_or_invoke_done_callbacks = virtual_notify


def waits(kernel: Kernel) -> Iterator[Note]:
    """Yield which coroutines wait now and keep others waiting, and which callbacks for good."""
    for task, since in _waiting.items():
        if note := _wait(task, since, kernel.now):
            yield msgspec.structs.replace(note, count=0)
    for ident, begin, seen in _running.values():
        thread, frame = kernel.threads[ident], sys._current_frames().get(ident)
        spins = False
        while frame is not None and not host.is_beside(frame.f_code.co_filename):
            spins = spins or frame.f_code.co_name.startswith("spin_until_future")
            frame = frame.f_back
        lasted = kernel.now - begin
        in_vain = thread.until is None and not thread.asks and thread.seen == seen
        sleeps = thread.until is not None and thread.until - thread.since >= SLEEP
        if frame is not None and thread.parked and (in_vain or spins or sleeps) and lasted >= LONG:
            place, more = place_of(frame.f_code, frame.f_lineno), "spins" * spins
            kind = "waits" if in_vain or spins else "sleeps"
            yield Note(kind, frame.f_code.co_name, place, 0, max(0, begin), lasted, more)


def _wait(task: Any, since: int, now: int) -> Note | None:
    """Return a note about a coroutine whose callback group does nothing else while it waits."""
    entity = task.__dict__.get("_course_entity")
    group = getattr(entity, "callback_group", None)
    steps = [each for each in _chain(task) if getattr(each, "cr_frame", None)]
    own = [each for each in steps if host.is_beside(each.cr_code.co_filename)]
    if now - since < SHORT or not isinstance(group, MutuallyExclusiveCallbackGroup) or not own:
        return None
    kind, more = "awaits", _kept_waiting(task, entity, group)
    future = _waits_for(task)
    members = [reference() for reference in group.entities]
    for end in (*members, *_ends(task, "clients")):
        if any(future in getattr(end, name, {}).values() for name in PENDING):
            server = end.__dict__.get("_course_name") or end._action_name
            if end in members or server in [getattr(e, "_course_name", "") for e in members]:
                kind, more = "stuck", server
    if not more:
        return None
    place = place_of(own[-1].cr_code, own[-1].cr_frame.f_lineno)
    return Note(kind, own[0].cr_code.co_name, place, 1, max(0, since), now - since, more)


def _block(task: Any, begin: int, now: int) -> Note | None:
    """Return a note about a callback that has kept its executor's thread, or its group."""
    entity = task.__dict__.get("_course_entity")
    callback = getattr(entity, "callback", None)
    code = getattr(getattr(callback, "func", callback), "__code__", None)
    if code is None or not host.is_beside(code.co_filename):
        return None
    group = entity.callback_group if _has_threads(task._executor()) else None
    more = _kept_waiting(task, entity, group)
    if isinstance(entity, Timer) and now - begin > entity.timer_period_ns:
        more = more or Note.OWN_TIMER
    place = place_of(code, code.co_firstlineno)
    return Note("lasts", code.co_name, place, 1, max(0, begin), now - begin, more) if more else None


def _has_threads(executor: Any) -> bool:
    """Return whether an executor runs callbacks of several groups side by side."""
    return isinstance(executor, MultiThreadedExecutor) and executor._executor._max_workers > 1


def _kept_waiting(task: Any, entity: Any, group: Any) -> str:
    """Name what can't be called meanwhile: all of an exclusive group; None: of the executor."""
    if group is not None and not isinstance(group, MutuallyExclusiveCallbackGroup):
        return ""
    names = set()
    for end in _ends(task, "subscriptions", "services", "timers"):
        name = end.__dict__.get("_course_name", "")
        timer = isinstance(end, Timer)
        if group in (None, end.callback_group) and not (timer and end is entity):
            names.add(f"a timer of {name}" if timer else name)
    return ", ".join(sorted(names - {""}))


def _ends(task: Any, *kinds: str) -> Iterator[Any]:
    """Yield the ends that the executor of a task knows."""
    executor = task._executor()
    for node in executor.get_nodes() if executor else ():
        for kind in kinds:
            yield from getattr(node, kind)


def is_new(kernel: Kernel, task: Any) -> bool:
    """Return whether a task that an executor offers deserves to be handed out.

    Not if it was handed out and still queues in the thread pool (rclpy#1452 offers it again and
    again), nor if it is a coroutine that waits for a future which is pending.
    """
    if getattr(task, "_course_queued", False):
        return False
    waits_for = _waits_for(task)
    if waits_for is not None and waits_for is not YIELDED:
        if waits_for._pending():  # `done` is false for one that was cancelled
            return False
    elif waits_for is None and getattr(task, "_course_tried", None) == kernel.epoch:
        return False
    if not hasattr(task, "_course_queued"):
        kernel.epoch += 1
    task._course_queued = True
    task._course_tried = kernel.epoch
    return True


def rests(task: Any) -> bool:
    """Return whether an executor has nothing to do for a task that it has made."""
    if task.done() or task.executing() or task.__dict__.get("_course_queued"):
        return True
    waits_for = _waits_for(task)
    return waits_for is not None and waits_for is not YIELDED and bool(waits_for._pending())


def _waits_for(task: Any) -> Any:
    """Return the future of rclpy for which a coroutine waits; None if it has not begun.

    `YIELDED` if it has given way of its own accord, as with `asyncio.sleep(0)`.
    """
    waiting = _chain(task)[-1]
    code = getattr(waiting, "gi_code", None)
    if code is None:
        return None
    if code is not Future.__await__.__code__:
        return YIELDED
    return waiting.gi_frame.f_locals["self"]


def _chain(task: Any) -> list[Any]:
    """Return the coroutine of a task, that for which it waits, and so on."""
    chain = [getattr(task, "_handler", None)]
    while deeper := getattr(chain[-1], "cr_await", None) or getattr(
        chain[-1], "gi_yieldfrom", None
    ):
        chain.append(deeper)
    return chain
