"""The plug-in that pytest loads where the engine is installed: the fixture `virtual_time`.

A test that asks for it runs, as a whole, in another process (see `virtual_time.py` beside this
file). Nothing is started before a test asks, and little is imported: every run of pytest loads
this.
"""

from typing import TYPE_CHECKING

import pytest

from rclpy_virtual_time.host import packages

if TYPE_CHECKING:
    from rclpy_virtual_time.testing.virtual_time import TestHosts

PROCESSES = "virtual-time-processes"
HOST = "course-host"  # the plug-in of a pytest that runs in virtual time already
FIXTURE = MARK = "virtual_time"
MARKER = (
    "virtual_time(limit=60.0, patience=120.0): run this test in virtual time, as the fixture does. "
    "limit: virtual seconds that it may take; patience: seconds of real time."
)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options for whole runs."""
    group = parser.getgroup("virtual time", "ROS 2 nodes in virtual time")
    group.addoption("--virtual-time", action="store_true", help="run every test in virtual time")
    group.addoption(
        "--virtual-time-portable",
        action="store_true",
        help="take the portable rclpy for tests in virtual time, also without ROS 2",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Offer the fixture, unless this is a host that runs one test in virtual time."""
    config.addinivalue_line("markers", MARKER)
    here = config.rootpath  # a package's folder, or the workspace
    packages.offer((here, here / "src", *([here.parent] * (here / "package.xml").is_file())))
    if config.pluginmanager.has_plugin(HOST):
        return
    portable = config.getoption("virtual_time_portable")
    if portable:
        import rclpy_portable  # noqa: PLC0415

        rclpy_portable.activate()  # for modules of tests, which import rclpy when collected
    every = config.getoption("virtual_time")
    config.pluginmanager.register(Processes(every=every, portable=portable), PROCESSES)


@pytest.fixture
def virtual_time() -> None:
    """Run this test in virtual time: `with virtual_time() as world:`."""
    pytest.fail("virtual_time is for tests that pytest itself runs", pytrace=False)


class Processes:
    """The process behind the fixture; it starts when a test first asks."""

    def __init__(self, *, every: bool, portable: bool) -> None:
        self._every, self._portable = every, portable
        self._hosts: TestHosts | None = None

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(
        self, item: pytest.Item, nextitem: pytest.Item | None
    ) -> bool | None:
        """Run a test that wants virtual time in a process of its own."""
        if not self._wanted(item):
            return None
        from rclpy_virtual_time.link.practice import PracticeServer  # noqa: PLC0415

        if reason := PracticeServer.why_needed(portable=self._portable):
            item.add_marker(pytest.mark.skip(reason=f"virtual_time needs the real rclpy: {reason}"))
            return None
        if self._hosts is None:
            from rclpy_virtual_time.testing.virtual_time import TestHosts  # noqa: PLC0415

            self._hosts = TestHosts(portable=self._portable)
        self._hosts.run(item)
        item.session._setupstate.teardown_exact(nextitem)  # of fixtures that this module's had
        return True

    @pytest.hookimpl(optionalhook=True, tryfirst=True)
    def pytest_timeout_set_timer(self, item: pytest.Item) -> bool | None:
        """Leave pytest-timeout's timer to the test's process, where its seconds are virtual."""
        return self._wanted(item) or None

    def _wanted(self, item: pytest.Item) -> bool:
        asked = FIXTURE in getattr(item, "fixturenames", ()) or item.get_closest_marker(MARK)
        return self._every or bool(asked)

    def pytest_unconfigure(self) -> None:
        """End the process."""
        if self._hosts is not None:
            self._hosts.close()
