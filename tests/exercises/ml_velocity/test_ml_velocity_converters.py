"""The table of hints.md: which regressors skl2onnx writes, with the versions that are pinned."""

import importlib
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grader.hosted.models import Predict, _convert

pytest.importorskip("skl2onnx")
HINTS = Path(__file__).parents[3] / "exercises/ml_velocity/hints.md"
MODULES = (
    "ensemble", "linear_model", "neighbors", "neural_network", "svm", "tree", "preprocessing",
    "pipeline", "model_selection", "compose", "kernel_ridge",
)  # fmt: skip
FOREST = "RandomForestRegressor(9, random_state=0)"
SEARCHED = f"{FOREST}, {{'min_samples_leaf': [1, 2]}}, cv=2"
TWO = f"[('a', {FOREST}), ('b', Ridge())]"
SAME, OTHER, NONE = "the same", "another", "can't be written"
OUTCOMES = {
    FOREST: SAME,
    "ExtraTreesRegressor(9, random_state=0)": SAME,
    "BaggingRegressor(random_state=0)": SAME,
    "GradientBoostingRegressor(random_state=0)": SAME,
    "DecisionTreeRegressor(random_state=0)": SAME,
    f"StackingRegressor({TWO})": SAME,
    "make_pipeline(StandardScaler(), MLPRegressor(max_iter=9, random_state=0))": SAME,
    "make_pipeline(StandardScaler(), SVR())": SAME,
    "LinearRegression()": SAME,
    "Ridge()": SAME,
    "KNeighborsRegressor(5)": SAME,
    f"GridSearchCV({SEARCHED})": SAME,
    "HistGradientBoostingRegressor(max_iter=9)": NONE,
    f"RandomizedSearchCV({SEARCHED}, n_iter=2)": NONE,
    f"RandomizedSearchCV({SEARCHED}, n_iter=2).fit(x, y).best_estimator_": SAME,
    f"VotingRegressor({TWO}, weights=[1, 2])": NONE,
    f"VotingRegressor({TWO}, weights=np.array([1, 2]))": SAME,
    "TransformedTargetRegressor(Ridge(), func=np.sqrt, inverse_func=np.square)": NONE,
    "KernelRidge()": NONE,
    "make_pipeline(SplineTransformer(), Ridge())": NONE,
    "make_pipeline(FunctionTransformer(np.log1p), Ridge())": NONE,
    "KNeighborsRegressor(weights='distance')": OTHER,
    f"make_pipeline(StandardScaler(), {FOREST})": OTHER,
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("written", OUTCOMES)
def test_the_table_says_what_comes_of_it(written: str) -> None:
    modules = [importlib.import_module(f"sklearn.{name}") for name in MODULES]
    scope: dict[str, Any] = {"np": np}
    for name in set(re.findall(r"\b[A-Za-z]\w+(?=\()", written)):
        scope |= {name: next((getattr(m, name) for m in modules if hasattr(m, name)), None)}
    x = np.round(np.random.default_rng(0).uniform(0.2, 9, (400, 5)), 1).astype(np.float32)
    scope |= {"x": x, "y": np.minimum(x[:, 0] / 9, x[:, 1:].min(axis=1))}
    model = eval(written, scope).fit(x, scope["y"])

    said = _convert(Predict("it", x.astype(float).tobytes()), {"it": model})

    gap = 1.0 if said.problem else np.abs(np.frombuffer(said.values) - model.predict(x))
    agrees = SAME if np.mean(gap <= 1e-4) >= 0.98 else OTHER
    assert (NONE if said.problem else agrees) == OUTCOMES[written], said.problem


def test_the_table_names_each() -> None:
    table = HINTS.read_text().partition("| Regressor |")[2].partition("</details>")[0]
    named = set(re.findall(r"[A-Z]\w+", " ".join(OUTCOMES)))
    assert named == set(re.findall(r"\b[A-Z]\w*[a-z][A-Z]\w+|\bRidge\b|MLPRegressor|SVR", table))
