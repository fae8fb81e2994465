"""What a callback did at a moment: what came, what the node kept, what it sent and from where.

Only for a drive in which somebody asks: a launcher whose hosts are to be able to has imported this
module as one of its libraries, and a grader's has not. Nothing that the program sees is different:
its run is the same with and without. Written against rclpy 7.1 (Jazzy) and 9.1 (Kilted).
"""

from __future__ import annotations

import collections
import functools
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import CodeType, CoroutineType, FrameType, FunctionType, MethodType
from typing import Any

import numpy as np
import rclpy.action.client
import rclpy.action.server
import rclpy.executors
import rclpy.node
import rclpy.publisher
from msgspec.structs import replace
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.task import Future, Task
from rclpy.timer import Timer

from .asked import EACH_HAS
from .endpoints import HIDDEN_TOPICS
from .frames import MAX_NAME, Moment, Place, Sending, Value
from .imports import host, place_of
from .in_words import class_name, fields_of, is_beside, of_class, parts_of, values_of, words
from .virtual import executors
from .virtual.kernel import Kernel, real_get_ident
from .wire import sendable

KINDS = {Subscription: "subscription", Timer: "timer", Service: "service"}
MESSAGE = 1000  # [characters]
OPTIMIZED = 1  # in a code's flags: a function's locals, of which Python shows a copy
DATA = {id(cls) for cls in (int, float, bool, str, list, dict, collections.deque, np.ndarray)}
# What nodes keep for rclpy; the first three with a life cycle
ROS_NAMES = {"_state_machine", "_managed_entities", "_callbacks"}
ROS_NAMES |= set(vars(rclpy.node.Node)["__init__"].__code__.co_names)
# Nobody asks for what rclpy itself does when something comes, or what stands in for tf2.
NOT_THEIRS = (
    str(Path(rclpy.node.__file__).parent),
    str(Path(__file__).parent / "stand_ins" / "tf2_ros"),
)
_traceback: Any = BaseException.__dict__["__traceback__"].__get__
_arguments: Any = BaseException.__dict__["args"].__get__


class _Call:
    """A callback under way, or over: what is known of it, and what it may change."""

    def __init__(self, moment: Moment, keeps: Callable[[], list[Value]], came: Any = None) -> None:
        self.known, self.came = moment, came  # came: while it runs
        self._keeps = keeps
        self._before = {value.name: value.text for value in keeps()}

    def as_moment(self) -> Moment:
        """Return what is known by now; the same object if that is nothing new."""
        if self.known.lasted is not None or self.known.kind == "program":
            return self.known
        before = self._before
        values = [replace(each, before=before.get(each.name, "")) for each in self._keeps()]
        return replace(self.known, values=values)

    def end(self, now: int, answer: Any = None, error: Any = None) -> None:
        """Note how it ended."""
        known = self.as_moment()
        if isinstance(error, Exception):
            said = ", ".join(words(each) for each in _arguments(error)[:3])
            raised, places = sendable(f"{class_name(error)}({said})")[:MESSAGE], []
            trace = _traceback(error)
            while trace is not None:
                if host.is_beside(trace.tb_frame.f_code.co_filename):
                    places.append(_place(trace.tb_frame, trace.tb_lineno, self.came))
                trace = trace.tb_next
            known = replace(known, raised=raised, raised_in=places[: -Place.MOST - 1 : -1])
        if known.kind == "service" and answer is not None:
            known = replace(known, answered=words(answer, MESSAGE))
        self.known, self.came, self._keeps = replace(known, lasted=now - known.time), None, list

    def add(self, sending: Sending) -> None:
        """Note a message that left."""
        sent, more = self.known.sent, self.known.more
        most = [*sent, sending][-Moment.MOST :]
        self.known = replace(self.known, sent=most, more=more + (len(sent) == len(most)))


class Looker:
    """Keeps, for each time that is asked [ns], the callbacks of each program begun last by then."""

    def __init__(self, asked: tuple[int, ...], kernel: Kernel) -> None:
        self._asked, self._kernel = asked, kernel
        self._found: dict[tuple[int, int], dict[str, _Call]] = {}  # by time and program; function
        self._told: dict[tuple[int, _Call], Moment] = {}  # as it was known then
        self._tasks: dict[int, Any] = {}  # that threads run

    def install(self) -> None:
        """Come between executors and callbacks, and between a program and its publishers."""
        looker, really = self, rclpy.executors.await_or_execute

        async def looked(callback: Any, *arguments: Any) -> Any:
            call = looker._begin(callback, arguments, looker._tasks.get(real_get_ident()))
            answer = error = None
            try:
                answer = await really(callback, *arguments)
                return answer
            except BaseException as raised:
                error = raised
                raise
            finally:
                if call:
                    call.end(looker._now, answer, error)

        cls: Any = Task
        run = cls.__call__

        def called(task: Any) -> None:
            """Run a task; one without an entity is a callback itself: of a future, or made."""
            thread, call = real_get_ident(), task.__dict__.get("_course_call")
            outer, looker._tasks[thread] = looker._tasks.get(thread), task
            if call is None and task.__dict__.get("_course_entity") is None:
                call = looker._begin(task._handler, task._args or (), task)
                task._course_call = call
            try:
                run(task)
            finally:
                looker._tasks[thread] = outer
                if call and call.known.lasted is None and task.done():
                    call.end(looker._now, None, task._exception)

        for module in (rclpy.executors, executors, rclpy.action.client, rclpy.action.server):
            module.__dict__["await_or_execute"] = looked
        cls.__call__ = called
        publisher: Any = rclpy.publisher.Publisher
        publish, ours = publisher.publish, {looked.__code__, called.__code__}

        def published(end: Any, message: Any) -> None:
            publish(end, message)
            name = end.__dict__.get("_course_name")
            if name and name not in HIDDEN_TOPICS:  # the robot's ends have none
                looker._note_sent(name, message, sys._getframe(1), ours)

        publisher.publish = published

    def news(self, *, all: bool = False) -> list[Moment]:
        """Return moments that are past, or all: those of which something new is known."""
        new = []
        for (asked, _), calls in self._found.items():
            for call in calls.values() if all or asked < self._kernel.now else ():
                if self._told.get((asked, call)) is not call.known:
                    self._told[asked, call] = call.known
                    new.append(replace(call.as_moment(), asked=asked))
        return new

    @property
    def _now(self) -> int:
        return max(0, self._kernel.now)

    def _keep(self, call: _Call, asked: int) -> _Call:
        calls, place = self._found.setdefault((asked, call.known.program), {}), call.known.place
        calls.pop(key := f"{place.function}, {place.line}", None)
        calls[key] = call  # the last now
        if len(calls) > Moment.FUNCTIONS:
            del calls[next(iter(calls))]
        return call

    def _moment(self, kind: str, about: str, node: Any, place: Place, came: Any = None) -> Moment:
        program, name = getattr(self._kernel.program, "number", 0), ""
        if node is not None:
            name = sendable(executors._name_of(node))[:MAX_NAME]
        message = "" if came is None else class_name(came)
        return Moment(0, program, self._now, None, kind, about[:MAX_NAME], name, place, message,
                      parts_of(came), [], [], 0, "", "", [])  # fmt: skip

    def _begin(self, callback: Any, arguments: Any, task: Any) -> _Call | None:
        if self._now > max(self._asked):
            return None
        function, bound = _function_of(callback)
        code = function.__code__ if type(function) is FunctionType else None
        code = callback.cr_code if type(callback) is CoroutineType else code
        if code and code.co_filename.startswith(NOT_THEIRS):
            return None
        entity, node = (getattr(task, f"_course_{name}", None) for name in ("entity", "node"))
        if node is None and issubclass(type(bound), rclpy.node.Node):
            node = bound
        came: Any = arguments[0] if arguments else None
        kind = next((name for cls, name in KINDS.items() if issubclass(type(entity), cls)), "other")
        if entity is None:
            kind = "answer" if issubclass(type(came), Future) else "task"
            came = came._result if kind == "answer" else None
        about = str(getattr(entity, "__dict__", {}).get("_course_name", ""))
        place = _place_of(code, code.co_firstlineno) if code else Place(words(callback), "")
        moment = self._moment(kind, about, node, place, came)
        call = _Call(moment, lambda: values_of(_kept(node, function, bound)), came)
        for asked in self._asked:
            if moment.time <= asked:
                self._keep(call, asked)
        return call

    def _note_sent(
        self, topic: str, message: Any, frame: FrameType | None, ours: set[CodeType]
    ) -> None:
        own: list[FrameType] = []
        while frame is not None and frame.f_code not in ours:
            if host.is_beside(frame.f_code.co_filename):
                own.append(frame)
            frame = frame.f_back
        call, now = frame and frame.f_locals["call"], self._now
        if not own or not (call or now <= max(self._asked)):
            return
        shown = (message, call and call.came)
        places = [_place(each, each.f_lineno, *shown) for each in own[: Place.MOST]]
        sending = Sending(now, topic[:MAX_NAME], words(message, MESSAGE), places)
        by = f"thread {threading.current_thread().__dict__.get('_name')}"
        if call:
            by = f"{call.known.place.function}, begun at {call.known.time / 1e9:.3f} s"
            call.add(sending)
        elif by == "thread MainThread":
            by = "the main program"
        for other in {self._latest(asked, own[-1].f_code) for asked in self._asked if now <= asked}:
            if other is not call:
                other.add(replace(sending, by=sendable(by)[:MAX_NAME]))

    def _latest(self, asked: int, code: CodeType) -> _Call:
        """Return the last callback of the program that runs; where there is none, the program."""
        itself = self._moment("program", "", None, _place_of(code, code.co_firstlineno))
        call = next(reversed(self._found.get((asked, itself.program), {}).values()), None)
        if call is None or (call.known.kind == "program" and call.known.time < itself.time):
            return self._keep(_Call(itself, list), asked)
        return call


def _place_of(code: CodeType, line: int | None, values: list[Value] | None = None) -> Place:
    name, line_of = (sendable(text) for text in (code.co_name, place_of(code, line or 0)))
    return Place(name[:MAX_NAME], line_of[:MAX_NAME], values or [])


def _place(frame: FrameType, line: int | None, *but: Any) -> Place:
    """Return where a function stands, with its locals but some."""
    code, kept = frame.f_code, frame.f_locals
    is_function = code.co_flags & OPTIMIZED
    found = (each for each in kept.items() if all(each[1] is not x for x in but if x is not None))
    values = values_of(each for each in found if is_function or not str.isupper(each[0]))
    if is_function and type(kept) is dict and sys.gettrace() is None:
        kept.clear()  # a copy of Python's, which would keep the program's objects alive
    return _place_of(code, line, values)


def _function_of(callback: Any) -> tuple[Any, Any]:
    """Return the function behind a callback, and the object that it is bound to; None: neither."""
    while type(callback) is functools.partial:
        callback = callback.func
    if type(callback) is MethodType:
        return callback.__func__, callback.__self__
    if type(callback) is FunctionType:
        return callback, None
    return of_class(callback, "__call__"), callback


def _kept(node: Any, function: Any, bound: Any) -> Iterator[tuple[str, Any]]:
    """Yield what a callback can change: of its node, of its own object, and what it encloses."""
    for name, value in fields_of(node):
        if name == "_parameters" and type(value) is dict:
            for key, parameter in value.items():
                if type(key) is str and not key.startswith(EACH_HAS):
                    yield f"parameter {key}", dict(fields_of(parameter)).get("_value")
        elif name not in ROS_NAMES and not name.startswith("_course_"):
            yield name, value
    if bound is not node and is_beside(bound):
        yield from ((f"{class_name(bound)}.{name}", value) for name, value in fields_of(bound))
    if type(function) is FunctionType:
        code, outside = function.__code__, function.__globals__
        cells = zip(code.co_freevars, function.__closure__ or (), strict=True)
        yield from ((name, value) for name, cell in cells for value in _contents(cell))
        data = ((name, outside[name]) for name in code.co_names if name in outside)
        yield from (each for each in data if id(type(each[1])) in DATA and not each[0].isupper())


def _contents(cell: Any) -> list[Any]:
    try:
        return [cell.cell_contents]
    except ValueError:  # it is empty
        return []
