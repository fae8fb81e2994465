"""How long a check may compute: nothing that a node says may keep the judge from the others."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType
from typing import NoReturn

from grader.checks.verdict import Inconclusive


@contextlib.contextmanager
def cpu_limit(seconds: float) -> Iterator[None]:
    """Raise in a block that takes more CPU time of this process than a limit [s].

    Only the main thread of a POSIX system can be interrupted; elsewhere there is no limit.

    Raises Inconclusive: the block took longer; a person has to look at it.
    """
    if (
        not (hasattr(signal, "setitimer") and hasattr(signal, "SIGVTALRM"))
        or threading.current_thread() is not threading.main_thread()
    ):
        yield
        return

    def too_long(_: int, __: FrameType | None) -> NoReturn:
        raise Inconclusive(
            f"judging this took more than {seconds:.0f} s of CPU time: the nodes published, or "
            "asked their model, far more often than any node needs to; a person has to look at it"
        )

    before = signal.signal(signal.SIGVTALRM, too_long)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)
