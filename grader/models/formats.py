"""Write one model in any of four formats, in a process that serves `grader.models.exporter`.

The judge must not import PyTorch, Keras or scikit-learn; this process does, when first needed. A
request is a line of JSON, and so is its answer::

    {"suffix": ".onnx", "probe": "linear", "settings": {"weights": [...], "offset": 0.1}}
    {"content": "<base64>"}    or    {"problem": "no module named torch"}

Whatever its format, a model is linear or a decision tree; a pickle may hold a forest. It computes
in float32, takes features (n, 5) and returns (n, 1), with `flat` (n,), as scikit-learn's do. No
file needs code of ours.
"""

from __future__ import annotations

import base64
import io
import json
import os
import pickle
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grader.models.dataset import make_dataset
from grader.models.features import features
from grader.models.scans import PROFILE

FEATURES = 5
ONNX_OPSETS = (("", 17), ("ai.onnx.ml", 3))
ONNX_FORMAT = 8  # the oldest that has these operators: every onnxruntime of today reads it
PROTOCOL = 4  # of pickle

Settings = Mapping[str, Any]


@dataclass(frozen=True)
class Linear:
    """The weights times the features, plus the offset."""

    weights: tuple[float, ...]
    offset: float


@dataclass(frozen=True)
class Leaf:
    """The end of a path through a tree."""

    value: float  # [m/s]; may be NaN or infinite


@dataclass(frozen=True)
class Fork:
    """Go left where the feature is at most the threshold (in float32)."""

    feature: int
    threshold: float
    left: Fork | Leaf
    right: Fork | Leaf


@dataclass(frozen=True)
class RaisesNear:
    """Returns the value; raises where the front minimum is below the distance."""

    distance: float
    value: float


Model = Linear | Fork | Leaf | RaisesNear


def content(suffix: str, probe: str, settings: Settings) -> bytes:
    """Return the content of a model file with this suffix (in lower case)."""
    if suffix == ".pkl":
        return _pickled(probe, settings)
    return _WRITERS[suffix](_model(probe, settings), settings)


def _model(probe: str, settings: Settings) -> Model:
    if probe == "linear":
        weights = tuple(float(weight) for weight in settings["weights"])
        return Linear(weights, float(settings.get("offset", 0.0)))
    if probe == "by_distance":
        return _steps(settings["values"], 0)
    if probe == "raises_near":
        return RaisesNear(settings["distance"], settings["value"])
    if probe == "tree":
        return _grown(_learnt_tree(settings).tree_, 0)
    raise ValueError(f"no probe {probe!r} in this format")


def _steps(values: Sequence[float], first: int) -> Fork | Leaf:
    """Return a tree that gives `values[i]` where the front minimum is about `first + i` metres."""
    if len(values) == 1:
        return Leaf(float(values[0]))
    half = len(values) // 2
    left, right = _steps(values[:half], first), _steps(values[half:], first + half)
    return Fork(0, first + half - 0.5, left, right)


# --- scikit-learn ---------------------------------------------------------------------------------


def _pickled(probe: str, settings: Settings) -> bytes:
    if probe == "tree":
        return pickle.dumps(_learnt_tree(settings), PROTOCOL)
    if probe == "trained":
        return pickle.dumps(_learnt_forest(**settings), PROTOCOL)
    from sklearn.linear_model import LinearRegression  # noqa: PLC0415

    model = _model(probe, settings)
    if not isinstance(model, Linear):
        raise ValueError(f"no probe {probe!r} as a model of scikit-learn")
    regression = LinearRegression()
    regression.coef_, regression.intercept_ = np.array(model.weights), model.offset
    regression.n_features_in_ = FEATURES
    return pickle.dumps(regression, PROTOCOL)


def _learnt_tree(settings: Settings) -> Any:
    """Return a DecisionTreeRegressor fitted to the expert's speeds."""
    from sklearn.tree import DecisionTreeRegressor  # noqa: PLC0415

    tree = DecisionTreeRegressor(max_depth=int(settings["depth"]), random_state=0)
    return _fitted(tree, settings["rows"], settings["seed"])


def _learnt_forest(rows: float = 600, trees: float = 12, seed: float = 5) -> Any:
    from sklearn.ensemble import RandomForestRegressor  # noqa: PLC0415

    forest = RandomForestRegressor(n_estimators=int(trees), random_state=int(seed))
    return _fitted(forest, rows, seed)


def _fitted(model: Any, rows: float, seed: float) -> Any:
    """Return a model of scikit-learn's that has learnt the expert's speeds."""
    data = make_dataset(int(rows), int(seed))
    seen = features(data.ranges, np.degrees(PROFILE.angles), PROFILE.range_min, PROFILE.range_max)
    whole = np.isfinite(seen).all(axis=1)
    return model.fit(seen[whole], data.speed[whole])


def _grown(tree: Any, node: int) -> Fork | Leaf:
    """Return the subtree at a node of scikit-learn's tree."""
    if tree.children_left[node] < 0:
        return Leaf(float(tree.value[node, 0, 0]))
    return Fork(
        int(tree.feature[node]),
        _at_most(float(tree.threshold[node])),
        _grown(tree, tree.children_left[node]),
        _grown(tree, tree.children_right[node]),
    )


def _at_most(threshold: float) -> float:
    """Return the greatest float32 not above the threshold: it splits all float32 the same way."""
    rounded = np.float32(threshold)
    if rounded > threshold:
        rounded = np.nextafter(rounded, np.float32(-np.inf))
    return float(rounded)


# --- ONNX -----------------------------------------------------------------------------------------


def _onnx(model: Model, settings: Settings) -> bytes:
    import onnx  # noqa: PLC0415
    from onnx import TensorProto, helper  # noqa: PLC0415

    given, said = settings.get("input", "features"), settings.get("output", "speed")
    flat = bool(settings.get("flat", False))
    nodes, constants = _onnx_nodes(helper, model, given)
    if flat:
        constants["one_row"] = np.array([-1])
        nodes.append(helper.make_node("Reshape", ["column", "one_row"], [said]))
    else:
        nodes.append(helper.make_node("Identity", ["column"], [said]))
    graph = helper.make_graph(
        nodes,
        "velocity_model",
        [helper.make_tensor_value_info(given, TensorProto.FLOAT, [None, FEATURES])],
        [helper.make_tensor_value_info(said, TensorProto.FLOAT, [None] if flat else [None, 1])],
        [onnx.numpy_helper.from_array(array, name) for name, array in constants.items()],
    )
    opsets = [helper.make_opsetid(*opset) for opset in ONNX_OPSETS]
    made = helper.make_model(graph, opset_imports=opsets, ir_version=ONNX_FORMAT)
    onnx.checker.check_model(made)
    return bytes(made.SerializeToString())


def _onnx_nodes(
    helper: Any, model: Model, given: str
) -> tuple[list[Any], dict[str, np.ndarray[Any, Any]]]:
    """Return the nodes from the input `given` to `column`, (n, 1), and their constants."""
    make = helper.make_node
    if isinstance(model, Linear):
        weights = np.array(model.weights, np.float32)[:, None]
        return (
            [
                make("MatMul", [given, "weights"], ["sum"]),
                make("Add", ["sum", "offset"], ["column"]),
            ],
            {"weights": weights, "offset": np.array([model.offset], np.float32)},
        )
    if isinstance(model, RaisesNear):  # below the distance the index is 1, which is out of range
        chain = [
            make("Gather", [given, "first"], ["nearest"], axis=1),
            make("Less", ["nearest", "distance"], ["near"]),
            make("Cast", ["near"], ["index"], to=7),  # int64
            make("Gather", ["values", "index"], ["column"]),
        ]
        return chain, {
            "first": np.array([0]),
            "distance": np.array([model.distance], np.float32),
            "values": np.array([model.value], np.float32),
        }
    ensemble = make(
        "TreeEnsembleRegressor", [given], ["column"], domain="ai.onnx.ml", n_targets=1,
        **_onnx_tree(model),
    )  # fmt: skip
    return [ensemble], {}


def _onnx_tree(model: Fork | Leaf) -> dict[str, list[Any]]:
    """Return the attributes of a TreeEnsembleRegressor of this one tree."""
    rows: list[tuple[int, str, int, float, int, int]] = []  # id, mode, feature, value, yes, no
    leaves: list[tuple[int, float]] = []

    def add(node: Fork | Leaf) -> int:
        number = len(rows)
        rows.append((number, "LEAF", 0, 0.0, 0, 0))
        if isinstance(node, Leaf):
            leaves.append((number, node.value))
        else:
            yes, no = add(node.left), add(node.right)
            rows[number] = (number, "BRANCH_LEQ", node.feature, node.threshold, yes, no)
        return number

    add(model)
    ids, modes, chosen, values, yes, no = (list(column) for column in zip(*rows, strict=True))
    return {
        "nodes_treeids": [0] * len(rows),
        "nodes_nodeids": ids,
        "nodes_modes": modes,
        "nodes_featureids": chosen,
        "nodes_values": values,
        "nodes_truenodeids": yes,
        "nodes_falsenodeids": no,
        "target_treeids": [0] * len(leaves),
        "target_nodeids": [number for number, _ in leaves],
        "target_ids": [0] * len(leaves),
        "target_weights": [value for _, value in leaves],
    }


# --- PyTorch --------------------------------------------------------------------------------------


def _torch(model: Model, settings: Settings) -> bytes:
    import torch  # noqa: PLC0415

    class Network(torch.nn.Module):  # type: ignore[misc]
        """A linear layer."""

        def __init__(self, linear: Linear) -> None:
            super().__init__()
            self.layer = torch.nn.Linear(FEATURES, 1)
            with torch.no_grad():
                self.layer.weight.copy_(torch.tensor([linear.weights]))
                self.layer.bias.fill_(linear.offset)

        def forward(self, features: Any) -> Any:
            return self.layer(features)

    class Tree(torch.nn.Module):  # type: ignore[misc]
        """A choice between two values at each fork."""

        def __init__(self, root: Fork | Leaf) -> None:
            super().__init__()
            self.root = root

        def forward(self, features: Any) -> Any:
            return self._said(self.root, features)[:, None]

        def _said(self, node: Fork | Leaf, features: Any) -> Any:
            if isinstance(node, Leaf):
                return torch.full_like(features[:, 0], node.value)
            left, right = self._said(node.left, features), self._said(node.right, features)
            return torch.where(features[:, node.feature] <= node.threshold, left, right)

    class Raising(torch.nn.Module):  # type: ignore[misc]
        """A list of one value, and an index that is 1 below the distance."""

        def __init__(self, raising: RaisesNear) -> None:
            super().__init__()
            self.distance = raising.distance
            self.register_buffer("values", torch.tensor([raising.value]))

        def forward(self, features: Any) -> Any:
            index = (features[:, 0] < self.distance).long()
            return torch.index_select(self.values, 0, index)[:, None]

    class Flat(torch.nn.Module):  # type: ignore[misc]
        """Numbers (n,) in the place of (n, 1)."""

        def __init__(self, column: Any) -> None:
            super().__init__()
            self.column = column

        def forward(self, features: Any) -> Any:
            return self.column(features)[:, 0]

    if isinstance(model, RaisesNear):
        module: Any = Raising(model)
    else:
        module = Network(model) if isinstance(model, Linear) else Tree(model)
    if settings.get("flat", False):
        module = Flat(module)
    rows = ({0: torch.export.Dim.AUTO},)
    program = torch.export.export(module.eval(), (torch.zeros(2, FEATURES),), dynamic_shapes=rows)
    file = io.BytesIO()
    torch.export.save(program, file)
    return file.getvalue()


# --- Keras ----------------------------------------------------------------------------------------


def _keras(model: Model, settings: Settings) -> bytes:
    import keras  # noqa: PLC0415

    def said(node: Fork | Leaf) -> Any:
        if isinstance(node, Leaf):
            return node.value
        condition = given[:, node.feature : node.feature + 1] <= node.threshold
        return keras.ops.where(condition, said(node.left), said(node.right))

    given = keras.Input((FEATURES,), name="features")
    if isinstance(model, Linear):
        layer = keras.layers.Dense(1)
        column = layer(given)
        layer.set_weights([np.array(model.weights)[:, None], np.array([model.offset])])
    elif isinstance(model, Fork):
        column = said(model)
    elif isinstance(model, RaisesNear):  # a list of one value; below the distance the index is 1
        layer = keras.layers.Embedding(1, 1)
        column = layer(keras.ops.cast(given[:, 0] < model.distance, "int32"))
        layer.set_weights([np.array([[model.value]])])
    else:
        raise ValueError("no such model in this format")
    network = keras.Model(given, column[:, 0] if settings.get("flat", False) else column)
    with tempfile.TemporaryDirectory(prefix="course-model-") as folder:
        path = Path(folder) / "model.keras"
        network.save(path)
        return path.read_bytes()


_WRITERS: dict[str, Callable[[Model, Settings], bytes]] = {
    ".onnx": _onnx,
    ".pt2": _torch,
    ".keras": _keras,
}


def main() -> None:
    """Answer requests until there are no more."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what libraries print goes to stderr
    for line in sys.stdin:
        request = json.loads(line)
        try:
            made = content(request["suffix"], request["probe"], request["settings"])
            answer = {"content": base64.b64encode(made).decode("ascii")}
        except Exception as error:
            answer = {"problem": f"{type(error).__name__}: {error}"}
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main()
