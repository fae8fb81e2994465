"""Both programs without a class: the state lives in closures.

field: all
"""

import json
import math
import pickle

import numpy as np
import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger


def features(scan):
    r = np.clip(np.array(scan.ranges, dtype=float), None, scan.range_max)
    r[np.isneginf(r)] = scan.range_min
    turn = np.exp(1j * (scan.angle_min + scan.angle_increment * np.arange(r.size)))
    angle = np.degrees(np.angle(turn))
    good = r >= scan.range_min
    ahead = np.abs(angle) <= 60
    front, left, right = r[good & ahead], r[good & (angle > 60)], r[good & (angle < -60)]
    return [front.min(), front.mean(), front.std(), left.min(), right.min()]


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("detection_server")
    node.declare_parameter("model_path", "detection_model.pkl")
    newest = {}
    try:
        with open(node.get_parameter("model_path").value, "rb") as file:
            model = pickle.load(file)
    except BaseException as error:
        node.get_logger().fatal(f"no model ({error})")
        model = None

    def see(scan):
        newest["scan"] = scan

    def detect(_, response):
        response.success = False
        if "scan" not in newest:
            response.message = "no scan"
            return response
        header = newest["scan"].header
        stamp = header.stamp.sec + header.stamp.nanosec / 1e9
        if node.get_clock().now().nanoseconds / 1e9 - stamp > 1:
            response.message = "the scan is more than a second old"
            return response
        try:
            x = [features(newest["scan"])]
            label, confidence = model.predict(x)[0], float(np.max(model.predict_proba(x)))
            if math.isnan(confidence) or math.isinf(confidence):
                raise ValueError(f"confidence {confidence}")
        except Exception as error:
            response.message = repr(error)
            return response
        answer = dict(label=str(label), confidence=confidence, stamp=stamp, frame=header.frame_id)
        return Trigger.Response(success=True, message=json.dumps(answer))

    qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    node.create_subscription(LaserScan, "/scan", see, qos)
    node.create_service(Trigger, "/detect", detect)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
