"""The server in a beginner's style: plain loops, no numpy but for the model's input, no exceptions.

field: all
"""

import json
import math
import pickle

import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger


class DetectionServer(Node):
    def __init__(self):
        super().__init__("detection_server")
        self.declare_parameter("model_path", "detection_model.pkl")
        self.model = None
        self.last_scan = None
        try:
            with open(self.get_parameter("model_path").value, "rb") as f:
                self.model = pickle.load(f)
        except Exception as e:
            self.get_logger().error("could not load the model: " + str(e))
        self.create_subscription(LaserScan, "/scan", self.on_scan, qos_profile_sensor_data)
        self.create_service(Trigger, "/detect", self.on_detect)

    def on_scan(self, msg):
        self.last_scan = msg

    def on_detect(self, request, response):
        response.success = False
        if self.model is None:
            response.message = "no model"
            return response
        if self.last_scan is None:
            response.message = "no scan"
            return response
        scan = self.last_scan
        stamp = scan.header.stamp.sec + scan.header.stamp.nanosec / 1e9
        now = self.get_clock().now().nanoseconds / 1e9
        if now - stamp > 1.0:
            response.message = "scan too old"
            return response
        front = []
        left = []
        right = []
        for i in range(len(scan.ranges)):
            degrees = math.degrees(scan.angle_min + i * scan.angle_increment)
            while degrees > 180:
                degrees = degrees - 360
            while degrees < -180:
                degrees = degrees + 360
            r = scan.ranges[i]
            if r == float("-inf"):
                r = scan.range_min
            if r > scan.range_max:
                r = scan.range_max
            if not r >= scan.range_min:
                continue
            if degrees > 60:
                left.append(r)
            elif degrees < -60:
                right.append(r)
            else:
                front.append(r)
        if len(front) == 0 or len(left) == 0 or len(right) == 0:
            response.message = "blind"
            return response
        mean = sum(front) / len(front)
        variance = 0.0
        for r in front:
            variance = variance + (r - mean) ** 2
        std = math.sqrt(variance / len(front))
        features = [[min(front), mean, std, min(left), min(right)]]
        try:
            label = self.model.predict(features)[0]
            probabilities = self.model.predict_proba(features)[0]
        except Exception as e:
            response.message = "the model raised " + repr(e)
            return response
        confidence = 0.0
        for p in probabilities:
            if not math.isfinite(p):
                response.message = "the model said " + str(p)
                return response
            if p > confidence:
                confidence = float(p)
        answer = {"label": str(label), "confidence": confidence, "stamp": stamp}
        response.success = True
        response.message = json.dumps(answer)
        return response


def main(args=None):
    rclpy.init(args=args)
    rclpy.spin(DetectionServer())


if __name__ == "__main__":
    main()
