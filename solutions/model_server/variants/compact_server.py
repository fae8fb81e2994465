"""As little code as the contract allows.

field: all
"""

import json
import math
import pickle

import numpy as np
import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger


class DetectionServer(Node):
    def __init__(self):
        super().__init__("detection_server")
        self.scan = None
        path = self.declare_parameter("model_path", "detection_model.pkl").value
        try:
            with open(path, "rb") as file:
                self.model = pickle.load(file)
        except Exception as error:
            self.get_logger().error(f"no model: {error!r}")
            self.model = None
        self.create_subscription(LaserScan, "/scan", self.scan_callback, qos_profile_sensor_data)
        self.create_service(Trigger, "/detect", self.detect_callback)

    def scan_callback(self, scan):
        self.scan = scan

    def features(self, scan):
        sectors = {"front": [], "left": [], "right": []}
        for i, r in enumerate(scan.ranges):
            angle = math.remainder(scan.angle_min + i * scan.angle_increment, math.tau)
            if r == -math.inf:
                r = scan.range_min
            if math.isnan(r) or r < scan.range_min:
                continue
            r = min(r, scan.range_max)
            if abs(angle) <= math.radians(60):
                sectors["front"].append(r)
            elif angle > 0:
                sectors["left"].append(r)
            else:
                sectors["right"].append(r)
        for name, readings in sectors.items():
            if not readings:
                raise ValueError(f"the {name} sector is blind")
        front = sectors["front"]
        return [
            min(front),
            np.mean(front),
            np.std(front),
            min(sectors["left"]),
            min(sectors["right"]),
        ]

    def age(self, scan):
        stamp = scan.header.stamp.sec + scan.header.stamp.nanosec * 1e-9
        return self.get_clock().now().nanoseconds * 1e-9 - stamp

    def detect(self):
        if self.model is None:
            raise ValueError("there is no model")
        if self.scan is None:
            raise ValueError("there is no scan yet")
        if self.age(self.scan) > 1.0:
            raise ValueError("the newest scan is too old")
        x = np.array([self.features(self.scan)])
        label = self.model.predict(x)[0]
        confidence = float(max(self.model.predict_proba(x)[0]))
        if not math.isfinite(confidence):
            raise ValueError("the confidence is not finite")
        stamp = self.scan.header.stamp.sec + self.scan.header.stamp.nanosec * 1e-9
        return {"label": str(label), "confidence": confidence, "stamp": stamp}

    def detect_callback(self, request, response):
        try:
            response.message = json.dumps(self.detect())
            response.success = True
        except Exception as error:
            response.message = str(error)
            response.success = False
        return response


def main(args=None):
    rclpy.init(args=args)
    node = DetectionServer()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
