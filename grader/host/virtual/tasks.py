"""Put the kernel under rclpy's tasks: callbacks and coroutines that an executor may run.

Written against rclpy 7.1 (Jazzy).
"""

from __future__ import annotations

from typing import Any

from rclpy.task import Future, Task

from .kernel import IDLE_STEP, Kernel

YIELDS = 10  # of a coroutine at one moment, after which it costs time to give way
YIELDED = object()


def install(kernel: Kernel) -> None:
    """Let coroutines that give way cost time, and futures tell the kernel that they are done."""
    cls: Any = Task
    call = cls.__call__

    def virtual_call(self: Any) -> Any:
        self._course_queued = False
        result = call(self)
        if not self.done() and _waits_for(self) is YIELDED:
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


def _waits_for(task: Any) -> Any:
    """Return the future of rclpy for which a coroutine waits; None if it has not begun.

    `YIELDED` if it has given way of its own accord, as with `asyncio.sleep(0)`.
    """
    waiting: Any = getattr(task, "_handler", None)
    while True:
        deeper = getattr(waiting, "cr_await", None) or getattr(waiting, "gi_yieldfrom", None)
        if deeper is None:
            break
        waiting = deeper
    code = getattr(waiting, "gi_code", None)
    if code is None:
        return None
    if code is not Future.__await__.__code__:
        return YIELDED
    return waiting.gi_frame.f_locals["self"]
