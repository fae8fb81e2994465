"""Run tests and write how each ended. A host runs this file, and so does plain Python.

    python run_tests.py rclpy FOLDER/test_timer.py
    python run_tests.py cpython test.test_queue

One JSON line for each test goes to `results.jsonl` in the working folder when it starts, and one
when it ends: a test that hangs or kills its process can be told from what comes after it. What the
file holds already is not run again.
"""

import json
import os
import sys
import unittest
from collections.abc import Iterator
from pathlib import Path
from typing import Any

RESULTS = Path("results.jsonl")
STARTED, PASSED, FAILED, SKIPPED = "started", "passed", "failed", "skipped"
LEFT_OUT = (  # in names of tests
    "ProcessPool",  # a host starts no processes
    "ForkInThread",
    "after_fork",
    "settime",  # sets the machine's clock
)
TEXT = 600  # [characters] of why a test failed


class Results:
    """The file of results."""

    def __init__(self) -> None:
        lines = RESULTS.read_text("utf-8").splitlines() if RESULTS.exists() else []
        self.known = {json.loads(line)["test"] for line in lines}
        self._fd = os.open(RESULTS, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)

    def write(self, test: str, outcome: str, text: str = "") -> None:
        """Add a line."""
        line = json.dumps({"test": test, "outcome": outcome, "text": text[-TEXT:]})
        os.write(self._fd, f"{line}\n".encode())


class PytestPlugin:
    """Tells of pytest's tests."""

    def __init__(self, results: Results) -> None:
        self._results = results
        self._worst = (PASSED, "")

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        """Leave out what has been run."""
        items[:] = [item for item in items if item.nodeid not in self._results.known]

    def pytest_collectreport(self, report: Any) -> None:
        """Write that a module can't be imported."""
        if report.failed and report.nodeid not in self._results.known:
            self._results.write(report.nodeid, FAILED, str(report.longrepr))

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """Write that a test starts."""
        self._worst = (PASSED, "")
        self._results.write(nodeid, STARTED)

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note how the set-up, the call or the tear-down of a test ended."""
        if report.failed:
            self._worst = (FAILED, str(report.longrepr))
        elif report.skipped and self._worst[0] == PASSED:
            self._worst = (SKIPPED, str(report.longrepr))

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        """Write how a test ended."""
        self._results.write(nodeid, *self._worst)


class UnittestResult(unittest.TestResult):
    """Tells of unittest's tests."""

    def __init__(self, results: Results) -> None:
        super().__init__()
        self._results = results
        self._worst = (PASSED, "")

    def startTest(self, test: unittest.TestCase) -> None:  # noqa: N802
        super().startTest(test)
        self._worst = (PASSED, "")
        self._results.write(test.id(), STARTED)

    def stopTest(self, test: unittest.TestCase) -> None:  # noqa: N802
        self._results.write(test.id(), *self._worst)
        super().stopTest(test)

    def _failed(self, test: unittest.TestCase, error: Any) -> None:
        self._worst = (FAILED, self._exc_info_to_string(error, test))  # type: ignore[attr-defined]
        if not isinstance(test, unittest.TestCase):  # setUpClass or setUpModule
            self._results.write(test.id(), *self._worst)

    def addError(self, test: unittest.TestCase, err: Any) -> None:  # noqa: N802
        self._failed(test, err)

    def addFailure(self, test: unittest.TestCase, err: Any) -> None:  # noqa: N802
        self._failed(test, err)

    def addSubTest(self, test: Any, subtest: Any, err: Any) -> None:  # noqa: N802
        if err is not None:
            self._failed(test, err)

    def addUnexpectedSuccess(self, test: unittest.TestCase) -> None:  # noqa: N802
        self._worst = (FAILED, "unexpected success")

    def addSkip(self, test: unittest.TestCase, reason: str) -> None:  # noqa: N802
        if self._worst[0] == PASSED:
            self._worst = (SKIPPED, reason)
        if not isinstance(test, unittest.TestCase):
            self._results.write(test.id(), *self._worst)


def run_pytest(target: str, results: Results) -> None:
    """Run a file of tests that need pytest."""
    import pytest  # noqa: PLC0415  (plain unittests do without)

    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"  # the tests bring what they need
    Path("pytest.ini").write_text("[pytest]\n", "utf-8")  # this folder is the root
    options = ["-q", "-s", "-c", "pytest.ini", "--confcutdir=."]
    options += ["-p", "no:cacheprovider", "-p", "no:faulthandler", "-p", "no:hypothesispytest"]
    pytest.main([*options, target], plugins=[PytestPlugin(results)])


def run_unittest(target: str, results: Results) -> None:
    """Run a module of CPython's tests."""
    from test import support  # noqa: PLC0415

    support.use_resources = []  # no network, nothing that takes minutes
    support.verbose = False
    try:
        found = unittest.defaultTestLoader.loadTestsFromName(target)
    except unittest.SkipTest as skipped:  # the whole module, which is for another system
        results.write(target, SKIPPED, str(skipped))
        return
    suite = unittest.TestSuite(
        test
        for test in _flat(found)
        if test.id() not in results.known and not any(part in test.id() for part in LEFT_OUT)
    )
    suite.run(UnittestResult(results))


def _flat(suite: Any) -> Iterator[Any]:
    for test in suite:
        if isinstance(test, unittest.TestSuite):
            yield from _flat(test)
        else:
            yield test


if __name__ == "__main__":
    {"rclpy": run_pytest, "cpython": run_unittest}[sys.argv[1]](sys.argv[2], Results())
