"""How well rules, formulas and models follow exercise 2's expert, in rooms they have not seen.

`python tests/grader/models/expert_table.py` prints the table for three pairs of seeds and, on the
first of them, for each of the experts that a graded class may get.
"""

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.ensemble import RandomForestRegressor
from sklearn.linear_model import LinearRegression
from sklearn.neural_network import MLPRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler
from sklearn.tree import DecisionTreeRegressor

from grader.models.expert import OTHERS, PUBLISHED, Character, speeds
from grader.models.features import features
from grader.models.scans import PROFILE, make_scans

Floats = NDArray[np.float64]

PAIRS = ((1, 99), (7, 123), (42, 314))  # to learn from, to be judged on
ROWS, TEST_ROWS = 2000, 3000
RULES = {1: "best rule of 1", 2: "best rule of 2", 3: "best rule of 3"}
POLYNOMIALS = {1: "linear", 2: "quadratic", 3: "cubic"}
MODELS: dict[str, Callable[[], Any]] = {
    "forest": lambda: RandomForestRegressor(40, random_state=0),
    "network": lambda: make_pipeline(
        StandardScaler(),
        MLPRegressor(
            hidden_layer_sizes=(32, 32), learning_rate_init=0.003, max_iter=300, tol=1e-6,
            random_state=0,
        ),
    ),
}  # fmt: skip


def examples(rows: int, seed: int, expert: Character) -> tuple[Floats, Floats]:
    """Return the features, as read, and the speeds of the scans that aren't blind."""
    scans = make_scans(rows, seed, blind=True, plain=False)
    degrees = np.degrees(PROFILE.angles)
    seen = features(scans.ranges, degrees, PROFILE.range_min, PROFILE.range_max)
    whole = np.isfinite(seen).all(axis=1)
    return seen[whole], speeds(scans.exact, expert)[whole]


def errors(pair: tuple[int, int], expert: Character) -> dict[str, float]:
    """Return the mean absolute errors [m/s]; the best of several rules is chosen on the test."""
    (x, y), (tx, ty) = examples(ROWS, pair[0], expert), examples(TEST_ROWS, pair[1], expert)

    def error(model: Any, columns: tuple[int, ...] = (0, 1, 2, 3, 4)) -> float:
        said = model.fit(x[:, columns], y).predict(tx[:, columns])
        return float(np.abs(np.clip(said, 0.0, 0.5) - ty).mean())

    found = {"constant": float(np.abs(np.median(y) - ty).mean())}
    for count, name in RULES.items():
        found[name] = min(
            error(model, columns)
            for columns in itertools.combinations(range(5), count)
            for model in (
                RandomForestRegressor(20, min_samples_leaf=5, random_state=0),
                DecisionTreeRegressor(min_samples_leaf=20, random_state=0),
            )
        )
    for degree, name in POLYNOMIALS.items():
        formula = make_pipeline(StandardScaler(), PolynomialFeatures(degree), LinearRegression())
        found[name] = error(formula)
    return found | {name: error(make()) for name, make in MODELS.items()}


def main() -> None:
    """Print the table."""
    rows = {f"published, seeds {a}/{b}": errors((a, b), PUBLISHED) for a, b in PAIRS}
    for number, expert in enumerate(OTHERS, 1):
        rows[f"other {number}, seeds {PAIRS[0][0]}/{PAIRS[0][1]}"] = errors(PAIRS[0], expert)
    print(f"{'':28}" + "".join(f"{name:>16}" for name in next(iter(rows.values()))))
    for name, found in rows.items():
        print(f"{name:28}" + "".join(f"{error:16.4f}" for error in found.values()))


if __name__ == "__main__":
    main()
