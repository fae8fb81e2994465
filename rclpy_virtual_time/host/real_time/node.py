"""A host in real time: the student's file on plain rclpy and DDS, as on a robot.

For nodes that virtual time can't carry, and for Tier 2. Nothing of Python or rclpy is replaced but
what rclpy 7.1 does wrong; the process only says, several times a second, how the node is.
"""

from __future__ import annotations

import os
import threading
import time
from typing import Any

import rclpy.executors
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.task import Task

from .. import asked, program, randomness
from ..desk import desk
from ..endpoints import ACTIONS, HIDDEN_TOPICS, EndpointWatch, is_parameter_service, report
from ..frames import MAX_CONNECTED, MAX_ENDPOINTS, EndpointReport, Note, Pulse, Start, TuneIn
from ..wire import Wire, ended
from .questions import Desk
from .robot import Radio

PERIOD = 0.1  # [s] between pulses
EVENTS_PERIOD = 0.5  # [s] an EventsExecutor waits at a time
REST = 0.001  # [s] after a wait that ended for nothing


def serve(read_fd: int, write_fd: int) -> None:
    """Do what the judge's first frame says: run a program, or be the robot's radio."""
    wire = Wire(read_fd, write_fd)
    match wire.receive():
        case Start() as start:
            _run_program(wire, start)
        case TuneIn() as order:
            Radio(wire, order).serve()
        case other:
            raise ValueError(f"{type(other).__name__} is not for hosts in real time")


class Vitals:
    """The state of a running program, for the judge."""

    def __init__(self) -> None:
        self._new: list[EndpointReport] = []
        self.notes: list[Note] = []  # of several alike the last counts
        self._ends: list[tuple[str, Any]] = []  # "kind topic", endpoint
        self._waiting = 0  # executors that wait for work now
        self._last_wait = 0.0
        self._spun = 0  # [ns] since 1970, when an executor first waited
        self._lock = threading.Lock()  # pulses are made beside the node's threads

    def on_endpoint(self, kind: str, node: Any, endpoint: Any) -> None:
        """Note an endpoint that the student's node has created."""
        if kind in ("service", "client"):
            if is_parameter_service(endpoint.service_name):
                return
            if kind == "client":
                self._ends.append((f"client {endpoint.service_name}", endpoint))
        elif kind not in ACTIONS and endpoint.topic_name in HIDDEN_TOPICS:
            return
        elif kind not in ACTIONS:
            self._ends.append((f"{kind} {endpoint.topic_name}", endpoint))
        new = report(kind, node, endpoint)
        with self._lock:
            self._new.append(new)

    def waits_unseen(self) -> None:
        """An executor looks for work or does it: which of the two, it doesn't tell."""
        self._spun = self._spun or time.time_ns()
        self._last_wait = time.monotonic()

    def wait_begins(self) -> None:
        """An executor waits for work."""
        with self._lock:
            self._waiting += 1
        self._spun = self._spun or time.time_ns()

    def wait_ends(self) -> None:
        """The executor has found work."""
        with self._lock:
            self._waiting -= 1
        self._last_wait = time.monotonic()

    def pulse(self) -> Pulse:
        """Return the state of things."""
        spun = self._spun  # before the rest: who spins has told of all that its constructor made
        with self._lock:
            new, self._new = self._new[:MAX_ENDPOINTS], self._new[MAX_ENDPOINTS:]
        idle = self._waiting > 0 or not spun
        busy = 0.0 if idle else time.monotonic() - self._last_wait
        return Pulse(spun, busy, new, self._connected(), self.notes[-Note.MOST :])

    def _connected(self) -> dict[str, int]:
        found: dict[str, int] = {}
        for name, endpoint in self._ends[:MAX_CONNECTED]:
            try:
                if name.startswith("client"):
                    found[name] = int(endpoint.service_is_ready())
                elif name.startswith("publisher"):
                    found[name] = endpoint.get_subscription_count()
                else:
                    found[name] = endpoint.get_publisher_count()
            except Exception:  # destroyed by its node
                continue
        return found


def _run_program(wire: Wire, start: Start) -> None:
    os.environ["ROS_DOMAIN_ID"] = str(start.domain)
    vitals = Vitals()
    EndpointWatch(vitals.on_endpoint).install()
    _mend_executors()
    _watch_executors(vitals)
    lock = threading.Lock()
    desk.ask = Desk(wire, lock).ask
    threading.Thread(target=_beat, args=(wire, vitals, lock), daemon=True).start()
    randomness.seed(start.seed)
    program.enter_folders(start.programs)
    asked.watch(start.programs, lambda: start.programs[0], vitals.notes.append)
    end = program.run_file(start.programs[0])
    with lock:
        wire.send(vitals.pulse())
        wire.send(ended(*end))
        os._exit(0)


def _beat(wire: Wire, vitals: Vitals, lock: threading.Lock) -> None:
    while True:
        with lock:
            wire.send(vitals.pulse())
        time.sleep(PERIOD)


def _watch_executors(vitals: Vitals) -> None:
    cls: Any = rclpy.executors.Executor
    wait = cls.wait_for_ready_callbacks

    def watched_wait(self: Any, *args: Any, **kwargs: Any) -> Any:
        vitals.wait_begins()
        try:
            found = wait(self, *args, **kwargs)
        finally:
            vitals.wait_ends()
        found[0]._course_queued = True
        return found

    cls.wait_for_ready_callbacks = watched_wait
    events_executor: Any = rclpy_implementation.EventsExecutor
    spin_once = events_executor.spin_once

    def watched_spin_once(self: Any, *args: Any, **kwargs: Any) -> None:
        vitals.waits_unseen()
        spin_once(self, *args, **kwargs)

    def watched_spin(self: Any) -> None:
        """The wheels' own spin() never calls anything; spin_once() does."""
        while self.context.ok():
            watched_spin_once(self, EVENTS_PERIOD)

    events_executor.spin_once, events_executor.spin = watched_spin_once, watched_spin


def _mend_executors() -> None:
    """Work around two defects of rclpy 7.1 that hurt correct multi-threaded nodes.

    A task that still queues in the thread pool is submitted again and again (ros2/rclpy#1452); and
    a wait ends at once, for nothing, while a message is pending whose subscription is not waited
    for but whose QoS events are: a loop that takes the interpreter from the pool's threads.
    """
    cls: Any = Task
    call, executing = cls.__call__, cls.executing

    def mended_call(self: Any) -> Any:
        try:
            return call(self)
        finally:
            self._course_queued = False

    cls.__call__ = mended_call
    cls.executing = lambda self: executing(self) or getattr(self, "_course_queued", False)
    module: Any = rclpy.executors
    module._rclpy = _Implementation(module._rclpy)


class _Implementation:
    """`rclpy`'s native module, with wait sets that rest after a wait for nothing."""

    def __init__(self, real: Any) -> None:
        self._real = real

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)

    def WaitSet(self, *sizes: Any) -> Any:  # noqa: N802  (the name of what it replaces)
        """Return a wait set."""
        return _WaitSet(self._real.WaitSet(*sizes))


class _WaitSet:
    KINDS = ("subscription", "guard_condition", "timer", "client", "service")

    def __init__(self, real: Any) -> None:
        self._real = real

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)

    def wait(self, nanoseconds: int) -> None:
        self._real.wait(nanoseconds)
        if nanoseconds and not any(self._real.get_ready_entities(kind) for kind in self.KINDS):
            time.sleep(REST)
