"""What a lesson's page runs in the browser's Python: drive a node, judge recordings, show them.

`begin` warms up. Then the page keeps an image of the memory, and each call of the other functions
begins in a fresh copy of it: of a trial nothing is left but its recording, a file, and the judge
never shares a process with the node. They take and return JSON, because nothing else outlives a
copy. The recordings are pickled: they are the reader's own, in the reader's own browser.
"""

from __future__ import annotations

import json
import pickle
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grader.grading.grading import Grading
    from grader.link.in_process import InProcess
    from grader.recording import Recording

PATIENCE = 3600.0  # [s] of a trial: whether to wait is the reader's choice
MESSAGES = ("numpy.random", "numpy.linalg", "numpy.fft")  # a node's first use would load them


class Runtime:
    """One warm process.

    `recordings` is a folder that outlives its copies; `reached` is told the time [s] in a trial,
    twice in a second or less often.
    """

    def __init__(self, recordings: Path, reached: Callable[[float], object]) -> None:
        self._recordings = recordings
        self._reached = reached
        self._launcher: InProcess

    def begin(self) -> None:
        """Import all that a trial, a judge or a replay needs; put virtual time under Python."""
        from grader.host import imports

        imports.host.watch()
        import _time_machine

        import rclpy_portable

        rclpy_portable.activate()
        from rclpy_portable.native import machine

        machine.use_clock(_time_machine.original_time_ns)
        if not hasattr(time, "thread_time"):  # Emscripten has one thread
            time.thread_time, time.thread_time_ns = time.process_time, time.process_time_ns
        import pytest  # noqa: F401

        import grader.grading.causes
        import grader.grading.grading
        import grader.report.page
        import grader.trial.virtual_time  # noqa: F401
        from grader.link.in_process import InProcess
        from sim.messages import EPOCH_NS, typestore

        for name in MESSAGES:
            __import__(name)
        typestore()
        self._launcher = InProcess(EPOCH_NS, self._reached)

    def trial(self, order: str) -> str:
        """Run a trial and keep its recording under the name of its scenario; say how it ended.

        The order names the `file`, the `scenario`, the other files of its exercise (`others`),
        perhaps a `seed` and a `lead` [ns], and whether to `interrupt`. `{"lead": …}` in the answer:
        the same again in a fresh copy, with this lead.
        """
        from grader.course.submission import find_submission
        from grader.link.in_process import StartEarlier
        from grader.trial.seeds import mixed_seed
        from grader.trial.virtual_time import Limits, run_trial
        from sim.scenario_files import load_scenario

        wanted = json.loads(order)
        scenario = load_scenario(wanted["scenario"])
        try:
            recording = run_trial(
                find_submission(Path(wanted["file"]), others=wanted["others"]),
                scenario,
                self._launcher,
                seed=mixed_seed(scenario.seed, wanted.get("seed")),
                limits=Limits(total=PATIENCE),
                interrupt=wanted.get("interrupt", False),
                lead=wanted.get("lead", 0),
            )
        except StartEarlier as early:
            return json.dumps({"lead": early.lead})
        self._place(scenario.name).write_bytes(pickle.dumps(recording))
        outcome = recording.outcome
        return json.dumps({"kind": outcome.kind, "text": outcome.text, "at": outcome.at})

    def judge(self, order: str) -> str:
        """Judge the recordings of `scenarios`: return the JSON object of the grading.

        The order names the `exercise`, the `file`, and perhaps the checks to judge (`only`).
        """
        wanted = json.loads(order)
        return json.dumps(self._grading(wanted).as_dict(), default=str)

    def replay(self, order: str) -> str:
        """Return the page with the replays of `scenarios`, for a frame.

        With `checks`, objects of a grading, it opens at the moment of the first that failed.
        """
        from grader.report.page import embedded_payload, page_html

        wanted = json.loads(order)
        shown = self._load(wanted["scenarios"])
        return page_html(embedded_payload(wanted.get("checks", ()), shown, wanted["title"]))

    def _grading(self, wanted: dict[str, Any]) -> Grading:
        from grader.course.exercises import find_exercise
        from grader.grading.grading import grade
        from grader.trial.trials import SavedTrials

        return grade(
            find_exercise(wanted["exercise"]),
            SavedTrials(self._load(wanted["scenarios"])),
            file=wanted["file"],
            only=wanted.get("only", ()),
            isolation=self._launcher.isolation,
            practice=self._launcher.practice,
        )

    def _load(self, scenarios: Sequence[str]) -> list[Recording]:
        return [pickle.loads(self._place(name).read_bytes()) for name in scenarios]

    def _place(self, scenario: str) -> Path:
        return self._recordings / f"{scenario}.pickle"


def warm(recordings: str, reached: Callable[[float], object] = lambda _: None) -> Runtime:
    """Return a runtime that has begun."""
    sys.path.append(str(Path(__file__).parent / "stand_ins" / "gaps"))
    runtime = Runtime(Path(recordings), reached)
    runtime.begin()
    return runtime
