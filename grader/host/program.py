"""Run the student's file as `__main__` and put into words how it ended."""

from __future__ import annotations

import linecache
import os
import random
import sys
import threading
import traceback
import types
from pathlib import Path

from . import libraries
from .frames import ProgramStart, Start
from .virtual.session import Session

OURS = Path(__file__).parent


def run(session: Session, start: Start) -> None:
    """Run the programs to their end and report it; a node that spins for ever never returns."""
    random.seed(start.seed)
    sys.path.insert(0, str(Path(start.programs[0].file).resolve().parent))
    if len(start.programs) == 1 and start.programs[0].start == 0:
        session.begin(start.lead)
        session.end(*run_file(start.programs[0]))
        return
    from .virtual.programs import Programs  # noqa: PLC0415  (needs rclpy)

    session.programs = Programs(
        session.kernel, start.programs, lambda program: _run_one_of_many(session, program)
    )
    session.programs.supervise()


def _run_one_of_many(session: Session, program: ProgramStart) -> None:
    """Run one of several programs; when it ends, the trial does."""
    kind, text, detail = run_file(program)
    session.end(kind, f"{Path(program.file).name}: {text}", detail)
    os._exit(0)


def run_file(program: ProgramStart) -> tuple[str, str, str]:
    """Run a file as `__main__`; return how it ended: kind, text and detail."""
    libraries.hide(program.hides)
    sys.argv = [program.file, *program.arguments]
    try:
        code = compile(Path(program.file).read_bytes(), program.file, "exec")
    except (SyntaxError, ValueError) as error:  # ValueError: null bytes
        return "syntax_error", _syntax_error_text(error), _own_traceback(error)
    linecache.checkcache(program.file)
    main = types.ModuleType("__main__")
    main.__file__ = program.file
    sys.modules["__main__"] = main
    try:
        exec(code, main.__dict__)
        _join_threads()
    except SystemExit as error:
        return "exited", f"sys.exit({'' if error.code is None else repr(error.code)})", ""
    except BaseException as error:  # students may raise anything
        return "exception", _exception_text(error, program.file), _own_traceback(error)
    return "returned", "the program ran to its end", ""


def join_threads() -> None:
    """Wait for the threads of the file that are not daemons, in real time, as Python does."""
    for thread in threading.enumerate():
        if thread is not threading.current_thread() and not thread.daemon:
            thread.join()


def _join_threads() -> None:
    """Python itself waits at exit for the threads of a program that are not daemons."""
    own = getattr(threading.current_thread(), "_virtual", None)
    program = own.program if own else None
    for thread in threading.enumerate():
        other = getattr(thread, "_virtual", None)
        if other is None or other is own or other.program is not program or thread.daemon:
            continue
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
    try:
        report = traceback.TracebackException.from_exception(error)
        _forget_our_frames(report)
        return "".join(report.format())
    except Exception:
        return f"{type(error).__name__} (its traceback could not be formatted)"


def _forget_our_frames(report: traceback.TracebackException) -> None:
    report.stack[:] = [frame for frame in report.stack if Path(frame.filename).parent != OURS]
    for other in (report.__cause__, report.__context__, *(report.exceptions or ())):
        if other is not None:
            _forget_our_frames(other)
