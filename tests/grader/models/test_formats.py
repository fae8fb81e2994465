"""The same model says the same in every format, and the judge imports none of the libraries."""

import pickle
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from grader.errors import GraderError
from grader.models.exporter import Exporter
from grader.models.files import model_bytes, probe, write_models
from sim.scenario import Model

nan, inf = float("nan"), float("inf")
LINEAR = Model("linear", {"weights": (0.02, 0.03, -0.05, 0.015, 0.01), "offset": 0.08})
STEPS = Model("by_distance", {"values": (0.0, 0.2, 9.9, -3.0, nan, inf, -inf, 0.3)})
TREE = Model("tree", {"rows": 300.0, "depth": 4.0, "seed": 5.0})
ROWS = np.random.default_rng(1).uniform(0.2, 6.8, (50, 5)).astype(np.float32)
ROWS[:25, 0] = np.linspace(0.2, 0.49, 25)  # [m] ahead: here the trained tree has its thresholds

deep = pytest.mark.deep
anything_goes = pytest.mark.filterwarnings("ignore")  # of what other libraries say on import


def answers(suffix: str, content: bytes, folder: Path) -> np.ndarray:
    """Return what a model file says of ROWS, as its own library reads it."""
    path = folder / f"model{suffix}"
    path.write_bytes(content)
    if suffix == ".pkl":
        return np.ravel(pickle.loads(content).predict(ROWS))
    if suffix == ".onnx":
        session = pytest.importorskip("onnxruntime").InferenceSession(str(path))
        return np.ravel(session.run(None, {session.get_inputs()[0].name: ROWS})[0])
    torch = pytest.importorskip("torch")
    if suffix == ".pt2":
        with torch.no_grad():
            return torch.export.load(path).module()(torch.from_numpy(ROWS)).numpy().ravel()
    keras = pytest.importorskip("keras")
    return np.ravel(keras.ops.convert_to_numpy(keras.saving.load_model(path)(ROWS)))


FORMATS = [
    pytest.param(".pkl"),
    pytest.param(".onnx"),
    pytest.param(".pt2", marks=deep),
    pytest.param(".keras", marks=deep),
]


@pytest.fixture(autouse=True)
def keras_on_torch(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("KERAS_BACKEND", "torch")
    monkeypatch.setenv("KERAS_HOME", str(tmp_path))


def needs(suffix: str) -> None:
    for module in {".pkl": ("sklearn",), ".onnx": ("onnx", "sklearn"), ".pt2": ("torch",)}.get(
        suffix, ("torch", "keras")
    ):
        pytest.importorskip(module)


@anything_goes
@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("model", [LINEAR, STEPS], ids=["linear", "steps"])
def test_a_model_says_in_every_format_what_its_probe_says(
    suffix: str, model: Model, tmp_path: Path
) -> None:
    needs(suffix)
    said = answers(suffix, model_bytes(model, suffix), tmp_path)
    np.testing.assert_allclose(said, probe(model).predict(ROWS), atol=1e-5)


@anything_goes
@pytest.mark.parametrize("suffix", FORMATS[1:])
def test_a_trained_tree_is_the_same_tree_in_every_format(suffix: str, tmp_path: Path) -> None:
    needs(suffix)
    said = answers(suffix, model_bytes(TREE, suffix), tmp_path)
    learnt = answers(".pkl", model_bytes(TREE, ".pkl"), tmp_path)
    np.testing.assert_allclose(said, learnt, atol=1e-5)
    assert len(set(learnt.round(3).tolist())) > 2


def test_an_onnx_model_may_be_called_as_the_scenario_likes(tmp_path: Path) -> None:
    onnxruntime = pytest.importorskip("onnxruntime")
    form = {"flat": True, "input": "X", "output": "variable"}
    model = Model("linear", {**LINEAR.settings, **form})
    session = onnxruntime.InferenceSession(model_bytes(model, ".onnx"))
    assert [given.name for given in session.get_inputs()] == ["X"]
    assert [said.name for said in session.get_outputs()] == ["variable"]
    assert session.run(None, {"X": ROWS})[0].shape == (50,)
    flat, column = model_bytes(model, ".onnx"), model_bytes(LINEAR, ".onnx")
    np.testing.assert_allclose(answers(".onnx", flat, tmp_path), answers(".onnx", column, tmp_path))


def test_an_onnx_model_that_raises(capfd: pytest.CaptureFixture[str]) -> None:
    onnxruntime = pytest.importorskip("onnxruntime")
    content = model_bytes(Model("raises_near", {"distance": 2.0, "value": 0.3}), ".onnx")
    session = onnxruntime.InferenceSession(content)
    far, near = np.full((1, 5), 3.0, np.float32), np.full((1, 5), 1.0, np.float32)
    assert session.run(None, {"features": far})[0] == pytest.approx(0.3)
    with pytest.raises(Exception, match="out of data bounds"):
        session.run(None, {"features": near})


def test_the_suffix_says_the_format_also_in_capitals(tmp_path: Path) -> None:
    pytest.importorskip("onnx")
    write_models(
        {"MODEL.ONNX": LINEAR, "policy.joblib": Model("constant", {"value": 1.0})}, tmp_path
    )
    assert (tmp_path / "MODEL.ONNX").read_bytes() == model_bytes(LINEAR, ".onnx")
    assert pickle.loads((tmp_path / "policy.joblib").read_bytes()).predict([[0]]) == 1.0


@pytest.fixture
def exporter() -> Iterator[Exporter]:
    exporter = Exporter()
    yield exporter
    exporter.close()


def test_what_can_not_be_exported_is_the_graders_fault(exporter: Exporter) -> None:
    with pytest.raises(GraderError, match=r"no model file .*no probe 'sequence' in this format"):
        exporter.content(".onnx", "sequence", {"values": [0.1]})
    assert exporter.content(".onnx", "linear", {"weights": [0, 0, 0, 0, 0]})  # it lives on


def test_a_file_is_made_once(exporter: Exporter) -> None:
    first = exporter.content(".onnx", "linear", LINEAR.settings)
    assert exporter.content(".onnx", "linear", LINEAR.settings) is first


def test_the_exporter_starts_again_after_its_end(exporter: Exporter) -> None:
    first = exporter.content(".onnx", "linear", LINEAR.settings)
    exporter.close()
    exporter._made.clear()
    assert exporter.content(".onnx", "linear", LINEAR.settings) == first


def test_the_judge_imports_none_of_the_libraries() -> None:
    code = """
import sys
from grader.models.files import model_bytes
from sim.scenario import Model
model_bytes(Model("linear", {"weights": (0.0, 0.0, 0.0, 0.0, 0.0)}), ".onnx")
print({"onnx", "onnxruntime", "torch", "keras", "sklearn"} & set(sys.modules))
"""
    pytest.importorskip("onnx")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
