"""Style: closures instead of a class, and a thread with time.sleep for the report.

field: all
"""

import math
import pickle
import threading
import time

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist
from rclpy.executors import ExternalShutdownException
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan


def sectors(scan):
    front, left, right = [], [], []
    for i, reading in enumerate(scan.ranges):
        angle = scan.angle_min + i * scan.angle_increment
        if angle >= math.pi:
            angle -= 2 * math.pi
        if math.isinf(reading):
            reading = scan.range_max if reading > 0 else scan.range_min
        if reading > scan.range_max:
            reading = scan.range_max
        if not (scan.range_min <= reading):
            continue
        side = left if angle > math.pi / 3 else right if angle < -math.pi / 3 else front
        side.append(reading)
    return front, left, right


def main(args=None):
    rclpy.init(args=args)
    node = rclpy.create_node("profiled_controller")
    path = node.declare_parameter("model_path", "velocity_model.pkl").value
    max_speed = node.declare_parameter("max_speed", 0.5).value
    deadline = node.declare_parameter("deadline_ms", 100.0).value
    command_publisher = node.create_publisher(Twist, "/cmd_vel", 10)
    report_publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
    log = node.get_logger()
    latencies = []
    try:
        model = pickle.loads(open(path, "rb").read())
    except Exception as error:
        model = None
        log.error(f"no model: {error!r}")

    def predict(scan):
        front, left, right = sectors(scan)
        if model is None or not (front and left and right):
            return 0.0
        row = np.array([[min(front), np.mean(front), np.std(front), min(left), min(right)]])
        began = time.perf_counter()
        try:
            said = model.predict(row)
        except Exception as error:
            log.error(f"no prediction: {error!r}")
            return 0.0
        latencies.append((time.perf_counter() - began) * 1000)
        speed = float(said[0])
        return max(0.0, min(max_speed, speed)) if math.isfinite(speed) else 0.0

    def on_scan(scan):
        command = Twist()
        command.linear.x = predict(scan)
        command_publisher.publish(command)

    def report():
        window = latencies[-100:]
        p50, p95, p99 = np.percentile(window or [0.0], [50, 95, 99])
        missed = sum(took > deadline for took in window)
        level = DiagnosticStatus.ERROR if p95 > deadline else DiagnosticStatus.OK
        if level == DiagnosticStatus.OK and missed:
            level = DiagnosticStatus.WARN
        numbers = [
            ("count", len(window)),
            ("mean_ms", np.mean(window or [0.0])),
            ("p50_ms", p50),
            ("p95_ms", p95),
            ("p99_ms", p99),
            ("max_ms", max(window, default=0.0)),
            ("deadline_ms", deadline),
            ("missed", missed),
        ]
        status = DiagnosticStatus()
        status.name = "profiled_controller: inference"
        status.level = level if window else DiagnosticStatus.STALE
        status.values = [KeyValue(key=key, value=f"{number:.4f}") for key, number in numbers]
        report_publisher.publish(DiagnosticArray(status=[status]))

    def report_for_ever():
        while rclpy.ok():
            time.sleep(1.0)
            report()

    node.create_subscription(LaserScan, "/scan", on_scan, qos_profile_sensor_data)
    threading.Thread(target=report_for_ever, daemon=True).start()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
