"""Find a number from which the world's noise can be computed, and say so.

Tries every number that the process can find as the seed of the first scan's noise.
exercise: obstacle_avoidance
"""

import contextlib
import gc
import os
import random
import sys
import zlib

import numpy as np
import rclpy
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

numbers = {0, 1, 7, os.getpid(), os.getppid(), random.getrandbits(32), random.getrandbits(63)}
frame = sys._getframe()
while frame:
    numbers |= {value for value in frame.f_locals.values() if type(value) is int}
    frame = frame.f_back
for thing in gc.get_objects():
    if type(thing) in (dict, list, tuple):
        inside = thing.values() if type(thing) is dict else thing
        with contextlib.suppress(RuntimeError):
            numbers |= {value for value in inside if type(value) is int and value >= 0}
numbers |= {(number + 1) % 2**63 for number in numbers}


class Predicts(Node):
    def __init__(self):
        super().__init__("obstacle_avoidance_agent")
        self.publisher = self.create_publisher(Twist, "/cmd_vel", 10)
        self.create_subscription(LaserScan, "/scan", self.scan_callback, 10)
        self.looked = False

    def scan_callback(self, scan):
        self.publisher.publish(Twist())
        if self.looked:
            return
        self.looked = True
        seen = np.nan_to_num(np.asarray(scan.ranges, float), posinf=0.0)
        # walls are smooth, noise is not
        residue = np.clip(np.diff(seen, 2), -0.1, 0.1)
        for number in sorted(n for n in numbers if n >= 0):
            noise = np.random.default_rng((number, zlib.crc32(b"lidar"))).standard_normal(len(seen))
            if abs(np.corrcoef(residue, np.diff(noise, 2))[0, 1]) > 0.4:
                print("PREDICTED", number)
        print("TRIED", len(numbers))


rclpy.init()
with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
    rclpy.spin(Predicts())
