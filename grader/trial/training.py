"""One training: run the student's script on made data, and ask its models about hidden scans.

The judge makes the data and keeps the hidden labels. With a seed other than the scenario's, they
are those of another expert: what was learned at home helps no more. The script runs twice, each
time in a fresh host; a third host loads what it wrote. If the first run ends with an error before
it has a model, the script gets plain numbers instead of a lidar's: one row that it does not expect
should not hide all else it can do. The judge itself never unpickles anything: it only carries bytes
from one host to the next, and reads numbers.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import msgspec
import numpy as np

from grader.course import installed
from grader.course.submission import Submission, read_regular_file
from grader.errors import GraderError
from grader.hosted.models import CONVERT, LOAD, PREDICT, Loaded, LoadModels, Predict, Predicted
from grader.models.dataset import HAS_EXPERT, Dataset, make_dataset
from grader.models.features import features
from grader.models.scans import PROFILE
from grader.recording import (
    COMPLETED,
    Floats,
    ModelAnswers,
    Outcome,
    Recording,
    ScriptRun,
    Training,
)
from grader.trial.endings import GRACE, line_without_folder, not_run, without_folder
from rclpy_virtual_time import (
    Excess,
    HostDied,
    HostForged,
    HostHung,
    Launcher,
    Link,
    LogLine,
    fresh_folder,
    real_clock,
)
from sim.scenario import Scenario, TrainingSpec
from sim.simulation import Simulation

DATA = "train.npz"
PICKLE, ONNX = "velocity_model.pkl", "velocity_model.onnx"
AGAIN_PICKLE, AGAIN_ONNX = "again.pkl", "again.onnx"  # other names: a script may not know them
NEEDED = ("sklearn", "skl2onnx", "onnxruntime")
MAX_FILE = 64 * 1024 * 1024  # [bytes] of a model
LOAD_LIMIT = 30.0  # [s]
PREDICT_LIMIT = 30.0  # [s]
SINGLES = 200  # predictions of one scan each
SLOW = 0.1  # [s] for one of them
FAILED = ("exception", "exited")  # ends of a run that the data may have brought about
ENOUGH_SLOW = 10  # slow ones decide, the rest need not be waited for


@dataclass(frozen=True)
class Trained:
    """A training's recording, and the files that came out of it."""

    recording: Recording
    pickle: bytes | None  # the model for the node; None if it could not drive a robot


def run_training(
    submission: Submission, scenario: Scenario, launcher: Launcher, *, seed: int | None = None
) -> Trained:
    """Run the training script that belongs to a submission, and question its models.

    Raises GraderError: the grader or the machine failed, or a library is missing.
    """
    simulation = Simulation(scenario, seed)
    spec = scenario.training
    assert spec is not None
    problem = submission.problem or _missing(submission, spec)
    if problem:
        outcome = Outcome("unreadable", problem)
        training = Training(spec.script, problem)
        return Trained(replace(not_run(simulation, outcome), training=training), None)
    _require_libraries()
    return _train(submission, simulation, spec, launcher.workshop)


def _train(
    submission: Submission, simulation: Simulation, spec: TrainingSpec, workshop: Launcher
) -> Trained:
    own, seed = simulation.scenario.seed, simulation.seed
    if not HAS_EXPERT:  # a student's copy: what the published one said, whatever the seed
        seed = own
    make = partial(make_dataset, expert=None if seed == own else seed)
    data = make(spec.rows, 2 * seed)
    hidden = make(spec.hidden_rows, 2 * seed + 1, blind=False)
    run, files, log = _run_script(submission, spec, data, workshop, (PICKLE, ONNX))
    training = Training(spec.script, runs=(run,), labels=hidden.speed.tobytes())
    if run.kind in FAILED and not run.succeeded and PICKLE not in files:
        data = make(spec.rows, 2 * seed, plain=True)
        plain, files, _ = _run_script(submission, spec, data, workshop, (PICKLE, ONNX))
        training = msgspec.structs.replace(training, plain=plain)
    if PICKLE in files if training.made.kind in FAILED else training.made.succeeded and files:
        second, more, _ = _run_script(submission, spec, data, workshop, (AGAIN_PICKLE, AGAIN_ONNX))
        training = msgspec.structs.replace(training, runs=(run, second))
        training = _question({**files, **more}, training, hidden, workshop)
    kind = COMPLETED if run.succeeded else run.kind
    outcome = Outcome(kind, "" if run.succeeded else run.text, run.wall, run.detail)
    recording = replace(not_run(simulation, outcome), training=training, log=log)
    return Trained(recording, files[PICKLE] if _is_usable(training) else None)


def _is_usable(training: Training) -> bool:
    """Return whether the model can drive: it predicts, and does not take for ever."""
    predicts = training.pickle.loaded and not training.pickle.problem
    return predicts and len(training.single_wall) == SINGLES * np.float64().itemsize


def _missing(submission: Submission, spec: TrainingSpec) -> str:
    """Say that the script is missing; nothing if it is there."""
    if any(path.name == spec.script for path in (submission.path, *submission.others)):
        return ""
    return f"there is no {spec.script} beside {submission.path.name}"


def _require_libraries() -> None:
    if missing := installed.why_not(NEEDED):
        raise GraderError(f"no training here: {missing.removeprefix('skipped: ')}")


# --- the script ----------------------------------------------------------------------------------


def _run_script(
    submission: Submission,
    spec: TrainingSpec,
    data: Dataset,
    workshop: Launcher,
    names: tuple[str, str],
) -> tuple[ScriptRun, dict[str, bytes], tuple[LogLine, ...]]:
    """Run the script once; return its outcome, its files and its output."""
    with submission.folder(without=(DATA, *names)) as folder:  # what it writes is new
        data.save(folder / DATA)
        arguments = ("--data", DATA, "--out", names[0], "--onnx", names[1])
        seed = zlib.crc32(repr((names, spec)).encode())  # another in each run, as in real life
        script = next((p.file for p in submission.started(spec.script)), spec.script)
        with workshop.workplace(folder) as place:
            with workshop.host(place) as link:
                began = real_clock.perf_counter()
                outcome = _conduct(link, folder / script, arguments, seed, spec.time_limit)
                wall = real_clock.perf_counter() - began
                log = link.log()
            files = {name: _take_file(place.seen / name) for name in names}
        outcome = without_folder(outcome, folder)
        kept = {name: content for name, content in files.items() if content is not None}
        sizes = {name: len(content) for name, content in kept.items()}
        run = ScriptRun(outcome.kind, outcome.text, outcome.detail, wall, sizes)
        return run, kept, tuple(line_without_folder(line, folder) for line in log)


def _conduct(
    link: Link, file: Path, arguments: tuple[str, ...], seed: int, limit: float
) -> Outcome:
    try:
        answer, _ = link.run_script(file, arguments, seed, limit)
    except HostHung as hung:
        return Outcome("hung", f"the script was not done after {limit:.0f} s", detail=hung.stacks)
    except HostDied:
        status = link.wait(GRACE)
        return Outcome("died", f"the script's process ended by itself ({status})")
    except Excess as error:
        return Outcome("flooded", f"the script took more of the machine than it may: {error}")
    except HostForged as error:
        return Outcome("forged", f"the script answered in the host's place: {error}")
    return Outcome(answer.kind, answer.text, detail=answer.detail)


def _take_file(path: Path) -> bytes | None:
    """Return the file that the script wrote; None unless it is ordinary, in kind and size."""
    try:
        content = read_regular_file(path, MAX_FILE)
    except OSError:
        return None
    return content if len(content) <= MAX_FILE else None


# --- its models ----------------------------------------------------------------------------------


def _question(
    files: dict[str, bytes], training: Training, hidden: Dataset, workshop: Launcher
) -> Training:
    """Let a fresh host load the models, without the script beside them, and predict."""
    seen = features(hidden.ranges, np.degrees(PROFILE.angles), PROFILE.range_min, PROFILE.range_max)
    with fresh_folder() as folder:
        for file, content in files.items():
            (folder / file).write_bytes(content)
        with workshop.host(folder) as link:
            try:
                return _interview(link, seen, training)
            except (HostHung, HostDied, HostForged, Excess) as error:
                problem = f"the process that loaded the models ended or hung ({error!r})"
                return msgspec.structs.replace(training, pickle=ModelAnswers(problem[:300]))


def _interview(link: Link, seen: Floats, training: Training) -> Training:
    loaded, _ = link.carry_out(LOAD, LoadModels((PICKLE, AGAIN_PICKLE), ONNX), Loaded, LOAD_LIMIT)
    answers = {}
    for file in (PICKLE, AGAIN_PICKLE, ONNX):
        problem = loaded.problems.get(file, "it was not tried")
        answers[file] = ModelAnswers(problem) if problem else _answers(link, file, seen)
    wall, cpu = np.empty(0), np.empty(0)
    if not answers[PICKLE].problem:
        wall, cpu = _time_singles(link, seen)
    converted = _converted(link, seen, answers[PICKLE], answers[ONNX])
    return msgspec.structs.replace(
        training,
        pickle=answers[PICKLE],
        converted=converted,
        again=answers[AGAIN_PICKLE],
        onnx=answers[ONNX],
        onnx_inputs=loaded.inputs,
        onnx_outputs=loaded.outputs,
        single_wall=wall.tobytes(),
        single_cpu=cpu.tobytes(),
    )


def _converted(link: Link, seen: Floats, said: ModelAnswers, onnx: ModelAnswers) -> ModelAnswers:
    """Where ONNX does not say what the pickle says, find out whether the converter is at fault."""
    same = len(said.speeds) == len(onnx.speeds) and np.allclose(said.speeds, onnx.speeds, 0, 1e-4)
    if said.problem or same:
        return ModelAnswers()
    try:
        return _answers(link, PICKLE, seen, CONVERT)
    except (HostHung, HostDied, Excess):
        return ModelAnswers()


def _answers(link: Link, file: str, seen: Floats, task: str = PREDICT) -> ModelAnswers:
    said = _ask(link, file, seen, task)
    return ModelAnswers(said.problem, True, said.shape, said.values)


def _ask(link: Link, file: str, seen: Floats, task: str) -> Predicted:
    said, _ = link.carry_out(task, Predict(file, seen.tobytes()), Predicted, PREDICT_LIMIT)
    if len(said.values) % 8:
        raise HostForged("no predictions")
    if not said.problem and 8 * math.prod(said.shape) != len(said.values):
        raise HostForged("predictions of another shape than they say")
    return said


def _time_singles(link: Link, seen: Floats) -> tuple[Floats, Floats]:
    """Return wall and CPU time [s] of predictions for one scan each, measured from outside."""
    costs = []
    slow = 0
    for row in seen[np.arange(SINGLES) % len(seen)]:
        order = Predict(PICKLE, row.tobytes())
        _, cost = link.carry_out(PREDICT, order, Predicted, PREDICT_LIMIT)
        costs.append((cost.wall, cost.cpu))
        slow += min(cost.wall, cost.cpu) > SLOW
        if slow >= ENOUGH_SLOW:
            break
    wall, cpu = np.array(costs).T.copy()
    return wall, cpu
