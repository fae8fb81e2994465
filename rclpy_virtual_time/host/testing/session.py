"""Run one test of pytest's in this process, in virtual time, and hand back its reports.

The test is the user's own, as is the machine: it gets the environment of the pytest that runs it,
and no sandbox.
"""

from __future__ import annotations

import contextlib
import faulthandler
import functools
import json
import os
import signal
import sys
import traceback
from collections.abc import Iterator
from io import StringIO
from typing import Any

import pytest
import rclpy.node
from _pytest._io import TerminalWriter
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.qos import DurabilityPolicy

from .. import randomness
from ..frames import Ended, Reported, RunTest
from ..virtual import discovery, executors
from ..virtual.kernel import Kernel
from ..wire import Wire, ended
from .alone import Alone, StandIn
from .world import VirtualTime

NAME = "course-host"  # of the plug-in below; the one outside asks for it
HISTORY = 100_000_000  # [ns] of real time in which DDS hands over what was latched
FROM_THE_USER = ("PATH", "HOME", "TMPDIR", "LANG")  # else the fork server's settings go first


def warm_up() -> None:
    """Load pytest with the plug-ins that are installed: most of what a test costs."""
    with contextlib.suppress(Exception):
        pytest.main(["--collect-only", "-p", "no:terminal", "-p", "no:cacheprovider", os.devnull])


def serve(kernel: Kernel, epoch: int, read_fd: int, write_fd: int) -> None:
    """Run the test that the first frame names, and end the process."""
    faulthandler.register(signal.SIGUSR1, file=os.dup(2), all_threads=True)  # pytest captures 2
    wire = Wire(read_fd, write_fd)
    order = wire.receive()
    if not isinstance(order, RunTest):
        raise ValueError("the first frame must say which test to run")
    _move_in(order)
    kernel.world = alone = Alone(kernel, order.limit, _complain)
    alone.clocks = executors.install(kernel, epoch, StandIn())
    executors.refuse_real_time(_complain)
    _await_history()
    randomness.seed(order.seed)
    _hide_our_frames()
    try:
        _run(order, Inside(wire, alone))
        last = ended("returned", "")
    except BaseException as error:  # of conftest.py files, say
        last = ended("exception", f"{type(error).__name__}: {error}", traceback.format_exc())
    wire.send(last)
    os._exit(0)


class Inside:
    """The plug-in of pytest that the host's session has."""

    def __init__(self, wire: Wire, alone: Alone) -> None:
        self._wire = wire
        self._alone = alone

    @pytest.fixture
    def virtual_time(self) -> Iterator[VirtualTime]:
        """Run this test in virtual time: `with virtual_time() as world:`."""
        yield VirtualTime(self._alone)

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Hand a report on."""
        self._send(report)

    def pytest_collectreport(self, report: Any) -> None:
        """Say why the test could not be collected here."""
        if report.failed:
            self._wire.send(Ended(0, "exception", "", str(report.longrepr)[-10_000:], []))
            os._exit(0)

    def pytest_configure(self, config: Any) -> None:
        """Keep the configuration, whose hooks know how to write a report down."""
        self._config = config
        nowhere = TerminalWriter(StringIO())  # for plug-ins that don't ask whether there is one
        config.get_terminal_writer = lambda: nowhere

    def pytest_warning_recorded(self, warning_message: Any, when: str) -> None:
        """Hand a warning of the test on."""
        of = warning_message
        said = {"category": of.category.__name__, "text": str(of.message)}
        if when == "runtest":
            self._wire.send(Reported(json.dumps(said | {"place": (of.filename, of.lineno)})))

    def _send(self, report: Any) -> None:
        hook = self._config.hook
        data = hook.pytest_report_to_serializable(config=self._config, report=report)
        self._wire.send(Reported(json.dumps(data, default=str)))


def _await_history() -> None:
    """Let a subscription have what was latched before it: DDS brings it, in a thread, later."""
    cls: Any = rclpy.node.Node
    create = cls.create_subscription

    @functools.wraps(create)
    def create_subscription(self: Any, *args: Any, **kwargs: Any) -> Any:
        made = create(self, *args, **kwargs)
        latched = made.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        if latched and discovery.sent[made.topic_name] and not discovery.PORTABLE:
            with self.context.handle, made.handle:
                ready = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, self.context.handle)
                with ready:
                    ready.clear_entities()
                    ready.add_subscription(made.handle)
                    ready.wait(HISTORY)
        return made

    cls.create_subscription = create_subscription


def _run(order: RunTest, plugin: Inside) -> None:
    config = pytest.Config.fromdictargs(order.options, [order.test])
    config.workerinput = order.worker  # type: ignore[attr-defined]  # as pytest-xdist's: no reports
    config.workeroutput = {}  # type: ignore[attr-defined]  # pytest-cov leaves notes there
    config.pluginmanager.register(plugin, NAME)
    config.hook.pytest_cmdline_main(config=config)


def _move_in(order: RunTest) -> None:
    os.chdir(order.folder)
    for name, value in order.environment.items():
        if name not in os.environ or name in FROM_THE_USER:
            os.environ[name] = value
    sys.path += [path for path in order.path if path not in sys.path]


def _hide_our_frames() -> None:
    """Leave this package out of the tracebacks that pytest shows: it asks a module's globals."""
    for name, module in sys.modules.items():
        if name.startswith("rclpy_virtual_time.host."):
            module.__dict__["__tracebackhide__"] = True


def _complain(text: str) -> None:
    pytest.fail(text)
