"""The kernel's end of a judge in the browser: nodes run in a worker beside it (docs/page.md).

A trial leaves its traces in a process, and a kernel has to live on. So the worker of the lesson's
pages runs trials, each in a fresh copy of its Python, and the kernel judges their recordings.
"""

import asyncio
import json
import pickle
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from grader.course.exercises import Exercise, find_exercise
from grader.errors import GraderError, InputError
from grader.grading.grading import grade
from grader.notebook.answers import graded
from grader.notebook.orders import Answer, Drive, Driven, Grade, Graded, Order, Problem, Progressed
from grader.notebook.show import tell
from grader.recording import Recording
from grader.trial.page import PageTrials
from grader.trial.progress import TRIAL, OnProgress, Step
from rclpy_virtual_time import PracticeServer

FOLDER = "/home/reader"  # of the node, in the worker
PATIENCE = 30.0  # [s] without a word of a trial
STARTED = "its worker did not start; is there a network?"
INSTALLED = "take the installed course"
READY = (
    "Ready: nodes run in this browser, for practice. Your instructor's grade comes from the real "
    "rclpy on Linux. A browser interrupts no cell: restart the kernel instead, and run this cell "
    "again."
)
NO_WAITING = (
    "nodes can't run in this browser's notebooks: a cell has to wait for them, which takes JSPI "
    f"(WebAssembly.Suspending). The exercises' own pages say what runs without it; or {INSTALLED}"
)
SEARCH = f"a search can't be had in the browser; {INSTALLED}"
FIELD = f"Without the field checks, which can't be had in the browser; {INSTALLED}."
SILENT = (
    f"time stood still for {PATIENCE:.0f} s, at {{:.1f}} s of the drive: the node computes, or a "
    "loop never ends"
)


def why_not() -> str:
    """Say what this browser lacks to let nodes run; "" if nothing."""
    from pyodide.ffi import can_run_sync  # noqa: PLC0415  (only a browser has it)

    return "" if can_run_sync() else NO_WAITING


class Judge:
    """Answers a kernel's orders. The worker starts when first needed, and again after a failure."""

    def __init__(self) -> None:
        self._worker: Worker | None = None

    def warm(self, libraries: tuple[str, ...] = ()) -> None:
        """Let the worker get ready in the background, for any `libraries`."""
        del libraries
        if self._worker is None:
            self._worker = Worker()

    def ask(
        self,
        order: Order,
        on_progress: Callable[[Progressed], None],
        beat: Callable[[], None] = lambda: None,
    ) -> Answer:
        """Carry out an order; meanwhile `beat` is called whenever the worker has said something."""
        if said := why_not():
            return Problem(said)
        self.warm()
        assert self._worker is not None
        self._worker.beat = beat
        try:
            match order:
                case Drive():
                    return _drive(order, self._worker)
                case Grade():
                    return _grade(order, self._worker, on_progress)
                case _:
                    return Problem(SEARCH)
        except InputError as error:
            return Problem(str(error))
        finally:
            if self._worker.ended:
                self._worker = None


class Worker:
    """Python in a worker of the page's: one call at a time."""

    def __init__(self) -> None:
        import js  # noqa: PLC0415  (only a browser has it)
        from pyodide.ffi import create_proxy  # noqa: PLC0415
        from rclpy_agents_course import MANIFEST, PLAN, WORKSPACE  # noqa: PLC0415

        self.beat: Callable[[], None] = lambda: None
        self.ended = False
        self.exercises = frozenset(PLAN["exercises"])
        self._reached = 0.0  # [s] in a trial
        self._heard = asyncio.Event()
        self._answer: asyncio.Future[Any]
        self._js = js.Worker.new(f"{WORKSPACE}worker.js?{MANIFEST['worker.js']['sha256']}")
        self._js.onmessage = create_proxy(lambda event: self._hear(event.data.to_py()))
        self._js.onerror = create_proxy(
            lambda event: self._hear({"kind": "error", "text": getattr(event, "message", STARTED)})
        )
        self._ready = self._send({"call": "load", "manifest": MANIFEST})

    def call(
        self,
        call: str,
        order: Mapping[str, Any],
        files: Mapping[str, bytes],
        recordings: Mapping[str, bytes] | None = None,
    ) -> tuple[str, dict[str, bytes]]:
        """Call a method of workspace.runtime.Runtime in a fresh copy; return its answer.

        The files lie in `FOLDER`. Also return the recordings that it has made, by their files.

        Raises GraderError: the worker failed.
        Raises InputError: a node lets no time pass.
        """
        from pyodide.ffi import run_sync  # noqa: PLC0415

        self._await(run_sync, self._ready)
        message = {"call": call, "order": order, "files": files, "recordings": recordings or {}}
        answer = self._await(run_sync, self._send(message))
        made = {name: bytes(content) for name, content in answer["recordings"].items()}
        return answer["said"], made

    def run(
        self, call: str, order: Mapping[str, Any], files: Mapping[str, bytes]
    ) -> tuple[dict[str, Any], dict[str, bytes]]:
        """Let a node run, if need be once more: earlier, or with what its launch file starts."""
        kept: dict[str, bytes] = {}
        while True:
            said, kept = self.call(call, order, files, kept)
            ended = json.loads(said)
            if "lead" not in ended:
                return ended, kept
            order = {**order, "lead": ended["lead"]}

    def _send(self, message: Mapping[str, Any]) -> asyncio.Future[Any]:
        from js import Object  # noqa: PLC0415
        from pyodide.ffi import to_js  # noqa: PLC0415

        self._answer = asyncio.get_event_loop().create_future()
        self._js.postMessage(to_js(message, dict_converter=Object.fromEntries))
        return self._answer

    def _hear(self, news: Mapping[str, Any]) -> None:
        self._heard.set()
        match news["kind"]:
            case "answer":
                self._answer.set_result(news)
            case "error" if not self._answer.done():
                self._end()
                self._answer.set_exception(GraderError(str(news["text"]).strip()))
            case "reached":
                self._reached = float(news["seconds"])

    def _await(self, run_sync: Callable[[Any], Any], answer: asyncio.Future[Any]) -> Any:
        self._reached = 0.0
        while not answer.done():
            self._heard.clear()
            if not run_sync(self._is_heard()):
                self._end()
                raise InputError(SILENT.format(self._reached))
            self.beat()
        return answer.result()

    async def _is_heard(self) -> bool:
        try:
            await asyncio.wait_for(self._heard.wait(), PATIENCE)
        except TimeoutError:
            return False
        return True

    def _end(self) -> None:
        self._js.terminate()
        self.ended = True


class WorkerTrials(PageTrials):
    """Lets the worker run a node in each scenario that is asked for."""

    def __init__(
        self, worker: Worker, exercise: Exercise, file: Path, on_progress: OnProgress
    ) -> None:
        super().__init__([])
        self._worker, self._others, self._file = worker, exercise.files, file
        self._files = _files(file)
        self._on_progress = on_progress
        self._planned: dict[str, None] = {}
        self.stopped: GraderError | InputError | None = None  # by this: no check is worth its words

    def prepare(self, scenarios: Sequence[str]) -> None:
        """Count the trials that will be needed."""
        self._planned |= dict.fromkeys(scenarios)

    def get(self, scenario: str) -> Recording:
        """Return the recording of a scenario; at the end of the first trial Ctrl-C is tried."""
        if scenario not in self._recordings:
            self.prepare([scenario])
            self._tell(scenario)
            order = {
                "file": f"{FOLDER}/{self._file.name}",
                "others": self._others,
                "scenario": scenario,
                "interrupt": not self._recordings,
            }
            try:
                ended, made = self._worker.run("trial", order, self._files)
            except (GraderError, InputError) as error:
                self.stopped = error
                raise
            self._recordings[scenario], _ = pickle.loads(made[f"{scenario}.pickle"])
            self._tell(scenario, ended["kind"])
        return self._recordings[scenario]

    def recordings(self) -> list[Recording]:
        """Return those that were made, in the order in which they were announced."""
        return [self._recordings[name] for name in self._planned if name in self._recordings]

    def _tell(self, scenario: str, outcome: str = "") -> None:
        self._on_progress(Step(TRIAL, len(self._recordings), len(self._planned), scenario, outcome))


def _drive(order: Drive, worker: Worker) -> Answer:
    file, files = Path(order.file), _files(Path(order.file))
    scenario = order.scenario
    if scenario.endswith(".toml"):
        files[Path(scenario).name] = Path(scenario).read_bytes()
        scenario = Path(scenario).name
    words = ["--scenario", scenario]
    options = {"lidar": order.lidar, "duration": order.duration, "seed": order.seed}
    words += [f"--{name}={value}" for name, value in options.items() if value is not None]
    words += [word for goal in order.goals for word in ("--goal", *map(str, goal))]
    words += [word for param in order.params for word in ("--param", param)]
    words += [word for time in order.at for word in ("--at", str(time))]
    asked = {"file": f"{FOLDER}/{file.name}", "arguments": shlex.join(words)}
    told, made = worker.run("drive", asked, files)
    if "scenario" not in told:
        return Problem(told["printed"].strip().removeprefix("course: "))
    shown = {"scenarios": [told["scenario"]], "checks": [], "title": told["scenario"]}
    return Driven(told["printed"], worker.call("replay", shown, {}, made)[0])


def _grade(
    order: Grade, worker: Worker, on_progress: Callable[[Progressed], None]
) -> Graded | Problem:
    exercise, path = find_exercise(order.exercise), Path(order.file)
    if order.field:
        tell(FIELD)
    if exercise.slug not in worker.exercises:
        return Problem(f"exercise {exercise.number} can't be judged in the browser; {INSTALLED}")

    def on_step(step: Step) -> None:
        on_progress(Progressed(*step))

    trials = WorkerTrials(worker, exercise, path, on_step)
    grading = grade(
        exercise,
        trials,
        file=order.shown,
        only=order.only,
        isolation=PracticeServer.IN_BROWSER,
        practice=PracticeServer.practice,
        on_progress=on_step,
    )
    if trials.stopped is not None:
        raise trials.stopped
    return graded(grading, path)


def _files(file: Path) -> dict[str, bytes]:
    """Return the node and the programs beside it: which of them it needs is for the worker."""
    return {path.name: path.read_bytes() for path in [*file.parent.glob("*.py"), file]}
