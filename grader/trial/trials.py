"""Where the checks of one grading get their recordings: run now, or loaded from bags."""

from __future__ import annotations

import contextlib
import os
import shutil
import threading
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

from grader.course import installed
from grader.course.students import Seed
from grader.course.submission import Submission
from grader.errors import GraderError, InputError, is_disk_full
from grader.models.files import OWN, needed_for
from grader.recording import Outcome, Recording, bag, ended_of, growth_of
from grader.trial.endings import is_halt, not_run
from grader.trial.hangs import busy_wait
from grader.trial.kept import KeptRecordings
from grader.trial.progress import LEFT_OUT, TRIAL, OnProgress, Step, ignore
from grader.trial.seeds import trial_seed
from grader.trial.training import Trained, run_training
from grader.trial.virtual_time import Limits, run_trial
from rclpy_virtual_time import Launcher
from sim.scenario import Scenario
from sim.scenario_files import load_scenario
from sim.simulation import Simulation

REAL_TIME_TRIALS = 4  # at once: each mostly waits for the clock
MAX_SAID = 200  # [characters] of an error in a message
IMPATIENT = Limits(start=10.0, step=1.0, total=20.0)  # once a node has hung
NOT_RUN = "The node {ended} in the run {name}, so {count} were left out."
ENDED = {"hung": "hung", "never_spun": "never spun"}
AFTER = "After the run {name} the node was sent Ctrl-C, which costs no points: {what}"
PATIENCE = 300.0  # [s] of computing, and of waits for anything but a CPU, in all virtual trials
HURRIED = Limits(total=20.0)  # once they have
MUCH, LITTLE = 128 * 2**20, 2**20  # [bytes] published in all trials; then in each that is left
SLOW = (
    f"The node's trials took more than {PATIENCE:.0f} s, far longer than any solution's: from then "
    f"on each had to end within {HURRIED.total:.0f} s."
)


class NoRecording(Exception):
    """There is no recording of this scenario, and none can be made."""


class TrialFault(GraderError):
    """The grader failed in one trial; the others say as much as before."""

    def __init__(self, scenario: str, error: Exception) -> None:
        said = " ".join(str(error).split())[:MAX_SAID]
        kind = type(error).__name__
        super().__init__(
            f"the grader failed in the trial {scenario} ({kind}{': ' if said else ''}{said}); "
            "that is not the node's fault"
        )
        self.scenario = scenario


class _LeftOut(Exception):
    """A trial was not run, because the node hung or ended at once in another trial."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario.name)
        self.scenario = scenario


class Trials:
    """A source of recordings, by the name of the scenario; this base class has none."""

    def prepare(self, scenarios: Sequence[str]) -> None:
        """Announce the trials that will be needed."""

    def get(self, scenario: str) -> Recording:
        """Return a recording; NoRecording if there can be none, TrialFault if making it failed."""
        raise NoRecording(f"no recording of the scenario {scenario}")

    def recordings(self) -> list[Recording]:
        """Return all that were asked for and could be made, in order."""
        return []

    def faults(self) -> list[TrialFault]:
        """Return the trials in which the grader failed."""
        return []

    def notes(self) -> list[str]:
        """Return notes on the trials for a reader of the score, a sentence each."""
        return []

    def lacks(self, scenarios: Sequence[str], libraries: Sequence[str]) -> str:
        """Say which libraries are missing to record these scenarios; empty if none is."""
        return installed.why_not(libraries)


@dataclass
class NodeTrials(Trials):
    """Runs the student's node, a few scenarios at a time."""

    submission: Submission
    launcher: Launcher
    seed: Seed | None = None  # mixed into every scenario's own
    bags: Path | None = None
    limits: Limits = field(default_factory=Limits)
    real_time: bool = False  # Tier 2: all trials in wall-clock time, on DDS
    on_progress: OnProgress = ignore
    kept: KeptRecordings | None = None  # where recordings are looked for, and kept
    _futures: dict[str, Future[Recording]] = field(default_factory=dict)
    _trained: dict[str, Future[Trained]] = field(default_factory=dict)
    _scenarios: dict[str, Scenario] = field(default_factory=dict)
    _seeds: dict[str, int] = field(default_factory=dict)  # by scenario
    _unsaved: list[str] = field(default_factory=list)  # sentences
    _asked: set[str] = field(default_factory=set)  # scenarios whose recordings a check needed

    def __post_init__(self) -> None:
        self._pool = ThreadPoolExecutor(
            REAL_TIME_TRIALS if self.real_time else max(2, min(4, os.cpu_count() or 2))
        )
        self._hung = False
        self._planned, self._ended = 0, 0  # trials
        self._counting = threading.Lock()
        self._halted = False  # it hung or ended at once: what no check asks for doesn't run
        self._took: list[float] = []  # [s] by each virtual trial
        self._published = 0  # [bytes] in them
        self._interrupted: str | None = None  # the scenario at whose end Ctrl-C is tried
        self._second_look = threading.Lock()  # at a node that hung in virtual time
        self._why_real: str | None = None  # the node can't run in virtual time
        # What hangs before it has started, whatever the scenario, by the student's programs in it
        self._dead: dict[frozenset[str], Outcome] = {}

    def __enter__(self) -> NodeTrials:
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def prepare(self, scenarios: Sequence[str]) -> None:
        """Start the trials in the background; trainings first, because others wait for them."""
        new = [name for name in dict.fromkeys(scenarios) if name not in self._futures]
        # read here: several threads that build msgspec's type tables at once crash Python
        loaded = {name: self._load(name) for name in new}
        driven = [name for name, each in loaded.items() if each and each.training is None]
        self._interrupted = self._interrupted or next(iter(driven), None)
        self._planned += sum(scenario is not None for scenario in loaded.values())
        for name, scenario in loaded.items():
            if scenario is not None:
                self._futures[name] = self._pool.submit(self._run_unless_halted, scenario)

    def get(self, scenario: str) -> Recording:
        """Return the recording of a scenario, when its trial is over."""
        self._asked.add(scenario)
        self.prepare([scenario])
        try:
            return self._futures[scenario].result()
        except _LeftOut as left_out:
            self._futures[scenario] = self._pool.submit(self._run, left_out.scenario)
            return self._futures[scenario].result()

    def recordings(self) -> list[Recording]:
        """Return the recordings made, in order; of a node that hung only those that checks need."""
        over = self._futures.values()
        made = [future.result() for future in over if future.exception() is None]
        return [recording for recording in made if not self._unasked(recording.name)]

    def lacks(self, scenarios: Sequence[str], libraries: Sequence[str]) -> str:
        """Say which libraries are missing, those that write the scenarios' models among them."""
        needed: list[str] = list(libraries)
        for name in scenarios:
            with contextlib.suppress(InputError):  # its trial says so
                needed += needed_for(self._read(name).node.models)
        return installed.why_not(dict.fromkeys(needed))

    def faults(self) -> list[TrialFault]:
        """Return the trials in which the grader failed, in order."""
        found = (future.exception() for future in self._futures.values())
        return [error for error in found if isinstance(error, TrialFault)]

    def notes(self) -> list[str]:
        """Say what came along, what was not saved, and that a node took too much time."""
        return [
            *self.submission.account(),
            *self._unsaved,
            *self._left_out(),
            *self._ended_early(),
            *self._grown(),
            *([SLOW] if self._slow else []),
            *self._after_interrupt(),
        ]

    def _ended_early(self) -> list[str]:
        """Say which programs ended while others went on, each in the first run that shows it."""
        first: dict[tuple[str, str, str], str] = {}
        for run in self.recordings():
            notes = [note for note in run.notes if note.kind == "ended"]
            for note, said in zip(notes, ended_of(run), strict=True):
                first.setdefault((note.about, note.line, note.more), f"In {run.name}, {said}.")
        return list(first.values())

    def _grown(self) -> list[str]:
        """Say what grew, in the trial that shows it most."""
        found = [(growth_of(recording, models=False), recording) for recording in self.recordings()]
        found.sort(key=lambda each: (len(each[0]), each[1].duration_s))
        lines = [f"In {run.name}, {line}" for said, run in found[-1:] for line in said]
        return [line if line.endswith((".", "?")) else f"{line}." for line in lines]

    def _after_interrupt(self) -> list[str]:
        ends = [(each.name, each.ending) for each in self.recordings() if each.ending]
        return [AFTER.format(name=name, what=end.problem) for name, end in ends if end.problem]

    def _left_out(self) -> list[str]:
        ends = [recording for recording in self.recordings() if is_halt(recording)]
        count = sum(self._unasked(name) for name in self._futures)
        if not ends or not count:
            return []
        ended = ENDED.get(ends[0].outcome.kind, "ended before its first message")
        runs = f"the other {count} runs" if count > 1 else "the other run"
        said = NOT_RUN.format(ended=ended, name=ends[0].name, count=runs)
        return [said if count > 1 else said.replace("were", "was")]

    def _unasked(self, scenario: str) -> bool:
        """Return whether a trial is left out, were it over by chance: each grading has the same."""
        return self._halted and scenario not in self._asked

    def seed_of(self, scenario: Scenario) -> int:
        """Return the seed of a scenario's trial."""
        if scenario.name not in self._seeds:
            self._seeds[scenario.name] = trial_seed(scenario, self.seed)
        return self._seeds[scenario.name]

    @property
    def _slow(self) -> bool:
        """Return whether the trials have used up PATIENCE: no submission holds up a class."""
        return sum(self._took) > PATIENCE

    def _load(self, name: str) -> Scenario | None:
        """Read a scenario and start its trainings; if that fails, so does its trial alone."""
        try:
            scenario = self._read(name)
            for needed in _trainings(scenario):
                self._train(needed)
        except Exception as error:
            self._futures[name] = Future()
            self._futures[name].set_exception(TrialFault(name, error))
            return None
        return scenario

    def _read(self, name: str) -> Scenario:
        if name not in self._scenarios:
            self._scenarios[name] = load_scenario(name)
        return self._scenarios[name]

    def _tell(self, name: str, outcome: str = "") -> None:
        with self._counting:
            self._ended += bool(outcome)
            done = min(self._ended, self._planned)
            self.on_progress(Step(TRIAL, done, self._planned, name, outcome))

    def _train(self, name: str) -> None:
        if name in self._trained:
            return
        scenario = self._read(name)
        self._trained[name] = self._pool.submit(self._run_training, scenario)

    def _run_training(self, scenario: Scenario) -> Trained:
        seed = self.seed_of(scenario)
        if self.kept and (found := self.kept.get(self.submission, scenario, seed, {})):
            return Trained(*found)
        trained = run_training(self.submission, scenario, self.launcher, seed=seed)
        if self.kept:
            self.kept.put(self.submission, trained.recording, {}, trained.pickle)
        return trained

    def _run_unless_halted(self, scenario: Scenario) -> Recording:
        if self._unasked(scenario.name):
            self._tell(scenario.name, LEFT_OUT)
            raise _LeftOut(scenario)
        return self._run(scenario)

    def _run(self, scenario: Scenario) -> Recording:
        self._tell(scenario.name)
        outcome = "fault"
        try:
            recording = self._drive_or_train(scenario)
            outcome = recording.outcome.kind
            self._halted = self._halted or is_halt(recording)
            return recording if self.bags is None else self._saved(recording, self.bags)
        except Exception as error:  # ours: whatever a node does is an outcome
            raise TrialFault(scenario.name, error) from error
        finally:
            self._tell(scenario.name, outcome)

    def _saved(self, recording: Recording, bags: Path) -> Recording:
        """Save a recording; without a saved copy, a trial is judged all the same."""
        place = bags / recording.name
        try:
            return replace(recording, bag=str(bag.save(recording, place)))
        except Exception as error:
            if is_disk_full(error):
                raise
            shutil.rmtree(place, ignore_errors=True)
            self._unsaved.append(
                f"The trial {recording.name} could not be saved ({type(error).__name__}): it has "
                "no replay and can't be judged again."
            )
            return recording

    def _drive_or_train(self, scenario: Scenario) -> Recording:
        if scenario.training is not None:
            return self._trained[scenario.name].result().recording
        files = self._own_models(scenario)
        seed = self.seed_of(scenario)
        if self.kept and (found := self.kept.get(self.submission, scenario, seed, files)):
            return found[0]
        recording = self._drive(scenario, files)
        if self.kept:
            self.kept.put(self.submission, recording, files)
        return recording

    def _drive(self, scenario: Scenario, files: Mapping[str, bytes]) -> Recording:
        if dead := self._dead.get(_own_programs(scenario)):
            return not_run(Simulation(scenario, self.seed_of(scenario)), dead)
        if self.real_time or self._why_real is not None:
            return self._run_in_real_time(scenario, self._why_real or "")
        limits = HURRIED if self._slow else self.limits
        limits = IMPATIENT if self._hung else limits
        if self._published > MUCH:  # all is kept until the last check, and in bags for good
            limits = replace(limits, published=LITTLE)
        recording = run_trial(
            self.submission,
            scenario,
            self.launcher,
            seed=self.seed_of(scenario),
            limits=limits,
            files=files,
            interrupt=scenario.name == self._interrupted,
        )
        self._took.append(float(recording.compute.busy.sum()))
        self._published += sum(len(message.data) for message in recording.published)
        if self.launcher.practice:
            return recording  # there is no real time: the node hangs, or can't run
        if recording.outcome.kind == "real_time":
            self._why_real = recording.outcome.text
        elif recording.outcome.kind == "slow":
            self._took.append(PATIENCE)
        elif recording.outcome.kind == "hung":
            return self._look_again(scenario, recording)
        if self._why_real is not None:
            return self._run_in_real_time(scenario, self._why_real)
        return recording

    def _look_again(self, scenario: Scenario, virtual: Recording) -> Recording:
        """Return the recording of a node that hung; in real time if only that ends the node's wait.

        `while not self.done: pass` never ends in virtual time, because no time goes by; on a robot
        it does. One trial in real time decides for all.
        """
        with self._second_look:
            if not self._hung and self._why_real is None:
                reason = busy_wait(virtual)
                real = self._run_in_real_time(scenario, reason)
                if real.outcome.kind not in ("hung", "never_spun"):
                    self._why_real = reason
                    return real
                self._hung = True
                if not virtual.delivered:
                    self._dead[_own_programs(scenario)] = virtual.outcome
        if self._why_real is not None:
            return self._run_in_real_time(scenario, self._why_real)
        return virtual

    def _run_in_real_time(self, scenario: Scenario, reason: str) -> Recording:
        from grader.trial.real_time import run_live_trial  # noqa: PLC0415
        from rclpy_virtual_time import ForkServer  # noqa: PLC0415  (Linux only)

        assert isinstance(self.launcher, ForkServer)
        return run_live_trial(
            self.submission,
            scenario,
            self.launcher,
            seed=self.seed_of(scenario),
            files=self._own_models(scenario),
            reason=reason,
        )

    def _own_models(self, scenario: Scenario) -> dict[str, bytes]:
        """Return the models of the student's own training that a scenario's node is to find."""
        found = {}
        for file, model in scenario.node.models.items():
            if model.probe == OWN:
                made = self._trained[str(model.settings["training"])].result().pickle
                if made is not None:
                    found[file] = made
        return found


def _own_programs(scenario: Scenario) -> frozenset[str]:
    """Return which of an exercise's several files a scenario starts; none where there is one."""
    return frozenset(spec.file for spec in scenario.program if not spec.supplied)


def _trainings(scenario: Scenario) -> list[str]:
    """Return the training scenarios that this one is or needs a model from."""
    own = [model for model in scenario.node.models.values() if model.probe == OWN]
    needed = [str(model.settings["training"]) for model in own]
    return [*needed, *([scenario.name] if scenario.training is not None else [])]


class SavedTrials(Trials):
    """Recordings from bags; no student's code runs."""

    def __init__(self, recordings: Iterable[Recording]) -> None:
        self._recordings = {recording.name: recording for recording in recordings}

    def lacks(self, scenarios: Sequence[str], libraries: Sequence[str]) -> str:
        """Say which of the libraries are not installed; what was recorded needs none any more."""
        missing = [name for name in scenarios if name not in self._recordings]
        return installed.why_not(libraries) if missing else ""

    def get(self, scenario: str) -> Recording:
        """Return the recording of a scenario; NoRecording if no bag has it."""
        if scenario not in self._recordings:
            return super().get(scenario)
        return self._recordings[scenario]

    def recordings(self) -> list[Recording]:
        """Return all recordings."""
        return list(self._recordings.values())
