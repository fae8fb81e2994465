"""Signals that programs send themselves reach their main thread at a moment of virtual time.

`install_alone` is for the only program of a process, `install` for several: each has a main thread
and handlers of its own. Python runs handlers in the main thread of the process, and lets nobody
else set one. On a robot every program is a process, so `signal.signal`, `asyncio`'s loops and who
else asks for the main thread must find the program's own.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any

from .kernel import Kernel


class Signals:
    """The handlers of one program, and the thread in which they run."""

    def __init__(self, kernel: Kernel) -> None:
        self._kernel = kernel
        self._handlers: dict[int, Any] = {signal.SIGINT: signal.default_int_handler}
        self.main: threading.Thread | None = None  # once it has started

    def handler(self, number: int) -> Any:
        """Return a signal's handler."""
        return self._handlers.get(number, signal.SIG_DFL)

    def handle(self, number: int, handler: Any) -> Any:
        """Set a signal's handler; return the handler before."""
        if threading.current_thread() is not self.main:
            raise ValueError("signal only works in main thread of the main interpreter")
        before = self.handler(number)
        self._handlers[number] = handler
        return before

    def deliver(self, number: int) -> None:
        """Run the handler in the main thread, which goes on with what it did unless it raises."""
        handler = self.handler(number)
        main: Any = self.main
        if callable(handler):
            self._kernel.interrupt(main._virtual, lambda: handler(number, sys._getframe()))
        elif handler == signal.SIG_DFL and number not in (signal.SIGCHLD, signal.SIGURG):
            os._exit(128 + number)  # as the shell tells of a process that a signal has ended


def install(current: Callable[[], Signals | None]) -> None:
    """Ask the program that runs, where Python would ask the process; None: the host itself."""
    module: Any = signal
    set_handler, get_handler, wakeup = module.signal, module.getsignal, module.set_wakeup_fd
    real_main, real_kill, real_raise = threading.main_thread, os.kill, module.raise_signal

    def main_thread() -> threading.Thread:
        program = current()
        return real_main() if program is None or program.main is None else program.main

    def virtual_signal(number: int, handler: Any) -> Any:
        program = current()
        return set_handler(number, handler) if program is None else program.handle(number, handler)

    def getsignal(number: int) -> Any:
        program = current()
        return get_handler(number) if program is None else program.handler(number)

    def set_wakeup_fd(fd: int, **options: Any) -> int:
        return int(wakeup(fd, **options)) if current() is None else -1

    def kill(pid: int, number: int) -> None:
        program = current()
        if program is None or pid != os.getpid():
            real_kill(pid, number)
        elif number:
            program.deliver(number)

    def raise_signal(number: int) -> None:
        program = current()
        if program is None:
            real_raise(number)
        else:
            program.deliver(number)

    module.signal, module.getsignal, module.set_wakeup_fd = virtual_signal, getsignal, set_wakeup_fd
    module.raise_signal, os.kill = raise_signal, kill
    threading.main_thread = main_thread


def install_alone(
    kernel: Kernel, contexts: Callable[[], list[Any]] = list
) -> Callable[[int, int], None]:
    """Deliver what the only program sends itself; its main thread is the calling one.

    `contexts` are rclpy's, which it shuts down. Returns what takes the place of `os.kill`.

    The system would deliver it to the main thread wherever that waits, also while another thread
    holds the baton.
    """
    module: Any = signal
    main = kernel.me()
    real_kill = os.kill

    def deliver(number: int) -> bool:
        handler, stops = signal.getsignal(number), _is_rclpys(number)
        if not callable(handler) and not stops:
            return False

        def handle() -> None:
            if stops:
                default = sys.modules["rclpy.utilities"].get_default_context()
                for context in dict.fromkeys((*contexts(), default)):
                    _shut_down(context)
            _wake_up_loop(number)
            if callable(handler):
                handler(number, sys._getframe())

        kernel.interrupt(main, handle)
        return True

    def kill(pid: int, number: int) -> None:
        if pid != os.getpid() or not number or not deliver(number):
            real_kill(pid, number)

    os.kill = kill
    module.raise_signal = lambda number: kill(os.getpid(), number)
    return kill


def _shut_down(context: Any) -> None:
    """Shut a context down as rclpy does on a signal: in C, so no on_shutdown callback is called."""
    if hasattr(context, "_cleanup"):  # Kilted's, whose nodes stay until it calls shutdown()
        context._cleanup = context.handle.shutdown
        context.try_shutdown()
        context._cleanup = lambda: _end_nodes(context)
    else:
        context._callbacks, context._logging_initialized = [], False
        context.try_shutdown()


def _end_nodes(context: Any) -> None:
    """Clean up as Kilted's shutdown() does after a signal, which leaves nothing to do in C."""
    handle, context._Context__context = context.handle, None
    type(context)._cleanup(context)
    context._Context__context = handle


def _wake_up_loop(number: int) -> None:
    """Let asyncio know, whose `add_signal_handler` reads signals from a pipe."""
    descriptor = signal.set_wakeup_fd(-1)
    if descriptor >= 0:
        signal.set_wakeup_fd(descriptor)
        os.write(descriptor, bytes([number]))


def _is_rclpys(number: int) -> bool:
    """Return whether rclpy handles a signal: it shuts down, and passes the signal on."""
    rclpy: Any = sys.modules.get("rclpy.signals")
    if rclpy is None or number not in (signal.SIGINT, signal.SIGTERM):
        return False
    options = rclpy.SignalHandlerOptions
    own = options.SIGINT if number == signal.SIGINT else options.SIGTERM
    return rclpy.get_current_signal_handlers_options() in (options.ALL, own)
