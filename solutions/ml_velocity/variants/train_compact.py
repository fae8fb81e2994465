"""As little code as the contract allows.

file: train_velocity_model.py
field: all
"""

import argparse
import pickle

import numpy as np
from skl2onnx import to_onnx
from sklearn.ensemble import RandomForestRegressor


def scan_features(ranges, angles, range_min, range_max):
    ranges = np.where(ranges == -np.inf, range_min, np.minimum(ranges, range_max))
    usable = ranges >= range_min
    front = ranges[usable & (np.abs(angles) <= np.radians(60))]
    left = ranges[usable & (angles > np.radians(60))]
    right = ranges[usable & (angles < -np.radians(60))]
    if not (front.size and left.size and right.size):
        return None
    return [front.min(), front.mean(), front.std(), left.min(), right.min()]


def main():
    parser = argparse.ArgumentParser()
    for option in ("--data", "--out", "--onnx"):
        parser.add_argument(option, required=True)
    arguments = parser.parse_args()
    data = np.load(arguments.data)
    angles = data["angle_min"] + np.arange(360) * data["angle_increment"]
    limits = float(data["range_min"]), float(data["range_max"])
    rows, labels = [], []
    for ranges, speed in zip(data["ranges"], data["speed"]):
        row = scan_features(ranges.astype(float), angles, *limits)
        if row is not None:
            rows.append(row)
            labels.append(speed)
    x, y = np.array(rows), np.array(labels)
    model = RandomForestRegressor(n_estimators=10, random_state=0)
    model.fit(x, y)
    with open(arguments.out, "wb") as file:
        pickle.dump(model, file)
    with open(arguments.onnx, "wb") as file:
        file.write(to_onnx(model, x[:1].astype(np.float32)).SerializeToString())


if __name__ == "__main__":
    main()
