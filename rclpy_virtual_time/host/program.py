"""Run the student's file as `__main__` and put into words how it ended."""

from __future__ import annotations

import atexit
import contextlib
import linecache
import os
import signal
import sys
import threading
import traceback
import types
from collections.abc import Callable, Collection, Iterable, Iterator
from concurrent.futures import thread as futures
from pathlib import Path

from . import advice, imports, packages, randomness
from .frames import Ended, Note, ProgramStart, Start
from .source import compiled
from .virtual import signals
from .virtual.session import Session
from .wire import steady

OURS = Path(__file__).parent
GONE = "its process ended by itself (exit code {})"
MAX_ACCOUNT, MAX_TRACE = 4_000, 12_000  # [characters]


def run(session: Session, start: Start) -> None:
    """Run the programs to their end and report it; a node that spins for ever never returns."""
    from . import asked  # noqa: PLC0415  (needs rclpy)
    from .virtual.programs import Programs  # noqa: PLC0415

    randomness.seed(start.seed)
    enter_folders(start.programs)
    advice.given.begin()
    running = lambda: getattr(session.kernel.program, "start", start.programs[0])  # noqa: E731
    asked.watch(start.programs, running, session.note)
    if len(start.programs) == 1 and start.programs[0].start == 0:
        kill = signals.install_alone(session.kernel, session.bridge.contexts)
        session.interrupt = lambda: kill(os.getpid(), signal.SIGINT)
        session.begin(start.lead)
        kind, text, detail = run_file(start.programs[0], lambda: session.ending)
        if kind == "returned" and not session.bridge.changes:
            text += Ended.NO_NODE
        session.end(kind, text, detail)
        return
    session.programs = Programs(
        session.kernel,
        start.programs,
        lambda program: _run_one_of_many(session, program),
        lambda program, status: _leave(session, program, GONE.format(status)),
    )
    session.interrupt = session.programs.interrupt
    session.programs.supervise()


def enter_folders(programs: Iterable[ProgramStart]) -> None:
    """Let modules be imported from where each program's lie, as Python and `ros2 run` do."""
    folders = [str(folder_of(program)) for program in programs]
    installed = Path("share", "ament_index").is_dir()  # as a package is, and can be imported
    imports.host.enter(dict.fromkeys([*folders, str(Path.cwd())] if installed else folders))
    packages.offer([Path.cwd() / "share", *map(Path, folders)])
    if installed:  # `get_package_share_directory` looks
        paths = (str(Path.cwd()), os.environ.get("AMENT_PREFIX_PATH", ""))
        os.environ["AMENT_PREFIX_PATH"] = os.pathsep.join(filter(None, paths))


def folder_of(program: ProgramStart) -> Path:
    """Return the folder of a program's modules: of a package, the one in which it is installed."""
    file = Path(program.file).resolve()
    module = program.entry.partition(":")[0]
    depth = module.count(".") + (file.name == "__init__.py") if module else 0
    return file.parents[depth]


def _run_one_of_many(session: Session, program: ProgramStart) -> None:
    """Run one of several programs; when it ends, the trial does, unless it is spared.

    If all have been asked to end, the last does, or the first that raises anything else.
    """
    kind, text, detail = run_file(program, lambda: session.ending)
    as_asked = kind in ("returned", "exited") or text.startswith(Ended.ASKED_TO_END)
    name = Path(program.file).name
    if session.ending and as_asked and session.programs.others():
        return
    if _leave(session, program, text, detail):
        return
    said = text if session.ending and as_asked else f"{name}: {text}"
    session.end(kind, said, detail)
    os._exit(0)


def _leave(session: Session, program: ProgramStart, text: str, detail: str = "") -> bool:
    """Leave the others of several programs alone, if they go on; return whether they do."""
    if session.ending or not program.spared or not session.programs.go_on():
        return False
    name, now = Path(program.file).name, max(0, session.kernel.now)
    if len(text) > Note.MAX_NAME:  # rcl's own words are long; place and advice stand at the end
        text = f"{text[:90]} … {text[93 - Note.MAX_NAME :]}"
    session.note(Note("ended", name, program.entry, time=now, more=text))
    trace = detail if detail.startswith("Traceback ") else detail.partition("\n\n")[2]
    print(trace, end="", file=sys.stderr)  # without the advice before it
    session.programs.leave()
    return True


def run_file(
    program: ProgramStart, ending: Callable[[], bool] = lambda: False
) -> tuple[str, str, str]:
    """Run a file as `__main__`; return how it ended: kind, text and detail.

    `ending`: it was asked to.
    """
    imports.host.hide(program.hides)
    sys.argv = [program.file, *program.arguments]
    try:
        code = compiled(program.file)
        if program.entry:
            code = compile(_starter(program.entry), "<ros2 run>", "exec", dont_inherit=True)
        for said in advice.given.slips(Path(program.file).read_bytes()):
            print(said, file=sys.stderr)
    except (SyntaxError, ValueError) as error:  # ValueError: null bytes
        return "syntax_error", _syntax_error_text(error), _detail(error, program)
    linecache.checkcache(program.file)
    main = types.ModuleType("__main__")
    main.__file__ = program.file
    sys.modules["__main__"] = main
    try:
        with _ending(ending, pools=not program.spared):
            exec(code, main.__dict__)
    except SystemExit as error:
        return "exited", f"sys.exit({'' if error.code is None else repr(error.code)})", ""
    except BaseException as error:  # students may raise anything
        if not ending():
            atexit._run_exitfuncs()
        if not program.spared:
            imports.host.leave()
        first = _first(error)
        return "exception", _exception_text(first, program), _detail(first, program)
    return "returned", "the program ran to its end", ""


def _starter(entry: str) -> str:
    """Return what pip writes for an entry point; a `main` that returns nothing ends well."""
    module, _, function = entry.partition(":")
    first, dot, rest = function.partition(".")
    return (
        f"from {module} import {first} as main\n"
        f"status = main{dot}{rest}()\n"
        "if status is not None:\n"
        "    raise SystemExit(status)\n"
    )


@contextlib.contextmanager
def _ending(asked: Callable[[], bool], *, pools: bool) -> Iterator[None]:
    """Do at the end what Python does: let pools go, wait for threads, call exit handlers.

    (After an exception Python waits for threads, too. Here one that comes before the program was
    `asked` to end is reported at once. And Python lets go the `pools` of all programs, or of none.)
    """
    ended: BaseException | None = None
    try:
        yield
    except BaseException as error:
        if not isinstance(error, SystemExit) and not asked():
            raise
        ended = error
    pools = pools or asked()
    for let_go in reversed(threading._threading_atexits if pools else ()):  # type: ignore[attr-defined]
        let_go()
    _join_threads(() if pools else futures._threads_queues)
    atexit._run_exitfuncs()
    if ended is not None:
        raise ended


def _join_threads(but: Collection[threading.Thread]) -> None:
    """Wait for the threads of this program that are not daemons, but for some."""
    own = getattr(threading.current_thread(), "_virtual", None)
    program = own.program if own else None
    for thread in threading.enumerate():
        other = getattr(thread, "_virtual", None)
        if thread is threading.current_thread() or thread.daemon or thread in but:
            continue
        if own is None or (other is not None and other.program is program):
            thread.join()


def _syntax_error_text(error: SyntaxError | ValueError) -> str:
    if isinstance(error, SyntaxError):
        where = f"line {error.lineno}" if error.lineno else "the file"
        return f"{type(error).__name__} in {where}: {error.msg}"
    return f"{type(error).__name__}: {error}"


def _exception_text(error: BaseException, program: ProgramStart) -> str:
    """Say what was raised and in which of the student's functions."""
    folder = folder_of(program)
    frames = traceback.extract_tb(error.__traceback__)
    own = [f for f in frames if Path(f.filename).is_relative_to(folder)]
    where = f" (line {own[-1].lineno}, in {own[-1].name})" if own else ""
    if own and own[-1].filename != program.file:
        where = f" ({Path(own[-1].filename).relative_to(folder).as_posix()}, {where[2:]}"
    message = _first_line(error)
    said = f"{type(error).__name__}{': ' if message else ''}{message}{where}"
    return f"{said}; {advice}" if (advice := _advice(error)) else said


def _first(error: BaseException) -> BaseException:
    try:
        return advice.given.cause(error)
    except Exception:  # the exception is the student's, and may be anything
        return error


def _advice(error: BaseException) -> str:
    try:
        return advice.given.hint(error)
    except Exception:  # the exception is the student's, and may be anything
        return ""


def _first_line(error: BaseException) -> str:
    try:
        return steady((str(error).splitlines() or [""])[0])
    except Exception:
        return "(its text could not be read)"


def _detail(error: BaseException, program: ProgramStart) -> str:
    """Return what is said of an exception, and Python's traceback after it."""
    trace = _own_traceback(error)
    try:
        told = advice.given.account(error, folder_of(program))
    except Exception:  # the exception is the student's, and may be anything
        return trace
    return f"{told[:MAX_ACCOUNT]}\n\n{trace[-MAX_TRACE:]}" if told else trace


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
