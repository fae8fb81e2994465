"""Training scripts that misbehave: the judge stays safe, and says what was wrong."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from grader.course.submission import find_submission
from grader.recording import bag
from grader.trial.training import Trained, run_training
from rclpy_virtual_time.link.hosts import ForkServer
from sim.scenario import Scenario
from sim.scenario_files import scenario_from_toml

pytestmark = pytest.mark.skipif(find_spec("skl2onnx") is None, reason="skl2onnx is not installed")

SHORT = """
title = "Short"
duration = 1.0
[training]
script = "train.py"
rows = 100
hidden_rows = 100
time_limit = 2.0
[world]
"""
ARGUMENTS = "import sys\ndata, out, onnx = sys.argv[2::2]\n"


def train(forkserver: ForkServer, folder: Path, script: str | None, limit: float = 2.0) -> Trained:
    (folder / "node.py").write_text("pass\n")
    if script is not None:
        (folder / "train.py").write_text(ARGUMENTS + script)
    submission = find_submission(folder, "node.py", ["train.py"])
    return run_training(submission, short(limit), forkserver)


def short(limit: float = 2.0) -> Scenario:
    return scenario_from_toml(SHORT.replace("2.0", f"{limit}"), "short")


def test_a_missing_script_is_named(forkserver: ForkServer, tmp_path: Path) -> None:
    training = train(forkserver, tmp_path, None).recording.training
    assert training is not None
    assert training.problem == "there is no train.py beside node.py"


@pytest.mark.parametrize(
    ("script", "kind"),
    [
        ("raise ValueError('no')", "exception"),
        ("sys.exit(3)", "exited"),
        ("import os; os._exit(3)", "died"),
        pytest.param("while True: pass", "hung", marks=pytest.mark.long),
    ],
)
def test_a_script_that_fails(
    script: str, kind: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    trained = train(forkserver, tmp_path, script)
    assert trained.recording.training is not None
    (run,) = trained.recording.training.runs
    assert (run.kind, run.succeeded) == (kind, False)
    assert trained.pickle is None


@pytest.mark.parametrize("make", ["symlink('/etc/passwd', out)", "mkfifo(out)"])
def test_only_ordinary_files_are_taken(make: str, forkserver: ForkServer, tmp_path: Path) -> None:
    training = train(forkserver, tmp_path, f"import os; os.{make}").recording.training
    assert training is not None
    assert training.runs[0].succeeded
    assert training.runs[0].files == {}


@pytest.mark.parametrize("name", ["velocity_model.pkl", "velocity_model.onnx", "train.npz/x"])
def test_what_lay_there_before_was_not_written(
    name: str, forkserver: ForkServer, tmp_path: Path
) -> None:
    """Neither a model beside the script nor a folder with the name of the data counts."""
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("mine")
    training = train(forkserver, tmp_path, "open(data).close()").recording.training
    assert training is not None
    assert (training.made.kind, training.made.files) == ("returned", {})


def test_unpickling_happens_far_from_the_judge(forkserver: ForkServer, tmp_path: Path) -> None:
    script = (
        "class Evil:\n    def __reduce__(self):\n        import os\n        return os._exit, (7,)\n"
        "import pickle\nopen(out, 'wb').write(pickle.dumps(Evil()))\nopen(onnx, 'wb').write(b'x')\n"
    )
    training = train(forkserver, tmp_path, script).recording.training
    assert training is not None
    assert not training.pickle.loaded
    assert "ended or hung" in training.pickle.problem


def test_a_bag_keeps_what_was_trained(forkserver: ForkServer, tmp_path: Path) -> None:
    script = (
        "import pickle\nfrom sklearn.dummy import DummyRegressor\n"
        "model = DummyRegressor(strategy='constant', constant=0.25).fit([[0.0] * 5], [0.25])\n"
        "open(out, 'wb').write(pickle.dumps(model))\nopen(onnx, 'wb').write(b'no model')\n"
    )
    recording = train(forkserver, tmp_path, script).recording
    assert recording.training is not None
    assert set(recording.training.pickle.speeds) == {0.25}
    assert recording.training.onnx.problem
    loaded = bag.load(bag.save(recording, tmp_path / "bag"))
    assert loaded.training == recording.training
    assert loaded.digest() == recording.digest()


BOOSTED = """
import pickle, numpy
from sklearn.ensemble import HistGradientBoostingRegressor
from skl2onnx import to_onnx
from threadpoolctl import threadpool_limits
x = numpy.random.rand(400, 5)
with threadpool_limits(2):
    model = HistGradientBoostingRegressor(max_iter=3).fit(x, x[:, 0] / 2)
open(out, "wb").write(pickle.dumps(model))
to_onnx(model, x[:1].astype(numpy.float32))
"""


def test_what_the_converter_cannot_write_is_still_a_pickle(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    """Boosted trees compute in threads of OpenMP, which a forked process may hang on."""
    training = train(forkserver, tmp_path, BOOSTED, limit=60.0).recording.training
    assert training is not None
    assert (training.made.kind, training.plain, len(training.runs)) == ("exception", None, 2)
    assert (training.pickle.problem, training.pickle.shape) == ("", (100,))
    assert "HistGradientBoostingRegressor, ValueError" in training.converted.problem
