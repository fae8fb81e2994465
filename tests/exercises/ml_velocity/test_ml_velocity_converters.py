"""The table of hints.md: which regressors skl2onnx writes, with the versions that are pinned."""

import importlib
import re
from pathlib import Path

import numpy as np
import pytest

from grader.hosted.models import Predict, _convert

pytest.importorskip("skl2onnx")
HINTS = Path(__file__).parents[3] / "exercises/ml_velocity/hints.md"
MODULES = [importlib.import_module(f"sklearn.{name}") for name in (
    "compose", "ensemble", "kernel_ridge", "linear_model", "model_selection", "neighbors",
    "neural_network", "pipeline", "preprocessing", "svm", "tree",
)]  # fmt: skip
FOREST = "RandomForestRegressor(9, random_state=0)"
SEARCHED = f"{FOREST}, {{'min_samples_leaf': [1, 2]}}, cv=2"
TWO = f"[('a', {FOREST}), ('b', Ridge())]"
OUTCOMES = {"the same": (
    FOREST, "ExtraTreesRegressor(9)", "BaggingRegressor()", "GradientBoostingRegressor()",
    "DecisionTreeRegressor()", f"StackingRegressor({TWO})", "LinearRegression()", "Ridge()",
    "make_pipeline(StandardScaler(), MLPRegressor(max_iter=9, random_state=0))",
    "make_pipeline(StandardScaler(), SVR())", "KNeighborsRegressor()",
    f"GridSearchCV({SEARCHED})", f"VotingRegressor({TWO}, weights=np.array([1, 2]))",
    f"RandomizedSearchCV({SEARCHED}, n_iter=2).fit(x, y).best_estimator_",
), "can't be written": (
    "HistGradientBoostingRegressor(max_iter=9)", f"RandomizedSearchCV({SEARCHED}, n_iter=2)",
    f"VotingRegressor({TWO}, weights=[1, 2])", "KernelRidge()",
    "TransformedTargetRegressor(Ridge(), func=np.sqrt, inverse_func=np.square)",
    "make_pipeline(SplineTransformer(), Ridge())",
    "make_pipeline(FunctionTransformer(np.log1p), Ridge())",
), "another": (
    "KNeighborsRegressor(weights='distance')", f"make_pipeline(StandardScaler(), {FOREST})",
)}  # fmt: skip
ROWS = [(written, outcome) for outcome, each in OUTCOMES.items() for written in each]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("written", "outcome"), ROWS)
def test_the_table_says_what_comes_of_it(written: str, outcome: str) -> None:
    scope = {name: each for module in MODULES[::-1] for name, each in vars(module).items()}
    x = np.round(np.random.default_rng(0).uniform(0.2, 9, (400, 5)), 1).astype(np.float32)
    scope |= {"np": np, "x": x, "y": np.minimum(x[:, 0] / 9, x[:, 1:].min(axis=1))}
    model = eval(written, scope).fit(x, scope["y"])

    said = _convert(Predict("it", x.astype(float).tobytes()), {"it": model})

    gap = np.inf if said.problem else np.abs(np.frombuffer(said.values) - model.predict(x))
    agrees = "the same" if np.mean(gap <= 1e-4) >= 0.98 else "another"
    assert ("can't be written" if said.problem else agrees) == outcome, said.problem
    table = HINTS.read_text().partition("| Regressor |")[2].partition("</details>")[0]
    assert all(name in table for name in re.findall(r"[A-Z]\w+(?=\()", written))
