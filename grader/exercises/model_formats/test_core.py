"""The core checks of exercise 8: the node, and each format; with those of loading they sum to 100.

26 of the points are about PyTorch and Keras.
"""

from __future__ import annotations

from grader.checks.case import Runs
from grader.checks.check import DECISION, SAFETY, WIRING, check
from grader.checks.model_commands import FREE, obeys_parameters, predicts
from grader.checks.verbs import answers_once, drives_on, keeps_distance, only_linear_x, wired
from grader.exercises.model_formats.contract import KERAS, ONNX, SKLEARN, TORCH, deep

READINGS, LONG, BLIND = "format_readings", "format_hundred", "format_blind"
PARAMETERS = ("format_parameters", "format_held", "format_defaults")
STANDING = (BLIND, "format_no_file", "format_raises_pickle")
SAYS = "The model says the same of whatever it is given, a float32 table (1, 5): publish that."
SHAPES = "(n,) and (n, 1) both hold n numbers: np.ravel treats them alike."


@check(points=3, asks=WIRING, task=1, scenarios=(READINGS,), needs=())
def test_wiring(runs: Runs) -> None:
    """The node starts, spins, listens to /scan and publishes on /cmd_vel."""
    wired(runs)


@check(points=3, asks=DECISION, task=8, scenarios=(READINGS, LONG, BLIND, "format_says_pickle"))
def test_one_command_per_scan(runs: Runs) -> None:
    """Each scan is answered by exactly one Twist, and none comes before the first scan."""
    answers_once(runs)


@check(points=2, asks=DECISION, task=8, scenarios=(READINGS, *STANDING))
def test_only_linear_x(runs: Runs) -> None:
    """Every field of the Twist but linear.x is zero."""
    only_linear_x(runs, "The model only chooses how fast to drive straight ahead.")


@check(points=4, asks=DECISION, task=3, scenarios=(READINGS, LONG))
def test_readings(runs: Runs) -> None:
    """The features are those of exercise 2: infinities replaced, unusable readings dropped."""
    predicts(runs, "readings", help="Compare with your function of exercise 2, and its README.")


@check(points=4, asks=SAFETY, task=8, scenarios=(BLIND,))
def test_blind_sector(runs: Runs) -> None:
    """A sector without a usable reading means 0.0, and the node goes on."""
    predicts(runs, "blind")


@check(points=2, asks=WIRING, task=8, scenarios=PARAMETERS)
def test_parameters(runs: Runs) -> None:
    """The parameters model_path and max_speed are obeyed, and have their defaults."""
    obeys_parameters(runs, "0.0 is a number, too, though it is not true.")


@check(points=7, asks=DECISION, task=3, scenarios=("format_pickle",), requires=SKLEARN, hint="3.1")
def test_pickle(runs: Runs) -> None:
    """Drives at the speed that a scikit-learn model predicts (.pkl)."""
    predicts(runs, "features", help=SAYS)


@check(points=8, asks=DECISION, task=4, scenarios=("format_onnx",), requires=ONNX, hint="4.1")
def test_onnx(runs: Runs) -> None:
    """Drives at the speed that an ONNX model predicts (.onnx, output (n, 1))."""
    predicts(runs, "features", help=f"{SAYS} The session wants float32.")


@check(
    points=4,
    asks=DECISION,
    task=4,
    scenarios=("format_onnx_flat",),
    needs=("onnx",),
    requires=ONNX,
    hint="4.2",
)
def test_onnx_names(runs: Runs) -> None:
    """Takes an ONNX model with other names, and an output of the shape (n,)."""
    predicts(runs, "features", help=f"Ask the session: get_inputs()[0].name. {SHAPES}")


@check(points=6, asks=DECISION, task=5, scenarios=("format_torch",), requires=TORCH, hint="5.1")
def test_torch_export(runs: Runs) -> None:
    """Drives at the speed that a PyTorch program predicts (.pt2)."""
    help = "torch.export.load(path).module() is what can be called, with a float32 tensor (1, 5)."
    predicts(runs, "features", help=help)


@check(points=6, asks=DECISION, task=6, scenarios=("format_keras",), requires=KERAS, hint="6.1")
def test_keras(runs: Runs) -> None:
    """Drives at the speed that a Keras model predicts (.keras)."""
    predicts(runs, "features", help=f"{SAYS} keras.saving.load_model(path) loads it.")


@deep(points=3, asks=DECISION, task=7, scenarios=("format_other_torch", "format_other_keras"))
def test_deep_other_models(runs: Runs) -> None:
    """Takes other .pt2 and .keras: output (n,), POLICY.PT2, Keras and device = cuda."""
    predicts(runs, "features", help=f"{SHAPES} The suffix may be in capitals.")


@check(
    points=2,
    asks=SAFETY,
    scenarios=("format_drive_pickle", "format_drive_onnx"),
    needs=("one_command_per_scan", "pickle", "onnx"),
    requires=SKLEARN + ONNX,
)
def test_drives(runs: Runs) -> None:
    """The same trained decision tree drives the robot as .pkl and as .onnx, without contact."""
    keeps_distance(runs, 0.0)
    drives_on(runs, FREE)


@check(
    points=2,
    asks=SAFETY,
    scenarios=("format_drive_torch", "format_drive_keras"),
    needs=("one_command_per_scan", "torch_export", "keras"),
    requires=SKLEARN + KERAS,
)
def test_deep_drives(runs: Runs) -> None:
    """The same tree drives the robot as .pt2 and as .keras, without contact."""
    keeps_distance(runs, 0.0)
    drives_on(runs, FREE)
