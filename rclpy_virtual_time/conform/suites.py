"""Run the modules of a suite of tests in both places; say how each test ended."""

import importlib.util
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from rclpy_virtual_time.conform import places, run_tests
from rclpy_virtual_time.conform.places import Ran
from rclpy_virtual_time.host.frames import ProgramStart
from rclpy_virtual_time.host.sandbox import layers
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.hosts import ForkServer

RUNNER = Path(run_tests.__file__)
VIRTUAL_SILENCE = 300.0  # [s] without progress, after which a test in a host is said to hang
ATTEMPTS = 3  # at tests that fail in plain Python: real time fails by chance
CPYTHON = (  # modules of the package `test`
    "test_threading", "test_threading_local", "test_thread", "test_queue", "test_sched",
    "test_time", "test_timeit", "test_datetime", "test_context", "test_asyncio",
    "test_concurrent_futures",
)  # fmt: skip
SERVERS = "their servers block in native code, where virtual time does not reach"
LEFT_OUT = {  # of test_asyncio
    **dict.fromkeys(
        ("test_events", "test_sendfile", "test_server", "test_sock_lowlevel", "test_ssl",
         "test_sslproto", "test_streams", "test_unix_events"), SERVERS,
    ),
    "test_subprocess": "a host starts no processes",
}  # fmt: skip
# Asyncio's tests open sockets as they are imported, and many others start a Python of their own.
# Nothing less: as root, CPython's tests would set the machine's clock.
LAYERS = {
    "rclpy": layers.LAYERS,
    "cpython": (layers.LIMITS, layers.USER, layers.MOUNTS, layers.NETWORK),
}

Place = Callable[[Path, str, str, Callable[[], int]], Ran]


@dataclass
class Outcomes:
    """How each test of a module ended, in one place."""

    outcomes: dict[str, str] = field(default_factory=dict)  # by test
    texts: dict[str, str] = field(default_factory=dict)  # why it failed or was skipped


def rclpy_modules(checkout: Path) -> list[str]:
    """Return the modules of rclpy's tests.

    Raises EngineError: it is no checkout of rclpy.
    """
    modules = sorted((checkout / "rclpy" / "test").glob("test_*.py"))
    if not modules:
        raise EngineError(f"{checkout}: expected a checkout of ros2/rclpy, with rclpy/test in it")
    return [f"test/{module.name}" for module in modules]


def cpython_modules() -> list[str]:
    """Return those modules of CPython's tests that this interpreter brings."""
    if importlib.util.find_spec("test.support") is None:
        raise EngineError(f"{sys.executable} comes without CPython's tests (the package `test`)")
    found: list[str] = []
    for name in CPYTHON:
        spec = importlib.util.find_spec(f"test.{name}")
        if spec is None:
            continue
        folders = spec.submodule_search_locations or []
        parts = sorted(path.stem for folder in folders for path in Path(folder).glob("test_*.py"))
        parts = [part for part in parts if part not in LEFT_OUT]
        found += [f"test.{name}.{part}" for part in parts] or [f"test.{name}"]
    return found


def check_unprivileged(forkserver: ForkServer) -> None:
    """Make sure that hosts are not root.

    Raises EngineError: they would be.
    """
    if os.getuid() == 0 and layers.USER not in forkserver.layers:
        raise EngineError("tests that are not ours would run as root; run this as another user")


def run_module(
    suite: str, module: str, forkserver: ForkServer, checkout: Path | None
) -> tuple[Outcomes, Outcomes]:
    """Run a module in plain Python and inside a host."""

    def plain(folder: Path, suite: str, module: str, progress: Callable[[], int]) -> Ran:
        command = [str(folder / RUNNER.name), suite, module]
        return places.run_plain(forkserver, folder, command, progress)

    def inside(folder: Path, suite: str, module: str, progress: Callable[[], int]) -> Ran:
        program = ProgramStart(str(folder / RUNNER.name), (suite, module))
        return places.run_inside(forkserver, folder, program, VIRTUAL_SILENCE, progress)

    real = _run(plain, suite, module, checkout)
    for _ in range(ATTEMPTS - 1):
        failed = {test for test, outcome in real.outcomes.items() if outcome not in GOOD}
        if not failed:
            break
        again = _run(plain, suite, module, checkout)
        for test in failed & again.outcomes.keys():
            real.outcomes[test] = again.outcomes[test]
    return real, _run(inside, suite, module, checkout)


GOOD = (run_tests.PASSED, run_tests.SKIPPED)


def _run(place: Place, suite: str, module: str, checkout: Path | None) -> Outcomes:
    """Run a module, anew after each test that hangs or ends the process."""
    with tempfile.TemporaryDirectory(prefix="conform-") as name:
        folder = Path(name)
        shutil.copy(RUNNER, folder)
        if checkout is not None:
            shutil.copytree(checkout / "rclpy" / "test", folder / "test")
            (folder / "test" / "__init__.py").write_text("")  # it looks for a build of rclpy
        results = folder / run_tests.RESULTS

        def progress() -> int:
            return results.stat().st_size if results.exists() else 0

        while True:
            before = progress()
            ran = place(folder, suite, module, progress)
            found = _read(results)
            unfinished = [t for t, o in found.outcomes.items() if o == run_tests.STARTED]
            if not unfinished or progress() == before:
                break
            with results.open("a") as lines:
                for test in unfinished:
                    line = {"test": test, "outcome": ran.kind, "text": f"{ran.text} {ran.said}"}
                    lines.write(json.dumps(line) + "\n")
        found = _read(results)
        if not found.outcomes:
            found.outcomes[module] = ran.kind
            found.texts[module] = f"{ran.text} {ran.said}"[-run_tests.TEXT :]
        return found


def _read(results: Path) -> Outcomes:
    outcomes = Outcomes()
    for line in _lines(results):
        outcomes.outcomes[line["test"]] = line["outcome"]
        outcomes.texts[line["test"]] = line["text"]
    return outcomes


def _lines(results: Path) -> Iterator[dict[str, str]]:
    if results.exists():
        for line in results.read_text("utf-8").splitlines():
            yield json.loads(line)
