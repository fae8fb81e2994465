"""Style: gradient boosting, its depth chosen by cross-validation on all cores, and a report.

file: train_velocity_model.py
field: all
"""

import argparse
import logging
import pickle
import sys
import time
from pathlib import Path

import numpy as np
from skl2onnx import to_onnx
from sklearn.ensemble import GradientBoostingRegressor
from sklearn.metrics import mean_absolute_error
from sklearn.model_selection import GridSearchCV, train_test_split

log = logging.getLogger("train")


def sectors(ranges, degrees, low, high):
    ranges = np.clip(np.nan_to_num(ranges, nan=-1.0, posinf=high, neginf=low), None, high)
    good = ranges >= low
    yield ranges[good & (np.abs(degrees) <= 60)]
    yield ranges[good & (degrees > 60)]
    yield ranges[good & (degrees < -60)]


def examples(data):
    degrees = np.degrees(data["angle_min"] + np.arange(360) * data["angle_increment"])
    for ranges, speed in zip(data["ranges"], data["speed"], strict=True):
        front, left, right = sectors(ranges, degrees, data["range_min"], data["range_max"])
        if front.size and left.size and right.size:
            yield (front.min(), front.mean(), front.std(), left.min(), right.min()), speed


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--data", type=Path)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--onnx", type=Path)
    args = parser.parse_args()
    logging.basicConfig(level=logging.INFO)
    with np.load(args.data) as data:
        x, y = (np.array(part, dtype=np.float32) for part in zip(*examples(data), strict=True))
    x_train, x_test, y_train, y_test = train_test_split(x, y, test_size=0.2, random_state=1)
    began = time.perf_counter()
    search = GridSearchCV(
        GradientBoostingRegressor(n_estimators=60, random_state=1),
        {"max_depth": [3, 4]},
        scoring="neg_mean_absolute_error",
        cv=3,
        n_jobs=-1,
    )
    best = search.fit(x_train, y_train).best_estimator_
    log.info("%s in %.1f s", search.best_params_, time.perf_counter() - began)
    log.info("error on held-out scans: %.4f m/s", mean_absolute_error(y_test, best.predict(x_test)))
    args.out.write_bytes(pickle.dumps(best))
    args.onnx.write_bytes(to_onnx(best, x[:1]).SerializeToString())
    return 0


if __name__ == "__main__":
    sys.exit(main())
