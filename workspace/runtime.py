"""What a lesson's page runs in the browser's Python: drive a node, judge recordings, show them.

`begin` warms up. Then the page keeps an image of the memory, and each call of the other functions
begins in a fresh copy of it: of a trial nothing is left but its recording, a file, and the judge
never shares a process with the node. They take and return JSON, because nothing else outlives a
copy. The recordings are pickled: they are the reader's own, in the reader's own browser.
"""

from __future__ import annotations

import _thread
import contextlib
import io
import json
import math
import os
import pickle
import shlex
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator
from functools import partial
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

from workspace.stacks import Browser, Gate, Stacks

if TYPE_CHECKING:
    from grader.course.submission import Submission
    from grader.grading.grading import Grading
    from grader.recording import Recording
    from rclpy_virtual_time.link.in_process import InProcess
    from workspace.knobs import Knobs

Lines = list[tuple[float, str, int]]  # [s] of each message, and from which file and line it came

MOMENT = 1e-6  # [s]
WAY = (  # to a node
    "/native/endpoints.py", "/rclpy/publisher.py", "/virtual/discovery.py", "/host/look.py",
)  # fmt: skip
PATIENCE = 3600.0  # [s] of a trial: whether to wait is the reader's choice
BESIDE = "the replay stands beside this text; the installed course writes files"
NO_FILES = "there are no files here but the node; take the installed course"
REFUSED = {  # options of `course drive`, and what a page says of them
    "--report": BESIDE,
    "--bag": BESIDE,
    "--params-file": f"{NO_FILES}, or --param",
    "--stdin": NO_FILES,
    "--keys": "there is no terminal here; take the installed course",
    "--portable": "here it is the portable runtime already",
    "--charge-compute": "no CPU time can be measured here; take the installed course",
}
MESSAGES = ("numpy.random", "numpy.linalg", "numpy.fft")  # a node's first use would load them


class Runtime:
    """One warm process.

    `recordings` is a folder that outlives its copies; `reached` is told the time [s] in a trial,
    twice in a second or less often. Without a `browser` nodes can start no threads.
    """

    def __init__(
        self, recordings: Path, reached: Callable[[float], object], browser: Browser | None
    ) -> None:
        self._recordings = recordings
        self._read_before = recordings / "read.pickle"  # what a launch file starts
        self._reached = reached
        self._stacks = Stacks(browser) if browser else None
        self._launcher: InProcess
        self._files: frozenset[str] = frozenset()  # the names of the reader's
        self._lines: Lines = []
        self._knobs: Knobs

    def begin(self) -> None:
        """Import all that a trial, a judge or a replay needs; put virtual time under Python."""
        from rclpy_virtual_time.host import imports

        imports.host.watch()
        if self._stacks:
            self._stacks.install()
            from rclpy_virtual_time.host.virtual import kernel

            kernel.real_allocate_lock = partial(Gate, self._stacks)  # type: ignore[assignment]
        else:
            for name in ("_start_new_thread", "_start_joinable_thread"):  # the latter from 3.13 on
                setattr(threading, name, _no_thread)
            _thread.start_new_thread = _no_thread
        import _time_machine

        import rclpy_portable

        rclpy_portable.activate()
        from rclpy_portable.native import machine

        machine.use_clock(_time_machine.original_time_ns)
        if not hasattr(time, "thread_time"):  # Emscripten has one thread
            time.thread_time, time.thread_time_ns = time.process_time, time.process_time_ns
        import pytest  # noqa: F401

        import grader.cli
        import grader.drive
        import grader.grading.causes.find
        import grader.grading.grading
        import grader.report.page
        import grader.trial.virtual_time  # noqa: F401
        from grader.launchers import ADVICE, HOSTED
        from grader.report.terminal import Console
        from rclpy_virtual_time import Link
        from rclpy_virtual_time.link.in_process import InProcess
        from sim.messages import EPOCH_NS, typestore
        from workspace.knobs import Knobs

        Console(file=io.StringIO()).print("[bold]…[/]")  # what it imports at the first line
        for name in MESSAGES:
            __import__(name)
        typestore()
        self._launcher = InProcess(EPOCH_NS, self._reached, self._stacks, ADVICE,
                                   (*HOSTED, Link.Moment.LIBRARY))  # fmt: skip
        self._knobs = Knobs(lambda: self._launcher.now)  # before what looks at its callers
        self._note_lines()

    def _note_lines(self) -> None:
        """Note with each message of a node which line of its callback led to it."""
        from rclpy_portable.native.endpoints import Publisher

        send = Publisher.publish_raw

        def noted(publisher: Any, data: bytes) -> None:
            frame: FrameType | None = sys._getframe(1)
            while frame is not None and frame.f_code.co_filename.endswith(WAY):
                frame = frame.f_back
            file, line = _callback_line(frame, self._files)
            if line:
                self._lines.append((self._launcher.now, file, line))
            send(publisher, data)

        Publisher.publish_raw = noted  # type: ignore[method-assign]

    def thread(self, number: int) -> None:
        """Do what a new stack is for (see `Browser.begin`)."""
        assert self._stacks
        self._stacks.run_body(number)

    def trial(self, order: str) -> str:
        """Run a trial and keep its recording under the name of its scenario; say how it ended.

        The order names the `file`, the `scenario`, all files of its exercise (`others`),
        perhaps a `seed` and a `lead` [ns], whether to `interrupt`, and whether to `tell`: to do as
        `course drive` does, and say what that prints; and what a person does meanwhile, `deeds`
        (`grader.drive.by_hand`): the file of the scenario with them is kept, too. With moments to
        `look` into [s] the answer has their `tables`, of a `callback` if one is named. Of an
        `exercise` it is printed whether the least is kept that it asks for in any world.
        `{"lead": …}` in the answer: the same again in a fresh copy, with this lead and what has
        been kept.
        """
        from grader.drive import scenario_for, tables_of
        from grader.trial.seeds import mixed_seed, trial_seed
        from grader.trial.virtual_time import Limits, run_trial
        from rclpy_virtual_time.link.in_process import StartEarlier
        from sim.errors import InputError
        from sim.scenario_files import load_scenario

        wanted = json.loads(order)
        tells, seed = wanted.get("tell", False), wanted.get("seed")
        try:
            scenario = (scenario_for if tells else load_scenario)(self._scenario(wanted))
        except InputError as error:  # in one's own
            return json.dumps({"printed": f"Nothing was driven: {error}"})
        self._files = frozenset(wanted["others"])
        submission = self._read(Path(wanted["file"]), wanted["others"])
        if submission is None:
            return json.dumps({"lead": 0})
        try:
            recording = run_trial(
                submission,
                scenario,
                self._launcher,
                seed=mixed_seed(scenario, seed) if tells else trial_seed(scenario, seed),
                limits=Limits(total=PATIENCE),
                stamped=tells,
                interrupt=wanted.get("interrupt", False),
                lead=wanted.get("lead", 0),
                look=wanted.get("look", ()),
            )
        except StartEarlier as early:
            return json.dumps({"lead": early.lead})
        told = {}
        if "look" in wanted:
            told["tables"] = tables_of(recording, wanted["look"], wanted.get("callback", ""))
        elif tells:
            told = {"printed": _summary(recording, submission), "hand": self._knobs.of(recording)}
            if "exercise" in wanted:
                told["printed"] += _least(recording, wanted["exercise"])
        return json.dumps({**told, **self._kept(recording)})

    def _read(self, file: Path, others: list[str]) -> Submission | None:
        """Return what to run; None: a launch file had to be read, and this is kept."""
        from grader.course.submission import find_submission
        from grader.trial.packages import unpacked

        if self._read_before.is_file():
            return pickle.loads(self._read_before.read_bytes())  # type: ignore[no-any-return]
        found = find_submission(file, others=others)
        if found.package is None:
            return found
        self._read_before.write_bytes(pickle.dumps(unpacked(found, self._launcher)))
        return None

    def drive(self, order: str) -> str:
        """Do what `course drive FILE ARGUMENTS` does; say what it prints, and how the run ended.

        The order names the `file` and the `arguments`, and perhaps a `lead` [ns], `deeds` with
        their `scenario`, and moments to `look` into, as in `trial`.
        """
        from grader import cli, drive
        from grader.cli.drive import Elsewhere
        from grader.trial.virtual_time import Limits
        from rclpy_virtual_time.link.in_process import StartEarlier

        wanted, made, printed = json.loads(order), [], io.StringIO()
        file = Path(wanted["file"])
        self._files = frozenset([file.name])
        os.chdir(file.parent)

        def drive_node(*what: Any, **how: Any) -> Recording:
            how |= {"limits": Limits(total=PATIENCE), "lead": wanted.get("lead", 0)}
            how["look"] = wanted.get("look", how["look"])
            with _to(sys.__stdout__, sys.__stderr__):  # for what the node prints
                made.append(drive.drive_node(*what, **how))
            return _unmeasured(made[0])

        with _to(printed, printed):
            try:
                words = _words(wanted["arguments"])
                if wanted.get("deeds"):
                    words += ["--scenario", self._scenario(wanted)]  # of two the last counts
                cli.run(["drive", file.name, *words], Elsewhere(self._launcher, drive_node))
            except StartEarlier as early:
                return json.dumps({"lead": early.lead})
            except ValueError as error:
                print(f"course: {error}")
        told: dict[str, Any] = {"printed": printed.getvalue()}
        if made:
            told |= {"hand": self._knobs.of(made[0]), **self._kept(made[0])}
            moments = (wanted.get("look", ()), wanted.get("callback", ""))
            told["tables"] = drive.tables_of(made[0], *moments)
        return json.dumps(told)

    def _scenario(self, wanted: dict[str, Any]) -> str:
        """Return the name of an order's scenario, or the file of the one with its deeds."""
        from grader.drive.by_hand import scenario_by_hand

        name: str = wanted["scenario"]
        if not wanted.get("deeds"):
            return name
        file = self._recordings / f"{Path(name).stem}_by_hand.toml"  # of one's own it is a path
        file.write_text(scenario_by_hand(name, wanted["deeds"]), "utf-8")
        return str(file)

    def judge(self, order: str) -> str:
        """Judge the recordings of `scenarios`: return the JSON object of the grading.

        The order names the `exercise`, the `file`, and perhaps the checks to judge (`only`). A
        check that failed has the `file` and `line` of the last message that had been sent by then,
        unless several of the reader's programs run.
        """
        wanted = json.loads(order)
        grading = self._grading(wanted).as_dict()
        for check in grading["checks"]:
            if check["outcome"] == "fail" and check["scenario"] and check["time"] is not None:
                recording, sent = self._load(check["scenario"])
                before = [where for time, *where in sent if time <= check["time"] + MOMENT]
                if len({end.process for end in recording.ends}) > 1:
                    before = []  # nobody knows which of them is meant
                ours = {each.file for each in recording.scenario.program if each.supplied}
                before = [where for where in before if where[0] not in ours]
                check["file"], check["line"] = before[-1] if before else ("", 0)
        return json.dumps(grading, default=str)

    def replay(self, order: str) -> str:
        """Return the page with the replays of `scenarios`, for a frame.

        With `checks`, objects of a grading, it opens at the moment of the first that failed;
        `ghosts` drive along, by the scenarios (`grader.report.replay.Ghosts`).
        """
        from grader.report.page import embedded_payload, page_html

        wanted = json.loads(order)
        shown = [self._load(name)[0] for name in wanted["scenarios"]]
        checks, ghosts = wanted.get("checks", ()), wanted.get("ghosts")
        return page_html(embedded_payload(checks, shown, wanted["title"], ghosts))

    def race(self, order: str) -> str:
        """Return the lap and the track (`grader.drive.race`) of each recording of `scenarios`.

        And where it loses to those `beside`: for each scenario laps and tracks, by whose they are.
        """
        import msgspec

        from grader.course.exercises import find_exercise
        from grader.drive.race import lap_of, loss_to, too_near, track_of
        from grader.exercises import contract_of

        wanted = json.loads(order)
        contract = contract_of(find_exercise(wanted["exercise"]))
        told = []
        for scenario, beside in zip(wanted["scenarios"], wanted["beside"], strict=True):
            recording, _ = self._load(scenario)
            lap = lap_of(recording, contract)
            lost = [
                loss_to(whose, other["track"], recording, contract)
                for whose, other in beside.items()
                if other["lap"]["of"] == lap.of and lap.figure is not None
            ]
            told.append([lap, track_of(recording), [too_near(lap, contract), *lost]])
        return msgspec.json.encode(told).decode()

    def _grading(self, wanted: dict[str, Any]) -> Grading:
        from grader.course.exercises import find_exercise
        from grader.grading.grading import grade
        from grader.trial.page import PageTrials

        return grade(
            find_exercise(wanted["exercise"]),
            PageTrials([self._load(name)[0] for name in wanted["scenarios"]], bool(self._stacks)),
            file=wanted["file"],
            only=wanted.get("only", ()),
            isolation=self._launcher.isolation,
            practice=self._launcher.practice,
        )

    def _kept(self, recording: Recording) -> dict[str, Any]:
        """Keep a recording; return its scenario, how it ended, and which programs had before."""
        from grader.checks.wiring import lines_of
        from grader.drive import touched_of
        from grader.recording import ended_of
        from grader.recording.deaths import death_of

        self._place(recording.name).write_bytes(pickle.dumps((recording, self._lines)))
        outcome = recording.outcome
        where = lines_of(death_of(outcome.detail))
        ended = [*ended_of(recording), *touched_of(recording)]
        return {"scenario": recording.name, "kind": outcome.kind, "text": outcome.text,
                "where": where, "ended": ended}  # fmt: skip

    def _load(self, scenario: str) -> tuple[Recording, Lines]:
        kept: tuple[Recording, Lines]
        kept = pickle.loads(self._place(scenario).read_bytes())
        return kept

    def _place(self, scenario: str) -> Path:
        return self._recordings / f"{scenario}.pickle"


def _no_thread(*_: object, **__: object) -> NoReturn:
    raise RuntimeError("a thread needs JSPI (WebAssembly.Suspending), which this browser has not")


def _unmeasured(recording: Recording) -> Recording:
    recording.compute.cpu[:] = math.nan  # nobody tells it here: what it costs is wall time
    return recording


def _summary(recording: Recording, submission: Submission) -> str:
    from grader.drive import print_summary

    with contextlib.redirect_stdout(io.StringIO()) as said:
        print_summary(_unmeasured(recording), file=submission.path.name)
    return said.getvalue()


def _least(recording: Recording, exercise: str) -> str:
    """Return whether a drive keeps the least that an exercise asks for in any world."""
    from grader.course.exercises import find_exercise
    from grader.drive.mishaps import mishap_of
    from grader.errors import InputError
    from grader.exercises import contract_of

    if recording.scenario.bench:
        return "Single scans: whether the answers to them are right is not judged in a drive.\n"
    try:
        mishap = mishap_of(recording, contract_of(find_exercise(exercise)))
    except InputError as error:
        return f"{error}\n"
    what = "no touch, no death, no command beyond its limits, no standing where the way is free"
    kept = f"not kept: at {mishap.at:.1f} s {mishap.text}" if mishap else "kept"
    return f"In a world of your own only the exercise's least is judged ({what}): {kept}.\n"


def _callback_line(frame: FrameType | None, files: Collection[str]) -> tuple[str, int]:
    """Return where the node's outermost function is on the way to a frame; line 0 without any."""
    where = ("", 0)
    while frame is not None and (name := frame.f_code.co_filename.rpartition("/")[2]) in files:
        where, frame = (name, frame.f_lineno), frame.f_back
    return where


def _words(arguments: str) -> list[str]:
    """Return the words of a command line.

    Raises ValueError: a quotation does not end, or an option has no sense in a page.
    """
    words = shlex.split(arguments)
    for word in words:
        option = word.partition("=")[0]
        if option in REFUSED:
            raise ValueError(f"{option}: {REFUSED[option]}")
    return words


@contextlib.contextmanager
def _to(out: TextIO, err: TextIO) -> Iterator[None]:
    """Let Python print somewhere."""
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        yield


def warm(
    recordings: str,
    reached: Callable[[float], object] = lambda _: None,
    browser: Browser | None = None,
) -> Runtime:
    """Return a runtime that has begun."""
    sys.path.append(str(Path(__file__).parent / "page_packages" / "gaps"))
    runtime = Runtime(Path(recordings), reached, browser)
    runtime.begin()
    return runtime
