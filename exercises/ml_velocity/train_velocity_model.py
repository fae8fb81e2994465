"""Train the velocity model: from recorded scans and an expert's speeds to two model files.

    python3 train_velocity_model.py --data train.npz --out velocity_model.pkl --onnx velocity_model.onnx

``train.npz`` holds ``ranges`` (n, 360) [m], ``speed`` (n,) [m/s] and the lidar's ``angle_min``,
``angle_increment`` [rad], ``range_min`` and ``range_max`` [m]. `course dataset` makes one.
"""  # noqa: E501

import argparse
import math
import pickle
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from skl2onnx import to_onnx
from sklearn.ensemble import RandomForestRegressor

FRONT_HALF_ANGLE = math.radians(60)  # [rad] the front sector is |θ| ≤ 60°
TREES = 40
SEED = 0  # the same data give the same model


def scan_features(
    ranges: NDArray[np.float64],
    angles: NDArray[np.float64],
    range_min: float,
    range_max: float,
) -> NDArray[np.float64] | None:
    """Return the (5,) features of one scan: exactly those that the controller computes.

    A model that is trained on other features than it meets on the robot is wrong without a warning.
    ``None`` if a sector has no usable reading.
    """
    # TODO(task 6): the function of your controller.
    return None


def load_examples(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return features (m, 5) and speeds (m,) [m/s] of the scans that have all features."""
    # TODO(task 6): np.load(path), features of each row, skip the rows that have none.
    return np.empty((0, 5)), np.empty(0)


def train(features: NDArray[np.float64], speed: NDArray[np.float64]) -> RandomForestRegressor:
    """Return a model fitted to the examples."""
    # TODO(task 7): fit a RandomForestRegressor. Give it a random_state.
    return RandomForestRegressor()


def save(model: RandomForestRegressor, pickle_path: Path, onnx_path: Path) -> None:
    """Write the model twice: for scikit-learn, and for onnxruntime."""
    # TODO(task 8): pickle the model to pickle_path; convert it with to_onnx for onnx_path.


def main() -> None:
    """Train on the data that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="scans and speeds, .npz")
    parser.add_argument("--out", type=Path, required=True, help="the model for the node, .pkl")
    parser.add_argument("--onnx", type=Path, required=True, help="the same model, .onnx")
    arguments = parser.parse_args()
    features, speed = load_examples(arguments.data)
    print(f"{len(speed)} examples")
    model = train(features, speed)
    save(model, arguments.out, arguments.onnx)


if __name__ == "__main__":
    main()
