"""Style: plain loops and lists, a decision tree is enough, sys.argv by hand.

file: train_velocity_model.py
field: all
"""

import math
import pickle
import statistics
import sys

import numpy
import skl2onnx
from sklearn.tree import DecisionTreeRegressor

options = {}
for i in range(1, len(sys.argv), 2):
    options[sys.argv[i]] = sys.argv[i + 1]

data = numpy.load(options["--data"])
angle_min = float(data["angle_min"])
angle_increment = float(data["angle_increment"])
range_min = float(data["range_min"])
range_max = float(data["range_max"])

X = []
y = []
for ranges, speed in zip(data["ranges"].tolist(), data["speed"].tolist()):
    front = []
    left = []
    right = []
    for i in range(len(ranges)):
        r = ranges[i]
        if r == -math.inf:
            r = range_min
        if math.isnan(r) or r < range_min:
            continue
        if r > range_max:
            r = range_max
        angle = math.degrees(angle_min + i * angle_increment)
        if abs(angle) <= 60:
            front.append(r)
        elif angle > 0:
            left.append(r)
        else:
            right.append(r)
    if len(front) > 0 and len(left) > 0 and len(right) > 0:
        mean = sum(front) / len(front)
        X.append([min(front), mean, statistics.pstdev(front), min(left), min(right)])
        y.append(speed)
print("learning from", len(X), "scans")

tree = DecisionTreeRegressor(random_state=0)
tree.fit(X, y)

with open(options["--out"], "wb") as f:
    pickle.dump(tree, f)
example = numpy.zeros((1, 5), dtype=numpy.float32)
with open(options["--onnx"], "wb") as f:
    f.write(skl2onnx.to_onnx(tree, example).SerializeToString())
