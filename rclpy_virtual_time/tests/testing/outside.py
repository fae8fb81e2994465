"""Run pytest as a student does: in a folder outside the checkout, in a process of its own."""

import os
import subprocess
import sys
import textwrap
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from pathlib import Path

PLAIN = ["-p", "no:hypothesispytest"]  # half a second for what no such test uses
PATIENCE = 300  # [s], for a busy machine


@dataclass
class Result:
    """What pytest said of one test."""

    outcome: str  # passed, failed, error, skipped
    text: str = ""  # of the failure
    properties: dict[str, str] = field(default_factory=dict)


@dataclass
class Session:
    """What a run of pytest said."""

    code: int
    output: str
    tests: dict[str, Result]  # by "file.test_name"

    def outcomes(self) -> dict[str, str]:
        return {name: result.outcome for name, result in self.tests.items()}


def write(folder: Path, **files: str) -> None:
    """Write Python files: by name, their lines."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / f"{name}.py").write_text(textwrap.dedent(text), "utf-8")


def pytest_in(folder: Path, *arguments: str) -> Session:
    """Run pytest there, with warnings as errors; nothing of this run's settings reaches it."""
    results = folder / "results.xml"
    temporary = folder.with_name(f"{folder.name}-temporary")  # not what others left in /tmp
    env = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST_", "PYTHONPATH"))}
    written = [f"--junitxml={results}", "-o", "junit_family=xunit1"]  # which knows properties
    command = [sys.executable, "-m", "pytest", "-W", "error", *PLAIN, *written, *arguments]
    command.append(f"--basetemp={temporary}")
    done = subprocess.run(
        command, cwd=folder, env=env, text=True, timeout=PATIENCE, check=False,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    cases = ET.parse(results).getroot().iter("testcase") if results.exists() else ()
    tests = {f"{c.get('classname')}.{c.get('name')}".lstrip("."): _result(c) for c in cases}
    return Session(done.returncode, done.stdout, tests)


def _result(case: ET.Element) -> Result:
    properties = {p.get("name", ""): p.get("value", "") for p in case.iter("property")}
    for tag, outcome in (("error", "error"), ("failure", "failed"), ("skipped", "skipped")):
        if (found := case.find(tag)) is not None:
            return Result(outcome, f"{found.get('message')}\n{found.text}", properties)
    return Result("passed", "", properties)
