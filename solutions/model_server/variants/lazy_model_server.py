"""The server loads its model with the first request; reads scans as reliable, so no badge."""

import functools
import json
import pickle
import statistics
from math import degrees, inf, isfinite, remainder, tau

import rclpy
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger


class Detector(Node):
    def __init__(self):
        super().__init__("detection_server")
        self.declare_parameter("model_path", "detection_model.pkl")
        self.scans = []
        self.create_subscription(LaserScan, "/scan", self.scans.append, 10)
        self.create_service(Trigger, "/detect", self.detect)

    @functools.cached_property
    def model(self):
        try:
            with open(self.get_parameter("model_path").value, "rb") as file:
                return pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"no model: {error!r}")
            raise

    def detect(self, request, response):
        del self.scans[:-1]
        try:
            text = json.dumps(self.look(self.scans[0]))
        except IndexError:
            return Trigger.Response(success=False, message="no scan yet")
        except Exception as error:
            return Trigger.Response(success=False, message=repr(error))
        return Trigger.Response(success=True, message=text)

    def look(self, scan):
        stamp = scan.header.stamp.sec + 1e-9 * scan.header.stamp.nanosec
        assert self.get_clock().now().nanoseconds * 1e-9 - stamp <= 1.0, "old scan"
        beams = [
            (degrees(remainder(scan.angle_min + i * scan.angle_increment, tau)), r)
            for i, r in enumerate(scan.ranges)
        ]
        beams = [
            (a, scan.range_min if r == -inf else min(r, scan.range_max)) for a, r in beams if r == r
        ]
        beams = [(a, r) for a, r in beams if r >= scan.range_min]
        front = [r for a, r in beams if -60 <= a <= 60]
        left = [r for a, r in beams if a > 60]
        right = [r for a, r in beams if a < -60]
        x = [[min(front), statistics.fmean(front), statistics.pstdev(front), min(left), min(right)]]
        probabilities = [float(p) for p in self.model.predict_proba(x)[0]]
        assert all(map(isfinite, probabilities)), "the model is not sure of anything"
        return {
            "label": str(self.model.predict(x)[0]),
            "confidence": max(probabilities),
            "stamp": stamp,
        }


def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(Detector())


if __name__ == "__main__":
    main()
