"""What Ctrl-C does: it shuts the contexts down, and wakes executors."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import TYPE_CHECKING, Any

from .enums import SignalHandlerOptions

if TYPE_CHECKING:
    from .context import Context
    from .wait_set import GuardCondition

contexts: list[Context] = []  # not shut down
guards: list[GuardCondition] = []  # triggered by SIGINT
_options = SignalHandlerOptions.NO
_set_handler = signal.signal  # a program may be given a virtual one ...
_main_thread = threading.main_thread  # ... and a main thread of its own
_before: dict[int, Any] = {}  # the handlers that ours took the place of


def install_signal_handlers(options: SignalHandlerOptions) -> None:
    """Handle SIGINT, SIGTERM, both or none."""
    global _options  # noqa: PLW0603  (a process has one set of handlers)
    uninstall_signal_handlers()
    _options = SignalHandlerOptions(options)
    if threading.current_thread() is not _main_thread():
        return  # Python lets only the main thread set handlers
    for number, option in (
        (signal.SIGINT, SignalHandlerOptions.SIGINT),
        (signal.SIGTERM, SignalHandlerOptions.SIGTERM),
    ):
        if _options & option:
            _before[number] = _set_handler(number, _handle)


def uninstall_signal_handlers() -> None:
    """Handle signals as before."""
    global _options  # noqa: PLW0603
    _options = SignalHandlerOptions.NO
    if threading.current_thread() is _main_thread():
        while _before:
            number, handler = _before.popitem()
            if signal.getsignal(number) is _handle:
                _set_handler(number, handler)


def get_current_signal_handlers_options() -> SignalHandlerOptions:
    """Tell which signals are handled."""
    return _options


def register_sigint_guard_condition(guard: GuardCondition) -> None:
    """Trigger a guard condition on SIGINT."""
    guards.append(guard)


def unregister_sigint_guard_condition(guard: GuardCondition) -> None:
    """Trigger a guard condition no more."""
    guards.remove(guard)


def _handle(number: int, frame: FrameType | None) -> None:
    for context in list(contexts):
        context.shutdown()
    for guard in list(guards):
        guard.trigger_guard_condition()
    handler = _before.get(number)
    if callable(handler):
        handler(number, frame)
    elif handler == signal.SIG_DFL and number != signal.SIGINT:
        uninstall_signal_handlers()
        signal.raise_signal(number)
