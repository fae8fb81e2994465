"""The kernel's end of its judge process: start it, send it orders, end it."""

import atexit
import contextlib
import os
import select
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import msgspec

from grader.course.exercises import ROOT
from grader.errors import GraderError
from grader.notebook.orders import Answer, Order, Progressed, Warm
from grader.notebook.show import BEAT
from rclpy_virtual_time import sweep

GRACE = 4.0  # [s] for an interrupted judge to end the nodes and exit
CHUNK = 1 << 16  # [bytes]
MODULE = "grader.notebook.judge"


class _EndedBefore(GraderError):
    """The judge ended before it answered anything."""


class Judge:
    """A kernel's judge process. It starts when first needed, and again if it has ended."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._log: IO[bytes] | None = None
        self._rest = b""  # read, but not a whole line yet
        self._lock = threading.Lock()
        atexit.register(self.end)

    def warm(self, libraries: tuple[str, ...] = ()) -> None:
        """Let the judge get ready in the background."""
        if not self._lock.acquire(blocking=False):
            return  # it is working, so it is warm
        try:
            self._tell(Warm(libraries))
        finally:
            self._lock.release()

    def ask(
        self,
        order: Order,
        on_progress: Callable[[Progressed], None],
        beat: Callable[[], None] = lambda: None,
    ) -> Answer:
        """Send an order and wait for the answer; meanwhile `beat` is called every `BEAT` seconds.

        An interrupt (the kernel's stop button) ends the judge and the nodes with it.

        Raises GraderError: the judge died.
        """
        with self._lock:
            was_idle = self._process is not None
            try:
                try:
                    return self._ask(order, on_progress, beat)
                except _EndedBefore:
                    if not was_idle:
                        raise
                    self.end()  # something ended it while it was idle: a new one can answer
                    return self._ask(order, on_progress, beat)
            except BaseException:
                self.end()
                raise

    def end(self) -> None:
        """End the judge and its nodes, if it runs."""
        process, self._process = self._process, None
        if process is None:
            return
        with contextlib.suppress(OSError):
            process.send_signal(signal.SIGINT)
        for pipe in (process.stdin, process.stdout):
            with contextlib.suppress(OSError):
                pipe.close()  # type: ignore[union-attr]
        try:
            process.wait(GRACE)
        except (subprocess.TimeoutExpired, KeyboardInterrupt):
            process.kill()
            process.wait()
        if self._log is not None:
            self._log.close()
        sweep()  # remove what it had no time to

    @property
    def pid(self) -> int | None:
        """The process's id, if it runs."""
        return None if self._process is None else self._process.pid

    def _ask(
        self, order: Order, on_progress: Callable[[Progressed], None], beat: Callable[[], None]
    ) -> Answer:
        self._tell(order)
        answer = self._next(beat)
        while isinstance(answer, Progressed):
            on_progress(answer)
            try:
                answer = self._next(beat)
            except _EndedBefore as error:
                raise GraderError(str(error)) from None  # a second judge might end there, too
        return answer

    def _tell(self, order: Order) -> None:
        if self._process is not None and self._process.poll() is not None:
            self.end()  # it died between two orders
        if self._process is None:
            self._start()
        assert self._process is not None and self._process.stdin is not None
        try:
            self._process.stdin.write(msgspec.json.encode(order) + b"\n")
            self._process.stdin.flush()
        except OSError as error:
            raise _EndedBefore(f"the judge has ended: {self._last_words()}") from error

    def _start(self) -> None:
        self._log = tempfile.TemporaryFile()  # noqa: SIM115  (closed in `end`)
        self._rest = b""
        self._process = subprocess.Popen(
            command(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            cwd="/",
            env=environment(),
            start_new_session=True,  # the stop button is for the kernel, which tells the judge
        )

    def _next(self, beat: Callable[[], None]) -> Answer:
        assert self._process is not None and self._process.stdout is not None
        source = self._process.stdout.fileno()
        while b"\n" not in self._rest:
            beat()
            if not select.select([source], [], [], BEAT)[0]:
                continue
            data = os.read(source, CHUNK)
            if not data:
                raise _EndedBefore(f"the judge has ended: {self._last_words()}")
            self._rest += data
        line, _, self._rest = self._rest.partition(b"\n")
        answer: Answer = msgspec.json.decode(line, type=Answer)
        return answer

    def _last_words(self) -> str:
        if self._log is None:
            return "it said nothing"
        self._log.seek(0)
        lines = self._log.read().decode("utf-8", "replace").strip().splitlines()
        return lines[-1] if lines else "it said nothing"


def command() -> list[str]:
    """Return the command line of the judge: this kernel's Python, and this kernel's course.

    The notebook's folder is not on its path: a file `random.py` there would hide Python's.
    """
    here = ("", str(Path.cwd()))
    paths = [path for path in sys.path if path not in here]
    boot = (
        f"import sys; sys.path[:0] = [{str(ROOT)!r}]; "
        f"sys.path += [path for path in {paths!r} if path not in sys.path]; "
        f"import runpy; runpy.run_module({MODULE!r}, run_name='__main__')"
    )
    return [sys.executable, "-P", "-c", boot]


def environment() -> dict[str, str]:
    """Return the environment for processes that the kernel starts."""
    strange = ("MPLBACKEND", "PYTHONSTARTUP", "IPYTHONDIR", "JPY_PARENT_PID", "FORCE_COLOR")
    kept = {name: value for name, value in os.environ.items() if name not in strange}
    return {
        **kept,
        "COLUMNS": "100",
        "TERM": "dumb",
        "PYTHONIOENCODING": "utf-8",
        # ROS wheels' start-up hook would execute Python a second time
        "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1",
    }


def _judge() -> Any:
    if sys.platform != "emscripten":
        return Judge()
    from grader.notebook import page  # noqa: PLC0415  (in a browser there are no processes)

    return page.Judge()


JUDGE: Judge = _judge()
