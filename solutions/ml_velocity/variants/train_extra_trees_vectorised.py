"""Style: all scans at once with masked arrays, a pipeline of extra trees, skl2onnx's older call.

file: train_velocity_model.py
field: all
"""  # noqa: E501

import argparse
import pickle

import numpy as np
from skl2onnx import convert_sklearn
from skl2onnx.common.data_types import FloatTensorType
from sklearn.ensemble import ExtraTreesRegressor
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler


def all_features(data):
    """(n, 5) features, masked where a sector is blind."""
    low, high = float(data["range_min"]), float(data["range_max"])
    ranges = data["ranges"].astype(np.float64)
    degrees = np.degrees(
        float(data["angle_min"]) + np.arange(ranges.shape[1]) * float(data["angle_increment"])
    )
    ranges[np.isneginf(ranges)] = low
    ranges[ranges > high] = high
    useless = ~(ranges >= low)
    front = np.ma.array(ranges, mask=useless | (abs(degrees) > 60))
    left = np.ma.array(ranges, mask=useless | (degrees <= 60))
    right = np.ma.array(ranges, mask=useless | (degrees >= -60))
    columns = front.min(1), front.mean(1), front.std(1), left.min(1), right.min(1)
    return np.ma.column_stack(columns)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--data", default="train.npz")
    parser.add_argument("--out", default="velocity_model.pkl")
    parser.add_argument("--onnx", default="velocity_model.onnx")
    arguments = parser.parse_args()
    data = np.load(arguments.data)
    table = all_features(data)
    whole = ~np.ma.getmaskarray(table).any(axis=1)
    features, speed = table[whole].filled(), data["speed"][whole]
    trees = ExtraTreesRegressor(30, min_samples_leaf=2, random_state=7, n_jobs=-1)
    model = make_pipeline(StandardScaler(), trees).fit(features, speed)
    with open(arguments.out, "wb") as file:
        pickle.dump(model, file, protocol=pickle.HIGHEST_PROTOCOL)
    onnx = convert_sklearn(model, initial_types=[("features", FloatTensorType([None, 5]))])
    with open(arguments.onnx, "wb") as file:
        file.write(onnx.SerializeToString())
