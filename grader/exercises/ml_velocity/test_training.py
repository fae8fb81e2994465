"""The core checks of exercise 2's training script, and of the models that it writes."""

from __future__ import annotations

from functools import partial

import numpy as np

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, TIMING, WIRING, check
from grader.checks.verdict import fail, inconclusive
from grader.checks.wiring import advice_on, lines_of
from grader.checks.words import keeps_distance
from grader.exercises.ml_velocity.contract import TRAINING
from grader.recording import Recording, ScriptRun, Training, death_of

ACCURACY = 0.03  # [m/s] mean absolute error
PREDICTION_LIMIT = 0.1  # [s], p99
LEAST_CALLS = 200
AGREE, AGREE_PART = 1e-4, 0.98  # [m/s], on this part of the scans
AGREE_ALL = 0.02  # [m/s] on all of them
REPEATABLE = 1e-9  # [m/s]; sums in another order differ in the last bits
FLOAT32 = "tensor(float)"
PICKLE, ONNX = "velocity_model.pkl", "velocity_model.onnx"
AGAIN_PICKLE, AGAIN_ONNX = "again.pkl", "again.onnx"
COMMAND = "python3 {} --data train.npz --out velocity_model.pkl --onnx velocity_model.onnx"

trained = partial(check, scenarios=("ml_training",), requires=TRAINING)


@trained(points=3, asks=WIRING, task=7, needs=())
def test_training_runs(runs: Runs) -> None:
    """The training script runs in 60 s and writes the pickle that it is asked for."""
    recording, training = _trained(runs)
    if training.problem:
        fail(
            training.problem,
            expected=f"{training.script} in the same folder as the controller",
            actual="no such file" if not training.runs else training.problem,
            recording=recording,
            help="Give the folder to `course grade`, or put both files side by side.",
        )
    _require_success(recording, training, training.made)
    _require_file(recording, training.made, "--out", PICKLE)


@trained(points=2, asks=DECISION, task=6, needs=("training_runs",))
def test_training_data(runs: Runs) -> None:
    """The training copes with a lidar's data: NaN, infinities, and sectors without a reading."""
    recording, training = _trained(runs)
    help = (
        "With finite readings only, the same script comes to its end. Which rows of train.npz "
        "hold NaN or ±inf, and which have a sector without any usable reading?"
    )
    _require_success(recording, training, training.runs[0], help)


@trained(points=1, asks=WIRING, task=8, needs=("training_runs",))
def test_file_names(runs: Runs) -> None:
    """Run again with other names, the script writes its models under those."""
    recording, training = _trained(runs)
    again = training.runs[-1]
    if training.made.succeeded and len(training.runs) > 1:
        _require_success(recording, training, again)
    _require_file(recording, again, "--out", AGAIN_PICKLE)
    if ONNX in training.made.files:
        _require_file(recording, again, "--onnx", AGAIN_ONNX)


@trained(points=4, asks=WIRING, task=8, needs=("training_runs",), hint="6.5")
def test_model_loads(runs: Runs) -> None:
    """The pickle loads without the script, and predicts one speed for each row of features."""
    recording, training = _trained(runs)
    answers, count = training.pickle, len(training.expert)
    if not answers.loaded:
        fail(
            "the pickle cannot be loaded where the training script is not",
            expected="a scikit-learn model and nothing of your own in it",
            actual=answers.problem,
            recording=recording,
            help="The node calls pickle.load, which cannot read what joblib.dump wrote."
            if answers.problem.startswith("UnpicklingError")
            else "A pickle holds the names of its classes, not their code: a class of your "
            "script is missing on the robot.",
        )
    if answers.problem or answers.shape != (count,) or len(answers.speeds) != count:
        fail(
            "the unpickled object does not predict",
            expected=f"predict(X) of shape ({count},) for X of shape ({count}, 5)",
            actual=answers.problem or f"shape {answers.shape}",
            recording=recording,
            help="Pickle the fitted model itself, not a dictionary around it; "
            "it takes the five features in their order.",
        )


@trained(points=7, asks=DECISION, task=7, needs=("model_loads",), hint="6.3")
def test_model_accuracy(runs: Runs) -> None:
    """On scans from rooms it has not seen the model errs by at most 0.03 m/s on average."""
    recording, training = _trained(runs)
    said, right = training.pickle.speeds, training.expert
    error = float(np.abs(said - right).mean())
    if error > ACCURACY:
        fail(
            f"the model errs by {error:.3f} m/s on average over {len(right)} new scans",
            expected=f"at most {ACCURACY} m/s",
            actual=f"{error:.3f} m/s; it predicts {said.mean():.3f} m/s on average, "
            f"the expert {right.mean():.3f} m/s",
            recording=recording,
            help="Are the features those that the controller computes, in the same order? "
            "Did it learn from all scans, and is the label in m/s? A neural network also wants "
            "scaled inputs, and enough units and iterations.",
        )


@trained(points=3, asks=TIMING, task=7, needs=("model_loads",))
def test_prediction_time(runs: Runs) -> None:
    """One prediction takes at most 100 ms, at least 99 times in 100."""
    recording, training = _trained(runs)
    wall, cpu = np.frombuffer(training.single_wall), np.frombuffer(training.single_cpu)
    wall, cpu = wall[: len(cpu)], cpu[: len(wall)]
    own = np.fmin(wall, cpu)  # without the time spent waiting for a CPU
    measured = bool(np.isfinite(cpu).all())  # not every system tells: then it may have waited
    decided = measured and (own > PREDICTION_LIMIT).sum() > LEAST_CALLS / 100
    if len(wall) < LEAST_CALLS and not decided:
        fail("not enough predictions came to measure", recording=recording)
    if not decided and np.percentile(wall, 99) <= PREDICTION_LIMIT:
        return
    if not decided and np.percentile(own, 99 if measured else 50) <= PREDICTION_LIMIT:
        inconclusive("the machine stalled while the predictions were being measured")
    fail(
        "a prediction takes too long",
        expected=f"at most {1000 * PREDICTION_LIMIT:.0f} ms (p99)",
        actual=f"{1000 * np.median(own):.0f} ms (median of {len(own)} calls)",
        recording=recording,
        help="At 10 Hz the next scan comes after 100 ms. A smaller model is hardly worse.",
    )


@trained(points=4, asks=WIRING, task=8, needs=("training_runs",), hint="6.4")
def test_onnx_form(runs: Runs) -> None:
    """The ONNX model takes one (n, 5) float32, and its first output is (n,) or (n, 1) float32."""
    recording, training = _trained(runs)
    _require_file(recording, training.made, "--onnx", ONNX)
    if not training.onnx.loaded:
        fail(
            "onnxruntime cannot load the ONNX file",
            expected="a model that onnxruntime.InferenceSession accepts",
            actual=training.onnx.problem or training.pickle.problem,
            recording=recording,
            help="skl2onnx.to_onnx(model, X[:1].astype(np.float32)).SerializeToString()",
        )
    inputs = [_spell(tensor.type, tensor.shape) for tensor in training.onnx_inputs]
    if inputs not in (["float32 (n, 5)"], ["float32 (n, n)"]):
        fail(
            "the ONNX model takes other inputs than the robot will give it",
            expected="one input: float32 (n, 5)",
            actual=" and ".join(inputs) or "no input",
            recording=recording,
            help="The sample that to_onnx gets sets type and width: "
            "np.zeros((1, 5), dtype=np.float32).",
        )
    first = [_spell(tensor.type, tensor.shape) for tensor in training.onnx_outputs[:1]]
    if first not in (["float32 (n)"], ["float32 (n, 1)"]):
        fail(
            "the ONNX model's first output is not a speed for each row",
            expected="float32 (n) or float32 (n, 1)",
            actual="".join(first) or "no output",
            recording=recording,
            help="Convert the fitted regressor itself.",
        )


@trained(points=3, asks=DECISION, task=8, needs=("model_loads", "onnx_form"), hint="6.4")
def test_onnx_agrees(runs: Runs) -> None:
    """ONNX and pickle predict the same: to 1e-4 m/s on 98 % of the scans, to 0.02 m/s on all."""
    recording, training = _trained(runs)
    onnx, said = training.onnx, training.pickle.speeds
    shapes = ((len(said),), (len(said), 1))
    if onnx.problem or onnx.shape not in shapes or len(onnx.speeds) != len(said):
        fail(
            "the ONNX model does not predict",
            expected=f"{len(said)} speeds for {len(said)} rows",
            actual=onnx.problem or f"shape {onnx.shape}",
            recording=recording,
            help="Try it with onnxruntime on a few rows of your own.",
        )
    gap = np.abs(onnx.speeds - said)
    part = float((gap <= AGREE).mean())
    if part < AGREE_PART or not gap.max() <= AGREE_ALL:  # never true of NaN
        fail(
            "the ONNX model and the pickle are different models",
            expected=f"the same to {AGREE} m/s on 98 % of the scans, to {AGREE_ALL} on all",
            actual=f"the same on {100 * part:.0f} %, apart by {gap.max():.3f} m/s at most",
            recording=recording,
            help="Fit once, then write the same object in both formats.",
        )


@trained(points=3, asks=DECISION, task=7, needs=("model_loads", "file_names"), hint="6.3")
def test_repeatable(runs: Runs) -> None:
    """Two trainings on the same data predict the same."""
    recording, training = _trained(runs)
    first, second = training.pickle, training.again
    same = not second.problem and len(first.speeds) == len(second.speeds)
    gap = np.abs(first.speeds - second.speeds).max(initial=0.0) if same else np.inf
    if not gap <= REPEATABLE:
        fail(
            "two trainings on the same data give different models",
            expected="the same predictions",
            actual=f"apart by up to {gap:.3f} m/s"
            if same
            else second.problem or "no comparable predictions",
            recording=recording,
            help="Whatever draws random numbers needs a seed: random_state=0.",
        )


@check(
    points=5,
    asks=SAFETY,
    scenarios=("ml_own_dense", "ml_own_crates"),
    needs=("drives", "model_accuracy", "prediction_time"),
    requires=TRAINING,
)
def test_drives_own_model(runs: Runs) -> None:
    """Your model drives your controller through worlds denser than those it learned from."""
    keeps_distance(runs, 0.0)


def _trained(runs: Runs) -> tuple[Recording, Training]:
    (recording,) = runs
    if recording.training is None:
        fail("nothing was trained in this recording", recording=recording)
    return recording, recording.training


def _require_success(
    recording: Recording, training: Training, run: ScriptRun, help: str = ""
) -> None:
    if run.succeeded:
        return
    death = death_of(run.detail)
    said = [line.text for line in recording.log if line.text.strip()]
    fail(
        f"the training script failed: {run.text}",
        expected=COMMAND.format(training.script) + " to end without an error",
        actual=said[-1] if run.kind == "exited" and said else run.text,
        recording=recording,
        help=help or advice_on(death) or "Run it yourself: `course dataset train.npz` makes data.",
        where=lines_of(death),
    )


def _require_file(recording: Recording, run: ScriptRun, option: str, name: str) -> None:
    if run.files.get(name):
        return
    fail(
        f"the training script has not written {name}",
        expected=f"a file {name}, because it was started with {option} {name}",
        actual="an empty file" if name in run.files else "no such file",
        recording=recording,
        help="Take the names from the command line (argparse), do not hard-code them.",
    )


def _spell(type: str, shape: tuple[str, ...]) -> str:
    sizes = ", ".join(size or "n" for size in shape)
    kind = "float32" if type == FLOAT32 else type.removeprefix("tensor(").removesuffix(")")
    return f"{kind} ({sizes})"
