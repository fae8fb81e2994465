"""Run the student's file as `__main__` and put into words how it ended."""

from __future__ import annotations

import linecache
import random
import sys
import threading
import traceback
import types
from pathlib import Path

from .frames import Start
from .session import Session


def run(session: Session, start: Start) -> None:
    """Run the file to its end and report that end; a node that spins for ever never returns."""
    random.seed(start.seed)
    sys.argv = [start.file, *start.arguments]
    sys.path.insert(0, str(Path(start.file).resolve().parent))
    try:
        source = Path(start.file).read_bytes()
        code = compile(source, start.file, "exec")
    except (SyntaxError, ValueError) as error:  # ValueError: null bytes
        session.end("syntax_error", _syntax_error_text(error), _own_traceback(error))
        return
    linecache.checkcache(start.file)
    main = types.ModuleType("__main__")
    main.__file__ = start.file
    sys.modules["__main__"] = main
    try:
        exec(code, main.__dict__)
        _join_threads()
    except SystemExit as error:
        session.end("exited", f"sys.exit({'' if error.code is None else repr(error.code)})")
    except BaseException as error:  # students may raise anything
        session.end("exception", _exception_text(error, start.file), _own_traceback(error))
    else:
        session.end("returned", "the program ran to its end")


def _join_threads() -> None:
    """Python itself waits at exit for threads that are not daemons."""
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and not thread.daemon:
            thread.join()


def _syntax_error_text(error: SyntaxError | ValueError) -> str:
    if isinstance(error, SyntaxError):
        where = f"line {error.lineno}" if error.lineno else "the file"
        return f"{type(error).__name__} in {where}: {error.msg}"
    return f"{type(error).__name__}: {error}"


def _exception_text(error: BaseException, file: str) -> str:
    """Say what was raised and in which of the student's functions."""
    own = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == file]
    where = f" (line {own[-1].lineno}, in {own[-1].name})" if own else ""
    message = _first_line(error)
    return f"{type(error).__name__}{': ' if message else ''}{message}{where}"


def _first_line(error: BaseException) -> str:
    try:
        return (str(error).splitlines() or [""])[0]
    except Exception:
        return "(its text could not be read)"


def _own_traceback(error: BaseException) -> str:
    """Format the traceback without the frames of this package."""
    tb = error.__traceback__
    while tb is not None and tb.tb_frame.f_globals.get("__package__") == __package__:
        tb = tb.tb_next
    try:
        return "".join(traceback.format_exception(type(error), error, tb))
    except Exception:
        return f"{type(error).__name__} (its traceback could not be formatted)"
