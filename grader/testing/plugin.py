"""The plug-in that pytest loads where the course is installed: `drive`, and what failures say.

`drive` runs a node in the mock robot. (The fixture `virtual_time` is the engine's.) Nothing is
started before a test asks, and little is imported: every run of pytest loads this.
"""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from grader.testing.drives import Drive, Drives

PROCESSES = "course-processes"
HOST = "course-host"  # the plug-in of a pytest that runs in virtual time already
REPLAYS = Path(".course", "replays")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option `--replays`."""
    parser.getgroup("course", "ROS 2 nodes in virtual time").addoption(
        "--replays",
        metavar="DIR",
        help="where the replays of failed drives go; default: .course/replays beside the rootdir",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Offer the fixture, unless this is a host that runs one test in virtual time."""
    if not config.pluginmanager.has_plugin(HOST):
        config.pluginmanager.register(Processes(config), PROCESSES)


@pytest.fixture(scope="module")
def drive(request: pytest.FixtureRequest) -> Drive:
    """Run a node in the mock robot: `run = drive("my_agent.py", scenario="avoid_wall")`."""
    processes: Processes | None = request.config.pluginmanager.get_plugin(PROCESSES)
    if processes is None:
        pytest.fail("drive has a time of its own: use it without virtual_time", pytrace=False)
    return processes.drives_in(request.path.parent)


class Processes:
    """The process behind the fixture; it starts when a test first asks."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._drives: Drives | None = None

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self) -> None:
        """Forget the runs of the test before."""
        if self._drives is not None:
            self._drives.begin()

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
        """End the process."""
        if self._drives is not None:
            self._drives.close()

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
