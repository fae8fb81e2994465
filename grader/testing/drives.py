"""The fixture `drive`: nodes in the mock robot, and what a failed test says of them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from grader.course.submission import find_submission
from grader.drive import drive_node, scenario_for
from grader.errors import GraderError, InputError
from grader.launchers import start_launcher
from grader.testing.run import Run, write_replays
from grader.trial.staging import parameter_arguments
from rclpy_virtual_time import PracticeServer, readable
from sim.scenario import Scenario

if TYPE_CHECKING:
    from rclpy_virtual_time import ForkServer

LONGEST = 150  # [characters] of a replay's file name

Section = tuple[str, str]  # of pytest's report: heading, text


class Drive:
    """What the fixture gives to the tests of one folder."""

    def __init__(self, drives: Drives, folder: Path) -> None:
        self._drives = drives
        self._folder = folder

    def __call__(
        self,
        file: str | Path,
        *,
        scenario: str | Path,
        seed: int | None = None,
        lidar: str | None = None,
        duration: float | None = None,
        goals: Sequence[tuple[float, float]] = (),
        parameters: Mapping[str, str | bool | int | float] | None = None,
        stamped: bool = False,
    ) -> Run:
        """Run a node in a scenario, in virtual time, and return what happened.

        Parameters
        ----------
        file
            The node's program; a relative path begins at the test's folder.
        scenario
            A scenario of the course by its name, or a TOML file by its path (ends in `.toml`).
        seed
            Varies the noise, and the layout within the scenario's bounds.
        lidar
            Another profile: default, lds01, lds02 or wide.
        duration
            Another duration [s].
        goals
            (x, y) [m] to send on /goal_pose in place of the scenario's own.
        parameters
            ROS parameters by name.
        stamped
            The robot takes TwistStamped on /cmd_vel, too.
        """
        __tracebackhide__ = True
        try:
            chosen = self._scenario(scenario, lidar, duration, goals)
            others = [spec.file for spec in chosen.program if spec.file and not spec.supplied]
            recording = drive_node(
                find_submission(self._folder / file, others=others),
                chosen,
                self._drives.launcher,
                seed=seed,
                arguments=parameter_arguments(parameters or {}),
                stamped=stamped,
            )
        except (InputError, GraderError) as error:
            problem = str(error).removeprefix("--")  # `--duration`, as on a command line
        else:
            run = Run(recording, str(file))
            self._drives.runs.append(run)
            return run
        pytest.fail(readable(f"drive: {problem}"))

    def _scenario(
        self,
        scenario: str | Path,
        lidar: str | None,
        duration: float | None,
        goals: Sequence[tuple[float, float]],
    ) -> Scenario:
        if isinstance(scenario, Path) or scenario.endswith(".toml"):
            scenario = str(self._folder / scenario)
        return scenario_for(scenario, lidar=lidar, duration=duration, goals=goals)


class Drives:
    """The drives of one run of pytest; they share a warm process, which starts with the first."""

    def __init__(self) -> None:
        self.runs: list[Run] = []  # of the present test
        self._launcher: ForkServer | PracticeServer | None = None

    @property
    def launcher(self) -> ForkServer | PracticeServer:
        """The process that runs the nodes."""
        if self._launcher is None:
            self._launcher = start_launcher()
        return self._launcher

    @property
    def practice(self) -> str:
        """Why these drives are for practice only; "" if they aren't."""
        return "" if self._launcher is None else self._launcher.practice

    def for_folder(self, folder: Path) -> Drive:
        """Return the fixture for tests in a folder."""
        return Drive(self, folder)

    def begin(self) -> None:
        """Forget the runs of the test before."""
        self.runs = []

    def explain(self, item: pytest.Item, folder: Path) -> list[Section]:
        """Write the replay of a failed test's runs; return what the failure says of them."""
        given = getattr(item, "funcargs", {}).values()  # a fixture may have driven for more tests
        runs = [*self.runs, *(v for v in given if isinstance(v, Run) and v not in self.runs)]
        if not runs:
            return []
        said = [line for run in runs for line in run.summary()]
        try:
            path = _place(folder, item)
            write_replays(path, runs, f"{item.name} failed")
            said.append(f"Replay: {path}")
        except OSError as error:
            said.append(f"No replay: {error.filename or folder}: {error.strerror}")
        return [("what the robot did", "\n".join(said))]

    def close(self) -> None:
        """End the process."""
        if self._launcher is not None:
            self._launcher.__exit__()


def make_readable(report: pytest.TestReport) -> None:
    """Let a failure say nothing but text to a terminal: it may quote a node's log or exception."""
    report.sections = [(heading, readable(text)) for heading, text in report.sections]
    for traceback, crash, _ in getattr(report.longrepr, "chain", ()):
        for entry in traceback.reprentries:
            entry.lines = [readable(line) for line in entry.lines]
        if crash is not None:
            crash.message = readable(crash.message)


def _place(folder: Path, item: pytest.Item) -> Path:
    """Return where a test's replay belongs; git leaves a folder of ours alone."""
    if not folder.exists():
        folder.mkdir(parents=True)
        ours = folder.parent if folder.parent.name == ".course" else folder
        (ours / ".gitignore").write_text("*\n", "utf-8")
    name = f"{item.path.stem}-{item.nodeid.partition('::')[2]}"
    return folder / f"{re.sub(r'[^A-Za-z0-9_.=-]+', '_', name)[:LONGEST].strip('_')}.html"
