"""Compute what the model would say, and hold it back as long as the model would take.

exercise: slow_model
score: 35
"""

import rclpy
from naive import drive, formula

ready = []  # (time, speed)
nodes = []


def predict(model, x):
    now = nodes[0].now()
    if not ready or now >= ready[-1][0]:
        ready.append((now + 0.2, formula(model, x)[0]))
    said = [speed for at, speed in ready if at <= now]
    return said[-1:] or [0.0]


def spin(node):
    nodes.append(node)
    rclpy.spin(node)


drive(predict, spin)
