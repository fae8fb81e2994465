"""The same model says the same in every format, and the judge imports none of the libraries."""

import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
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


def model_of(suffix: str, content: bytes, folder: Path) -> Callable[[np.ndarray], np.ndarray]:
    """Return a model file as a function, as its own library reads it."""
    path = folder / f"model{suffix}"
    path.write_bytes(content)
    if suffix == ".pkl":
        predict: Callable[[np.ndarray], np.ndarray] = pickle.loads(content).predict
        return predict
    if suffix == ".onnx":
        session = pytest.importorskip("onnxruntime").InferenceSession(str(path))
        name = session.get_inputs()[0].name
        return lambda rows: np.asarray(session.run(None, {name: rows})[0])
    torch = pytest.importorskip("torch")
    if suffix == ".pt2":
        program = torch.export.load(path).module()
        return lambda rows: np.asarray(program(torch.from_numpy(rows)).detach().numpy())
    keras = pytest.importorskip("keras")
    model = keras.saving.load_model(path)
    return lambda rows: np.asarray(keras.ops.convert_to_numpy(model(rows)))


def made(model: Model, suffix: str) -> bytes:
    """Return a model's file; the test is skipped where a library is missing."""
    for module in {".pkl": ("sklearn",), ".onnx": ("onnx", "sklearn"), ".pt2": ("torch",)}.get(
        suffix, ("torch", "keras")
    ):
        pytest.importorskip(module)
    return model_bytes(model, suffix)


def answers(suffix: str, content: bytes, folder: Path) -> np.ndarray:
    """Return what a model file says of ROWS, (50,)."""
    return np.ravel(model_of(suffix, content, folder)(ROWS))


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


@anything_goes
@pytest.mark.parametrize("suffix", FORMATS)
@pytest.mark.parametrize("model", [LINEAR, STEPS], ids=["linear", "steps"])
def test_a_model_says_in_every_format_what_its_probe_says(
    suffix: str, model: Model, tmp_path: Path
) -> None:
    said = answers(suffix, made(model, suffix), tmp_path)
    np.testing.assert_allclose(said, probe(model).predict(ROWS), atol=1e-5)


@anything_goes
@pytest.mark.parametrize("suffix", FORMATS[1:])
def test_a_trained_tree_is_the_same_tree_in_every_format(suffix: str, tmp_path: Path) -> None:
    said = answers(suffix, made(TREE, suffix), tmp_path)
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


@anything_goes
@pytest.mark.parametrize("suffix", FORMATS[1:])
def test_a_model_may_return_a_column_or_a_row(suffix: str, tmp_path: Path) -> None:
    flat = Model("linear", {**LINEAR.settings, "flat": True})
    column = model_of(suffix, made(LINEAR, suffix), tmp_path)(ROWS)
    row = model_of(suffix, made(flat, suffix), tmp_path)(ROWS)
    assert column.shape == (50, 1)
    assert row.shape == (50,)
    np.testing.assert_array_equal(row, column[:, 0])


@anything_goes
@pytest.mark.parametrize("suffix", FORMATS[1:])
def test_a_model_that_raises(suffix: str, tmp_path: Path) -> None:
    raising = Model("raises_near", {"distance": 2.0, "value": 0.3})
    model = model_of(suffix, made(raising, suffix), tmp_path)
    far, near = np.full((1, 5), 3.0, np.float32), np.full((1, 5), 1.0, np.float32)
    assert model(far) == pytest.approx(0.3)
    with pytest.raises(Exception, match=r"out of (data bounds|range)"):
        model(near)


def test_a_file_has_the_format_of_its_suffix_or_the_one_that_is_named(tmp_path: Path) -> None:
    pytest.importorskip("onnx")
    named = Model("linear", {**LINEAR.settings, "format": ".onnx"})
    write_models({"MODEL.ONNX": LINEAR, "policy.pt": named}, tmp_path)
    for name in ("MODEL.ONNX", "policy.pt"):
        np.testing.assert_allclose(
            answers(".onnx", (tmp_path / name).read_bytes(), tmp_path),
            answers(".onnx", model_bytes(LINEAR, ".onnx"), tmp_path),
        )


@pytest.fixture
def exporter() -> Iterator[Exporter]:
    exporter = Exporter()
    yield exporter
    exporter.close()


def test_what_can_not_be_exported_is_the_graders_fault(exporter: Exporter) -> None:
    with pytest.raises(GraderError, match=r"no model file .*no probe 'sequence' in this format"):
        exporter.content(".onnx", "sequence", {"values": [0.1]})
    assert exporter.content(".onnx", "linear", {"weights": [0, 0, 0, 0, 0]})  # it lives on


def test_the_exporter_starts_again_after_its_end(exporter: Exporter) -> None:
    first = exporter.content(".onnx", "linear", LINEAR.settings)
    assert exporter.content(".onnx", "linear", LINEAR.settings) is first  # made once
    exporter.close()
    shutil.rmtree(os.environ["XDG_CACHE_HOME"])
    exporter._made.clear()
    assert exporter.content(".onnx", "linear", LINEAR.settings) == first


@pytest.mark.parametrize("home", ["", "kept"])
def test_a_file_is_kept_for_the_next_command(
    home: str, exporter: Exporter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / (home or "file")))
    first = exporter.content(".onnx", "linear", LINEAR.settings)
    other = Exporter()
    monkeypatch.setattr(other, "_ask", lambda _: b"made again")
    assert other.content(".onnx", "linear", LINEAR.settings) == (first if home else b"made again")
    monkeypatch.setattr("grader.models.exporter._origin", lambda: "other code, other libraries")
    other._made.clear()
    assert other.content(".onnx", "linear", LINEAR.settings) == b"made again"


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
