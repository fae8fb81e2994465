"""Several programs in one host, each as if it were a process of its own.

On a robot a server and its clients are processes. Here they are threads of one process that share
one DDS participant, because only within a participant are matching and delivery synchronous. What
Python and rclpy keep once per process (the default context, the global executor, `__main__`,
`sys.argv`, the students' own modules) changes hands whenever the kernel's baton passes from one
program to another; a program that is killed never runs again, and its nodes disappear.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import rclpy
from rclpy import utilities
from rclpy.context import Context
from rclpy.node import Node

from ..frames import ProgramStart
from ..robot_ends import ROBOT_NODE
from . import signals
from .kernel import Kernel
from .signals import Signals

GLOBAL_EXECUTOR = "__executor"  # of the module rclpy


class Program:
    """One emulated process."""

    def __init__(self, kernel: Kernel, start: ProgramStart | None = None, number: int = 0) -> None:
        self.start = start or ProgramStart("")  # without one: the host itself
        self.signals = Signals(kernel) if start else None
        self.number = number
        self.initialised = False  # rclpy.init was called
        self.shut = False  # rclpy.shutdown was called
        self.killed = False
        self.nodes: list[Any] = []
        self.argv = [self.start.file, *self.start.arguments]
        self.main: Any = sys.modules["__main__"]
        self.executor: Any = None
        self.modules: dict[str, Any] = {}  # that it has imported from the students' files
        self.exits: list[functools.partial[object]] = []  # what it has registered with atexit
        self.callbacks: list[Any] = []  # of its default context, for its shutdown


class Programs:
    """Starts and kills the programs of a trial on time."""

    def __init__(
        self,
        kernel: Kernel,
        starts: tuple[ProgramStart, ...],
        run: Callable[[ProgramStart], None],
        leaves: Callable[[ProgramStart, int], bool] = lambda *_: False,
    ) -> None:
        self._kernel = kernel
        self._programs = [Program(kernel, start, i) for i, start in enumerate(starts)]
        self._run = run
        self._leaves = leaves  # with `os._exit`, and the others go on
        self._host = Program(kernel)
        self._context: Any = Context()  # what each takes for its default one
        self._own = _modules_here()

    def supervise(self) -> None:
        """Start and kill programs, each at its time; never returns."""
        kernel = self._kernel
        self._supervisor = kernel.me()
        self._supervisor.program = kernel.program = self._host
        self._install()
        never = max(p.start.stop or 0 for p in self._programs) + 1
        plan = [(p.start.start, i, self._start, p) for i, p in enumerate(self._programs)]
        plan += [(p.start.stop or never, -1, self._kill, p) for p in self._programs if p.start.stop]
        for time, _, act, program in sorted(plan, key=lambda entry: entry[:2]):
            if time > kernel.now:
                kernel.park(time)
            act(program)
        kernel.park()

    def interrupt(self) -> None:
        """Send every program that runs SIGINT, as Ctrl-C does in their terminals."""
        for program in self._alive():
            program.shut = program.initialised
            if program.signals is not None:
                program.signals.deliver(signal.SIGINT)

    def others(self) -> bool:
        """Return whether other programs run than the calling one."""
        return any(program is not self._kernel.program for program in self._alive())

    def go_on(self) -> bool:
        """Return whether programs run, or will, that are spared as the calling program is."""
        alive = (*self._alive(), *(p for p in self._programs if p.signals and not p.signals.main))
        return any(p.start.spared and p is not self._kernel.program for p in alive)

    def leave(self) -> None:
        """End the calling program, its other threads and its nodes; the others go on."""
        program: Any = self._kernel.program
        self._supervisor.program = self._host  # it may be about to start this very program
        self._kill(program)

    def _alive(self) -> list[Program]:
        mains = ((p, p.signals.main) for p in self._programs if p.signals and not p.killed)
        return [p for p, main in mains if main is not None and main.is_alive()]

    def switch(self, before: Any, after: Any) -> None:
        """Exchange the globals of two programs."""
        if before is not None:
            before.argv, before.main = sys.argv, sys.modules["__main__"]
            before.executor = rclpy.__dict__[GLOBAL_EXECUTOR]
            before.callbacks = self._context._callbacks
            there = {name: sys.modules.pop(name, None) for name in self._own}
            before.modules = {name: module for name, module in there.items() if module is not None}
        if after is not None:
            sys.modules.update(after.modules)
            sys.argv, sys.modules["__main__"] = after.argv, after.main
            rclpy.__dict__[GLOBAL_EXECUTOR] = after.executor
            self._context._callbacks = after.callbacks

    def _start(self, program: Program) -> None:
        with self._kernel.acting_as(program):
            main = threading.Thread(
                target=self._run, args=(program.start,), daemon=True, name="MainThread"
            )
            if program.signals:
                program.signals.main = main
            main.start()

    def _kill(self, program: Program) -> None:
        self._kernel.kill(program)
        program.killed = True
        for node in program.nodes:
            with contextlib.suppress(Exception):
                node.destroy_node()

    def _install(self) -> None:
        """Give every program an rclpy of its own, all on one real context."""
        kernel = self._kernel
        cls: Any = Context
        real_init, real_ok = cls.init, cls.ok

        def init(self: Any, args: Any = None, **kwargs: Any) -> None:
            program: Any = kernel.program
            if program.initialised and not program.shut:
                raise RuntimeError("Context.init() must only be called once")
            if self.handle is None:
                real_init(self, ["host"], **kwargs)
            program.initialised, program.shut = True, False

        def ok(self: Any) -> bool:
            program: Any = kernel.program
            return program.initialised and not program.shut and bool(real_ok(self))

        def shutdown(self: Any) -> None:
            if not kernel.program.initialised:  # type: ignore[attr-defined]
                raise RuntimeError("Context must be initialized before it can be shutdown")
            kernel.program.shut = True  # type: ignore[attr-defined]
            self._call_on_shutdown_callbacks()
            kernel.epoch += 1

        def try_shutdown(self: Any) -> None:
            if kernel.program.initialised:  # type: ignore[attr-defined]
                shutdown(self)

        cls.init, cls.ok, cls.shutdown, cls.try_shutdown = init, ok, shutdown, try_shutdown
        cls.destroy = cls._remove_callback = lambda *_: None  # they would be the others', too
        utilities.Context = lambda: self._context
        signals.install(lambda: kernel.program.signals)  # type: ignore[attr-defined]
        self._install_nodes()
        self._install_exits()

    def _install_nodes(self) -> None:
        kernel = self._kernel
        cls: Any = Node
        create = cls.__init__

        def created(self: Any, node_name: str, **kwargs: Any) -> None:
            program: Any = kernel.program
            own = list(kwargs.pop("cli_args", None) or [])
            if kwargs.get("use_global_arguments", True):
                own = [*program.start.arguments, *own]
            create(self, node_name, cli_args=own or None, **kwargs)
            if node_name != ROBOT_NODE:  # ours: it outlives them all
                program.nodes.append(self)

        cls.__init__ = created

    def _install_exits(self) -> None:
        """Let each program have exit handlers, and an end, of its own."""
        kernel, module = self._kernel, cast("Any", atexit)

        def exits() -> list[functools.partial[object]]:
            return kernel.program.exits  # type: ignore[attr-defined,no-any-return]

        def register(function: Any, *args: Any, **kwargs: Any) -> Any:
            exits().append(functools.partial(function, *args, **kwargs))
            return function

        def unregister(function: Any) -> None:
            exits()[:] = [each for each in exits() if each.func != function]

        def run() -> None:
            while exits():
                try:
                    exits().pop()()
                except Exception:  # Python says so, too, and goes on
                    traceback.print_exc()

        def leave(status: int) -> None:
            program: Any = kernel.program
            if program is not self._host and self._leaves(program.start, status):
                kernel.park()
            end(status)

        end, cast("Any", os)._exit = os._exit, leave
        module.register, module.unregister, module._run_exitfuncs = register, unregister, run


def _modules_here() -> list[str]:
    """Return the names of the modules that lie in the working folder, and of their packages."""
    files = [path.relative_to(Path.cwd()).with_suffix("") for path in Path.cwd().rglob("*.py")]
    paths = {each for file in files for each in (file, *file.parents)}
    names = {".".join(path.parts).removesuffix(".__init__") for path in paths}
    return sorted(name for name in names if name and name not in sys.modules)
