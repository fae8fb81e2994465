"""A host for programs that return, and for the models that they leave behind, in real time.

The judge gives one order at a time: run this script, load these models, predict. It never loads a
model itself: unpickling runs whatever code the pickle asks for.
"""

from __future__ import annotations

import importlib
import pickle
from pathlib import Path
from typing import Any

import numpy as np

from . import imports, program, randomness
from .frames import (
    Ended,
    FromScript,
    Loaded,
    LoadModels,
    Predict,
    Predicted,
    ProgramStart,
    Script,
    Tensor,
)
from .wire import MAX_LINE, Wire, ended, sendable

FEATURES = 5
MAX_VALUES = 100_000  # predictions in one answer


def serve(read_fd: int, write_fd: int) -> None:
    """Carry out the judge's orders until it is gone; never returns."""
    models: dict[str, Any] = {}
    wire = Wire(read_fd, write_fd)
    while True:
        match wire.receive():
            case Script() as order:
                answer: FromScript = _run(order)
            case LoadModels() as order:
                answer = _load(order, models)
            case Predict() as order:
                answer = _predict(order, models)
            case other:
                raise ValueError(f"{type(other).__name__} is for nodes")
        wire.send(answer)


def _run(order: Script) -> Ended:
    randomness.seed(order.seed)  # a fork inherits the fork server's generators
    imports.host.enter([str(Path(order.file).parent)])
    kind, text, detail = program.run_file(ProgramStart(order.file, order.arguments))
    return ended(kind, text, detail)


def _load(order: LoadModels, models: dict[str, Any]) -> Loaded:
    problems = {name: _load_pickle(name, models) for name in order.pickles}
    try:
        onnxruntime: Any = importlib.import_module("onnxruntime")
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        session = onnxruntime.InferenceSession(
            order.onnx, options, providers=["CPUExecutionProvider"]
        )
    except Exception as error:
        return Loaded({**problems, order.onnx: _problem(error)})
    models[order.onnx] = _Onnx(session)
    return Loaded(
        {**problems, order.onnx: ""},
        tuple(_tensor(node) for node in session.get_inputs()),
        tuple(_tensor(node) for node in session.get_outputs()),
    )


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
