"""Style: imports the features from the controller, so that robot and training cannot differ.

file: train_velocity_model.py
field: all
"""

import argparse
import pickle

import numpy as np
from ml_velocity_controller import scan_features
from skl2onnx import to_onnx
from sklearn.ensemble import RandomForestRegressor


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--data", required=True)
    parser.add_argument("--out", type=argparse.FileType("wb"), required=True)
    parser.add_argument("--onnx", type=argparse.FileType("wb"), required=True)
    arguments = parser.parse_args()
    data = dict(np.load(arguments.data))
    angles = data["angle_min"] + data["angle_increment"] * np.arange(data["ranges"].shape[1])
    limits = data["range_min"], data["range_max"]
    seen = [scan_features(ranges, angles, *limits) for ranges in data["ranges"].astype(float)]
    kept = np.array([features is not None for features in seen])
    x = np.array([features for features in seen if features is not None])
    model = RandomForestRegressor(n_estimators=30, max_depth=10, n_jobs=4, random_state=3)
    model.fit(x, data["speed"][kept])
    with arguments.out, arguments.onnx:
        pickle.dump(model, arguments.out)
        arguments.onnx.write(to_onnx(model, x[:1].astype(np.float32)).SerializeToString())


if __name__ == "__main__":
    main()
