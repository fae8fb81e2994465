"""Style: imports the features from the controller, so that robot and training cannot differ.

file: train_velocity_model.py
field: all
"""

import argparse
import pickle
from types import SimpleNamespace

import numpy as np
from ml_velocity_controller import extract_features
from skl2onnx import to_onnx
from sklearn.ensemble import RandomForestRegressor


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--data", required=True)
    parser.add_argument("--out", type=argparse.FileType("wb"), required=True)
    parser.add_argument("--onnx", type=argparse.FileType("wb"), required=True)
    arguments = parser.parse_args()
    data = dict(np.load(arguments.data))
    lidar = {name: value.item() for name, value in data.items() if value.ndim == 0}
    seen = [extract_features(SimpleNamespace(ranges=row, **lidar)) for row in data["ranges"]]
    kept = np.array([features is not None for features in seen])
    x = np.concatenate([features for features in seen if features is not None])
    model = RandomForestRegressor(n_estimators=30, max_depth=10, n_jobs=4, random_state=3)
    model.fit(x, data["speed"][kept])
    with arguments.out, arguments.onnx:
        pickle.dump(model, arguments.out)
        arguments.onnx.write(to_onnx(model, x[:1]).SerializeToString())


if __name__ == "__main__":
    main()
