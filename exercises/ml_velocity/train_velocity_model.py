"""Train the velocity model: from recorded scans and an expert's speeds to two model files.

    python3 train_velocity_model.py --data train.npz --out velocity_model.pkl --onnx velocity_model.onnx

``train.npz`` holds ``ranges`` (n, 360) [m], ``speed`` (n,) [m/s], ``room`` (n,) and the lidar's
``angle_min``, ``angle_increment`` [rad], ``range_min`` and ``range_max`` [m]. `course dataset`
makes one.
"""  # noqa: E501

import argparse
import math
import pickle
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from skl2onnx import to_onnx
from sklearn.ensemble import RandomForestRegressor
from sklearn.linear_model import LinearRegression

FRONT_HALF_ANGLE = math.radians(60.0)  # [rad] the front sector is |θ| ≤ 60°
TREES = 40
SEED = 0  # the same data give the same model
HELD_OUT = 5  # one room in so many is held out


class LaserScan(NamedTuple):
    """The part of sensor_msgs/msg/LaserScan that features are made of: training needs no ROS."""

    ranges: list[float]  # [m]
    angle_min: float  # [rad]
    angle_increment: float  # [rad]
    range_min: float  # [m]
    range_max: float  # [m]

    @property
    def angle_max(self) -> float:
        """Angle of the last beam [rad]."""
        return self.angle_min + self.angle_increment * (len(self.ranges) - 1)


def extract_features(scan: LaserScan) -> np.ndarray | None:
    """Return what the model sees of a scan: one row of five features, (1, 5) float32 [m].

    Minimum, mean and population standard deviation of the front sector (|θ| ≤ 60°), minimum of
    the left sector (60° < θ ≤ 180°), minimum of the right sector (-180° ≤ θ < -60°). ``+inf`` and
    readings above ``range_max`` count as ``range_max``, ``-inf`` counts as ``range_min``; NaN and
    readings below ``range_min`` are dropped. ``None``: a sector has no usable reading.
    """
    # TODO(task 6): paste extract_features from your controller; it fits as it is.
    return None


def load_examples(
    path: Path,
) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.int64]]:
    """Return features (m, 5), speeds (m,) [m/s] and rooms (m,) of the scans that are not blind."""
    # TODO(task 6): np.load(path), a LaserScan and its features for each row of ranges; skip
    # the rows that have none.
    return np.empty((0, 5), dtype=np.float32), np.empty(0), np.empty(0, dtype=int)


def train(features: NDArray[np.float32], speed: NDArray[np.float64]) -> RandomForestRegressor:
    """Return a model fitted to the examples."""
    # TODO(task 7): fit a RandomForestRegressor. Give it a random_state.
    return RandomForestRegressor()


def errors_in_new_rooms(
    features: NDArray[np.float32], speed: NDArray[np.float64], room: NDArray[np.int64]
) -> dict[str, float]:
    """Return mean absolute errors [m/s] in rooms that were held out, of what is to be beaten too.

    A constant is the least that a model has to beat, a straight line the next.
    """
    # TODO(task 7): train without the rooms whose number HELD_OUT divides, predict there, and
    # compare: with the median of the speeds, and with a LinearRegression.
    return {}


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
    features, speed, room = load_examples(arguments.data)
    print(f"{len(speed)} examples")
    for name, error in errors_in_new_rooms(features, speed, room).items():
        print(f"in new rooms {name} errs by {error:.4f} m/s")
    model = train(features, speed)
    save(model, arguments.out, arguments.onnx)


if __name__ == "__main__":
    main()
