"""The plug-in that pytest loads where the course is installed: fixtures, and what failures say.

`drive` runs a node in the mock robot. A test that asks for `virtual_time` runs, as a whole, in
another process (see `grader.testing.virtual_time`). Nothing is started before a test asks, and
little is imported: every run of pytest loads this.
"""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from grader.testing.drives import Drive, Drives
    from grader.testing.virtual_time import TestHosts

PROCESSES = "course-processes"
HOST = "course-host"  # the plug-in of a pytest that runs in virtual time already
FIXTURE = MARK = "virtual_time"
REPLAYS = Path(".course", "replays")
MARKER = (
    "virtual_time(limit=60.0, patience=120.0): run this test in virtual time, as the fixture does. "
    "limit: virtual seconds that it may take; patience: seconds of real time."
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option `--replays`."""
    parser.getgroup("course", "ROS 2 nodes in virtual time").addoption(
        "--replays",
        metavar="DIR",
        help="where the replays of failed drives go; default: .course/replays beside the rootdir",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Offer the fixtures, unless this is a host that runs one test in virtual time."""
    config.addinivalue_line("markers", MARKER)
    if not config.pluginmanager.has_plugin(HOST):
        config.pluginmanager.register(Processes(config), PROCESSES)


@pytest.fixture(scope="module")
def drive(request: pytest.FixtureRequest) -> Drive:
    """Run a node in the mock robot: `run = drive("my_agent.py", scenario="avoid_wall")`."""
    processes: Processes | None = request.config.pluginmanager.get_plugin(PROCESSES)
    if processes is None:
        pytest.fail("drive has a time of its own: use it without virtual_time", pytrace=False)
    return processes.drives_in(request.path.parent)


@pytest.fixture
def virtual_time() -> None:
    """Run this test in virtual time: `with virtual_time() as world:`."""
    pytest.fail("virtual_time is for tests that pytest itself runs", pytrace=False)


class Processes:
    """The processes behind the fixtures; they start when a test first asks."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._drives: Drives | None = None
        self._hosts: TestHosts | None = None

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(
        self, item: pytest.Item, nextitem: pytest.Item | None
    ) -> bool | None:
        """Run a test that wants virtual time in a process of its own."""
        if self._drives is not None:
            self._drives.begin()
        if FIXTURE not in getattr(item, "fixturenames", ()) and not item.get_closest_marker(MARK):
            return None
        from grader.link.choice import why_not_linux  # noqa: PLC0415

        if reason := why_not_linux():
            item.add_marker(pytest.mark.skip(reason=f"virtual_time needs the real rclpy: {reason}"))
            return None
        if self._hosts is None:
            from grader.testing.virtual_time import TestHosts  # noqa: PLC0415

            self._hosts = TestHosts()
        self._hosts.run(item)
        item.session._setupstate.teardown_exact(nextitem)  # of fixtures that this module's had
        return True

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Keep the replays of a failed test, and say where."""
        report = yield
        if self._drives is not None and report.failed:
            from grader.testing.drives import make_readable  # noqa: PLC0415

            report.sections += self._drives.explain(item, self._replays())
            make_readable(report)
        return report

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Say what drives on the portable runtime are not."""
        if self._drives is not None and self._drives.practice:
            terminalreporter.write_line(f"drive: {self._drives.practice}", yellow=True)

    def pytest_unconfigure(self) -> None:
        """End the processes."""
        for processes in (self._drives, self._hosts):
            if processes is not None:
                processes.close()

    def drives_in(self, folder: Path) -> Drive:
        """Return the fixture `drive` for tests in a folder."""
        if self._drives is None:
            from grader.testing.drives import Drives  # noqa: PLC0415

            self._drives = Drives()
        return self._drives.for_folder(folder)

    def _replays(self) -> Path:
        chosen: str | None = self._config.getoption("replays")
        if chosen:
            return self._config.invocation_params.dir / chosen
        return self._config.rootpath / REPLAYS
