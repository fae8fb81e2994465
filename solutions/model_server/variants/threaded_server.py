"""The server with a MultiThreadedExecutor: scans and requests in groups of their own, one lock.

field: all
"""

import json
import pickle
import threading
from pathlib import Path

import numpy as np
import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger


class Refusal(Exception):
    pass


def features_of(scan: LaserScan) -> np.ndarray:
    values = np.asarray(scan.ranges, dtype=np.float64)
    values = np.where(np.isneginf(values), scan.range_min, np.fmin(values, scan.range_max))
    values[np.isnan(np.asarray(scan.ranges))] = np.nan
    values[values < scan.range_min] = np.nan
    theta = scan.angle_min + np.arange(values.size) * scan.angle_increment
    theta = np.degrees(np.arctan2(np.sin(theta), np.cos(theta)))
    sectors = [values[np.abs(theta) <= 60], values[theta > 60], values[theta < -60]]
    if any(np.isnan(sector).all() for sector in sectors):
        raise Refusal("a sector says nothing")
    front, left, right = sectors
    return np.array(
        [[np.nanmin(front), np.nanmean(front), np.nanstd(front), np.nanmin(left), np.nanmin(right)]]
    )


class Server(Node):
    def __init__(self):
        super().__init__("detection_server")
        path = Path(self.declare_parameter("model_path", "detection_model.pkl").value)
        self.lock = threading.Lock()
        self.newest = None
        self.model = None
        try:
            self.model = pickle.loads(path.read_bytes())
        except Exception as error:
            self.get_logger().error(f"{path}: {error!r}")
        qos = QoSProfile(
            history=HistoryPolicy.KEEP_LAST, depth=2, reliability=ReliabilityPolicy.BEST_EFFORT
        )
        self.create_subscription(
            LaserScan, "scan", self.remember, qos, callback_group=MutuallyExclusiveCallbackGroup()
        )
        self.create_service(Trigger, "detect", self.answer, callback_group=ReentrantCallbackGroup())

    def remember(self, scan):
        with self.lock:
            self.newest = scan

    def detection(self):
        with self.lock:
            scan = self.newest
        if scan is None:
            raise Refusal("nothing seen yet")
        if self.model is None:
            raise Refusal("no model")
        stamp = Time.from_msg(scan.header.stamp)
        if self.get_clock().now() - stamp > Duration(seconds=1.0):
            raise Refusal("the scan is old")
        x = features_of(scan)
        label = self.model.predict(x)[0]
        sure = float(self.model.predict_proba(x).max())
        if not np.isfinite(sure):
            raise Refusal("the model does not know how sure it is")
        return {"label": f"{label}", "confidence": sure, "stamp": stamp.nanoseconds / 1e9}

    def answer(self, _, response):
        try:
            response.message, response.success = json.dumps(self.detection()), True
        except Exception as error:
            response.message, response.success = f"{type(error).__name__}: {error}", False
        return response


def main(args=None):
    rclpy.init(args=args)
    executor = MultiThreadedExecutor(num_threads=4)
    node = Server()
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        executor.shutdown()


if __name__ == "__main__":
    main()
