#!/usr/bin/env bash
# Guess: a number of numpy's may stand in a field as it may in Python; if not, an exception says so.
# Seen:  np.float64 may (it is a float). np.float32 arrives as 0 or as 5e-315, an int as 5e-324, the
#        array of one number that predict() gives as something else, and np.True_ as False, all in
#        silence; for the check of types is off unless ROS_PYTHON_CHECK_FIELDS=1. And which a
#        program holds depends on where it comes from: scikit-learn answers float32 rows in float32
#        from a linear model, a network and the nearest neighbours, in float64 from a forest,
#        boosting and an SVR; a LaserScan's ranges are Python floats in rclpy, np.float32 in
#        rosbags. So with another model the robot stands still.
# With:  ros-jazzy-rclpy 7.1.6, ros-jazzy-common-interfaces 5.3.6, scikit-learn 1.9.1, rosbags
#        0.11.9, numpy 2.4.6 (Python 3.11), 2026-11-29
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" --quiet install ros-jazzy-rclpy==7.1.6 ros-jazzy-common-interfaces==5.3.6 \
  ros-jazzy-rmw-fastrtps-cpp==8.4.3 scikit-learn==1.9.1 rosbags==0.11.9 numpy==2.4.6
"$work/venv/bin/python" -W ignore - > "$work/seen" <<'PY'
import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import LaserScan
from sklearn.ensemble import GradientBoostingRegressor, RandomForestRegressor
from sklearn.linear_model import LinearRegression
from sklearn.neighbors import KNeighborsRegressor
from sklearn.neural_network import MLPRegressor
from sklearn.svm import SVR
from std_msgs.msg import Bool, Float32, Float64


def arrives(kind, value):
    return deserialize_message(serialize_message(kind(data=value)), kind).data


half = np.float32(0.5)
print("float32:", arrives(Float64, half) < 1e-300, arrives(Float32, half))
print("float64:", arrives(Float64, np.float64(0.5)), "int:", arrives(Float64, 1))
print("array of one:", arrives(Float64, np.array([0.5])) == 0.5)
print("bool:", arrives(Bool, np.True_), arrives(Bool, 1), arrives(Bool, bool(np.True_)))

rows = np.linspace(0, 1, 200, dtype=np.float32).reshape(40, 5)
speeds = rows.mean(axis=1)
for model in (
    LinearRegression(),
    MLPRegressor(hidden_layer_sizes=(4,), max_iter=5, random_state=0),
    KNeighborsRegressor(),
    RandomForestRegressor(5, random_state=0),
    GradientBoostingRegressor(random_state=0),
    SVR(),
):
    speed = model.fit(rows, speeds).predict(rows[-1:])[0]
    name, sound = type(model).__name__, arrives(Float64, speed) == speed
    print(f"{name}: {speed.dtype}, arrives: {sound}")

data = serialize_message(LaserScan(ranges=[0.5, 2.0]))
for scan in (
    deserialize_message(data, LaserScan),
    get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(data, "sensor_msgs/msg/LaserScan"),
):
    nearest = min(scan.ranges)
    print(type(nearest).__name__, arrives(Float32, nearest))
PY
diff "$work/seen" - <<'SEEN' && echo "as it was"
float32: True 0.0
float64: 0.5 int: 5e-324
array of one: False
bool: False False True
LinearRegression: float32, arrives: False
MLPRegressor: float32, arrives: False
KNeighborsRegressor: float32, arrives: False
RandomForestRegressor: float64, arrives: True
GradientBoostingRegressor: float64, arrives: True
SVR: float64, arrives: True
float 0.5
float32 0.0
SEEN
