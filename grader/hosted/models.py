"""Load the models that a training script has left, and predict: two tasks of a host.

The judge never loads such a model itself: unpickling runs whatever code the pickle asks for.
"""

from __future__ import annotations

import importlib
import pickle
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from grader.hosted.fields import MAX_LINE, Name, Text, sendable

LOAD, PREDICT = "grader.hosted.models:load", "grader.hosted.models:predict"  # the tasks
CONVERT = "grader.hosted.models:convert"
FEATURES = 5
MAX_VALUES = 100_000  # predictions in one answer

_models: dict[str, Any] = {}  # of this process, by file


class LoadModels(msgspec.Struct, frozen=True):
    """Load these files of the working folder, pickles and one ONNX model."""

    pickles: tuple[str, ...]
    onnx: str


class Tensor(msgspec.Struct, array_like=True, frozen=True):
    """An input or output of an ONNX model."""

    type: Name  # "tensor(float)"
    shape: Annotated[tuple[Name, ...], msgspec.Meta(max_length=16)]  # "5", or "" where it is free


Tensors = Annotated[tuple[Tensor, ...], msgspec.Meta(max_length=100)]


class Loaded(msgspec.Struct, frozen=True):
    """Which models could be loaded."""

    problems: dict[Name, Text]  # by file; "" if there is none
    inputs: Tensors = ()  # of the ONNX model
    outputs: Tensors = ()


class Predict(msgspec.Struct, frozen=True):
    """Ask a model about these features."""

    file: str
    features: bytes  # (n, 5) float64


class Predicted(msgspec.Struct, frozen=True):
    """A model's answer."""

    problem: Text = ""
    shape: Annotated[tuple[int, ...], msgspec.Meta(max_length=16)] = ()
    values: bytes = b""  # float64


def load(order: bytes) -> bytes:
    """Load models, as `LoadModels` says; return `Loaded`."""
    return msgspec.msgpack.encode(_load(msgspec.msgpack.decode(order, type=LoadModels), _models))


def predict(order: bytes) -> bytes:
    """Predict, as `Predict` says; return `Predicted`."""
    return msgspec.msgpack.encode(_predict(msgspec.msgpack.decode(order, type=Predict), _models))


def convert(order: bytes) -> bytes:
    """Convert a model to ONNX as a script does, and predict with that; return `Predicted`."""
    return msgspec.msgpack.encode(_convert(msgspec.msgpack.decode(order, type=Predict), _models))


def _load(order: LoadModels, models: dict[str, Any]) -> Loaded:
    problems = {name: _load_pickle(name, models) for name in order.pickles}
    try:
        session = _session(order.onnx)
    except Exception as error:
        return Loaded({**problems, order.onnx: _problem(error)})
    models[order.onnx] = _Onnx(session)
    return Loaded(
        {**problems, order.onnx: ""},
        tuple(_tensor(node) for node in session.get_inputs()),
        tuple(_tensor(node) for node in session.get_outputs()),
    )


def _session(model: str | bytes) -> Any:
    onnxruntime: Any = importlib.import_module("onnxruntime")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])


def _load_pickle(name: str, models: dict[str, Any]) -> str:
    try:
        models[name] = pickle.loads(Path(name).read_bytes())
    except BaseException as error:  # a pickle can raise anything
        return _problem(error)
    return ""


def _predict(order: Predict, models: dict[str, Any]) -> Predicted:
    features = np.frombuffer(order.features).reshape(-1, FEATURES).copy()
    try:
        values = np.asarray(models[order.file].predict(features), dtype=float)
    except BaseException as error:  # a model can raise anything
        return Predicted(_problem(error))
    if values.size > MAX_VALUES:
        return Predicted(f"predict gave {values.size} values for {len(features)} rows")
    return Predicted("", values.shape, values.tobytes())


def _convert(order: Predict, models: dict[str, Any]) -> Predicted:
    model = models[order.file]
    try:
        skl2onnx: Any = importlib.import_module("skl2onnx")
        written = skl2onnx.to_onnx(model, np.zeros((1, FEATURES), np.float32))
        converted = _Onnx(_session(written.SerializeToString()))
    except BaseException as error:  # skl2onnx raises anything, too
        return Predicted(f"{type(model).__name__[:80]}, {_problem(error)}")
    return _predict(order, {order.file: converted})


class _Onnx:
    """An ONNX session with the interface of a scikit-learn model."""

    def __init__(self, session: Any) -> None:
        self._session = session
        self._input = session.get_inputs()[0].name

    def predict(self, features: Any) -> Any:
        """Return the first output."""
        return self._session.run(None, {self._input: features.astype(np.float32)})[0]


def _tensor(node: Any) -> Tensor:
    shape = tuple(str(size) if isinstance(size, int) else "" for size in (node.shape or ()))
    return Tensor(str(node.type)[:100], shape[:16])


def _problem(error: BaseException) -> str:
    return sendable(f"{type(error).__name__}: {error}"[:MAX_LINE]) or "unknown"
