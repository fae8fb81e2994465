"""Run a function in a forked child, where it may put layers on for good."""

import errno
import os
import select
import signal
from collections.abc import Callable


def in_child(body: Callable[[], object], limit: float = 20.0) -> str:
    """Run a function in a forked child; return what it returns, as text, or how it ended."""
    said, says = os.pipe()
    pid = os.fork()
    if pid == 0:
        try:
            os.close(said)
            os.write(says, repr(body()).encode()[:60_000])
        except BaseException as error:
            os.write(says, f"{type(error).__name__}: {error}".encode()[:60_000])
        finally:
            os._exit(0)
    os.close(says)
    with os.fdopen(said, "rb") as answer:
        if not select.select([answer], [], [], limit)[0]:
            os.kill(pid, signal.SIGKILL)
        text = answer.read().decode()
    _, status = os.waitpid(pid, 0)
    return text or f"exit status {os.waitstatus_to_exitcode(status)}"


def error_of(body: Callable[[], object]) -> str:
    """Return the name of the error that a function ends with; "fine" if none."""
    try:
        body()
    except OSError as error:
        return errno.errorcode[error.errno or 0]
    return "fine"
