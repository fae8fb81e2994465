"""Run tests in virtual time: each in a process of its own, forked from a warm one.

Virtual time replaces the locks and clocks of a process for good, so it can't come over the process
in which pytest runs. The host runs pytest on that one test, with all its fixtures, and its reports
come back as if the test had run here.
"""

import builtins
import json
import os
import re
import select
import sys
import warnings
from socket import gethostname
from typing import Any, Literal

import pytest

from rclpy_virtual_time.host.frames import Ended, Reported, RunTest, decode_from_test, encode
from rclpy_virtual_time.host.kinds import TESTS
from rclpy_virtual_time.link.errors import EngineError
from rclpy_virtual_time.link.exchange import HostDied, HostForged, HostHung, decoded, status_text
from rclpy_virtual_time.link.foreign import readable
from rclpy_virtual_time.link.host_process import HostProcess
from rclpy_virtual_time.link.hosts import ForkServer
from rclpy_virtual_time.link.pipes import Channel
from rclpy_virtual_time.link.real_clock import real_clock
from rclpy_virtual_time.link.ros_environment import RosEnvironment
from rclpy_virtual_time.link.scratch import fresh_folder
from rclpy_virtual_time.link.settings import EPOCH

LIMIT = 60.0  # [s] of virtual time
OTHERS_LIMIT = 3600.0  # [s] of it, for tests that did not ask for it: they may sleep for long
PATIENCE = 120.0  # [s] of real time
START = 10.0  # [s] to send the order
GRACE = 1.0  # [s] for the end of a process that has hung up
UNUSED = ("terminal", "cacheprovider", "junitxml", "pastebin")  # reports are of pytest outside
IMPORTED_EARLY = "ignore::pytest.PytestAssertRewriteWarning"  # plug-ins that the host itself uses
CHANGED: dict[str, Any] = {  # pytest-xdist's workers are outside, too, and so is the debugger
    "numprocesses": None,
    "maxprocesses": None,
    "dist": "no",
    "tx": [],
    "usepdb": False,
    "virtual_time": False,
    "virtual_time_portable": False,
}


OF_PYTEST = re.compile(r'  File "(.*/(_pytest|pluggy|rclpy_virtual_time/host)/|<)')


class TestHosts:
    """The process from which hosts for tests are forked; it starts with the first."""

    __test__ = False

    def __init__(self, *, portable: bool = False) -> None:
        self._portable = portable
        self._forkserver: ForkServer | None = None

    def run(self, item: pytest.Item) -> None:
        """Run a test and report on it."""
        hook = item.ihook
        hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for report in self._reports(item):
            hook.pytest_runtest_logreport(report=report)
        hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)

    def close(self) -> None:
        """End the process."""
        if self._forkserver is not None:
            self._forkserver.__exit__()

    def _reports(self, item: pytest.Item) -> list[pytest.TestReport]:
        try:
            order, patience = _order(item)
            if self._forkserver is None:
                ros = RosEnvironment.portable() if self._portable else RosEnvironment.find()
                self._forkserver = ForkServer(EPOCH, ros, kind=TESTS, layers=())
            with fresh_folder() as folder, self._forkserver.host_process(folder) as host:
                return _TestLink(host, item).conduct(order, patience)
        except EngineError as error:
            return [_failure(item, f"virtual_time: {error}")]


class _TestLink(Channel):
    """Frames from a host that runs one test."""

    def __init__(self, host: HostProcess, item: pytest.Item) -> None:
        super().__init__(host)
        self._item = item
        self._reports: list[pytest.TestReport] = []

    def conduct(self, order: RunTest, patience: float) -> list[pytest.TestReport]:
        """Run the test to its end; a report says so if it has none."""
        try:
            problem = self._wait(order, patience)
        except HostHung:
            stacks = "\n".join(filter(_is_theirs, self.stacks().splitlines()))
            problem = (
                f"the test still runs after {patience:g} s of real time: it computes, or waits in "
                "native code (os.read, a socket), where time is real; `patience=` of "
                f"@pytest.mark.virtual_time gives it more\n\n{stacks}"
            )
        except HostDied:
            problem = f"the test's process ended by itself ({status_text(self._host.wait(GRACE))})"
        except HostForged as error:
            problem = f"the test's process said what it can't: {error}"
        said = self.log()
        if self._item.config.getoption("capture", "fd") == "no":
            sys.stdout.write(readable("".join(f"{line.text}\n" for line in said)))
        if problem or not self._reports or self._reports[-1].when != "teardown":
            ended = "pytest ended in the test's own process, but the test did not"
            text = problem or "\n".join([ended, *(line.text for line in said)])
            self._reports.append(_failure(self._item, text))
        return self._reports

    def _wait(self, order: RunTest, patience: float) -> str:
        """Take reports until the test is over; return what went wrong."""
        since = real_clock.perf_counter()
        deadline = since + patience
        self._write(encode(order), real_clock.perf_counter() + START)
        ready = select.poll()
        for fd in (self._host.link_in, self._host.stdout, self._host.stderr):
            ready.register(fd, select.POLLIN)
        while True:
            while (body := self._take_frame()) is not None:
                match decoded(body, decode_from_test):
                    case Reported(text) if "category" in (data := _readable(json.loads(text))):
                        _warn(self._item, data)
                    case Reported(_):
                        self._reports.append(_report(self._item, data))
                        since, began = real_clock.perf_counter(), since
                        self._reports[-1].duration = since - began
                    case Ended() as end:
                        return (end.detail or end.text) if end.kind != "returned" else ""
            remaining = deadline - real_clock.perf_counter()
            if remaining <= 0:
                raise HostHung("")
            for fd, event in ready.poll(remaining * 1e3):
                if fd == self._host.link_in:
                    self._read(fd)
                elif event & select.POLLIN:
                    self._drain(fd)
                else:
                    ready.unregister(fd)


def _order(item: pytest.Item) -> tuple[RunTest, float]:
    """Return what the host is to do, and how long that may take [s]."""
    config = item.config
    asked = "virtual_time" in getattr(item, "fixturenames", ())
    limit, patience = LIMIT if asked else OTHERS_LIMIT, PATIENCE
    if (mark := item.get_closest_marker("virtual_time")) is not None:
        try:
            limit, patience = _seconds(*mark.args, **mark.kwargs)
        except TypeError as error:
            raise EngineError(f"@pytest.mark.virtual_time(limit=…, patience=…): {error}") from None
    options = {k: v for k, v in vars(config.option).items() if _plain(v)} | CHANGED
    options["plugins"] = [*options.get("plugins", []), *(f"no:{name}" for name in UNUSED)]
    options["pythonwarnings"] = [*(options.get("pythonwarnings") or []), IMPORTED_EARLY]
    options["rootdir"] = str(config.rootpath)
    options["inifilename"] = str(config.inipath) if config.inipath else None
    options["basetemp"] = _base_of_temporary_folders(config)
    options.pop("file_or_dir", None)
    _, _, within = item.nodeid.partition("::")
    worker = getattr(config, "workerinput", {"workerid": "virtual_time", "workercount": 1})
    measured = {"cov_master_host": gethostname(), "cov_master_topdir": os.getcwd()}  # noqa: PTH109
    order = RunTest(
        test=f"{item.path}::{within}",
        options=options,
        worker=measured | {name: value for name, value in worker.items() if _plain(value)},
        folder=os.getcwd(),  # noqa: PTH109
        environment=dict(os.environ),
        path=tuple(sys.path),
        limit=round(limit * 1e9),
    )
    return order, patience


def _base_of_temporary_folders(config: pytest.Config) -> str | None:
    """Return a folder inside this session's own, which is kept and removed with it.

    Without one the host's session would look through what all others have left in /tmp, and fail
    where it can't remove that.
    """
    factory = getattr(config, "_tmp_path_factory", None)
    if factory is None:  # pytest runs without its plug-in for temporary folders
        return None
    return str(factory.mktemp("virtual_time"))


def _seconds(limit: float = LIMIT, patience: float = PATIENCE) -> tuple[float, float]:
    for name, value in (("limit", limit), ("patience", patience)):
        if not 0 < value < 1e9:
            raise EngineError(f"@pytest.mark.virtual_time({name}={value}): expected seconds")
    return limit, patience


def _plain(value: object) -> bool:
    """Return whether a value can be sent: text, numbers, and lists and dicts of them."""
    if isinstance(value, list | tuple):
        return all(map(_plain, value))
    if isinstance(value, dict):
        return all(isinstance(key, str) and _plain(entry) for key, entry in value.items())
    return value is None or isinstance(value, str | int | float)


def _report(item: pytest.Item, data: dict[str, Any]) -> pytest.TestReport:
    hook = item.config.hook
    report: pytest.TestReport = hook.pytest_report_from_serializable(config=item.config, data=data)
    report.nodeid = item.nodeid
    if isinstance(report.longrepr, list):  # JSON has no tuples
        report.longrepr = tuple(report.longrepr)
    report.sections = [(heading, said) for heading, said in report.sections]
    report.user_properties = [(name, value) for name, value in report.user_properties]
    return report


def _warn(item: pytest.Item, data: dict[str, Any]) -> None:
    name = data["category"]
    kind: Any = getattr(builtins, name, None) or getattr(pytest, name, UserWarning)
    message = warnings.WarningMessage(kind(data["text"]), kind, *data["place"])
    said = {"warning_message": message, "when": "runtest", "nodeid": item.nodeid, "location": None}
    item.ihook.pytest_warning_recorded.call_historic(kwargs=said)


def _readable(data: Any) -> Any:
    """Return what JSON holds, with all its text readable."""
    if isinstance(data, dict):
        return {_readable(key): _readable(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_readable(each) for each in data]
    return readable(data) if isinstance(data, str) else data


def _failure(item: pytest.Item, text: str) -> pytest.TestReport:
    keywords: dict[str, Literal[1]] = dict.fromkeys(item.keywords, 1)
    return pytest.TestReport(item.nodeid, item.location, keywords, "failed", readable(text), "call")


def _is_theirs(line: str) -> bool:
    """Return whether a line of a stack is not of what runs the test."""
    return not OF_PYTEST.match(line)
